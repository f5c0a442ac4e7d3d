#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <array>
#include <memory>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"
#include "core/problem.hpp"
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

} // namespace livermark::interactive
