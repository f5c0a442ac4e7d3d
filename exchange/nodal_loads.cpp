#include "exchange/nodal_loads.hpp"

#include <cmath>
#include <limits>

namespace livermark::exchange {

using core::Vector3;

std::vector<Vector3> prescribed_displacement(const core::Problem &problem) {
    const auto &mesh = problem.body->mesh;
    const auto &load_case = problem.load_case;
    std::vector<Vector3> value(mesh.points.size(), Vector3::Constant(std::numeric_limits<double>::quiet_NaN()));
    for (int constraint = 0; constraint < static_cast<int>(load_case.constraint_names.size()); ++constraint)
        for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
            if (load_case.constraint[f] == constraint)
                for (const int node : mesh.boundary_triangles[f])
                    for (int i = 0; i < 3; ++i)
                        if (std::isnan(value[node][i]))
                            value[node][i] = load_case.value[f][i];
    return value;
}

std::vector<Vector3> nodal_forces(const core::Problem &problem) {
    const auto &mesh = problem.body->mesh;
    const auto &load_case = problem.load_case;
    std::vector<Vector3> force(mesh.points.size(), Vector3::Zero());
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (load_case.condition[f] == core::FacetCondition::traction) {
            const Vector3 third = core::area_vector(mesh, f).norm() / 3.0 * load_case.value[f];
            for (const int node : mesh.boundary_triangles[f])
                for (int i = 0; i < 3; ++i)
                    force[node][i] += std::isnan(third[i]) ? 0.0 : third[i];
        }
    const auto volumes = tetrahedron_volumes(mesh);
    for (int t = 0; t < mesh.num_tetrahedra(); ++t)
        for (const int node : mesh.tetrahedra[t])
            force[node] += 0.25 * problem.body->materials[mesh.region[t]].density * volumes[t] * load_case.acceleration;
    return force;
}

} // namespace livermark::exchange
