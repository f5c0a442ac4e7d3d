#pragma once

#include "core/problem.hpp"
#include "core/solution.hpp"

namespace livermark::fem_reference {

/// What StaticSolver does, by all ranks of MPI_COMM_WORLD together: the tetrahedra are cut among them with METIS, each
/// rank holds its rows of the matrix, and conjugate gradients with smoothed aggregation multigrid (Trilinos ML) solve.
/// Collective: every rank calls it, with the same problem, while an MpiSession lives. Every rank gets the whole
/// solution.
///
/// If a rank fails where the others cannot know of it (out of memory), it says so and ends them all.
/// @param degree          1 or 2
/// @param max_iterations  after how many steps it gives up
/// @return as StaticSolver::solve(); status not_converged if conjugate gradients do not reach a relative residual of
///   1e-12, with the last iterate
/// @throws std::invalid_argument on every rank for another degree, if a boundary triangle is not an outer face, or if
///   the load case is not for this mesh
core::Solution solve_distributed(const core::Problem &problem, int degree, int max_iterations = 2000);

} // namespace livermark::fem_reference
