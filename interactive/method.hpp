#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <array>
#include <cstddef>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"
#include "core/problem.hpp"
#include "core/tool/ball_contact.hpp"
#include "core/tool/needle/moving_needle.hpp"
#include "interactive/kernels/orders.hpp"

namespace livermark::interactive {

/// Choices among many in the layout of a body: in which order nodes, tetrahedra and edges stand, and which of them are
/// visited at once. These choices take most of the time of a set-up. They stay good, if not best, when
/// tetrahedra go or are parted, so that a body that is cut keeps them. What a method does not use is empty.
struct Orders {
    std::vector<int> rows;               ///< (N) nodes as rows come
    kernels::FanList fans;               ///< each tetrahedron in one of them, as they stand side by side
    std::vector<int> tetrahedron_colour; ///< (M) no two of a colour share a node; -1 where it has none
    core::EdgeTable edges;               ///< core::edge_table(), where edges have colours
    std::vector<int> edge_colour;        ///< (S) the same of these edges
    std::vector<int> node_colour;        ///< (N) no two of a colour are in a tetrahedron
    /// (N) facets opposite a node as strips, whose triangles are numbers of tetrahedra; none where it is constrained
    std::vector<std::vector<kernels::StripNode>> strips;
    std::vector<int> factor; ///< free nodes in the order in which they are eliminated
};

/// One vector for each node, shape (3, N): positions [m], velocities [m/s] or forces [N].
using Field = Eigen::Matrix3Xd;

/// A node of a method's own that is constrained because it lies in the middle of two nodes that are.
struct Follower {
    int node;
    std::array<int, 2> ends; ///< places in Scene::constrained_nodes
};

/// A body that moves, and what moves it from outside. Its N nodes are those of the mesh, and behind them those that a
/// method adds for itself: from outside there are none.
struct Scene {
    std::shared_ptr<const core::Body> body; ///< linear tetrahedra, one material per region
    std::vector<double> node_mass;          ///< (N) [kg], > 0
    /// (C) nodes whose positions are set from outside, each once: what a tool has taken hold of, or what holds the
    /// body.
    std::vector<int> constrained_nodes;
    double mass_damping = 0.0;              ///< alpha [1/s], >= 0: forces -alpha m v
    std::vector<core::Vector3> own_nodes{}; ///< of a method, at rest [m]
    std::vector<Follower> followers{};      ///< own nodes that are constrained
    std::shared_ptr<const Orders> orders{}; ///< of the body, where they are known; null to find them
};

/// N, with those of the method.
int num_nodes(const Scene &scene);

/// Positions of the nodes at rest.
Field rest_positions(const Scene &scene);

/// The nodes whose positions are not set from outside.
/// @return shape (N)
std::vector<bool> free_nodes(const Scene &scene);

/// Puts the constrained nodes, and those that follow them, where they are to be.
/// @param targets  shape (3, C) [m]
/// @param x        shape (3, N)
void put_constrained(const Scene &scene, const Field &targets, Field &x);

/// Forces that hold the constrained nodes, so that all forces on them are in balance. What acts
/// on a follower is carried by its two ends.
/// @param forces  shape (3, N) [N]
/// @return shape (3, C) [N]
Field reactions_to(const Scene &scene, const Field &forces);

/// The elastic energy behind a method: what its static solution minimises.
class Energy {
  public:
    using Triplets = std::vector<Eigen::Triplet<double>>;

    Energy() = default;
    virtual ~Energy() = default;
    Energy(const Energy &) = delete;
    Energy &operator=(const Energy &) = delete;

    /// @param x  positions, here and below
    /// @return W(x) [J]; infinity where it is not defined, as in tetrahedra that are inside out
    virtual double value(const Field &x) const = 0;

    /// f -= dW/dx [N].
    virtual void add_forces(const Field &x, Field &f) const = 0;

    /// Adds d2W/dx2 [N/m], unknown 3 i + c for component c of node i, both triangles.
    /// @param is_projected  whether that of each element is made positive semidefinite
    virtual void add_hessian(const Field &x, bool is_projected, Triplets &triplets) const = 0;
};

/// Cost of a step of a method, independent of the machine.
struct Cost {
    double element_passes = 0.0;    ///< how often a step visits all its elements, for forces or what takes their place
    double bytes_per_element = 0.0; ///< that it stores of the body, over the number of tetrahedra
};

/// Changes of the velocities that an explicit step gives some nodes: by masses that are scaled, say.
class StepCorrection {
  public:
    StepCorrection() = default;
    virtual ~StepCorrection() = default;
    StepCorrection(const StepCorrection &) = delete;
    StepCorrection &operator=(const StepCorrection &) = delete;

    /// (n) of these nodes, those of a method's own among them
    virtual const std::vector<int> &nodes() const = 0;

    /// @param x       shape (3, n), where the step starts [m]
    /// @param before  shape (3, n), velocities there [m/s]
    /// @param change  shape (3, n), what forces other than damping change them by in the step; replaced [m/s]
    /// @param step    h [s]
    virtual void correct(const Field &x, const Field &before, double step, Field &change) = 0;
};

using core::AfterStep;

/// A method on a scene. It begins at rest. For one thread; the same steps give the same bits.
/// A method with nodes of its own has them in its scene(), and behind those of the mesh in positions and velocities.
class Simulation {
  public:
    /// @throws std::invalid_argument if the scene has masses of another number or sign, or nodes that it does not have
    explicit Simulation(Scene scene);
    virtual ~Simulation() = default;
    Simulation(const Simulation &) = delete;
    Simulation &operator=(const Simulation &) = delete;

    /// Prepares what steps of a length need, so that the first one does not take time for it.
    virtual void prepare(double /*time_step*/) {}

    /// Moves everything forward in time. The constrained nodes come to where they were told to be.
    /// @param time_step   h [s], > 0
    /// @param iterations  > 0; what one is, the method says
    virtual void step(double time_step, int iterations) = 0;

    /// Energy that the static solution minimises, together with the work of the external forces.
    virtual const Energy &energy() const = 0;

    virtual Cost cost(int iterations) const = 0;

    /// Orders in which its body is laid out: good for the same scene, and, as cut, for what a cut leaves of it. Those
    /// that take long to find.
    virtual Orders orders() const;

    /// The longest stable step of one iteration at rest [s].
    virtual double critical_time_step() const { return std::numeric_limits<double>::infinity(); }

    /// Corrects all steps to come. critical_time_step() stays that without it.
    /// @return whether the method takes explicit steps; nothing happens otherwise
    virtual bool correct_steps(const std::shared_ptr<StepCorrection> & /*correction*/) { return false; }

    /// Lets a ball touch the facets that it is near to, from the next step on. In each step it goes the way that it has
    /// been given (BallContact::set_way), and is told when the step has ended. Null for no ball.
    /// @return whether the method knows how; nothing happens otherwise
    virtual bool touch(const std::shared_ptr<core::BallContact> & /*ball*/) { return false; }

    /// Lets something act after each of all explicit steps to come; null for nothing.
    /// @return whether the method takes explicit steps; nothing happens otherwise
    virtual bool act_after_steps(const AfterStep & /*action*/) { return false; }

    /// Gives nodes more velocity, and moves them on by as much in a step, as if an impulse had acted in the last one:
    /// what a method has found out on its way stays.
    /// @param velocity   shape (3, N), zero where constrained [m/s]
    /// @param time_step  h of the last step [s]
    virtual void kick(const Field &velocity, double time_step);

    const Scene &scene() const { return scene_; }
    const Field &positions() const { return x_; }
    const Field &velocities() const { return v_; }
    const Field &external_forces() const { return external_; }
    /// shape (3, C) where the constrained nodes are to be at the end of the next step
    const Field &targets() const { return targets_; }

    /// Dead forces on the nodes [N], from the next step on. Shape (3, N), or those of the nodes of the mesh alone.
    virtual void set_external_forces(const Field &forces);
    /// Positions of the constrained nodes at the end of the next step. shape (3, C) [m]
    void set_targets(const Field &positions);
    /// Starts elsewhere. Both shape (3, N).
    virtual void set_state(const Field &positions, const Field &velocities);

    /// Forces that the method itself applies to the nodes at the end of the last step [N]; unless it says otherwise,
    /// the forces of its energy. shape (3, N)
    virtual Field elastic_forces() const;

    /// Forces that hold each constrained node against the elastic and external ones [N]: what a hand feels
    /// through a tool, but for the inertia of the nodes. shape (3, C)
    Field reactions() const;

  protected:
    Field &mutable_positions() { return x_; }
    Field &mutable_velocities() { return v_; }
    const std::vector<bool> &is_free() const { return is_free_; }
    void move_to_targets();

  private:
    Scene scene_;
    std::vector<bool> is_free_;
    Field x_, v_, external_, targets_;
};

/// The inertia that backward Euler minimises beside the elastic energy, as a spring of each node to where it would go
/// without it:
///     sum over the nodes of m (1 + alpha h) / (2 h^2) |x - y|^2,
///     y = x_n + (h v_n + h^2 f_ext / m) / (1 + alpha h),
/// with the new velocity v = (x - x_n) / h. Where the sum with W is least,
///     m (v - v_n) = h (f_ext - dW/dx - alpha m v).
struct Inertia {
    std::vector<double> stiffness; ///< (N) m (1 + alpha h) / h^2 [N/m]
    Field predicted;               ///< y, and the target where constrained, shape (3, N) [m]
};

/// @param time_step  h [s], > 0
Inertia inertia(const Simulation &simulation, double time_step);

/// A frame of a display, 60 times a second [s].
inline constexpr double frame_time = 1.0 / 60.0;

/// A deformable method. One file each in methods/, named as the method.
struct Method {
    std::string name{};            ///< the file stem; set by the table
    std::string summary;           ///< one line
    std::string source;            ///< literature reference
    std::string energy;            ///< the equation of the energy behind it
    std::string converges_to;      ///< one line: what a step comes to as iterations grow
    std::string objection;         ///< what its users or authors object to, each with a source; how to see it here
    std::string implementation;    ///< one line: how good it is, and its number format
    double time_step = frame_time; ///< where nothing else is asked for [s]
    int iterations = 10;           ///< in a step, where nothing else is asked for
    bool is_explicit = false;      ///< whether its steps can be corrected, and have a critical time step
    bool knows_contact = false;    ///< whether a ball can touch(), see Simulation
    /// Puts the method on a scene, at rest.
    std::function<std::unique_ptr<Simulation>(const Scene &)> prepare;
};

/// Every method of methods/, in alphabetical order.
std::span<const Method> all_methods();

/// @throws std::invalid_argument if there is none of that name
const Method &find_method(std::string_view name);

/// A body of a scene after a cut along facets: tetrahedra are gone, or have nodes of their own where they
/// had them with others. Corners keep their order.
struct SceneCut {
    std::shared_ptr<const core::Body> body;
    std::vector<double> node_mass;       ///< (N') [kg]
    std::vector<int> parent_tetrahedron; ///< (M') that each tetrahedron was before, no two the same
};

/// A method goes on with what a cut leaves of a moving body. Nodes have the positions and velocities that they had, or
/// that those had from which they were parted; copies of a constrained node are constrained, with its target; external
/// forces on a node are shared among its copies by their masses. So a cut that parts keeps the momentum, and one that
/// takes tetrahedra away that of what is left. The motion is that of a set-up of the cut body with this state; the
/// orders of the layout are those before, as far as the cut leaves them. A ball and a correction of steps have to be
/// given again, and steps prepared: prepare().
/// @param method  that of the simulation
/// @param before  a simulation of the body before; it can go on as well
/// @throws std::invalid_argument if a parent is none of the tetrahedra before, or there twice
std::unique_ptr<Simulation> continue_after_cut(const Method &method, const Simulation &before, const SceneCut &cut);

} // namespace livermark::interactive
