#pragma once

#include <vector>

#include "fem_reference/dof_conditions.hpp"
#include "fem_reference/hyperelastic/elements.hpp"
#include "fem_reference/hyperelastic/tangent_solver.hpp"

namespace livermark::hyperelastic {

/// What equilibrium is looked for in: elements under conditions, of one process or of one of several MPI ranks, which
/// then all do the same at once. Entries that another rank owns are there to read from, and do not count in sums.
class PathSystem {
  public:
    virtual ~PathSystem() = default;

    /// At the whole load.
    virtual const fem_reference::DofConditions &conditions() const = 0;
    virtual State rest() const = 0;
    /// smallest_jacobian and energy are those of the whole body.
    virtual InternalForces internal_forces(const State &state) const = 0;
    /// Dead loads and follower pressures at a fraction of the load.
    /// @return shape (3 n) [N]
    virtual std::vector<double> loads(const State &state, double fraction) const = 0;

    /// The tangent that factorise(), solve() and product() are about.
    virtual void assemble(const State &state, double fraction) = 0;
    /// @return false if the tangent, or the one at rest, is not positive definite; there is no inverse then
    virtual bool factorise() = 0;
    virtual bool factorise_at_rest() = 0;
    /// After a factorise() that returned true, maybe of another state.
    virtual TangentSolver::Correction solve(const State &right, double tolerance) const = 0;
    /// Of displacements alone.
    virtual State product(const std::vector<double> &u) const = 0;
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
};

} // namespace livermark::hyperelastic
