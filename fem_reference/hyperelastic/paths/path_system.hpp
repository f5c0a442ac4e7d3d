#pragma once

#include <span>
#include <vector>

#include "fem_reference/dof_conditions.hpp"
#include "fem_reference/hyperelastic/elements.hpp"
#include "fem_reference/hyperelastic/follower_pressure.hpp"
#include "fem_reference/hyperelastic/surface/touching_ball.hpp"
#include "fem_reference/hyperelastic/tangent_solver.hpp"

namespace livermark::hyperelastic {

/// (3 n) whether each displacement is free
std::vector<bool> free_of(const std::vector<double> &prescribed);

/// [m^3]
double volume_of(const core::TetraMesh &mesh);

/// What equilibrium is looked for in: elements under conditions, of one process or of one of several MPI ranks, which
/// then all do the same at once. Entries that another rank owns are there to read from, and do not count in sums.
class PathSystem {
  public:
    /// Elements and conditions are kept alive by the caller.
    /// @param conditions  at the whole load
    /// @param pressure    shape (T) [Pa], see FollowerPressure; or empty
    /// @param ball        what touches the body, kept alive by the caller; or nullptr
    PathSystem(const Elements &elements, const fem_reference::DofConditions &conditions,
               std::span<const double> pressure, TouchingBall *ball = nullptr);
    virtual ~PathSystem() = default;

    const fem_reference::DofConditions &conditions() const { return conditions_; }
    TouchingBall *ball() const { return ball_; }
    State rest() const { return elements_.rest(); }
    /// Dead loads, follower pressures and contact at a fraction of the load.
    /// @return shape (3 n) [N]
    std::vector<double> loads(const State &state, double fraction) const;

    /// Where loads have found their equilibrium, the pressures of a ball are those of the tangents to come; without a
    /// ball this does nothing. See TouchingBall::expected_pressure().
    void expect(const State &state, double fraction);
    /// The same where the tangent says how they change.
    /// @param state  before the change
    /// @param part   of the change that is taken
    void expect(const State &state, double fraction, const State &change, double part);
    /// The tangent that factorise(), solve() and product() are about.
    void assemble(const State &state, double fraction);
    /// @return false if the tangent is not positive definite; there is no inverse then
    bool factorise() { return set_up(tangent_.stiffness); }
    /// The same of the tangent at rest.
    bool factorise_at_rest();
    /// Of displacements alone, whether free or not.
    State product(const std::vector<double> &u) const;

    /// smallest_jacobian and energy are those of the whole body.
    virtual InternalForces internal_forces(const State &state) const = 0;
    /// After a factorise() that returned true, maybe of another state.
    virtual TangentSolver::Correction solve(const State &right, double tolerance) const = 0;
    /// See TangentSolver.
    virtual double pressure_scale() const = 0;
    virtual bool is_direct() const = 0;
    /// [m^3]
    virtual double volume() const = 0;

    /// (3 n), (m) whether entries count here
    virtual const std::vector<bool> &counted_displacements() const = 0;
    virtual const std::vector<bool> &counted_pressures() const = 0;
    /// Over all ranks.
    virtual double sum(double mine) const = 0;

  protected:
    const Elements &elements() const { return elements_; }
    const TangentMatrices &tangent() const { return tangent_; }
    const SurfaceStiffness &surface_stiffness() const { return surface_stiffness_; }

  private:
    /// Makes the inverse of a stiffness.
    /// @return false if it is not positive definite
    virtual bool set_up(const fem_reference::SymmetricBlocks<double> &stiffness) = 0;

    const Elements &elements_;
    const fem_reference::DofConditions &conditions_;
    FollowerPressure follower_;
    TouchingBall *ball_;
    TangentMatrices tangent_;
    SurfaceStiffness surface_stiffness_;
    std::vector<double> expected_pressure_; ///< of the ball, see TouchingBall; or empty
};

} // namespace livermark::hyperelastic
