#pragma once

#include <optional>

#include "interactive/elements/central_differences.hpp"
#include "interactive/kernels/explicit_rows.hpp"

namespace livermark::interactive {

/// CentralDifferences of neo-Hookean tetrahedra, linear or those of quadratic_scene(), in the precision of the scene.
/// In single precision its state is what explicit_steps.hpp moves, and positions and velocities are that state after
/// each step.
class ExplicitTetrahedra : public CentralDifferences {
  public:
    ExplicitTetrahedra(Scene given, kernels::Pressure pressure);

    void step(double time_step, int iterations) override;
    void set_state(const Field &positions, const Field &velocities) override;
    void set_external_forces(const Field &forces) override;
    Cost cost(int iterations) const override;
    Orders orders() const override;

  private:
    void take_corrected_step(double h);
    void push_rows_out(const core::BallStep &step, double h);
    void act_on_rows(double part, double h);

    kernels::Pressure pressure_;
    Field rest_;
    std::optional<kernels::ExplicitRows> rows_; ///< in single precision
};

} // namespace livermark::interactive
