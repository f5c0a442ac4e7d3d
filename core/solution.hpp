#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"

namespace livermark::core {

enum class SolutionStatus { ok, diverged, not_converged };

/// The word for a status in tables and result files.
const char *to_string(SolutionStatus status);

/// Point masses joined by central springs.
struct SpringNetwork {
    std::vector<double> node_mass;         ///< (N) [kg]
    std::vector<std::array<int, 2>> edges; ///< (S) node numbers
    std::vector<double> stiffness;         ///< (S) [N/m]
    std::vector<double> rest_length;       ///< (S) [m]
};

/// Distance of a motion from that of ever finer meshes, as a model has observed it itself; see observed_motion_error().
struct ObservedMotionError {
    double order = 0.0;       ///< of convergence, from one refinement to the next
    double difference = 0.0;  ///< HistoryComparison::relative_l2 between the last two meshes
    double relative_l2 = 0.0; ///< estimated error of the motion of the probes, in the same norm

    bool operator==(const ObservedMotionError &) const = default;
};

/// Solution of a time-dependent load case: the motion of its probes. A record is made at t = 0 and after
/// each output interval, K in all.
struct History {
    std::vector<double> time;           ///< (K) [s]
    std::vector<Vector3> displacement;  ///< (K, Q) of each probe [m], all probes of one time behind each other
    std::vector<double> kinetic_energy; ///< (K) [J]
    std::vector<double> strain_energy;  ///< (K) [J]
    std::string integrator{};           ///< the rule that took the steps
    std::string kernel{};               ///< what evaluated the forces; empty where there is but one
    int forces_per_step = 0;            ///< evaluations of the forces in a step; 0 where a step solves equations
    double time_step = 0.0;             ///< of its steps; the records may be further apart [s]
    /// The longest step that would be stable [s]; infinity where every one is.
    double critical_time_step = std::numeric_limits<double>::infinity();
    /// When the motion left all bounds [s], NaN if it did not. The records from then on are NaN.
    double diverged_at = std::numeric_limits<double>::quiet_NaN();
    double setup_seconds = 0.0; ///< all that precedes the first step, or its space, and is not in those of the Solution
    double solve_seconds = 0.0; ///< the steps, and the space that they are taken in if it is not that of all unknowns
    /// (F, N) displacement of all nodes [m], frame after frame, for pictures: see Release::is_frame(). Single
    /// precision. Empty where only the probes were kept.
    std::vector<Eigen::Vector3f> frames{};
    std::optional<ObservedMotionError> observed_error{}; ///< of models that refine the mesh, or else their steps alone
};

/// Distance of a solution from that of ever finer meshes, as a model has observed it itself; see observed_error().
struct ObservedError {
    double order = 0.0;       ///< of convergence, from one refinement to the next
    double difference = 0.0;  ///< Comparison::relative_l2 between the last two meshes
    double relative_l2 = 0.0; ///< estimated error of the displacement, in the norm of core::Comparison
    double energy = 0.0;      ///< estimated, of the strain energy, relative, not signed
    double reaction = 0.0;    ///< estimated, of the reactions, as in core::Comparison
    /// Point of the path at which it was observed, in parts of the load: below 1 where finer meshes have no solution to
    /// the whole of it.
    double load_fraction = 1.0;
    /// Estimated, of the stiffness at the tool, as in core::ToolComparison, not signed; nothing without a tool.
    std::optional<double> stiffness{};

    bool operator==(const ObservedError &) const = default;
};

/// State of a body at a part of the load, on the way to the whole; or at a time of a slow history.
struct PathPoint {
    std::vector<Eigen::Vector3f> displacement; ///< (N) of all nodes [m], for pictures: single precision
    std::vector<Vector3> reaction;             ///< (P) force of each constraint on the body [N]
    double strain_energy = 0.0;                ///< [J]; of a body that relaxes what it stores, its branches included
    /// Only where time passes in the material: what all that drives the body has done so far, by the trapezoidal rule
    /// over the records, and what became heat [J]. NaN where the model does not say it.
    double work = std::numeric_limits<double>::quiet_NaN();
    double dissipated_energy = std::numeric_limits<double>::quiet_NaN();
};

/// Cost of explicit time stepping of a model: symplectic Euler without damping.
struct ExplicitSteps {
    /// The longest step that is stable [s]; infinity where nothing moves.
    double critical_time_step = std::numeric_limits<double>::infinity();
    double seconds_per_step = 0.0; ///< that one takes, on one core
    std::string kernel{};          ///< what evaluated the forces
};

/// Solution of a problem, in the numbering of the mesh file. To a time-dependent load case that is the
/// static start, and the history if the model can move in time.
struct Solution {
    SolutionStatus status = SolutionStatus::ok;
    std::string message;               ///< why the status is not ok
    std::vector<Vector3> displacement; ///< (N) [m]
    std::vector<Vector3> reaction; ///< (P) force of each constraint on the body [N], as in LoadCase::constraint_names
    double strain_energy = 0.0;    ///< [J]
    /// The integral of t . u over all given tractions t, with the model's own shape functions [J]. NaN where the model
    /// does not say it; of one that has no nodes but those of the mesh it is the sum of its nodal forces times u there.
    double load_work = std::numeric_limits<double>::quiet_NaN();
    /// |u - u_lin| / |u| with u_lin the solution of the linearised model; NaN for a linear model.
    double nonlinearity = std::numeric_limits<double>::quiet_NaN();
    std::int64_t degrees_of_freedom = 0;         ///< unknowns, constrained ones included
    double setup_seconds = 0.0;                  ///< all that needs no loads: parameters, assembly, first factorisation
    double solve_seconds = 0.0;                  ///< the rest; an equal part, where several were solved together
    std::string solver;                          ///< how its linear systems were solved; empty where nobody says
    std::optional<SpringNetwork> springs;        ///< what the springs were, for mass-spring models
    std::optional<ExplicitSteps> explicit_steps; ///< of models that move in explicit steps
    std::optional<History> history;              ///< only for time-dependent load cases
    std::optional<ObservedError> observed_error; ///< of models that refine the mesh
    /// At LoadCase::path, or at the times of LoadCase::slow_history; fewer where the way ended early.
    std::vector<PathPoint> path;
};

/// Undamped free vibrations of a constrained body, K phi = omega^2 M phi, the lowest first.
struct Modes {
    std::vector<double> angular_frequency; ///< (C) omega [rad/s], ascending
    std::vector<Vector3> shape;            ///< (C, N) phi at the mesh nodes [kg^-1/2], scaled so that phi^T M phi = 1
    std::int64_t degrees_of_freedom = 0;   ///< unknowns, constrained ones included
    double seconds = 0.0;                  ///< for all of it, from the mesh to the modes

    int count() const { return static_cast<int>(angular_frequency.size()); }

    /// (N) the shape of one mode
    std::span<const Vector3> shape_of(int mode) const {
        const auto num_nodes = shape.size() / angular_frequency.size();
        return std::span(shape).subspan(mode * num_nodes, num_nodes);
    }
};

/// Compliance of a body at rest, inside: C, the displacement of each of K places for one newton on each, linearised.
/// Component i of place k has number 3 k + i.
struct Compliance {
    Eigen::MatrixXd matrix;                  ///< C, shape (3 K, 3 K) [m/N], symmetric but for what solvers leave
    std::vector<Eigen::MatrixXd> on_coarser; ///< the same of the meshes before, of models that refine; coarsest first
    std::int64_t degrees_of_freedom = 0;     ///< unknowns, constrained ones included
    double seconds = 0.0;                    ///< for all of it
};

} // namespace livermark::core
