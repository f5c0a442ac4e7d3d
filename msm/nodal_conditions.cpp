#include "msm/nodal_conditions.hpp"

#include <cmath>
#include <limits>

namespace livermark::msm {

namespace {

/// Prescribes the components that a facet prescribes, unless a constraint of lower index has done so.
void prescribe(NodalConditions &nodes, int node, const core::Vector3 &value, int constraint) {
    for (int c = 0; c < 3; ++c) {
        int &owner = nodes.constraint[node][static_cast<std::size_t>(c)];
        if (!std::isnan(value[c]) && (owner < 0 || constraint < owner)) {
            owner = constraint;
            nodes.displacement[node][c] = value[c];
        }
    }
}

} // namespace

NodalConditions nodal_conditions(const core::Problem &problem, const std::vector<double> &node_mass) {
    const auto &mesh = problem.body->mesh;
    const auto &load_case = problem.load_case;
    NodalConditions nodes;
    nodes.press_depth = load_case.press_depth;
    nodes.displacement.assign(mesh.points.size(), core::Vector3::Constant(std::numeric_limits<double>::quiet_NaN()));
    nodes.constraint.assign(mesh.points.size(), {-1, -1, -1});
    nodes.force.reserve(mesh.points.size());
    for (const double mass : node_mass)
        nodes.force.push_back(mass * load_case.acceleration);

    for (int f = 0; f < mesh.num_boundary_triangles(); ++f) {
        if (load_case.is_loaded(f)) {
            const core::Vector3 force = area_vector(mesh, f).norm() * load_case.value[f];
            const auto part = core::linear_parts(load_case.round_load_on(f), core::corners_of(mesh, f));
            for (std::size_t k = 0; k < 3; ++k)
                nodes.force[mesh.boundary_triangles[f][k]] += part[k] * force;
        }
        if (load_case.is_constrained(f))
            for (const int node : mesh.boundary_triangles[f])
                prescribe(nodes, node, load_case.prescribed_at(f, node), load_case.constraint_on(f));
    }
    return nodes;
}

std::vector<core::Vector3> constraint_forces(const core::Problem &problem, const NodalConditions &conditions,
                                             const std::vector<core::Vector3> &force, double press,
                                             const core::Vector3 &touch) {
    auto total = core::press_resultants(problem.load_case, problem.body->mesh);
    for (auto &resultant : total)
        resultant *= press;
    for (std::size_t i = 0; i < force.size(); ++i)
        for (std::size_t c = 0; c < 3; ++c)
            if (const int owner = conditions.constraint[i][c]; owner >= 0)
                total[owner][static_cast<Eigen::Index>(c)] += force[i][static_cast<Eigen::Index>(c)];
    if (const auto contact = problem.load_case.contact())
        total[contact->constraint] += touch;
    return total;
}

} // namespace livermark::msm
