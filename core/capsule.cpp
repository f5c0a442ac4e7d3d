#include "core/capsule.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <set>
#include <utility>

#include "core/problem.hpp"

namespace livermark::core {

namespace {

/// An edge of facets in the plane of the surface at one of its ends.
Vector3 in_plane(const Vector3 &edge, const Vector3 &normal) {
    return edge - normal.dot(edge) * normal;
}

/// Calls a function with the ends of each edge of each covered facet, the lower number first.
void for_each_covered_edge(const TetraMesh &mesh, const auto &action) {
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f) {
        if (!Capsule::covers(mesh, f))
            continue;
        const auto &nodes = mesh.boundary_triangles[f];
        for (std::size_t k = 0; k < 3; ++k) {
            const auto [low, high] = std::minmax(nodes[k], nodes[(k + 1) % 3]);
            action(std::array{low, high});
        }
    }
}

} // namespace

Vector3 SmoothSurface::offset_between(const TetraMesh &mesh, int a, int b) const {
    const Vector3 edge = mesh.points[b] + offset[b] - mesh.points[a] - offset[a];
    return 0.5 * (offset[a] + offset[b]) + 0.125 * (in_plane(edge, normal[a]) - in_plane(edge, normal[b]));
}

Vector3 SmoothSurface::normal_between(const TetraMesh &mesh, int a, int b) const {
    if (normal[a].isZero(0.0) || normal[b].isZero(0.0))
        return Vector3::Zero();
    const Vector3 along = (mesh.points[b] + offset[b] - mesh.points[a] - offset[a]).normalized();
    return in_plane(normal[a] + normal[b], along).normalized();
}

SmoothSurface smooth_surface(const TetraMesh &mesh) {
    const std::vector<Vector3> zeros(mesh.points.size(), Vector3::Zero());
    SmoothSurface surface{zeros, zeros};
    const auto at_covered = [&](const auto &action) {
        for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
            for (const int node : mesh.boundary_triangles[f])
                if (Capsule::covers(mesh, f))
                    action(node, area_vector(mesh, f));
    };
    at_covered([&](int node, const Vector3 &area) { surface.normal[node] += area; });
    for (auto &normal : surface.normal)
        if (!normal.isZero(0.0))
            normal.normalize();
    const double smallest_cosine = std::cos(40.0 / 180.0 * std::numbers::pi);
    std::set<int> on_edges;
    at_covered([&](int node, const Vector3 &area) {
        if (area.normalized().dot(surface.normal[node]) < smallest_cosine)
            on_edges.insert(node);
    });
    for (const int node : on_edges)
        surface.normal[node].setZero();
    return surface;
}

std::shared_ptr<const SmoothSurface> capsule_surface(const Body &body) {
    const auto &known = body.capsule.value().surface;
    return known ? known : std::make_shared<const SmoothSurface>(smooth_surface(body.mesh));
}

std::shared_ptr<const SmoothSurface> refined_surface(const Body &coarse, std::span<const std::array<int, 2>> split,
                                                     std::span<const Vector3> points) {
    const auto before = capsule_surface(coarse);
    std::set<std::array<int, 2>> outside;
    for_each_covered_edge(coarse.mesh, [&](const auto &edge) { outside.insert(edge); });
    auto surface = *before;
    for (const auto &[first, second] : split) {
        const auto [a, b] = std::minmax(first, second);
        auto &normal = surface.normal.emplace_back(Vector3::Zero());
        auto &offset = surface.offset.emplace_back(Vector3::Zero());
        if (!outside.contains({a, b}))
            continue;
        const Vector3 &node = points[surface.offset.size() - 1];
        normal = before->normal_between(coarse.mesh, a, b);
        offset =
            0.5 * (coarse.mesh.points[a] + coarse.mesh.points[b]) - node + before->offset_between(coarse.mesh, a, b);
    }
    return std::make_shared<const SmoothSurface>(std::move(surface));
}

std::vector<double> capsule_springs(const Body &body, const EdgeTable &edges) {
    std::vector<double> stiffness(edges.edges.size(), 0.0);
    if (!body.capsule)
        return stiffness;
    const double added = std::numbers::sqrt3 / 4.0 * body.capsule->stiffness();
    for_each_covered_edge(body.mesh, [&](const auto &edge) {
        const auto found = std::ranges::lower_bound(edges.edges, edge);
        stiffness[static_cast<std::size_t>(found - edges.edges.begin())] += added;
    });
    return stiffness;
}

} // namespace livermark::core
