#pragma once

#include <array>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/load_case.hpp"
#include "core/mesh/places.hpp"
#include "core/tool/touching_tool.hpp"

/// A rigid ball or plate that moves and touches facets between point masses: contact without adhesion, with Coulomb
/// friction, for all methods that take steps of time.
namespace livermark::core {

/// The tool in a step: its centre goes straight from one place to the other.
struct BallStep {
    Vector3 from = Vector3::Zero(), to = Vector3::Zero(); ///< [m]
    ToolShape shape;
    double friction = 0.0; ///< mu, >= 0
};

/// Force of the tool on a point, N n + T with n of core::gap_to(), N >= 0 and |T| <= mu N: a step of
/// Gauss-Seidel from the force that it exerts so far. With the gap g of the point, s its way
/// relative to the tool's across n, N included, and C its compliance along these,
///     N = max(0, N' - (g + c N') / (C + c)),   T = T' - s / C, shortened to mu N.
/// Where forces stay as they are, the point is inside the tool by c N and sticks where the cone allows it. (Moreau
/// 1988, Unilateral contact and dry friction, section 5; Macklin et al. 2016, XPBD, MIG, section 4)
/// @param start       where the point was when the step began [m]
/// @param now         where it is, with what the force so far has displaced it by [m]
/// @param force       N' n' + T' [N]
/// @param yields      by how much forces on the point displace it in this step, symmetric and positive [m/N]
/// @param compliance  c of the contact [m/N], >= 0
Vector3 ball_force(const BallStep &ball, const Vector3 &start, const Vector3 &now, const Vector3 &force,
                   const Eigen::Matrix3d &yields, double compliance = 0.0);

/// Centre of a ball that presses, slides and lets go as a tool does: start, and parts of its press and of
/// the slide of the motion.
Vector3 ball_centre(const TouchingTool &ball, const ToolMotion &motion, double time);

/// Radius of what it touches then [m]: see ToolShape::contact_radius().
double circle_of_contact(const TouchingTool &ball, const ToolMotion &motion, double time);

/// A ball on its way, the facets that it may touch, and what it exerts at the points of their quadrature
/// (core::facet_points), each with the compliance 1 / (eps a) for its area a. Forces stay from step to step, so that a
/// body at rest feels those of its equilibrium. One for a body; for one thread.
class BallContact {
  public:
    /// @param facets     whose nodes may be constrained
    /// @param divisions  parts of a side of each
    BallContact(const std::vector<TouchedFacet> &facets, int divisions, const ToolShape &shape, double friction);

    /// Sets what the tool touches: compliances are those of core::FacetSoftness there. At first it touches nothing.
    /// @param circle  radius of it [m]
    void set_circle(double circle);

    /// Sets the way of the centre in the step or frame to come.
    void set_way(const Vector3 &from, const Vector3 &to);

    /// A part of that way: step s of 0 ... n - 1.
    BallStep part(int step, int num_steps) const;

    /// Chooses the facets that the ball may come to on its way: those within a quarter of its reach, and within twice
    /// what the nodes around have moved by since it was called before.
    /// @param position  of a node: int -> Vector3 [m]
    template <class Position> void look_around(const Position &position) {
        std::vector<Vector3> now;
        now.reserve(nodes_.size());
        for (const int node : nodes_)
            now.push_back(position(node));
        choose_near(std::move(now));
    }

    /// Nodes of all facets, ascending.
    const std::vector<int> &nodes() const { return nodes_; }
    /// Nodes of those that were chosen, ascending.
    const std::vector<int> &near() const { return near_nodes_; }

    /// Begins a step with what the ball exerted in the one before.
    /// @param give  (node, force [N])
    template <class Give> void begin_step(const Give &give) const {
        for (const int f : near_)
            if (facets_[f].is_pushed)
                for (std::size_t q = 0; q < points_.size(); ++q)
                    give_point(f, q, force_[number(f, q)], give);
    }

    /// One point after the other: ball_force(), and what that changes is given to the nodes.
    /// @param start     of a node: int -> Vector3, where it was when the step began [m]
    /// @param position  of a node, with all that was given: int -> Vector3 [m]
    /// @param yields    of a node, as ball_force() has it of a point: int -> Matrix3 [m/N]; zero where it cannot move.
    ///   Or of a point whose nodes displace each other: (nodes, shape functions) -> Matrix3
    /// @param give      (node, force [N])
    /// @return by how much forces on points have changed, over the sum of their sizes; 0 where there are none
    template <class Start, class Position, class Yields, class Give>
    double sweep(const BallStep &step, const Start &start, const Position &position, const Yields &yields,
                 const Give &give) {
        double changed = 0.0, all = 0.0;
        for (const int f : near_) {
            auto &facet = facets_[f];
            const auto &nodes = facet.touched.nodes;
            std::array<Vector3, 3> x{position(nodes[0]), position(nodes[1]), position(nodes[2])};
            if (!facet.is_pushed && is_beyond(step, x))
                continue;
            facet.is_pushed = false;
            for (std::size_t q = 0; q < points_.size(); ++q) {
                const auto &shape = points_[q].shape;
                auto &force = force_[number(f, q)];
                const Vector3 now = shape[0] * x[0] + shape[1] * x[1] + shape[2] * x[2];
                if (force.isZero(0.0) && is_outside(step.shape, now - step.to))
                    continue;
                const Vector3 before =
                    shape[0] * start(nodes[0]) + shape[1] * start(nodes[1]) + shape[2] * start(nodes[2]);
                const Vector3 next = ball_force(step, before, now, force, yields_of_point(yields, nodes, shape),
                                                facet.compliance / points_[q].part);
                changed += (next - force).norm();
                all += next.norm();
                give_point(f, q, next - force, give);
                force = next;
                facet.is_pushed = facet.is_pushed || !force.isZero(0.0);
                for (std::size_t k = 0; k < 3; ++k)
                    x[k] = position(nodes[k]);
            }
        }
        return all > 0.0 ? changed / all : changed;
    }

    /// For methods that solve for forces together with all else: calls for each point of the facets that were chosen.
    /// @param visit  (nodes of its facet, their shape functions, its compliance c [m/N], what the ball exerts on it
    /// [N],
    ///   which may be changed)
    template <class Visit> void visit_points(const Visit &visit) {
        for (const int f : near_) {
            auto &facet = facets_[f];
            facet.is_pushed = false;
            for (std::size_t q = 0; q < points_.size(); ++q) {
                auto &force = force_[number(f, q)];
                visit(facet.touched.nodes, points_[q].shape, facet.compliance / points_[q].part, force);
                facet.is_pushed = facet.is_pushed || !force.isZero(0.0);
            }
        }
    }

    /// Ends a step of a length [s].
    void end_step(double time_step) { impulse_ += time_step * force(); }

    /// Force on the body [N].
    Vector3 force() const;

    /// Impulse that it has given since this was called before [N s].
    Vector3 take_impulse();

  private:
    struct Facet {
        TouchedFacet touched;
        std::array<int, 3> places{}; ///< of its nodes in nodes_
        double compliance = 0.0;     ///< 1 / (eps A) [m/N]
        bool is_pushed = false;      ///< whether a point has a force
    };

    template <class Yields>
    static Eigen::Matrix3d yields_of_point(const Yields &yields, const std::array<int, 3> &nodes,
                                           const std::array<double, 3> &shape) {
        if constexpr (std::is_invocable_v<const Yields &, const std::array<int, 3> &, const std::array<double, 3> &>) {
            return yields(nodes, shape);
        } else {
            Eigen::Matrix3d point_yields = Eigen::Matrix3d::Zero();
            for (std::size_t k = 0; k < 3; ++k)
                point_yields += shape[k] * shape[k] * yields(nodes[k]);
            return point_yields;
        }
    }
    template <class Give> void give_point(int facet, std::size_t point, const Vector3 &force, const Give &give) const {
        for (std::size_t k = 0; k < 3; ++k)
            give(facets_[facet].touched.nodes[k], Vector3(points_[point].shape[k] * force));
    }
    std::size_t number(int facet, std::size_t point) const {
        return static_cast<std::size_t>(facet) * points_.size() + point;
    }
    static bool is_beyond(const BallStep &step, const std::array<Vector3, 3> &corners);
    void choose_near(std::vector<Vector3> now);

    std::vector<FacetPoint> points_; ///< of each facet
    std::vector<Facet> facets_;
    std::vector<Vector3> force_; ///< (facets, points) [N]
    std::vector<int> nodes_, near_, near_nodes_;
    std::vector<Vector3> before_; ///< of nodes_, when they were looked at; empty before
    Vector3 from_ = Vector3::Zero(), to_ = Vector3::Zero(), impulse_ = Vector3::Zero();
    ToolShape shape_;
    double friction_, circle_ = 0.0;
};

} // namespace livermark::core
