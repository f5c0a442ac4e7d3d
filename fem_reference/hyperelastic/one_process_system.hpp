#pragma once

#include <span>

#include "fem_reference/hyperelastic/path_system.hpp"

namespace livermark::hyperelastic {

/// Elements of a whole body.
class OneProcessSystem : public PathSystem {
  public:
    /// Elements and conditions are kept alive by the caller.
    /// @param pressure  shape (T) [Pa], see FollowerPressure; or empty
    OneProcessSystem(const Elements &elements, const fem_reference::DofConditions &conditions,
                     std::span<const double> pressure);

    const fem_reference::DofConditions &conditions() const override { return conditions_; }
    State rest() const override { return elements_.rest(); }
    InternalForces internal_forces(const State &state) const override { return elements_.internal_forces(state); }
    std::vector<double> loads(const State &state, double fraction) const override;
    void assemble(const State &state, double fraction) override;
    bool factorise() override { return solver_.factorise(tangent_.stiffness); }
    bool factorise_at_rest() override;
    TangentSolver::Correction solve(const State &right, double tolerance) const override {
        return solver_.solve(tangent_, load_stiffness_, right, tolerance);
    }
    State product(const std::vector<double> &u) const override { return solver_.product(tangent_, load_stiffness_, u); }
    double pressure_scale() const override { return solver_.pressure_scale(); }
    bool is_direct() const override { return solver_.is_direct(); }
    double volume() const override;
    const std::vector<bool> &counted_displacements() const override { return counted_displacements_; }
    const std::vector<bool> &counted_pressures() const override { return counted_pressures_; }
    double sum(double mine) const override { return mine; }

  private:
    const Elements &elements_;
    const fem_reference::DofConditions &conditions_;
    FollowerPressure follower_;
    TangentSolver solver_;
    TangentMatrices tangent_;
    FollowerPressure::LoadStiffness load_stiffness_;
    std::vector<bool> counted_displacements_, counted_pressures_; ///< all
};

/// (3 n) whether each displacement is free
std::vector<bool> free_of(const std::vector<double> &prescribed);

/// conditions.load and follower pressures at a fraction of the load.
std::vector<double> loads_at(const fem_reference::DofConditions &conditions, const FollowerPressure &follower,
                             const State &state, double fraction);

} // namespace livermark::hyperelastic
