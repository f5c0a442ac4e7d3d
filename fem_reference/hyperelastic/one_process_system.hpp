#pragma once

#include "fem_reference/hyperelastic/paths/path_system.hpp"

namespace livermark::hyperelastic {

/// Elements of a whole body.
class OneProcessSystem : public PathSystem {
  public:
    /// See PathSystem.
    OneProcessSystem(const Elements &elements, const fem_reference::DofConditions &conditions,
                     std::span<const double> pressure, TouchingBall *ball = nullptr);

    InternalForces internal_forces(const State &state) const override { return elements().internal_forces(state); }
    TangentSolver::Correction solve(const State &right, double tolerance) const override {
        return solver_.solve(tangent(), surface_stiffness(), right, tolerance);
    }
    double pressure_scale() const override { return solver_.pressure_scale(); }
    bool is_direct() const override { return solver_.is_direct(); }
    double volume() const override { return volume_of(elements().body().mesh); }
    const std::vector<bool> &counted_displacements() const override { return counted_displacements_; }
    const std::vector<bool> &counted_pressures() const override { return counted_pressures_; }
    double sum(double mine) const override { return mine; }

  private:
    bool set_up(const fem_reference::SymmetricBlocks<double> &stiffness) override {
        return solver_.factorise(stiffness);
    }

    TangentSolver solver_;
    std::vector<bool> counted_displacements_, counted_pressures_; ///< all
};

} // namespace livermark::hyperelastic
