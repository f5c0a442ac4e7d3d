#pragma once

#include <optional>
#include <vector>

#include "interactive/inertia.hpp"
#include "interactive/kernels/prefactored/prefactored_steps.hpp"
#include "support/factors/sparse_cholesky.hpp"

namespace livermark::interactive {

/// Backward Euler by iterations with one matrix for each of the three components, which is factorised once for a time
/// step: A = m (1 + alpha h) / h^2 + L with L constant, and
///     x <- x - A^-1 d(W + inertia)/dx.
/// With W the sum of w / 2 |G x - p(x)|^2 with p the nearest point of a set, and L the sum of w G^T G, that is local
/// projections followed by the global solve (A x = m / h^2 y + sum of w G^T p).
/// (Bouaziz, Martin, Liu, Kavan, Pauly 2014, ACM TOG 33(4), eq. 10; Liu, Bouaziz, Kavan 2017, ACM TOG 36(3), for the
/// iterations as above)
class Prefactored : public Simulation {
  public:
    explicit Prefactored(Scene given);

    /// Factorises, which takes longer than many steps.
    void prepare(double time_step) override;
    void step(double time_step, int iterations) override;
    void set_state(const Field &positions, const Field &velocities) override;
    void set_external_forces(const Field &forces) override;
    /// In single precision with the factor, once there is one.
    Cost cost(int iterations) const override;

  protected:
    /// Adds L, unknown i for node i, both triangles.
    virtual void add_laplacian(Energy::Triplets &triplets) const = 0;
    virtual std::size_t bytes_of_elements() const = 0; ///< in double precision, without the factor

    bool is_in_single_precision() const { return scene().precision == Precision::single_precision; }
    /// Steps go over these from now on.
    void use_vectors(kernels::PrefactoredElements elements);

  private:
    void step_in_double(double time_step, int iterations);
    void step_in_single(double time_step, int iterations);

    Field rest_;
    support::SparseCholesky factor_;
    double factorised_for_ = 0.0; ///< time step [s]
    std::vector<int> unknown_;    ///< (N) of a node, -1 where constrained
    int num_unknowns_ = 0;
    std::optional<kernels::PrefactoredRows> rows_; ///< in single precision
};

} // namespace livermark::interactive
