#pragma once

#include "results/records/needle.hpp"

namespace livermark::tests {

/// Two steps in and two out.
inline core::Insertion sample_insertion(double force) {
    core::Insertion found;
    for (int j = 0; j < 5; ++j) {
        found.depth.push_back(0.01 * (j < 3 ? j : 4 - j));
        found.force.push_back(j < 3 ? force * j : -0.5 * force);
        found.tip.push_back(0.008 * j);
        found.target.emplace_back(0.0, 0.003, 0.004);
        found.entry.push_back(0.001);
        found.work.push_back(0.1 * j);
        found.stored.push_back(0.02 * j);
        found.friction.push_back(0.03 * j);
        found.tearing.push_back(0.05 * j);
        found.holding.push_back(0.001 * j);
    }
    found.at_plan = 2;
    return found;
}

/// One needle in two models. The numbers are made up.
inline results::NeedleFile sample_needles() {
    results::NeedleStudy study{.needle = {.name = "to tumour 1",
                                          .entry = {0.0, 0.0, 0.0},
                                          .target = {0.0, 0.0, 0.02},
                                          .diameter = 1e-3,
                                          .spread = 6e-3,
                                          .toughness = 164.0,
                                          .friction = 20.0,
                                          .puncture_force = 0.2,
                                          .step = 0.01},
                               .runs = {{"judge", sample_insertion(1.0), 3.0}, {"springs", sample_insertion(1.1), 0.5}},
                               .reference_miss_change = 1e-5,
                               .reference_force_change = 0.004};
    study.runs[1].insertion.puncture_depth = 0.01;
    return {.provenance = {}, .body = "block", .load_case = "biopsy", .title = "Biopsy", .needles = {study}};
}

} // namespace livermark::tests
