#include "fem_reference/dof_conditions.hpp"

#include <cmath>
#include <limits>

namespace livermark::fem_reference {

namespace {

constexpr double is_free = std::numeric_limits<double>::quiet_NaN();

/// What prescribed displacements are multiplied by at the nodes of the facets; 1 at all others.
std::vector<double> factors(const core::LoadCase &load_case, const ElasticSystem &system) {
    std::vector<double> factor(system.points.size(), 1.0);
    if (load_case.node_factor.empty())
        return factor;
    for (std::size_t node = 0; node < system.mesh_node.size(); ++node)
        factor[system.mesh_node[node]] = load_case.node_factor[node];
    for (std::size_t first = 0; first < system.facet_nodes.size(); first += system.nodes_per_facet)
        for (int middle = 3; middle < system.nodes_per_facet; ++middle) {
            const int a = system.facet_nodes[first + middle - 3], b = system.facet_nodes[first + (middle - 2) % 3];
            factor[system.facet_nodes[first + middle]] = 0.5 * (factor[a] + factor[b]);
        }
    return factor;
}

} // namespace

DofConditions dof_conditions(const core::LoadCase &load_case, const ElasticSystem &system) {
    DofConditions dofs;
    dofs.prescribed.assign(3 * system.points.size(), is_free);
    dofs.constraint.assign(3 * system.points.size(), -1);
    dofs.load.reserve(3 * system.points.size());
    for (const double mass : system.mass_integral)
        for (int i = 0; i < 3; ++i)
            dofs.load.push_back(mass * load_case.acceleration[i]);

    const auto factor = factors(load_case, system);
    for (std::size_t f = 0; f < load_case.condition.size(); ++f) {
        for (std::size_t k = f * system.nodes_per_facet; k < (f + 1) * system.nodes_per_facet; ++k) {
            for (int i = 0; i < 3; ++i) {
                const double value = load_case.value[f][i];
                const int dof = 3 * system.facet_nodes[k] + i;
                if (std::isnan(value))
                    continue;
                if (load_case.condition[f] == core::FacetCondition::traction)
                    dofs.load[dof] += value * system.facet_integral[k];
                int &owner = dofs.constraint[dof];
                if (load_case.condition[f] == core::FacetCondition::prescribed_displacement &&
                    (owner < 0 || load_case.constraint[f] < owner)) {
                    owner = load_case.constraint[f];
                    dofs.prescribed[dof] = factor[system.facet_nodes[k]] * value;
                }
            }
        }
    }
    return dofs;
}

} // namespace livermark::fem_reference
