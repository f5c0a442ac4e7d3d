#pragma once

#include <memory>

#include "fem_reference/linear/elastic_system.hpp"
#include "fem_reference/solvers/preconditioner.hpp"

namespace livermark::fem_reference {

/// Two-level preconditioner for the quadratic elements of a refined body: a Gauss-Seidel sweep, a correction from
/// the quadratic elements of the body itself, and a sweep back. The coarse space is contained in the fine one, and its
/// stiffness matrix is P^T K P, so that nothing has to be assembled.
/// @param fine, coarse        kept alive and unchanged by the caller, like rounded_fine and coarse_solver
/// @param rounded_fine        stiffness of the fine system, for the sweeps
/// @param coarse_solver       solves on the coarse space, exactly or nearly so
/// @param parent              see prolongation()
/// @throws std::invalid_argument if the fine system is not that of the refined body
std::unique_ptr<Preconditioner> two_level(const ElasticSystem &fine, const SymmetricBlocks<float> &rounded_fine,
                                          const ElasticSystem &coarse, Preconditioner &coarse_solver,
                                          std::span<const int> parent = {});

} // namespace livermark::fem_reference
