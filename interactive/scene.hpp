#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "core/problem.hpp"

namespace livermark::interactive {

/// One vector for each node, shape (3, N): positions [m], velocities [m/s] or forces [N].
using Field = Eigen::Matrix3Xd;

/// What moves, and what is moved from outside.
struct Scene {
    std::shared_ptr<const core::Body> body; ///< linear tetrahedra, one material per region
    std::vector<double> node_mass;          ///< (N) [kg], > 0
    /// (C) nodes whose positions are set from outside, each once: what a tool has taken hold of, or what holds the
    /// body.
    std::vector<int> constrained_nodes;
    double mass_damping = 0.0; ///< alpha [1/s], >= 0: forces -alpha m v
};

/// Positions of the nodes at rest.
Field rest_positions(const Scene &scene);

/// The nodes whose positions are not set from outside.
/// @return shape (N)
std::vector<bool> free_nodes(const Scene &scene);

} // namespace livermark::interactive
