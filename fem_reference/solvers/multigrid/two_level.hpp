#pragma once

#include <memory>

#include "fem_reference/solvers/multigrid/prolongation.hpp"
#include "fem_reference/solvers/preconditioner.hpp"
#include "fem_reference/solvers/symmetric_blocks.hpp"

namespace livermark::fem_reference {

/// Two-level preconditioner: a Gauss-Seidel sweep on the fine unknowns, a correction from a coarse space, and a sweep
/// back. The coarse space is contained in the fine one, so a coarse stiffness matrix is P^T K P (see galerkin()) or
/// that of the coarse elements themselves, which is the same where the material is linear.
/// @param prolongation   from the coarse space
/// @param rounded_fine   stiffness of the fine system, for the sweeps; kept alive and unchanged by the caller
/// @param coarse_solver  solves on the coarse space, exactly or nearly so; kept alive by the caller
std::unique_ptr<Preconditioner> two_level(Prolongation prolongation, const SymmetricBlocks<float> &rounded_fine,
                                          Preconditioner &coarse_solver);

/// P^T K P
/// @param coarse_rows  which nodes of the coarse space share a cell, see CellEntries::below_diagonal
SymmetricBlocks<double> galerkin(const Prolongation &prolongation, const SymmetricBlocks<double> &stiffness,
                                 const LowerRows &coarse_rows);

} // namespace livermark::fem_reference
