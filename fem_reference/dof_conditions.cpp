#include "fem_reference/dof_conditions.hpp"

#include <cmath>
#include <limits>

namespace livermark::fem_reference {

namespace {

constexpr double is_free = std::numeric_limits<double>::quiet_NaN();

} // namespace

DofConditions dof_conditions(const core::LoadCase &load_case, const ElasticSystem &system) {
    DofConditions dofs;
    dofs.prescribed.assign(3 * system.points.size(), is_free);
    dofs.constraint.assign(3 * system.points.size(), -1);
    dofs.load.reserve(3 * system.points.size());
    for (const double mass : system.mass_integral)
        for (int i = 0; i < 3; ++i)
            dofs.load.push_back(mass * load_case.acceleration[i]);

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
                    dofs.prescribed[dof] = value;
                }
            }
        }
    }
    return dofs;
}

} // namespace livermark::fem_reference
