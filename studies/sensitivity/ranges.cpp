#include "studies/sensitivity/ranges.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <limits>

#include "support/input_error.hpp"
#include "support/toml_input.hpp"
#include "support/whole_file.hpp"

namespace livermark::studies {

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

/// A parameter that ranges may be given of.
struct KnownParameter {
    const char *name, *unit, *group;
    double above, below; ///< what its values are between; where it may be equal to one end, that is said
    bool may_reach_end;
};

constexpr std::array<KnownParameter, 7> known_parameters{
    {{"young_modulus", "Pa", "parameters", 0.0, infinite, false},
     {"poisson_ratio", "", "parameters", -1.0, 0.5, false},
     {"tumour_contrast", "", "parameters", 0.0, infinite, false},
     {"density", "kg/m^3", "parameters", 0.0, infinite, false},
     {"held_share", "", "support", 0.0, 1.0, true},
     {"support_stiffness", "Pa/m", "support", 0.0, infinite, false},
     {"tool_offset", "m", "tool", -infinite, infinite, false}}};

bool is_logarithmic(const toml::table &table) {
    if (!table.contains("scale"))
        return false;
    const auto scale = support::required_string(table, "scale");
    if (scale != "linear" && scale != "logarithmic")
        throw support::InputError(fmt::format("{}: the scale '{}' is not known; write \"linear\" or \"logarithmic\"",
                                              support::place_of(*table.get("scale")), support::shown(scale)));
    return scale == "logarithmic";
}

results::UncertainParameter read_range(const KnownParameter &known, const toml::table &table) {
    support::refuse_unknown_keys(table, {"from", "to", "scale", "source"});
    results::UncertainParameter range{.name = known.name,
                                      .unit = known.unit,
                                      .group = known.group,
                                      .lower = support::required_number(table, "from"),
                                      .upper = support::required_number(table, "to"),
                                      .is_logarithmic = is_logarithmic(table),
                                      .source = support::required_string(table, "source")};
    if (!(range.lower < range.upper))
        throw support::InputError(fmt::format("{}: {} goes from {:g} to {:g}; the second has to be larger",
                                              support::place_of(table), known.name, range.lower, range.upper));
    const bool ends_at = known.may_reach_end && range.upper <= known.below;
    if (!(range.lower > known.above) || !(range.upper < known.below || ends_at))
        throw support::InputError(fmt::format("{}: {} from {:g} to {:g} cannot be; it lies above {:g} and {} {:g}",
                                              support::place_of(table), known.name, range.lower, range.upper,
                                              known.above, known.may_reach_end ? "not above" : "below", known.below));
    if (range.is_logarithmic && !(range.lower > 0.0))
        throw support::InputError(
            fmt::format("{}: {} from {:g} has no logarithm; begin above 0, or leave the scale out",
                        support::place_of(table), known.name, range.lower));
    return range;
}

/// Why a parameter cannot act; empty where it can.
std::string obstacle(const std::string &name, const core::Problem &problem) {
    if (name == "tumour_contrast" && tumour_regions(*problem.body).empty())
        return "the body has no stiffer region";
    if (name == "density" && problem.load_case.acceleration.isZero(0.0))
        return "without an acceleration density has no effect on a body at rest: its index is exactly 0";
    if ((name == "held_share" || name == "support_stiffness") && held_facets(problem.load_case).empty())
        return "no facet is constrained in all directions";
    if (name.starts_with("tool_offset") && !has_movable_tool(problem.load_case))
        return "the load case does not have exactly one round tool to move";
    return {};
}

} // namespace

Ranges read_ranges(const std::filesystem::path &file) {
    const auto table = support::parse_toml(support::read_text(file), file);
    std::vector<std::string_view> keys{"measurement"};
    for (const auto &known : known_parameters)
        keys.emplace_back(known.name);
    support::refuse_unknown_keys(table, keys);
    Ranges ranges;
    for (const auto &known : known_parameters) {
        if (!table.contains(known.name))
            continue;
        auto range = read_range(known, support::required_table(table, known.name));
        const bool is_offset = range.name == "tool_offset";
        for (const auto *direction : {"_1", "_2"}) {
            ranges.parameters.push_back(range);
            if (!is_offset)
                break;
            ranges.parameters.back().name += direction;
        }
    }
    if (ranges.parameters.empty())
        throw support::InputError(fmt::format("{}: there is no range; add a table such as [young_modulus] with from, "
                                              "to and source",
                                              file.string()));
    if (table.contains("measurement")) {
        const auto &measurement = support::required_table(table, "measurement");
        support::refuse_unknown_keys(measurement, {"displacement", "source"});
        support::required_string(measurement, "source");
        ranges.displacement_noise = support::required_number(measurement, "displacement");
        if (!(*ranges.displacement_noise > 0.0))
            throw support::InputError(fmt::format("{}: 'displacement' has to be positive",
                                                  support::place_of(*measurement.get("displacement"))));
    }
    return ranges;
}

ActingParameters acting_on(const core::Problem &problem, const Ranges &ranges) {
    ActingParameters acting;
    for (const auto &parameter : ranges.parameters) {
        const auto why = obstacle(parameter.name, problem);
        if (why.empty())
            acting.parameters.push_back(parameter);
        else if (parameter.name != "tool_offset_2") // which is said once
            acting.notes.push_back(
                fmt::format("{} / {}: {} is not varied, because {}", problem.body->name, problem.load_case.name,
                            parameter.name == "tool_offset_1" ? "tool_offset" : parameter.name, why));
    }
    if (acting.parameters.empty())
        throw support::InputError(fmt::format("{} / {}: no parameter that has a range acts here; give a range of "
                                              "young_modulus",
                                              problem.body->name, problem.load_case.name));
    return acting;
}

Patient patient_of(const std::vector<results::UncertainParameter> &parameters, const std::vector<double> &values) {
    Patient patient;
    for (std::size_t p = 0; p < parameters.size(); ++p) {
        const auto &name = parameters[p].name;
        if (name == "young_modulus")
            patient.young_modulus = values[p];
        else if (name == "poisson_ratio")
            patient.poisson_ratio = values[p];
        else if (name == "tumour_contrast")
            patient.tumour_contrast = values[p];
        else if (name == "density")
            patient.density = values[p];
        else if (name == "held_share")
            patient.held_share = values[p];
        else if (name == "support_stiffness")
            patient.support_stiffness = values[p];
        else if (!patient.tool_offset)
            patient.tool_offset = Eigen::Vector2d(values[p], 0.0);
        else
            patient.tool_offset->y() = values[p];
    }
    return patient;
}

} // namespace livermark::studies
