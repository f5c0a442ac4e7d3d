#include "msm/statics/surface_pressure.hpp"

namespace livermark::msm {

SurfacePressure::SurfacePressure(const core::Problem &problem) {
    const auto &mesh = problem.body->mesh;
    const auto &load_case = problem.load_case;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (load_case.follows_surface(f)) {
            facets_.push_back({mesh.boundary_triangles[f], core::follower_pressure(load_case, mesh, f)});
            for (const int node : mesh.boundary_triangles[f])
                origin_ += mesh.points[node];
        }
    if (!facets_.empty())
        origin_ /= 3.0 * static_cast<double>(facets_.size());
}

double SurfacePressure::energy(const std::vector<core::Vector3> &positions) const {
    double energy = 0.0;
    for (const auto &[nodes, pressure] : facets_) {
        const core::Vector3 a = positions[nodes[0]] - origin_, b = positions[nodes[1]] - origin_;
        energy += pressure / 6.0 * a.cross(b).dot(positions[nodes[2]] - origin_);
    }
    return energy;
}

void SurfacePressure::add_gradient(const std::vector<core::Vector3> &positions,
                                   std::vector<core::Vector3> &gradient) const {
    for (const auto &[nodes, pressure] : facets_) {
        const core::Vector3 a = positions[nodes[0]] - origin_, b = positions[nodes[1]] - origin_,
                            c = positions[nodes[2]] - origin_;
        gradient[nodes[0]] += pressure / 6.0 * b.cross(c);
        gradient[nodes[1]] += pressure / 6.0 * c.cross(a);
        gradient[nodes[2]] += pressure / 6.0 * a.cross(b);
    }
}

std::vector<core::Vector3> SurfacePressure::rim_force(const std::vector<core::Vector3> &positions) const {
    auto result = force(positions);
    add_gradient(positions, result);
    return result;
}

std::vector<core::Vector3> SurfacePressure::force(const std::vector<core::Vector3> &positions) const {
    std::vector<core::Vector3> result(positions.size(), core::Vector3::Zero());
    for (const auto &[nodes, pressure] : facets_) {
        const core::Vector3 &a = positions[nodes[0]];
        const core::Vector3 area = 0.5 * (positions[nodes[1]] - a).cross(positions[nodes[2]] - a);
        for (const int node : nodes)
            result[node] -= pressure / 3.0 * area;
    }
    return result;
}

} // namespace livermark::msm
