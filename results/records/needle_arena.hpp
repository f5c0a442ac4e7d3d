#pragma once

#include <limits>
#include <string>
#include <vector>

#include "results/records/arena.hpp"

namespace livermark::results {

/// What the hand feels, in three numbers.
struct NeedleForces {
    double peak = 0.0;  ///< the largest on the way in [N]
    double slope = 0.0; ///< over depth, by least squares over the second half of the way in [N/m]: friction
    double pull = 0.0;  ///< the largest outwards after that [N]

    bool operator==(const NeedleForces &) const = default;
};

/// @param depth    (K) of the tip [m]
/// @param force    (K) of the hand, inwards [N]
/// @param at_plan  the last record of the way in
NeedleForces needle_forces(const std::vector<double> &depth, const std::vector<double> &force, int at_plan);

/// A method with a needle, on a mesh within a budget. Records are those of NeedleArena.
struct NeedleArenaRun {
    std::string method;
    std::string setting; ///< how it uses its time
    int tetrahedra = 0;  ///< of the mesh
    double budget = 0.0; ///< of one core, for a frame [s]
    int steps = 0;       ///< in a frame
    int iterations = 0;  ///< in a step
    int stops_early = 0; ///< as of ArenaRun
    ArenaOutcome outcome = ArenaOutcome::ok;
    std::vector<double> force;         ///< (K) of the hand, inwards [N]; NaN from where the body has diverged on
    std::vector<double> tip;           ///< (K) how much of the tissue's path is behind the tip, at rest [m]
    std::vector<core::Vector3> target; ///< (K) displacement of the target [m]
    double target_error = 0.0;         ///< of the displacement of the target at at_plan [m]
    double path_error = 0.0; ///< of displacements at the places of the needle there, sqrt(sum |u - r|^2 / sum |r|^2)
    NeedleForces forces;
    double frame_seconds = 0.0;    ///< of the processor, median over frames [s]
    double frame_seconds_95 = 0.0; ///< 95th percentile [s]
    double worst_frame_seconds = 0.0;
    double cost_ratio = 0.0;    ///< of a frame over one of the same body without the needle, of medians taken by turns
    double setup_seconds = 0.0; ///< before the first frame
    double calibration_spread = 0.0; ///< as of ArenaRun

    bool operator==(const NeedleArenaRun &) const = default;
};

/// A method that holds no needle, and why.
struct LeftOut {
    std::string method, because;

    bool operator==(const LeftOut &) const = default;
};

/// Methods that move under one needle, frame by frame. The reference is the static insertion of the needle study at the
/// same depths: between its records linear, at rest that of the plan, and after it is out of the body that of its end.
struct NeedleArena {
    double speed = 0.0;                          ///< of the hand [m/s]
    double rest = 0.0;                           ///< at the target [s]
    double mass_damping = 0.0;                   ///< alpha [1/s]
    double frame_interval = 0.0;                 ///< [s]
    int at_plan = 0;                             ///< record at which the hand has led the tip to the target
    std::vector<double> depth;                   ///< (K) as the hand leads the tip, at rest and after each frame [m]
    std::vector<double> reference_force;         ///< (K) [N]
    std::vector<core::Vector3> reference_target; ///< (K) [m]
    NeedleForces reference_forces;
    /// What the last refinement of its mesh changed these by; NaN of one that has no finer mesh.
    NeedleForces reference_changes{.peak = std::numeric_limits<double>::quiet_NaN(),
                                   .slope = std::numeric_limits<double>::quiet_NaN(),
                                   .pull = std::numeric_limits<double>::quiet_NaN()};
    std::vector<NeedleArenaRun> runs;
    std::vector<LeftOut> left_out;
};

} // namespace livermark::results
