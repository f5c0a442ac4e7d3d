#include "results/tables/tool_cells.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numeric>
#include <set>

#include "core/tool/tool_stiffness.hpp"
#include "core/units.hpp"
#include "results/quantile.hpp"
#include "results/tables/overview.hpp"
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

} // namespace

double stiffness_at_tool(const ModelResult &model) {
    return model.comparison && model.comparison->tool ? model.comparison->tool->worst_stiffness()
                                                      : std::numeric_limits<double>::quiet_NaN();
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
}

double StiffnessCases::mean() const {
    return std::accumulate(sizes.begin(), sizes.end(), 0.0) / static_cast<double>(sizes.size());
}

std::string StiffnessCases::mean_cell() const {
    return size_cell(mean());
}

std::string StiffnessCases::median_cell() const {
    return sizes.empty() ? "-" : size_cell(median(sizes));
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

std::string tool_radii(std::span<const Result> results) {
    std::vector<std::string> radii;
    for (const Result &result : results)
        if (const auto radius = radius_in_edges_of(result))
            radii.push_back(fmt::format("{} {} {:.1f}", body_label(result, results),
                                        printable(result.problem.load_case.name), *radius));
    return radii.empty() ? "" : fmt::format("\nradius of the smallest tool in edges: {}\n", fmt::join(radii, ", "));
}

std::optional<std::string> note_on_small_tools(std::span<const Result> results) {
    std::set<std::string> load_cases;
    std::vector<double> radii;
    for (const Result &result : results)
        if (const auto radius = radius_in_edges_of(result); radius && *radius < fewest_edges) {
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
