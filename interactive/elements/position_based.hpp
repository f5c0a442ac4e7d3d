#pragma once

#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "interactive/kernels/position_rows.hpp"
#include "interactive/simulation.hpp"

namespace livermark::interactive {

/// Steps of extended position-based dynamics: nodes go to where they would without elasticity, iterations over all
/// constraints move them from there, and velocities follow from positions. A method says what its
/// constraints are. A ball that touches is a constraint at each point of the facets that
/// it is near to, after all others in each iteration: see core::BallContact.
class PositionBased : public Simulation {
  public:
    explicit PositionBased(Scene given);

    void step(double time_step, int iterations) override;
    void set_state(const Field &positions, const Field &velocities) override;
    void set_external_forces(const Field &forces) override;
    void kick(const Field &velocity, double time_step) override;
    bool touch(const std::shared_ptr<core::BallContact> &ball) override;

    /// Those of the multipliers, as far as iterations have come: what a program would send to a haptic device.
    /// Before the first step those of the energy.
    Field elastic_forces() const override;

    Cost cost(int iterations) const override;

  protected:
    /// @param sets  with their multipliers, in the order of use_constraints()
    virtual void add_constraint_forces(const Field &x, double time_step, std::span<const kernels::ConstraintRows> sets,
                                       Field &f) const = 0;
    /// Steps go over these from now on.
    void use_constraints(std::vector<kernels::ConstraintRows> sets) { rows_.sets = std::move(sets); }

  private:
    /// One iteration; the first one of a step begins with the forces of the step before.
    /// @param position  of a node: int -> something that can be added to
    template <class Start, class Position> void project_ball(const Start &start, const Position &position);

    Field rest_;
    std::shared_ptr<core::BallContact> ball_;
    double time_step_ = 0.0;               ///< that is being taken [s]
    bool has_touched_ = false;             ///< in this step
    std::optional<double> last_time_step_; ///< [s]
    kernels::PositionRows rows_;
};

} // namespace livermark::interactive
