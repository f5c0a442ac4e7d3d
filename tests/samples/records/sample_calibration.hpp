#pragma once

#include "results/records/springs.hpp"

namespace livermark::tests {

/// A calibration that fits a body, with made-up numbers.
inline results::Calibration sample_calibration(const core::Body &body) {
    results::Calibration calibration;
    calibration.body = body.name;
    calibration.spring_law = "patch";
    calibration.volume_term = "nodal_volume";
    calibration.reference = "fem_p2p1";
    calibration.constrained = "x_min";
    calibration.seed = 7;
    calibration.iterations = 40;
    calibration.penalty = 0.25;
    calibration.springs.materials = body.materials;
    calibration.springs.edges = core::edge_table(body.mesh.tetrahedra).edges;
    for (const auto &[i, j] : calibration.springs.edges) {
        const double length = (body.mesh.points[j] - body.mesh.points[i]).norm();
        calibration.springs.rest_length.push_back(length);
        calibration.springs.stiffness.push_back(1.0 / length);
        calibration.start_stiffness.push_back(100.0 * length);
    }
    calibration.held_out = {0, 0, 1};
    calibration.error_before = {0.5, 0.25, 0.125};
    calibration.error_after = {0.1, 0.05, 0.025};
    return calibration;
}

} // namespace livermark::tests
