#pragma once

#include <vector>

#include "interactive/inertia.hpp"
#include "support/sparse_cholesky.hpp"

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
    using Simulation::Simulation;

    void step(double time_step, int iterations) override;

  protected:
    /// Adds L, unknown i for node i, both triangles.
    virtual void add_laplacian(Energy::Triplets &triplets) const = 0;

  private:
    void factorise(const Inertia &terms, double time_step);

    support::SparseCholesky factor_;
    double factorised_for_ = 0.0; ///< time step [s]
    std::vector<int> unknown_;    ///< (N) of a node, -1 where constrained
    int num_unknowns_ = 0;
};

} // namespace livermark::interactive
