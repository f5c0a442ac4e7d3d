#include "studies/advise/body_figures.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/mesh/parts_by_faces.hpp"

namespace livermark::studies {

namespace {

/// Tetrahedra of one region that faces join.
std::vector<std::vector<int>> parts_of_regions(const core::TetraMesh &mesh) {
    const auto part =
        core::parts_by_faces(mesh.tetrahedra, [&](int t, int other) { return mesh.region[t] == mesh.region[other]; });
    std::vector<std::vector<int>> parts(part.empty() ? 0 : *std::ranges::max_element(part) + 1);
    for (int t = 0; t < mesh.num_tetrahedra(); ++t)
        parts[part[t]].push_back(t);
    return parts;
}

double mean_edge_of(const core::TetraMesh &mesh, const std::vector<int> &tetrahedra) {
    double sum = 0.0;
    for (const int t : tetrahedra)
        for (const auto &[a, b] : core::tetrahedron_edges)
            sum += (mesh.points[mesh.tetrahedra[t][b]] - mesh.points[mesh.tetrahedra[t][a]]).norm();
    return sum / (static_cast<double>(core::tetrahedron_edges.size()) * static_cast<double>(tetrahedra.size()));
}

double diameter_of_ball(double volume) {
    return std::cbrt(6.0 * volume / std::numbers::pi);
}

std::vector<RegionFigures> region_figures(const core::Body &body, const std::vector<double> &volumes) {
    const auto &mesh = body.mesh;
    std::vector<RegionFigures> regions(mesh.region_names.size());
    std::vector<double> smallest(regions.size(), 0.0);
    for (std::size_t r = 0; r < regions.size(); ++r) {
        regions[r].name = mesh.region_names[r];
        regions[r].material = body.materials[r];
    }
    for (const auto &part : parts_of_regions(mesh)) {
        const auto r = static_cast<std::size_t>(mesh.region[part.front()]);
        double volume = 0.0;
        for (const int t : part)
            volume += volumes[t];
        auto &region = regions[r];
        region.volume += volume;
        region.num_tetrahedra += static_cast<int>(part.size());
        if (++region.num_parts == 1 || volume < smallest[r]) {
            smallest[r] = volume;
            region.smallest_part_tetrahedra = static_cast<int>(part.size());
            region.smallest_part_in_edges = diameter_of_ball(volume) / mean_edge_of(mesh, part);
        }
    }
    return regions;
}

double mean_edge_of_surface(const core::TetraMesh &mesh, const std::vector<std::array<int, 3>> &faces) {
    double sum = 0.0; // each edge of a closed surface is there twice
    for (const auto &face : faces)
        for (std::size_t c = 0; c < 3; ++c)
            sum += (mesh.points[face[(c + 1) % 3]] - mesh.points[face[c]]).norm();
    return sum / (3.0 * static_cast<double>(faces.size()));
}

double part_with_one_layer(const core::TetraMesh &mesh, const std::vector<std::array<int, 3>> &faces,
                           const std::vector<double> &volumes) {
    std::vector<bool> is_outside(mesh.points.size(), false);
    for (const auto &face : faces)
        for (const int node : face)
            is_outside[node] = true;
    double thin = 0.0, whole = 0.0;
    for (std::size_t t = 0; t < volumes.size(); ++t) {
        whole += volumes[t];
        if (std::ranges::all_of(mesh.tetrahedra[t], [&](int node) { return is_outside[node]; }))
            thin += volumes[t];
    }
    return thin / whole;
}

} // namespace

BodyFigures body_figures(const core::Body &body, double tool_radius) {
    const auto volumes = core::tetrahedron_volumes(body.mesh);
    const auto faces = core::outer_faces(body.mesh.tetrahedra);
    BodyFigures figures{.name = body.name,
                        .mesh = meshes::mesh_figures(body.mesh),
                        .regions = region_figures(body, volumes),
                        .surface_edge = mean_edge_of_surface(body.mesh, faces),
                        .tool_radius = tool_radius,
                        .thin_part = part_with_one_layer(body.mesh, faces, volumes)};
    const auto largest = std::ranges::max_element(figures.regions, {}, &RegionFigures::volume);
    figures.main_region = static_cast<std::size_t>(largest - figures.regions.begin());
    return figures;
}

} // namespace livermark::studies
