#pragma once

#include <utility>
#include <vector>

#include "core/load_case.hpp"

/// A rigid ball that moves and touches point masses: contact without adhesion, with Coulomb friction, for all methods
/// that take steps of time.
namespace livermark::core {

/// The ball in a step: its centre goes straight from one place to the other.
struct BallStep {
    Vector3 from = Vector3::Zero(), to = Vector3::Zero(); ///< [m]
    double radius = 0.0;                                  ///< R [m], > 0
    double friction = 0.0;                                ///< mu, >= 0
};

/// What the ball displaces a point by in a step, in all: N n + T, with n from the centre to the point, N >= 0 and
/// |T| <= mu N. Where that is more than nothing and the cone allows, the point ends on the ball and has moved along it
/// by nothing: with d its distance from the centre and s its way relative to the ball's,
///     N = max(0, n . pushed + R - d),   T = the part of pushed - s across n, shortened to mu N.
/// An explicit step calls it once. Iterations call it with what they have displaced the point by so far, and may take
/// some of that back: a projected Gauss-Seidel step of the conditions of contact with a mass that is the same in all
/// directions. (Moreau 1988, Unilateral contact and dry friction, section 5; Macklin et al. 2016, MIG, section 4)
/// @param start   where the point was when the step began [m]
/// @param now     where it is, with what it has been displaced by [m]
/// @param pushed  by which it has been displaced in this step so far [m]
Vector3 ball_push(const BallStep &ball, const Vector3 &start, const Vector3 &now,
                  const Vector3 &pushed = Vector3::Zero());

/// Where a node comes to rest, and what the ball exerts on it there.
struct NodeUnderBall {
    Vector3 position = Vector3::Zero(); ///< [m]
    Vector3 force = Vector3::Zero();    ///< N n + T [N], zero where it does not touch
};

/// The same for a step that minimises: what moves the node is K (m - x) at x, and n is that at the place where it is.
/// Where m is inside the ball the node ends in the plane n . (x - c) = R, so outside of the ball, and on it once
/// iterations have converged.
/// @param minimum    m, where the node would go without the ball [m]
/// @param stiffness  K, symmetric and positive definite [N/m]
NodeUnderBall rest_under_ball(const BallStep &ball, const Vector3 &start, const Vector3 &now, const Vector3 &minimum,
                              const Eigen::Matrix3d &stiffness);

/// Where the centre of a ball is that presses, slides and lets go as a tool does: start, and parts of its press and of
/// the slide of the motion.
Vector3 ball_centre(const TouchingTool &ball, const ToolMotion &motion, double time);

/// A ball on its way, the nodes that it may touch, and what it gives them. One for a body; for one thread.
class BallContact {
  public:
    /// @param nodes  of a surface, those that can move
    BallContact(std::vector<int> nodes, double radius, double friction);

    /// Where the centre goes in the step or frame to come.
    void set_way(const Vector3 &from, const Vector3 &to);

    /// A part of that way: step s of 0 ... n - 1.
    BallStep part(int step, int num_steps) const;

    /// Chooses the nodes that the ball may come to on its way: those within a quarter of its radius, and within twice
    /// what the nodes around have moved by since it was called before.
    /// @param position  of a node: int -> Vector3 [m]
    template <class Position> void look_around(const Position &position) {
        std::vector<Vector3> now;
        now.reserve(nodes_.size());
        for (const int node : nodes_)
            now.push_back(position(node));
        choose_near(std::move(now));
    }

    /// All that it may ever touch.
    const std::vector<int> &nodes() const { return nodes_; }
    /// Those of them that were chosen.
    const std::vector<int> &near() const { return near_; }

    /// Adds what nodes are given [N s].
    void add_impulse(const Vector3 &impulse) { impulse_ += impulse; }

    /// What the ball has given since this was called before [N s].
    Vector3 take_impulse();

  private:
    void choose_near(std::vector<Vector3> now);

    std::vector<int> nodes_, near_;
    std::vector<Vector3> before_; ///< of nodes_, when they were looked at; empty before
    Vector3 from_ = Vector3::Zero(), to_ = Vector3::Zero(), impulse_ = Vector3::Zero();
    double radius_, friction_;
};

/// Nodes of facets that the ball of a load case may touch, but for those of facets that it may not: ascending.
std::vector<int> touchable_nodes(const TetraMesh &mesh, const LoadCase &load_case);

} // namespace livermark::core
