#include "load_cases/readers/load_case_reader.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <string_view>
#include <utility>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"
#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "core/support/toml_input.hpp"
#include "load_cases/places/selector.hpp"
#include "load_cases/readers/event_reader.hpp"

namespace livermark::load_cases {

namespace {

void refuse_unknown_condition_keys(const toml::table &table) {
    auto known = keys_with_place({"name"});
    std::ranges::copy(effect_keys(), std::back_inserter(known));
    support::refuse_unknown_keys(table, known);
}

void take_depth(double depth, const toml::table &condition, core::LoadCase &load_case) {
    if (load_case.press_depth != 0.0 && load_case.press_depth != depth)
        support::refuse(
            condition,
            "the places that press are one instrument, and have depths of {:g} m and {:g} m; give all the same depth",
            load_case.press_depth, depth);
    load_case.press_depth = depth;
}

/// Together the places that press make one newton.
void share_newton(core::LoadCase &load_case, const std::string &file) {
    if (load_case.press_depth == 0.0)
        return;
    auto others = load_case;
    others.press_depth = 0.0;
    for (int f = 0; f < load_case.num_facets(); ++f)
        if (load_case.presses(f))
            others.value[f].setZero();
    if (core::is_driven(others))
        throw support::InputError("{}: a place that presses has to be the only load; leave out loads, accelerations "
                                  "and displacements other than 0, or write 'push', which fixes the place to the tool",
                                  file);
    const auto num_pressing = static_cast<double>(
        std::ranges::count(load_case.conditions, core::ConditionKind::press, &core::Condition::kind));
    for (int f = 0; f < load_case.num_facets(); ++f)
        if (load_case.presses(f))
            load_case.value[f] /= num_pressing;
}

void apply_condition(const toml::table &table, const core::TetraMesh &mesh, core::LoadCase &load_case) {
    auto place = select_facets(table, mesh, load_case);
    if (table.contains("name"))
        place.name = support::required_string(table, "name");
    const auto [selection, effect, lost_area] = place_apart(table, std::move(place), mesh, load_case);
    if (lost_area > 0.0)
        load_case.yielded.push_back({selection.name, lost_area});
    if (effect.kind == core::ConditionKind::press)
        take_depth(effect.press_depth, table, load_case);
    if (effect.kind == core::ConditionKind::pressure && load_case.regime == core::Regime::small)
        support::refuse(table, "a pressure that follows the surface needs large deformations; write regime = "
                               "\"large\", or give a 'pressure'");
    for (const int f : selection.facets) {
        load_case.condition_on[f] = static_cast<int>(load_case.conditions.size());
        load_case.value[f] = effect.value(f);
    }
    load_case.conditions.push_back({selection.name, effect.kind, effect.round});
    if (!effect.node_factor.empty()) {
        load_case.node_factor.resize(mesh.points.size(), 1.0);
        for (const int f : selection.facets)
            for (const int node : mesh.boundary_triangles[f])
                load_case.node_factor[node] = effect.node_factor[node];
    }
}

void refuse_unknown_keys_of_load_case(const toml::table &table) {
    std::vector<std::string_view> known{
        "title",        "regime",    "path", "target_peak_displacement", "scale_to_target", "unit",
        "acceleration", "condition", "cut"};
    for (const auto &event : all_events()) {
        known.push_back(event.name);
        std::ranges::copy(event.beside, std::back_inserter(known));
    }
    support::refuse_unknown_keys(table, known);
}

/// Whether the file has a table of an event, or one that belongs to it.
bool speaks_of(const toml::table &table, const EventReader &event) {
    return event.is_in(table) ||
           std::ranges::any_of(event.beside, [&](std::string_view key) { return table.contains(key); });
}

/// More would be frames of a motion, and fill disks.
constexpr std::size_t most_path_points = 50;

core::Regime regime_of(const toml::table &table) {
    if (!table.contains("regime"))
        return core::Regime::small;
    const auto word = support::required_string(table, "regime");
    for (const auto regime : {core::Regime::small, core::Regime::large})
        if (word == core::to_string(regime))
            return regime;
    support::refuse(*table.get("regime"), "there is no regime '{}'; write \"small\" or \"large\"", word);
}

/// The parts of the loads at which solutions are kept.
std::vector<double> read_path(const toml::table &table, core::Regime regime) {
    if (!table.contains("path"))
        return regime == core::Regime::large ? std::vector{0.2, 0.4, 0.6, 0.8, 1.0} : std::vector<double>{};
    const auto place = support::place_of(*table.get("path"));
    if (regime == core::Regime::small)
        throw support::InputError("{}: small deformations are proportional to the load and need no path; leave it out, "
                                  "or write regime = \"large\"",
                                  place);
    auto path = support::required_numbers(table, "path");
    const bool ascends = std::ranges::adjacent_find(path, std::greater_equal<>()) == path.end();
    if (path.size() < 2 || path.size() > most_path_points || !ascends || !(path.front() > 0.0) || path.back() != 1.0)
        throw support::InputError(
            "{}: a path has 2 to {} parts of the load that ascend from above 0 to 1, such as [0.25, 0.5, 0.75, 1.0]",
            place, most_path_points);
    return path;
}

void read_regime(const toml::table &table, core::LoadCase &load_case) {
    load_case.regime = regime_of(table);
    load_case.path = read_path(table, load_case.regime);
}

toml::table read_table(const std::string &text, const std::filesystem::path &file) {
    auto table = support::parse_toml(text, file);
    refuse_unknown_keys_of_load_case(table);
    return table;
}

const toml::array &required_conditions(const toml::table &table) {
    const auto *node = table.get("condition");
    if (!node || !node->is_array_of_tables())
        support::refuse(table, "there is no [[condition]]; add one that constrains the body");
    return *node->as_array();
}

/// The name of the file where it gives none.
std::string title_of(const toml::table &table, const std::filesystem::path &file) {
    return table.contains("title") ? support::required_string(table, "title") : file.stem().string();
}

void read_target(const toml::table &table, core::LoadCase &load_case) {
    if (!load_case.scale_to_target && !table.contains("target_peak_displacement"))
        return;
    load_case.target_peak_displacement = support::required_number(table, "target_peak_displacement");
    if (!(load_case.target_peak_displacement > 0.0))
        support::refuse(*table.get("target_peak_displacement"), "'target_peak_displacement' has to be positive");
}

/// Peak displacement where nothing says how far a load moves the body: as far as places are moved; or, where forces
/// alone act, a hundredth of its size, where small deformations end.
double expected_peak(const core::TetraMesh &mesh, const core::LoadCase &load_case) {
    double peak = std::max(load_case.contact_depth(), std::abs(load_case.press_depth));
    for (int f = 0; f < load_case.num_facets(); ++f)
        if (load_case.is_constrained(f))
            peak = std::max(peak,
                            load_case.value[f].array().isNaN().select(0.0, load_case.value[f].array()).matrix().norm());
    constexpr double small_part = 0.01;
    return peak > 0.0 ? peak : small_part * core::extent(mesh.points);
}

} // namespace

std::string load_case_title(const std::filesystem::path &toml_file) {
    return title_of(read_table(support::read_text(toml_file), toml_file), toml_file);
}

bool LoadCaseKind::is_for(std::string_view command) const {
    return std::ranges::find(commands, command) != commands.end();
}

LoadCaseKind load_case_kind(const std::filesystem::path &toml_file) {
    const auto table = read_table(support::read_text(toml_file), toml_file);
    core::LoadCase load_case;
    read_regime(table, load_case);
    LoadCaseKind kind{.regime = load_case.regime};
    for (const auto &event : all_events())
        if (event.is_in(table)) {
            kind.depends_on_time = kind.depends_on_time || event.in_time;
            if (event.command != run_command) {
                kind.commands.emplace_back(event.command);
                kind.what = kind.what.empty() ? event.what : kind.what;
            }
        }
    if (kind.commands.empty())
        kind.commands.emplace_back(run_command);
    return kind;
}

core::LoadCase read_load_case(const std::filesystem::path &toml_file, const core::TetraMesh &mesh) {
    return parse_load_case(support::read_text(toml_file), toml_file, mesh);
}

core::LoadCase parse_load_case(const std::string &text, const std::filesystem::path &file,
                               const core::TetraMesh &mesh) {
    auto table = support::parse_toml(text, file);
    auto load_case = load_case_of_table(table, file, mesh);
    load_case.definition = text;
    return load_case;
}

core::LoadCase read_load_case(const std::filesystem::path &toml_file, const core::Body &body) {
    return parse_load_case(support::read_text(toml_file), toml_file, body);
}

core::LoadCase parse_load_case(const std::string &text, const std::filesystem::path &file, const core::Body &body) {
    auto table = support::parse_toml(text, file);
    turn_directions(table, body.axes);
    auto load_case = load_case_of_table(table, file, body.mesh);
    load_case.definition = text;
    return load_case;
}

core::LoadCase load_case_of_table(toml::table &table, const std::filesystem::path &file, const core::TetraMesh &mesh) {
    refuse_unknown_keys_of_load_case(table);
    bring_to_metres(table);
    if (table.contains("cut") && std::ranges::find(mesh.patch_names, "wound") == mesh.patch_names.end())
        support::refuse(*table.get("cut"), "the load case cuts the body, and this one is not cut; cut it first");
    core::LoadCase load_case;
    load_case.name = file.stem().string();
    if (const auto *conditions = table["condition"].as_array(); conditions && conditions->is_array_of_tables())
        for (const auto &condition : *conditions) // a misspelt key is missing as well
            refuse_unknown_condition_keys(*condition.as_table());
    refuse_missing_parts(table);
    load_case.title = title_of(table, file);
    read_regime(table, load_case);
    const Reading reading{table, file, mesh, load_case};
    const auto for_each_named = [&](auto hook) {
        for (const auto &event : all_events())
            if (event.*hook && speaks_of(table, event))
                (event.*hook)(reading);
    };
    for_each_named(&EventReader::begin);
    load_case.scale_to_target = support::optional_flag(table, "scale_to_target");
    read_target(table, load_case);
    if (table.contains("acceleration"))
        load_case.acceleration = support::required_vector(table, "acceleration");
    load_case = core::with_free_surface(std::move(load_case), mesh);
    for (const auto &condition : required_conditions(table))
        apply_condition(*condition.as_table(), mesh, load_case);
    share_newton(load_case, file.string());
    if (!load_case.has(core::ConditionKind::displacement))
        throw support::InputError("{}: nothing constrains the body; add a [[condition]] with a displacement",
                                  file.string());
    for_each_named(&EventReader::refuse_company);
    for_each_named(&EventReader::read);
    if (load_case.scale_to_target && !core::is_driven(load_case))
        support::refuse(*table.get("scale_to_target"),
                        "nothing moves the body, so no factor reaches the target; add a load, a displacement or an "
                        "acceleration, or leave 'scale_to_target' out");
    if (!table.contains("target_peak_displacement"))
        load_case.target_peak_displacement = expected_peak(mesh, load_case);
    refuse_free_body(mesh, load_case, file.string());
    for_each_named(&EventReader::check);
    return load_case;
}

} // namespace livermark::load_cases
