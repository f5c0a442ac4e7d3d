#pragma once

#include "core/problem.hpp"
#include "core/solution.hpp"
#include "fem_reference/linear/choices.hpp"

namespace livermark::fem_reference {

/// Discretisation and end of solve_distributed().
struct DistributedOptions {
    int degree = 2;                                      ///< 1 or 2, of the displacement
    Formulation formulation = Formulation::displacement; ///< mixed for degree 2 only
    int num_refinements = 0;                             ///< uniform ones, which no rank sees but its part of
    int max_iterations = 2000;
};

/// The work of StaticSolver, by all ranks of MPI_COMM_WORLD together: METIS cuts the body among them (see Part), and
/// each rank assembles what it owns. Displacements alone are solved for by conjugate gradients with smoothed
/// aggregation multigrid (Trilinos ML), the mixed formulation as in DistributedSaddlePoint. Collective: every rank
/// calls it, with the same problem, while an MpiSession lives. Every rank gets the solution on the mesh.
///
/// If a rank fails where the others cannot know of it (out of memory), it says so and ends them all.
/// @return as StaticSolver::solve(); status not_converged if iterations do not come to a relative residual of 1e-12,
///   in the mixed formulation 1e-10 as the preconditioner sees it, with the last iterate
/// @throws std::invalid_argument on every rank for elements that do not exist, if a boundary triangle is not an outer
///   face, if the load case is not for this mesh, or if there are more ranks than nodes
core::Solution solve_distributed(const core::Problem &problem, const DistributedOptions &options);

} // namespace livermark::fem_reference
