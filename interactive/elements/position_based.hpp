#pragma once

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "interactive/inertia.hpp"

namespace livermark::interactive {

/// Steps of extended position-based dynamics: nodes go to where they would without elasticity, iterations over all
/// constraints move them from there, and velocities follow from positions. A method projects its constraints.
class PositionBased : public Simulation {
  public:
    explicit PositionBased(Scene given) : Simulation(std::move(given)), inverse_mass_(scene().node_mass.size()) {}

    void step(double time_step, int iterations) override {
        auto &x = mutable_positions();
        const Field before = x;
        const auto terms = inertia(*this, time_step);
        for (std::size_t i = 0; i < inverse_mass_.size(); ++i)
            inverse_mass_[i] = is_free()[i] ? 1.0 / (terms.stiffness[i] * time_step * time_step) : 0.0;
        x = terms.predicted;
        clear_multipliers();
        for (int i = 0; i < iterations; ++i)
            project(x, inverse_mass_, time_step);
        mutable_velocities() = (x - before) / time_step;
        last_time_step_ = time_step;
    }

    void set_state(const Field &positions, const Field &velocities) override {
        Simulation::set_state(positions, velocities);
        last_time_step_.reset();
    }

    /// Those of the multipliers, as far as iterations have come: what a program would send to a haptic device.
    /// Before the first step those of the energy.
    Field elastic_forces() const override {
        if (!last_time_step_)
            return Simulation::elastic_forces();
        Field forces = Field::Zero(3, positions().cols());
        add_constraint_forces(positions(), *last_time_step_, forces);
        return forces;
    }

  protected:
    virtual void clear_multipliers() = 0;
    virtual void project(Field &x, const std::vector<double> &inverse_mass, double time_step) = 0;
    virtual void add_constraint_forces(const Field &x, double time_step, Field &f) const = 0;

  private:
    std::vector<double> inverse_mass_;     ///< (N) 1 / (m (1 + alpha h)), zero where constrained
    std::optional<double> last_time_step_; ///< [s]
};

} // namespace livermark::interactive
