#include "load_cases/readers/missing_parts.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "load_cases/places/selector.hpp"
#include "load_cases/readers/effects.hpp"
#include "support/input_error.hpp"
#include "support/toml_input.hpp"

namespace livermark::load_cases {

namespace {

using Missing = std::vector<std::string>;

bool has_one_of(const toml::table &table, auto &&keys) {
    return std::ranges::any_of(keys, [&](std::string_view key) { return table.contains(key); });
}

std::vector<std::string_view> place_keys() {
    std::vector<std::string_view> keys;
    for (const auto &selector : all_selectors())
        keys.push_back(selector.name);
    return keys;
}

bool constrains(const toml::table &condition) {
    return condition.contains("displacement") || condition.contains("push");
}

void look_at_conditions(const toml::table &load_case, Missing &missing) {
    const auto *conditions = load_case["condition"].as_array();
    bool is_constrained = false;
    if (conditions && conditions->is_array_of_tables())
        for (const auto &node : *conditions) {
            const auto &condition = *node.as_table();
            is_constrained = is_constrained || constrains(condition);
            if (!has_one_of(condition, place_keys()))
                missing.push_back(fmt::format("a place in the [[condition]] of line {} (one of {})",
                                              condition.source().begin.line, fmt::join(place_keys(), ", ")));
            if (!has_one_of(condition, effect_keys()))
                missing.push_back(fmt::format("what happens there in the [[condition]] of line {} (one of {})",
                                              condition.source().begin.line, fmt::join(effect_keys(), ", ")));
        }
    if (!is_constrained)
        missing.emplace_back("a [[condition]] that constrains the body (such as patch = \"posterior\" and displacement "
                             "= [0.0, 0.0, 0.0])");
}

void look_at_keys(const toml::table &load_case, std::string_view part, std::initializer_list<std::string_view> keys,
                  Missing &missing) {
    const auto *table = load_case[part].as_table();
    if (!table)
        return;
    for (const auto key : keys)
        if (!table->contains(key))
            missing.push_back(fmt::format("'{}' in the [{}]", key, part));
}

void look_at_release(const toml::table &load_case, Missing &missing) {
    look_at_keys(load_case, "release", {"duration", "output_interval"}, missing);
    const auto *release = load_case["release"].as_table();
    if (!release)
        return;
    if (!has_one_of(*release,
                    std::initializer_list<std::string_view>{"damping_ratio", "damping_frequencies", "alpha", "beta"}))
        missing.emplace_back("'damping_ratio' and 'damping_frequencies' in the [release]");
    if (!load_case.contains("probe"))
        missing.emplace_back("a [[probe]] with a name and a patch");
}

} // namespace

void refuse_missing_parts(const toml::table &load_case) {
    Missing missing;
    if (load_case.contains("scale_to_target") && !load_case.contains("target_peak_displacement"))
        missing.emplace_back("'target_peak_displacement' [m], which 'scale_to_target' needs");
    look_at_conditions(load_case, missing);
    look_at_release(load_case, missing);
    look_at_keys(load_case, "tool", {"place", "press_until", "release_at", "duration", "mass_damping"}, missing);
    look_at_keys(load_case, "touch", {"radius", "depth"}, missing);
    if (missing.size() > 1)
        throw support::InputError(fmt::format("{}: {} things are missing: {}; add them", support::place_of(load_case),
                                              missing.size(), fmt::join(missing, "; ")));
}

} // namespace livermark::load_cases
