#include "meshes/generators/surface_mesh.hpp"

#include <cmath>
#include <map>

namespace livermark::meshes {

double enclosed_volume(const SurfaceMesh &surface) {
    double volume = 0.0;
    for (const auto &[a, b, c] : surface.triangles)
        volume += surface.points[a].dot(surface.points[b].cross(surface.points[c])) / 6.0;
    return volume;
}

SurfaceMesh geodesic_sphere(int frequency) {
    const double golden = (1.0 + std::sqrt(5.0)) / 2.0;
    const std::array<core::Vector3, 12> corners{{{-1, golden, 0},
                                                 {1, golden, 0},
                                                 {-1, -golden, 0},
                                                 {1, -golden, 0},
                                                 {0, -1, golden},
                                                 {0, 1, golden},
                                                 {0, -1, -golden},
                                                 {0, 1, -golden},
                                                 {golden, 0, -1},
                                                 {golden, 0, 1},
                                                 {-golden, 0, -1},
                                                 {-golden, 0, 1}}};
    constexpr std::array<std::array<int, 3>, 20> faces{{{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                                                        {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                                                        {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                                                        {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}}};

    SurfaceMesh sphere;
    // A node of the subdivision is known by its integer weights at the corners, which neighbouring faces share.
    std::map<std::array<int, 12>, int> known;
    for (const auto &face : faces) {
        const auto node = [&](int i, int j) {
            std::array<int, 12> weights{};
            weights[face[0]] = frequency - i - j;
            weights[face[1]] = i;
            weights[face[2]] = j;
            const auto [entry, is_new] = known.try_emplace(weights, static_cast<int>(sphere.points.size()));
            if (is_new)
                sphere.points.push_back(
                    ((frequency - i - j) * corners[face[0]] + i * corners[face[1]] + j * corners[face[2]])
                        .normalized());
            return entry->second;
        };
        for (int i = 0; i < frequency; ++i)
            for (int j = 0; i + j < frequency; ++j) {
                sphere.triangles.push_back({node(i, j), node(i + 1, j), node(i, j + 1)});
                if (i + j + 2 <= frequency)
                    sphere.triangles.push_back({node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)});
            }
    }
    return sphere;
}

} // namespace livermark::meshes
