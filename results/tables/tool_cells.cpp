#include "results/tables/table.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <set>

#include "core/tool/tool_stiffness.hpp"
#include "core/units.hpp"
#include "results/one_reference.hpp"
#include "results/tables/table_layout.hpp"

namespace livermark::results {

namespace {

/// A mesh cannot follow what a tool of fewer edges in radius does.
constexpr double fewest_edges = 2.0;

/// @param sign  "" or "+" before positive values
std::string felt_cell(double stiffness, const char *sign) {
    if (std::isnan(stiffness))
        return "-";
    return fmt::format("{}{}{}", stiffness > 0.0 ? sign : "", fixed(core::percent * stiffness, 1),
                       std::abs(stiffness) > core::smallest_felt_difference ? " !" : "");
}

std::optional<double> radius_in_edges_of(const Result &result) {
    return core::radius_in_edges(core::tool_places(result.problem.body->mesh, result.problem.load_case));
}

std::vector<double> contact_radii_of(const Result &result) {
    return core::contact_radii_in_edges(result.problem.body->mesh, result.problem.load_case);
}

bool is_small_contact(const std::vector<double> &radii) {
    return std::ranges::any_of(radii, [](double radius) { return radius < core::smallest_contact; });
}

} // namespace

bool is_reference(const ModelResult &model, const Result &result) {
    return std::ranges::any_of(result.models, [&](const ModelResult &other) {
        return other.comparison && other.comparison->reference == model.name;
    });
}

double stiffness_at_tool(const ModelResult &model) {
    return model.comparison && model.comparison->tool ? model.comparison->tool->worst_stiffness() : not_known;
}

std::string stiffness_cell(double stiffness) {
    return felt_cell(stiffness, "+");
}

std::string size_cell(double size) {
    return felt_cell(size, "");
}

void StiffnessCases::enter(double stiffness, const std::string &load_case) {
    if (std::isnan(stiffness))
        return;
    if (sizes.empty() || std::abs(stiffness) > std::abs(worst)) {
        worst = stiffness;
        worst_load_case = load_case;
    }
    sizes.push_back(std::abs(stiffness));
    has_positive = has_positive || stiffness > 0.0;
    has_negative = has_negative || stiffness < 0.0;
}

double StiffnessCases::mean() const {
    return results::mean(sizes);
}

std::string StiffnessCases::mean_cell() const {
    return size_cell(mean());
}

std::string StiffnessCases::median_cell() const {
    return sizes.empty() ? "-" : size_cell(median(sizes));
}

std::string StiffnessCases::signed_median_cell() const {
    if (sizes.empty() || has_positive == has_negative)
        return median_cell();
    return stiffness_cell(has_negative ? -median(sizes) : median(sizes));
}

std::string StiffnessCases::worst_cell() const {
    return sizes.empty() ? "-" : fmt::format("{} {}", stiffness_cell(worst), worst_load_case);
}

std::string tool_legend() {
    return fmt::format("tool: error of the stiffness at the tool. The tool is the place that the load case presses, "
                       "pulls or moves; its stiffness is its force divided by its displacement. Positive: the model is "
                       "stiffer than the reference. Along a path: the largest error. !: above {:.0f} %, which fingers "
                       "tell apart (Pang, Tan, Durlach 1991, Percept. Psychophys. 49(6))\n",
                       core::percent * core::smallest_felt_difference);
}

std::string mean_tool_legend() {
    return "tool, mean tool: mean of absolute values over load cases; worst tool: the one farthest from zero, with its "
           "sign\n";
}

std::string tool_radii(std::span<const Result> results) {
    std::vector<std::string> radii, contacts;
    for (const Result &result : results) {
        const auto name = fmt::format("{} {}", body_label(result, results), printable(result.problem.load_case.name));
        if (const auto contact = contact_radii_of(result); !contact.empty())
            contacts.push_back(fmt::format("{} {:.1f}", name, fmt::join(contact, " ")));
        if (const auto radius = radius_in_edges_of(result))
            radii.push_back(fmt::format("{} {:.1f}", name, *radius));
    }
    std::string text;
    if (!radii.empty())
        text += fmt::format("\nradius of the smallest tool in edges: {}\n", fmt::join(radii, ", "));
    if (!contacts.empty())
        text +=
            fmt::format("\nradius of the contact in edges (a ball by Hertz, a plate its size), along the path: {}\n",
                        fmt::join(contacts, ", "));
    return text;
}

std::optional<std::string> note_on_small_contacts(std::span<const Result> results) {
    std::vector<std::string> contacts;
    for (const Result &result : results)
        if (const auto radii = contact_radii_of(result); is_small_contact(radii)) {
            const auto [least, most] = std::ranges::minmax(radii);
            contacts.push_back(fmt::format("{} on {} touches {:.1f} to {:.1f} edges in radius",
                                           printable(result.problem.load_case.name), body_label(result, results), least,
                                           most));
        }
    if (contacts.empty())
        return std::nullopt;
    return fmt::format("the ball of {}; where that is below {:g}, errors of its force are ten percent and "
                       "more, and the mesh decides on their sign: take a finer mesh below it, a larger ball or a "
                       "deeper one",
                       fmt::join(contacts, ", that of "), core::smallest_contact);
}

std::optional<std::string> note_on_small_tools(std::span<const Result> results) {
    std::set<std::string> load_cases;
    std::vector<double> radii;
    for (const Result &result : results)
        if (const auto radius = radius_in_edges_of(result);
            radius && *radius < fewest_edges && contact_radii_of(result).empty()) {
            load_cases.insert(printable(result.problem.load_case.name));
            radii.push_back(*radius);
        }
    if (radii.empty())
        return std::nullopt;
    const auto [least, most] = std::ranges::minmax(radii);
    const auto smallest = fmt::format("{:.1f}", least), largest = fmt::format("{:.1f}", most);
    const bool is_one = load_cases.size() == 1;
    return fmt::format("the {} of {} {} {} edges in radius; below {:g}, expect stiffness at the tool to change by "
                       "several percent on a finer mesh",
                       is_one ? "tool" : "tools", fmt::join(load_cases, ", "), is_one ? "is" : "are",
                       smallest == largest ? smallest : smallest + " to " + largest, fewest_edges);
}

} // namespace livermark::results
