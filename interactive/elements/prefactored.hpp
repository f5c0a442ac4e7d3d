#pragma once

#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "core/support/factors/sparse_cholesky.hpp"
#include "interactive/kernels/prefactored_steps.hpp"
#include "interactive/method.hpp"

namespace livermark::interactive {

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
    /// With the factor, once there is one.
    Cost cost(int iterations) const override { return cost_of(iterations, rows_.bytes()); }
    /// With that of the factor, once there is one.
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
    // Of the contact of a ball.
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
