#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "core/load_case.hpp"
#include "core/problem.hpp"

namespace livermark::experiments {

/// Displacements of markers at equal intervals of time.
struct MarkerMotion {
    double interval = 0.0;                   ///< between two records [s], > 0
    int num_markers = 0;                     ///< K
    std::vector<core::Vector3> displacement; ///< (J, K) all markers of a record behind each other [m]

    int num_records() const { return static_cast<int>(displacement.size()) / num_markers; }
    const core::Vector3 &at(int record, int marker) const { return displacement[record * num_markers + marker]; }
};

/// How a real body rang after it was let go: it is at rest at t = 0, away from its equilibrium.
struct RingDown {
    std::string state;                 ///< one word or more, as of a MeasuredState
    std::vector<MarkerMotion> repeats; ///< of the same motion, at least one, all with the same records
    /// The body, with what hangs at it, at about this length of edges [m].
    std::function<core::Body(double edge_length)> body;
    /// Supports, acceleration, and one place with a traction: what holds the body at t = 0 and is let go. Its size is
    /// of the right order, and each model finds that with which its markers start where they were seen.
    std::function<core::LoadCase(const core::TetraMesh &)> load_case;
};

/// The mean of all repeats.
MarkerMotion mean_motion(std::span<const MarkerMotion> repeats);

/// A body with a mass that moves with it, spread evenly over the tetrahedra whose middle is in a box: they become a
/// region of their own that is denser. So it has its weight and its inertia in every model.
/// @param mass       [kg], >= 0
/// @param low, high  corners of the box [m]
/// @throws support::InputError if no tetrahedron is there, or they are of several regions
core::Body with_added_mass(core::Body body, double mass, const core::Vector3 &low, const core::Vector3 &high);

} // namespace livermark::experiments
