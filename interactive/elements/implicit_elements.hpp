#pragma once

#include <array>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "core/support/factors/sparse_cholesky.hpp"
#include "core/tool/ball_contact.hpp"
#include "interactive/elements/energies.hpp"
#include "interactive/elements/point_springs.hpp"
#include "interactive/kernels/method_steps.hpp"
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
/// Springs beside the tetrahedra add their forces, and their stiffness but for what is negative, across a spring that
/// is pressed. (Choi, Ko 2002, Stable but responsive cloth, SIGGRAPH)
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

    WithSprings<ElementEnergy<densities::Corotational>> energy_;
    ImplicitContact contact_; ///< of the ball
    kernels::CorotationalRows rows_;
};

/// Backward Euler by iterations with one matrix for each of the three components, which is factorised once for a time
/// step: A = m (1 + alpha h) / h^2 + L with L constant, and
///     x <- x - A^-1 d(W + inertia)/dx.
/// With W the sum of w / 2 |G x - p(x)|^2 with p the nearest point of a set, and L the sum of w G^T G, that is local
/// projections followed by the global solve (A x = m / h^2 y + sum of w G^T p).
/// (Bouaziz, Martin, Liu, Kavan, Pauly 2014, ACM TOG 33(4), eq. 10; Liu, Bouaziz, Kavan 2017, ACM TOG 36(3), for the
/// iterations as above)
///
/// A ball that touches is met after each iteration, by forces f that take part in the next one. The factor knows
/// nothing of them: what a force on a node moves is a column of A^-1, found when the ball first comes near the node, so
/// that contact is solved on the nodes near the ball alone, by Gauss and Seidel's sweeps over its points with the
/// compliance N (A^-1) N^T, and all nodes follow. (constraint correction with a precomputed compliance, Saupin, Duriez,
/// Cotin, Grisoni 2008, Efficient contact modeling using compliance warping, CGI, without the warping, because A does
/// not turn)
class Prefactored : public SimulationInRows {
  public:
    /// @param energy     W
    /// @param laplacian  gives L when it is to be factorised: unknown i for node i, both triangles
    /// @param elements   gives those of the scene
    Prefactored(Scene given, std::unique_ptr<Energy> energy, std::function<Energy::Triplets()> laplacian,
                const std::function<kernels::PrefactoredElements(const Scene &)> &elements)
        : SimulationInRows(std::move(given)), energy_(std::move(energy)), laplacian_(std::move(laplacian)),
          rows_(elements(scene())) {}

    /// Factorises, which takes longer than many steps.
    void prepare(double time_step) override;
    void step(double time_step, int iterations) override;
    bool touch(const std::shared_ptr<core::BallContact> &ball) override;
    /// Cost with the factor, once there is one.
    Cost cost(int iterations) const override { return cost_of(iterations, rows_.bytes()); }
    /// Orders with that of the factor, once there is one.
    Orders orders() const override;
    const Energy &energy() const override { return *energy_; }

  private:
    kernels::NodeRows &rows() override { return rows_.nodes(); }
    std::vector<int> order_of_unknowns() const;
    void find_columns();
    void touch_nodes();
    void touch_rows();

    std::unique_ptr<Energy> energy_;
    std::function<Energy::Triplets()> laplacian_;
    kernels::PrefactoredRows rows_;
    support::SparseCholesky factor_;
    double factorised_for_ = 0.0; ///< time step [s]
    std::vector<int> unknown_;    ///< (N) of a node, -1 where constrained
    int num_unknowns_ = 0;
    // Members for the contact of a ball.
    std::vector<Eigen::VectorXd> columns_;      ///< (N) of A^-1 [m/N], empty where the ball was never near
    std::vector<core::Vector3> forces_;         ///< (N) of the ball on the nodes in this step [N]
    std::vector<core::Vector3> near_predicted_; ///< (near) where they would go without the ball and elasticity [m]
    std::vector<double> stiffness_;             ///< (N) of inertia [N/m]
    bool has_touched_ = false;                  ///< in this step
};

/// L of springs, and of tetrahedra with densities::Projective.
Energy::Triplets laplacian(const Springs &springs);
Energy::Triplets laplacian(const std::vector<Tetrahedron> &tetrahedra);

} // namespace livermark::interactive
