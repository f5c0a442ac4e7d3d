#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "interactive/elements/energies/element_energy.hpp"
#include "interactive/elements/implicit_contact.hpp"
#include "interactive/kernels/corotational/corotational_rows.hpp"
#include "interactive/simulation.hpp"

namespace livermark::interactive {

/// Of conjugate gradients.
enum class Preconditioner : std::uint8_t {
    none,  ///< in double precision alone, for comparison with programs that have none
    blocks ///< the inverse of the 3 x 3 block of each node (block Jacobi)
};

/// One linearised step of backward Euler by conjugate gradients: with R of each tetrahedron and its forces f where the
/// step begins, and K the stiffness of linear elasticity, turned by R,
///     (m (1 + alpha h) + h^2 K) v = m v_n + h (f + f_ext),   x = x_n + h v.
/// An iteration is one of conjugate gradients, from v_n. In single precision its state is what corotational_steps.hpp
/// moves, and positions and velocities are that state after each step. A ball that touches takes part as
/// ImplicitContact, in up to five solutions of a step with so many iterations each: nothing is factorised.
class CorotationalTetrahedra : public Simulation {
  public:
    CorotationalTetrahedra(Scene given, Preconditioner preconditioner);

    void step(double time_step, int iterations) override;
    bool touch(const std::shared_ptr<core::BallContact> &ball) override;
    void set_state(const Field &positions, const Field &velocities) override;
    void set_external_forces(const Field &forces) override;
    const Energy &energy() const override { return energy_; }
    Cost cost(int iterations) const override;
    Orders orders() const override;

  private:
    void step_in_single(double time_step, int iterations);
    void step_in_double(double time_step, int iterations);
    template <class Guess, class Solve> void step_touched(double time_step, const Guess &guess, const Solve &solve);
    void put_touched_into_rows();
    std::size_t num_tetrahedra() const { return energy_.tetrahedra().size(); }
    void multiply(const Field &v, double time_step, Field &product) const;
    void precondition_and_solve(double time_step, int iterations);
    void invert_blocks(double time_step);
    void precondition(const Field &residual, Field &result) const;
    void solve(Field &v, double time_step, int iterations);

    ElementEnergy<densities::Corotational> energy_;
    Preconditioner preconditioner_;
    Field rest_;
    std::shared_ptr<core::BallContact> ball_;
    ImplicitContact contact_;                       ///< of the ball
    std::optional<kernels::CorotationalRows> rows_; ///< in single precision; what follows is of double precision
    std::vector<Matrix3> rotations_;                ///< (M) where the step began
    std::vector<Matrix3> inverse_blocks_;           ///< (N) [1/kg]
    Field residual_, direction_, product_, preconditioned_;
};

} // namespace livermark::interactive
