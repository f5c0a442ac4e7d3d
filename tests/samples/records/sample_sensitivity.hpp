#pragma once

#include <limits>

#include "results/records/sensitivity.hpp"

namespace livermark::tests {

/// Five patients of a jelly, three parameters in two groups, two outputs and one model. The numbers are made up.
inline results::Sensitivity sample_sensitivity() {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    results::Sensitivity sensitivity;
    sensitivity.body = "jelly";
    sensitivity.load_case = "spoon";
    sensitivity.title = "A spoon on a jelly";
    sensitivity.model = "elements";
    sensitivity.fingerprint = "0123456789abcdef";
    sensitivity.parameters = {{"young_modulus", "Pa", "parameters", 4000.0, 6000.0, false, "a cook"},
                              {"poisson_ratio", "", "parameters", 0.45, 0.49, false, "another cook"},
                              {"support_stiffness", "Pa/m", "support", 1e5, 1e7, true, "the plate"}};
    sensitivity.groups = {"parameters", "support"};
    for (int s = 0; s < 5; ++s) {
        sensitivity.points.push_back({4000.0 + 400.0 * s, 0.45 + 0.01 * s, 1e5 * (1.0 + s)});
        sensitivity.values.push_back({100.0 + s, 0.002});
    }
    results::OutputSensitivity stiffness{.name = "stiffness_at_tool",
                                         .unit = "N/m",
                                         .nominal = 101.0,
                                         .mean = 100.0,
                                         .deviation = 20.0,
                                         .lower = 70.0,
                                         .upper = 130.0,
                                         .unexplained = 0.01};
    stiffness.first = {0.75, 0.1, 0.1};
    stiffness.first_lower = {0.7, 0.05, 0.05};
    stiffness.first_upper = {0.8, 0.15, 0.15};
    stiffness.total = {0.8, 0.1, 0.15};
    stiffness.total_lower = {0.75, 0.05, 0.1};
    stiffness.total_upper = {0.85, 0.15, 0.2};
    stiffness.group_total = {0.9, 0.15};
    auto peak = stiffness;
    peak.name = "peak_displacement";
    peak.unit = "m";
    sensitivity.outputs = {stiffness, peak};
    sensitivity.budget = {.reference = "elements_refined",
                          .mesh = {0.002, 0.003},
                          .law = {-0.035, nan},
                          .measurement = {nan, 0.1},
                          .models = {{"springs", {0.04, -0.05}}}};
    return sensitivity;
}

} // namespace livermark::tests
