#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <span>
#include <stdexcept>
#include <vector>

#include "core/problem.hpp"
#include "core/tool/ball_contact.hpp"
#include "core/tool/needle/moving_needle.hpp"

/// Bodies that move in steps of time: springs and interactive methods, whatever acts on them.
namespace livermark::core {

/// Work of a method in a frame: steps of equal length, and iterations in each.
struct Effort {
    int steps = 1;
    int iterations = 1;
};

/// Cost of a frame, independent of the machine.
struct FrameCost {
    double element_passes = 0.0;    ///< how often all elements are visited for forces, or what takes their place
    double bytes_per_element = 0.0; ///< that are stored of the body, over the number of tetrahedra
};

/// A load case as a model with point masses sees it.
struct NodalConditions {
    std::vector<Vector3> displacement;          ///< (N) prescribed displacement [m], NaN where a component is free
    std::vector<std::array<int, 3>> constraint; ///< (N,3) index into LoadCase::constraint_names, -1 where free
    std::vector<Vector3> force;                 ///< (N) load [N]; where a place presses, for one newton of it [1]
    double press_depth = 0.0;                   ///< LoadCase::press_depth [m]

    /// Whether a node has a prescribed displacement in all components.
    bool constrains(std::size_t node) const { return !displacement[node].array().isNaN().any(); }
};

/// A body under constant loads as methods with point masses see it.
struct NodalProblem {
    std::shared_ptr<const Body> body;
    std::vector<double> node_mass; ///< (N) [kg]
    NodalConditions conditions;
};

/// A body that moves in steps, from rest. For one thread; the same calls give the same bits.
class Stepper : public MovingNodes {
  public:
    /// Prepares steps of a length, so that the first one does not take time for it.
    virtual void prepare(double time_step) = 0;

    /// Moves on by a step of the length that was prepared. Held nodes come to where they were led.
    /// @param iterations  > 0; of explicit interactive methods, steps of equal length that it is divided into
    virtual void step(double time_step, int iterations) = 0;

    /// Longest stable step at rest [s], of one iteration where steps are divided into these; infinity where every step
    /// is stable.
    virtual double critical_time_step() const = 0;

    /// Whether an explicit step is divided into iterations.
    virtual bool counts_iterations() const = 0;

    /// Leads held nodes: they are there when the next step ends.
    /// @param displacement  of each [m]
    virtual void lead(std::span<const int> nodes, std::span<const Vector3> displacement) = 0;

    /// Holds other nodes from now on; they stay where they are. What has to be prepared for that is prepared here.
    virtual void hold(const NodalConditions &conditions) = 0;

    /// Goes on with what a cut along facets has left: each node is where it was, or where that was from which it was
    /// parted, and as fast. The next step is prepared. Known to steppers that may be cut.
    /// @param after               the same loads on the body that is left
    /// @param parent_tetrahedron  (M') number before the cut of each tetrahedron
    virtual void cut(const NodalProblem &after, const std::vector<int> &parent_tetrahedron) = 0;

    /// Facets that a ball may touch, with the softness of the method: those of the mesh, or parts of them where it has
    /// nodes in between.
    virtual std::vector<TouchedFacet> touched_facets(std::vector<TouchedFacet> facets) const { return facets; }

    /// Lets a ball touch the body from the next step on; null for none.
    /// @throws std::logic_error if the method knows no contact
    virtual void touch(std::shared_ptr<BallContact> ball) = 0;

    /// Lets something act after each explicit step to come; null for nothing. Implicit steps know no such action.
    virtual void act_after_steps(AfterStep action) = 0;

    /// Position of a node now [m].
    virtual Vector3 position(int node) const = 0;

    /// Displacements of all nodes of the mesh, shape (N) [m].
    virtual std::vector<Vector3> displacement() const = 0;

    /// Starts from these displacements, at rest. shape (N) [m]
    virtual void start_from(const std::vector<Vector3> &displacement) = 0;

    /// Goes on from where another body of the same method and problem is, with its loads.
    virtual void take_motion_of(const Stepper &other) = 0;

    /// Elastic force of the body on whatever holds these nodes [N].
    virtual Vector3 elastic_force(std::span<const int> held) const = 0;

    /// Inverse masses of the nodes [1/kg], shape (N); zero where nothing moves.
    virtual std::vector<double> per_mass() const = 0;

    /// Cost of a frame.
    virtual FrameCost cost(const Effort &effort) const = 0;

    /// Response of implicit steps to impulses on places, converged (interactive::place_response) and as a frame of this
    /// effort gives it (interactive::observed_place_response).
    /// @param frame  [s]
    /// @return shape (3 N, 3 K) [1/kg]
    /// @throws std::logic_error of explicit steps, which respond by their masses: per_mass()
    virtual Eigen::MatrixXf converged_response(const PlaceWeights & /*weights*/, double /*frame*/) const {
        throw std::logic_error("explicit steps respond by their masses");
    }
    virtual Eigen::MatrixXf observed_response(const PlaceWeights & /*weights*/, double /*frame*/,
                                              const Effort & /*effort*/, double /*force*/) const {
        throw std::logic_error("explicit steps respond by their masses");
    }

    /// Loads some nodes from the next step on [N], and those no more that were loaded before.
    virtual void load(std::span<const int> nodes, std::span<const Vector3> force) = 0;
};

} // namespace livermark::core
