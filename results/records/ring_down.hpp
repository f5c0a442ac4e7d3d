#pragma once

#include <limits>
#include <string>
#include <vector>

#include "core/rayleigh_damping.hpp"
#include "core/solution.hpp"

namespace livermark::results {

/// How many swings of a ring-down are compared.
inline constexpr int num_swings = 4;

/// A model that rings down, on one mesh. What was measured of the real body is measured of the model in the same way.
struct RingDownRun {
    std::string model;
    int tetrahedra = 0; ///< of the mesh
    core::SolutionStatus status = core::SolutionStatus::ok;
    std::string message{};                                           ///< why it is not ok
    std::string integrator{};                                        ///< the rule that took the steps
    core::RayleighDamping damping{};                                 ///< that the model was given
    double time_step = std::numeric_limits<double>::quiet_NaN();     ///< [s]
    double frequency = std::numeric_limits<double>::quiet_NaN();     ///< [Hz]
    double damping_ratio = std::numeric_limits<double>::quiet_NaN(); ///< of the decay
    std::vector<double> swings{};                                    ///< (num_swings) [m]
    double swing_error = std::numeric_limits<double>::quiet_NaN();   ///< root mean square, over the swings [m]
    double error = std::numeric_limits<double>::quiet_NaN();         ///< of markers, over records and markers [m]
    double start_error = std::numeric_limits<double>::quiet_NaN();   ///< of markers at t = 0 [m]
    double seconds = 0.0;                                            ///< of everything
    std::vector<core::Vector3> displacement{};                       ///< (J, K) of the markers [m]
};

/// How a body rang down, as it was measured, and what can be said without a model. Errors are root mean square
/// distances over records and markers [m].
struct RingDownResult {
    std::string state;
    double interval = 0.0;                               ///< between records [s]
    std::vector<core::Vector3> displacement;             ///< (J, K) mean of all repeats [m]
    double frequency = 0.0, frequency_uncertainty = 0.0; ///< [Hz]
    double damping_ratio = 0.0, damping_uncertainty = 0.0;
    std::vector<double> swings; ///< (num_swings) [m]
    double swing_noise = 0.0;   ///< root mean square of half of how far repeats differ; 0 of one [m]
    double noise = 0.0;         ///< half of how far repeats differ; 0 of one
    double no_motion = 0.0;     ///< error of a body that stays at the mean place of each marker
    double rigid_motion = 0.0;  ///< of the rigid motion that fits the markers best in each record
    std::vector<RingDownRun> runs;

    int num_records(std::size_t num_markers) const { return static_cast<int>(displacement.size() / num_markers); }
};

/// Root of the mean squared distance between two sets of displacements.
double root_mean_square_distance(const std::vector<core::Vector3> &a, const std::vector<core::Vector3> &b);

} // namespace livermark::results
