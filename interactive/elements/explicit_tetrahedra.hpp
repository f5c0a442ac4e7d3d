#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "interactive/elements/energies.hpp"
#include "interactive/kernels/explicit_steps.hpp"
#include "interactive/method.hpp"
#include "interactive/scene.hpp"

namespace livermark::interactive {

/// The longest stable step of central differences at rest, 2 / omega with omega the highest angular frequency of
/// K phi = omega^2 M phi, K the second derivative of the energy, where what is constrained stays: Lanczos's method on
/// differences of forces, without a matrix, to a ten thousandth of omega^2. The same scene gives the same bits.
/// @return [s]; infinity if nothing can move
/// @throws std::runtime_error if the iteration does not converge
double critical_time_step(const Energy &energy, const Scene &scene);

/// A bound on it from below, without an iteration: 2 / omega with omega the highest angular frequency that any
/// tetrahedron has with its own share of the masses. (Irons, Treharne 1971; Belytschko, Liu, Moran 2000, Nonlinear
/// Finite Elements for Continua and Structures, 6.2.4)
/// @param node_mass  shape (N) [kg]; each tetrahedron's share goes by its volume
/// @return [s]
double critical_time_step_bound(const std::vector<Tetrahedron> &tetrahedra, const std::vector<double> &node_mass);

/// Explicit steps of neo-Hookean tetrahedra, linear or those of quadratic_scene(). An iteration is one step of central
/// differences, h = time step over iterations, with velocities half a step behind:
///     v = ((1 - alpha h / 2) v + h (f + f_ext) / m) / (1 + alpha h / 2),   x += h v.
/// Constrained nodes go to their targets in equal parts. Longer steps than critical_time_step() blow up. What a ball
/// that touches exerts takes part in the step. What acts after a step is given the nodes of the mesh alone. The state
/// is what explicit_steps.hpp moves, and positions and velocities are that state after each step.
/// (Belytschko, Liu, Moran 2000, Nonlinear Finite Elements for Continua and Structures, box 6.1 and section 10.7)
class ExplicitTetrahedra : public SimulationInRows {
  public:
    ExplicitTetrahedra(Scene given, kernels::Pressure pressure);

    void step(double time_step, int iterations) override;
    /// Found when it is asked for.
    double critical_time_step() const override;
    bool correct_steps(const std::shared_ptr<StepCorrection> &correction) override;
    bool act_after_steps(const AfterStep &action) override;
    Cost cost(int iterations) const override;
    Orders orders() const override { return rows_.orders(); }

  private:
    kernels::NodeRows &rows() override { return rows_; }
    void take_corrected_step(double h);
    void push_out(const core::BallStep &step, double h);

    kernels::Pressure pressure_;
    kernels::ExplicitRows rows_;
    std::shared_ptr<StepCorrection> correction_; ///< null if there is none
    AfterStep after_step_;
    mutable std::optional<double> critical_time_step_;
};

} // namespace livermark::interactive
