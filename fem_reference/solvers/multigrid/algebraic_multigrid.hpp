#pragma once

#include <memory>

#include "fem_reference/linear/elastic_system.hpp"
#include "fem_reference/solvers/preconditioner.hpp"

namespace livermark::fem_reference {

/// Smoothed aggregation multigrid (Trilinos ML) with the six rigid body modes as near-nullspace.
/// @param system  kept alive and unchanged by the caller
std::unique_ptr<Preconditioner> algebraic_multigrid(const ElasticSystem &system);

} // namespace livermark::fem_reference
