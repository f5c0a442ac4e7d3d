#include "msm/nodal_conditions.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace livermark::msm {

namespace {

/// Prescribes the components that the facet prescribes, and keeps what an earlier facet said of the others.
void prescribe(core::Vector3 &node, const core::Vector3 &facet) {
    for (int component = 0; component < 3; ++component)
        if (!std::isnan(facet[component]))
            node[component] = facet[component];
}

} // namespace

NodalConditions nodal_conditions(const core::Problem &problem, const std::vector<double> &node_mass) {
    const auto &mesh = problem.body->mesh;
    const auto &load_case = problem.load_case;
    NodalConditions nodes;
    nodes.displacement.assign(mesh.points.size(), core::Vector3::Constant(std::numeric_limits<double>::quiet_NaN()));
    nodes.constraint.assign(mesh.points.size(), -1);
    nodes.force.reserve(mesh.points.size());
    for (const double mass : node_mass)
        nodes.force.push_back(mass * load_case.acceleration);

    for (int f = 0; f < mesh.num_boundary_triangles(); ++f) {
        for (const int node : mesh.boundary_triangles[f]) {
            if (load_case.condition[f] == core::FacetCondition::traction)
                nodes.force[node] += area_vector(mesh, f).norm() / 3.0 * load_case.value[f];
            if (load_case.condition[f] == core::FacetCondition::prescribed_displacement) {
                prescribe(nodes.displacement[node], load_case.value[f]);
                int &owner = nodes.constraint[node];
                owner = owner < 0 ? load_case.constraint[f] : std::min(owner, load_case.constraint[f]);
            }
        }
    }
    return nodes;
}

std::vector<core::Vector3> constraint_forces(const core::Problem &problem, const NodalConditions &conditions,
                                             const std::vector<core::Vector3> &force) {
    std::vector<core::Vector3> total(problem.load_case.constraint_names.size(), core::Vector3::Zero());
    for (std::size_t i = 0; i < force.size(); ++i)
        if (conditions.constraint[i] >= 0)
            total[conditions.constraint[i]] += force[i];
    return total;
}

} // namespace livermark::msm
