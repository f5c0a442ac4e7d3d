#pragma once

#include <Teuchos_ParameterList.hpp>
#include <vector>

namespace livermark::fem_reference {

/// How Trilinos ML makes and applies the levels of a smoothed aggregation multigrid for elasticity.
/// @param modes  (6, n) rigid body modes at the n unknowns of this rank, the near-nullspace; the list points to them,
/// and
///               they are read while the levels are made
Teuchos::ParameterList multigrid_settings(std::vector<double> &modes);

} // namespace livermark::fem_reference
