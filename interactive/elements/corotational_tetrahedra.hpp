#pragma once

#include <memory>

#include "interactive/elements/energies/element_energy.hpp"
#include "interactive/elements/implicit_contact.hpp"
#include "interactive/kernels/corotational/corotational_rows.hpp"
#include "interactive/simulation.hpp"

namespace livermark::interactive {

/// One linearised step of backward Euler by conjugate gradients: with R of each tetrahedron and its forces f where the
/// step begins, and K the stiffness of linear elasticity, turned by R,
///     (m (1 + alpha h) + h^2 K) v = m v_n + h (f + f_ext),   x = x_n + h v.
/// An iteration is one of conjugate gradients, from v_n, with the inverse of the 3 x 3 block of each node as
/// preconditioner (block Jacobi). The state is what corotational_steps.hpp moves, and positions and velocities are that
/// state after each step. A ball that touches takes part as ImplicitContact, in up to five solutions of a step with so
/// many iterations each: nothing is factorised.
class CorotationalTetrahedra : public Simulation {
  public:
    explicit CorotationalTetrahedra(Scene given);

    void step(double time_step, int iterations) override;
    bool touch(const std::shared_ptr<core::BallContact> &ball) override;
    void set_state(const Field &positions, const Field &velocities) override;
    void set_external_forces(const Field &forces) override;
    const Energy &energy() const override { return energy_; }
    Cost cost(int iterations) const override;
    Orders orders() const override { return rows_.body.orders(); }

  private:
    void step_touched(double time_step, int iterations);
    void put_touched_into_rows();

    ElementEnergy<densities::Corotational> energy_;
    Field rest_;
    std::shared_ptr<core::BallContact> ball_;
    ImplicitContact contact_; ///< of the ball
    kernels::CorotationalRows rows_;
};

} // namespace livermark::interactive
