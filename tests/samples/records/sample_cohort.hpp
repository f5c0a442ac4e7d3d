#pragma once

#include <limits>
#include <string>

#include "results/records/cohort.hpp"

namespace livermark::tests {

/// Three bodies, one of which has failed, and two models, one of which has not come to an end on one body. The numbers
/// are made up.
inline results::Cohort sample_cohort() {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    using enum core::Regime;
    using enum core::SolutionStatus;
    const results::CohortLesion lesion{{0.01, 0.02, 0.03}, {0.009, 0.008, 0.007}};
    results::Cohort cohort;
    cohort.tetrahedra = 2000;
    cohort.bodies = {{1, "liver_variant_1", 1.1e-3, 1.6, 0.1, 0.9, false, {lesion, lesion}},
                     {2, "liver_variant_2", 1.5e-3, 1.8, 0.2, 1.1, true, {}},
                     {3, "liver_variant_3", 1.9e-3, 2.0, 0.15, 1.0, false, {lesion, lesion}}};
    const std::string linear = "fem_p2p1_refined", hyperelastic = "fem_p2p1_neo_hookean";
    cohort.errors = {
        {"liver_variant_1", small, 0.45, "palpation", "springs", ok, 0.04, 0.05, -0.15, linear, 1.2},
        {"liver_variant_1", small, 0.45, "traction", "springs", ok, 0.06, 0.07, 0.05, linear, 3.5},
        {"liver_variant_2", small, 0.45, "palpation", "springs", ok, 0.03, 0.02, 0.08, linear, 1.1},
        {"liver_variant_2", small, 0.45, "traction", "springs", ok, 0.05, nan, nan, linear},
        {"liver_variant_1", large, 0.45, "large_traction", "blown_up", diverged, nan, nan, nan, hyperelastic}};
    cohort.failures = {"liver_variant_3: gmsh fails", "liver_variant_2: pneumoperitoneum: does not move"};
    return cohort;
}

} // namespace livermark::tests
