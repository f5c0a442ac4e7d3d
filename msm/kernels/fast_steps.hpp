#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/load_case.hpp"
#include "core/relaxation.hpp"
#include "msm/cutting/cut_parts.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/elastic_body.hpp"
#include "msm/integrator.hpp"

namespace livermark::msm {

struct StepParts;

/// In what precision forces are evaluated. The state has twice the digits of single precision, or double precision.
enum class ForcePrecision { single_precision, double_precision };

struct FastStepOptions {
    ForcePrecision precision = ForcePrecision::single_precision;
    int num_threads = 1;               ///< >= 1; the result does not depend on it
    int num_stages = usual_num_stages; ///< of runge_kutta_chebyshev
    MassScaling scaling{};             ///< of masses; known to symplectic_euler alone
    /// Part of a length, below which springs with means of C or F take their energies as there, so that they get
    /// no stiffer and explicit steps bear what is pressed flat or turned inside out; of means of volumes its square
    /// root. Above it nothing differs.
    double least_stretch = 0.0;
    /// Bound of each component of a velocity [m/s], of symplectic_euler: steps that are too long for a body as
    /// it is then do not add energy without end. Slower motion does not differ.
    double largest_speed = std::numeric_limits<double>::infinity();
    /// (M) volume of each tetrahedron that has a guard against inversion below which is_pressed() tells of it [m^3]; 0
    /// where it does not have to. Empty if nobody asks.
    std::vector<double> watched_volume{};
    bool may_be_cut = false; ///< keeps what cut() asks for, which no step does
    /// Fading of the stresses that a RelaxingTerm says do, springs' and coupled springs'; elastic if there are no
    /// moduli. Not of bodies that may be cut.
    core::PronySeries relaxation{};
    /// Error of a stress that fades, as a part of the largest one that there was: branches move once in as many steps
    /// as this allows, see RelaxationClock, or in every step where it is 0. Errors of a motion are smaller, of second
    /// order in that time.
    double relaxation_error = 5e-3;
};

/// Explicit steps at the machine's speed: those of elastic_motion() and an integrator, with forces from vector units.
/// Springs, springs coupled around nodes or edges (with an energy that are_in_kernels() knows, springs.hpp),
/// their dashpots, volume terms and the inversion guard are known; springs coupled both ways are not, nor volumes
/// around nodes other than those that springs are coupled in. Springs relax with a Prony series, coupled ones too, with
/// every integrator.
///
/// Single precision is that of positions within the body: 2^-24 of its size, and so about 1e-6 of the strain of a
/// spring for each 1 % of it.
class FastSteps {
  public:
    /// @return nothing if fast kernels do not know the integrator, a part of the body, or how to scale its masses
    /// @param positions   shape (N) [m], where the body is at rest
    /// @param time_step   h [s], > 0
    static std::optional<FastSteps> prepare(const ElasticBody &body, const std::vector<core::Vector3> &positions,
                                            const NodalConditions &conditions, const core::RayleighDamping &damping,
                                            const std::string &integrator, double time_step,
                                            const FastStepOptions &options = {});

    /// Goes on from another state; of constrained components it takes the displacement alone. Branches keep what they
    /// bear, but none from a state that is not finite.
    void set_state(const State &state);
    State state() const;

    /// Displacement of one node, as it is now [m].
    core::Vector3 displacement(int node) const;

    /// The same of its velocity [m/s].
    core::Vector3 velocity(int node) const;

    /// Changes displacement [m] and velocity [m/s] of a node between steps: what it touched, say. Constrained
    /// components stay as they are.
    void push(int node, const core::Vector3 &displacement, const core::Vector3 &velocity);

    /// Displacements of some nodes, as they are now [m]: displacement() of each, in one call.
    void displacements(std::span<const int> nodes, std::span<core::Vector3> found) const;

    /// Gives some nodes more velocity [m/s], and moves them on by as much in a step, as if a force had acted in the
    /// last one of symplectic Euler: push() of each, in one call.
    /// @param velocity   of each of the nodes
    /// @param time_step  h of the last step [s]
    void kick(std::span<const int> nodes, std::span<const core::Vector3> velocity, double time_step);

    /// Moves the constrained components of a node there [m]; what is free stays as it is.
    void set_displacement(int node, const core::Vector3 &displacement);

    /// Loads a node from now on, in place of what the conditions say [N].
    void set_load(int node, const core::Vector3 &force);

    /// Takes steps of this length from now on.
    /// @param time_step  h [s], > 0
    void set_time_step(double time_step);

    /// Gives a node another mass from now on; what is constrained stays so.
    /// @param mass  [kg], > 0
    void set_mass(int node, double mass);

    /// Goes on without the tetrahedra that have been taken away, from where the body is: to the bit as steps that are
    /// prepared for the parts as they are now. Nodes that are gone stay where they are.
    /// @param parts      as they are now; FastStepOptions::may_be_cut was set
    /// @param node_mass  shape (N) [kg]; 0 of nodes that are gone
    /// @return false if masses of a stiff part were scaled that has lost a tetrahedron at one of its nodes, and some of
    ///   these nodes are left: they are scaled no more, and steps have to be as long as those without, until
    ///   set_scaling()
    bool cut(const StepParts &parts, const std::vector<double> &node_mass, const CutChanges &changes);

    /// Goes on with nodes parted: tetrahedra have new nodes in the places of those before. New nodes are where their
    /// parents are and as fast, so momentum stays; they are constrained where these are, and the load of a node is
    /// shared by mass with what was parted from it. The motion is that of steps that are prepared for the parts as they
    /// are now, but for the order of sums. Steps take a little longer than these.
    /// @param parts      as they are now; FastStepOptions::may_be_cut was set
    /// @param node_mass  shape (N) [kg], new nodes included
    /// @return false if masses of a stiff part were scaled of which a node is parted; see cut()
    bool part(const StepParts &parts, const std::vector<double> &node_mass, const PartingChanges &changes);

    /// Scales the masses of these parts from now on, and those of no others; what set_mass() gave their nodes is
    /// forgotten there.
    /// @param scaling  as for prepare(), of the nodes that are left: see scale_masses()
    /// @return false, with nothing changed, if the integrator does not know how to scale masses
    bool set_scaling(const MassScaling &scaling);

    /// Whether, when the last step began, a tetrahedron was below the volume that is watched, or the trace of C^-1 of
    /// springs with means of C or F around a node or an edge above four; never if no volumes are watched.
    bool is_pressed() const;

    /// Takes that many steps.
    void take(int num_steps);

    /// Lets stresses fade as if the body stayed where it is for that long [s], which may be infinite. State and time do
    /// not change. What is set or pushed to another place gets its stress there within one step.
    void relax(double time);

    /// Number of steps between two moves of the branches; 1 if nothing relaxes.
    int steps_between_relaxations() const;

    /// Memory that every step reads or writes [bytes].
    std::size_t working_set() const;

  private:
    struct Implementation;
    explicit FastSteps(std::shared_ptr<Implementation> implementation) : implementation_(std::move(implementation)) {}
    std::shared_ptr<Implementation> implementation_;
};

} // namespace livermark::msm
