#pragma once

#include <vector>

#include "fem_reference/linear/elastic_system.hpp"

namespace livermark::fem_reference {

/// A load case as the unknowns see it; n is the number of nodes.
struct DofConditions {
    std::vector<double> prescribed; ///< (3 n) [m], NaN where free
    std::vector<int> constraint;    ///< (3 n) index into LoadCase::constraint_names, -1 where free
    std::vector<double> load;       ///< (3 n) [N]; where a place presses, for one newton of it [1]
    double press_depth = 0.0;       ///< LoadCase::press_depth [m]
};

/// Integrates the loads of a load case and spreads its prescribed displacements over the nodes of the facets. Where
/// constraints meet at a node, each component takes value and owner from the constraint of lowest index that prescribes
/// it.
/// @param load_case  of the sizes of the mesh that the system was assembled on
DofConditions dof_conditions(const core::LoadCase &load_case, const ElasticSystem &system);

} // namespace livermark::fem_reference
