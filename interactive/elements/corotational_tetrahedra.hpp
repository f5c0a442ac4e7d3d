#pragma once

#include <array>
#include <memory>
#include <vector>

#include "core/tool/ball_contact.hpp"
#include "interactive/elements/energies.hpp"
#include "interactive/kernels/corotational_steps.hpp"
#include "interactive/method.hpp"

namespace livermark::interactive {

/// A ball that touches, as springs of the points of its facets that are solved for with all else in a linearised step:
/// the penalty 1 / c of core::BallContact along the normal, the same across it where a point sticks, and as much less
/// where it slips as the force of sticking is above the cone. Which points touch, and how much less that is, is what
/// the solution before has shown: solutions follow one another until forces are what these were found with. A slipping
/// point with a constant force in place of the secant sticks and slips in turn where steps are long. (active sets, P.
/// Wriggers, Computational Contact Mechanics, 2006, chapters 6 and 10; implicit penalty forces as in SOFA's
/// PenalityContactForceField)
class ImplicitContact {
  public:
    /// F(x) = force - stiffness (x - x_n) at x = sum of shape_k x_k, with x_n where the step begins.
    struct Point {
        std::array<int, 3> nodes{};
        std::array<double, 3> shape{};
        Matrix3 stiffness = Matrix3::Zero();          ///< [N/m], positive semi-definite
        core::Vector3 force = core::Vector3::Zero();  ///< [N]
        core::Vector3 start = core::Vector3::Zero();  ///< x_n [m]
        core::Vector3 before = core::Vector3::Zero(); ///< what the ball exerted in the step before [N]
        double compliance = 0.0;                      ///< c [m/N]
    };

    /// Begins a step.
    /// @param position  of a node: int -> Vector3 [m], here and below
    template <class Position> void begin(core::BallContact &ball, const Position &position) {
        step_ = ball.part(0, 1);
        points_.clear();
        has_solution_ = false;
        ball.visit_points([&](const std::array<int, 3> &nodes, const std::array<double, 3> &shape, double compliance,
                              const core::Vector3 &force) {
            Point point{.nodes = nodes, .shape = shape, .before = force, .compliance = compliance};
            point.start = at(point, position);
            points_.push_back(point);
        });
    }

    /// Takes from where a solution, or a guess before the first one, has brought the nodes what touches and slips.
    /// @return whether forces are others than those of the solution, by more than a hundredth of all
    template <class Position> bool linearise(const Position &position) {
        constexpr double steady = 0.01;
        double off = 0.0, all = 0.0;
        for (auto &point : points_) {
            const core::Vector3 now = at(point, position);
            const core::Vector3 solved = point.force - point.stiffness * (now - point.start);
            const core::Vector3 force = linearise_at(point, now);
            off += (force - solved).norm();
            all += force.norm();
        }
        const bool is_other = !has_solution_ || off > steady * all;
        has_solution_ = true;
        return is_other;
    }

    /// Ends the step with the forces where the nodes are.
    template <class Position> void finish(core::BallContact &ball, const Position &position) {
        std::size_t next = 0;
        ball.visit_points([&](const std::array<int, 3> &, const std::array<double, 3> &, double, core::Vector3 &force) {
            auto &point = points_[next++];
            force = linearise_at(point, at(point, position));
        });
    }

    const std::vector<Point> &points() const { return points_; }

  private:
    template <class Position> static core::Vector3 at(const Point &point, const Position &position) {
        core::Vector3 x = core::Vector3::Zero();
        for (std::size_t k = 0; k < 3; ++k)
            x += point.shape[k] * core::Vector3(position(point.nodes[k]));
        return x;
    }

    /// @return what the ball exerts there
    core::Vector3 linearise_at(Point &point, const core::Vector3 &x) const;

    core::BallStep step_;
    std::vector<Point> points_; ///< of the facets that the ball is near to
    bool has_solution_ = false; ///< whether points have been linearised in this step
};

/// One linearised step of backward Euler by conjugate gradients: with R of each tetrahedron and its forces f where the
/// step begins, and K the stiffness of linear elasticity, turned by R,
///     (m (1 + alpha h) + h^2 K) v = m v_n + h (f + f_ext),   x = x_n + h v.
/// An iteration is one of conjugate gradients, from v_n, with the inverse of the 3 x 3 block of each node as
/// preconditioner (block Jacobi). The state is what corotational_rows.hpp moves, and positions and velocities are that
/// state after each step. A ball that touches takes part as ImplicitContact, in up to five solutions of a step with so
/// many iterations each: nothing is factorised.
class CorotationalTetrahedra : public SimulationInRows {
  public:
    explicit CorotationalTetrahedra(Scene given);

    void step(double time_step, int iterations) override;
    bool touch(const std::shared_ptr<core::BallContact> &ball) override;
    const Energy &energy() const override { return energy_; }
    Cost cost(int iterations) const override { return cost_of(1.0 + iterations, rows_.bytes()); }
    Orders orders() const override { return rows_.body.orders(); }

  private:
    kernels::NodeRows &rows() override { return rows_.body; }
    void step_touched(double time_step, int iterations);
    void put_touched_into_rows();

    ElementEnergy<densities::Corotational> energy_;
    ImplicitContact contact_; ///< of the ball
    kernels::CorotationalRows rows_;
};

} // namespace livermark::interactive
