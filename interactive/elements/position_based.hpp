#pragma once

#include <optional>
#include <span>
#include <vector>

#include "interactive/kernels/position_rows.hpp"
#include "interactive/simulation.hpp"

namespace livermark::interactive {

/// Steps of extended position-based dynamics: nodes go to where they would without elasticity, iterations over all
/// constraints move them from there, and velocities follow from positions. A method projects its constraints, and in
/// single precision says what they are. A ball that touches is a constraint at each point of the facets that
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
    /// What a step in double precision does.
    virtual void clear_multipliers() = 0;
    virtual void project(Field &x, const std::vector<double> &inverse_mass, double time_step) = 0;
    /// In either precision.
    /// @param sets  with the multipliers of single precision, in the order of use_vectors(); none in double precision
    virtual void add_constraint_forces(const Field &x, double time_step, std::span<const kernels::ConstraintRows> sets,
                                       Field &f) const = 0;
    virtual std::size_t bytes_of_constraints() const = 0; ///< in double precision

    bool is_in_single_precision() const { return scene().precision == Precision::single_precision; }
    /// Steps go over these from now on.
    void use_vectors(std::vector<kernels::ConstraintRows> sets);

  private:
    void step_in_double(double time_step, int iterations);
    void step_in_single(double time_step, int iterations);
    /// One iteration; the first one of a step begins with the forces of the step before.
    /// @param position  of a node: int -> something that can be added to
    template <class Start, class Position> void project_ball(const Start &start, const Position &position);

    Field rest_;
    std::shared_ptr<core::BallContact> ball_;
    double time_step_ = 0.0;                    ///< that is being taken [s]
    bool has_touched_ = false;                  ///< in this step
    std::vector<double> inverse_mass_;          ///< (N) 1 / (m (1 + alpha h)), zero where constrained
    std::optional<double> last_time_step_;      ///< [s]
    std::optional<kernels::PositionRows> rows_; ///< in single precision
};

} // namespace livermark::interactive
