#pragma once

#include <Eigen/SparseCore>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "interactive/elements/energies.hpp"
#include "interactive/method.hpp"

namespace livermark::interactive {

/// A spring between two points of an element, beside the element: W = k / 2 (|d| - l)^2, where d = sum of w_a x_a goes
/// from one point to the other. A point is a node, with the weight 1 or -1, or is between nodes. All of its nodes are
/// those of one element: so it joins no nodes that the element does not join, and goes with the element in a cut.
struct PointSpring {
    std::vector<int> nodes;
    std::vector<double> weights; ///< w of each node; their sum is zero
    double rest_length;          ///< l [m], > 0
    double stiffness;            ///< k [N/m], > 0

    /// d, or its rate.
    core::Vector3 span(const Field &x) const {
        core::Vector3 sum = core::Vector3::Zero();
        for (std::size_t a = 0; a < nodes.size(); ++a)
            sum += weights[a] * x.col(nodes[a]);
        return sum;
    }
    StretchLaw law() const { return {stiffness, rest_length}; }
};

/// The capsule of a body as springs on the edges of its surface, with the stiffness of core::capsule_springs(). Where a
/// method has nodes of its own in the middle of edges, each facet is four.
/// @return empty where the body has none
std::vector<PointSpring> capsule_edges(const Scene &scene);

/// The vessels of a body as springs in tetrahedra: a fibre of the stretch s = F d has the energy weight / 2 (s - 1)^2
/// at a point of core::vessel_points(), which is that of a spring along the longest line in the tetrahedron that is
/// parallel to it, of the length l and with k = weight / l^2. Fibres that are parallel in a linear tetrahedron have one
/// stretch, so they are one spring between two points of its surface. In a quadratic tetrahedron each point has a
/// spring of ten nodes.
/// @return empty where the body has none
std::vector<PointSpring> vessel_fibres(const Scene &scene);

/// Both, of methods whose elements are no springs on edges themselves.
std::vector<PointSpring> capsule_and_vessels(const Scene &scene);

/// A spring at one of its nodes.
struct SpringEnd {
    std::size_t spring; ///< number
    std::size_t place;  ///< of the node among those of the spring
};

/// (N) the springs at each node, in their order.
std::vector<std::vector<SpringEnd>> springs_at_nodes(std::span<const PointSpring> springs, std::size_t num_nodes);

/// L of Prefactored: sum of k w_a w_b.
Energy::Triplets laplacian(const std::vector<PointSpring> &springs);
/// All entries of both.
Energy::Triplets sum_of(Energy::Triplets elements, const Energy::Triplets &springs);

/// W = sum of those of springs.
class PointSpringEnergy : public Energy {
  public:
    explicit PointSpringEnergy(std::vector<PointSpring> springs) : springs_(std::move(springs)) {}

    double value(const Field &x) const override;
    void add_forces(const Field &x, Field &f) const override;
    void add_hessian(const Field &x, bool is_projected, Triplets &triplets) const override;

    const std::vector<PointSpring> &springs() const { return springs_; }

  private:
    std::vector<PointSpring> springs_;
};

/// The energy of elements, and that of springs beside them.
template <class Elements> class WithSprings : public Elements {
  public:
    template <class... Arguments>
    explicit WithSprings(std::vector<PointSpring> springs, Arguments &&...of_elements)
        : Elements(std::forward<Arguments>(of_elements)...), beside_(std::move(springs)) {}

    double value(const Field &x) const override { return Elements::value(x) + beside_.value(x); }
    void add_forces(const Field &x, Field &f) const override {
        Elements::add_forces(x, f);
        beside_.add_forces(x, f);
    }
    void add_hessian(const Field &x, bool is_projected, Energy::Triplets &triplets) const override {
        Elements::add_hessian(x, is_projected, triplets);
        beside_.add_hessian(x, is_projected, triplets);
    }

    const std::vector<PointSpring> &point_springs() const { return beside_.springs(); }

  private:
    PointSpringEnergy beside_;
};

/// The energy of a body, and that of the springs of a foundation below it: 1/2 u . K u with u = x - X, which is
/// quadratic on a facet where a method has nodes of its own in the middle of edges, and otherwise linear.
class OnFoundation : public Energy {
  public:
    /// @param body  stays the owner's
    OnFoundation(const Energy &body, const Scene &scene, const core::Foundation &foundation);

    double value(const Field &x) const override;
    void add_forces(const Field &x, Field &f) const override;
    void add_hessian(const Field &x, bool is_projected, Triplets &triplets) const override;

  private:
    const Energy &body_;
    Field rest_;                            // shape (3, N) X [m]
    Eigen::SparseMatrix<double> stiffness_; // shape (3 N, 3 N) K [N/m]
};

} // namespace livermark::interactive
