#pragma once

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "core/problem.hpp"
#include "tests/test_meshes.hpp"

namespace livermark::tests {

/// A box_mesh whose inner nodes are moved at random by up to a tenth of a brick in each direction, always the same way.
inline core::TetraMesh shaken_box_mesh(const core::Vector3 &size, const std::array<int, 3> &bricks) {
    auto mesh = box_mesh(size, bricks);
    std::vector<bool> outer(mesh.points.size(), false);
    for (const auto &triangle : mesh.boundary_triangles)
        for (const int node : triangle)
            outer[node] = true;
    std::mt19937 generator(1);
    std::uniform_real_distribution<double> tenth(-0.1, 0.1);
    for (std::size_t node = 0; node < outer.size(); ++node)
        for (int i = 0; i < 3; ++i) {
            const double shift = tenth(generator) * size[i] / bricks[i];
            mesh.points[node][i] += outer[node] ? 0.0 : shift;
        }
    return mesh;
}

/// Largest distance between two fields over the largest vector of the second.
inline double relative_difference(const std::vector<core::Vector3> &a, const std::vector<core::Vector3> &b) {
    double difference = a.size() == b.size() ? 0.0 : std::numeric_limits<double>::infinity();
    double size = 0.0;
    for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
        const double here = (a[i] - b[i]).norm();
        difference = std::isnan(here) ? here : std::max(difference, here); // a NaN must not hide
        if (std::isnan(difference))
            return difference;
        size = std::max(size, b[i].norm());
    }
    return difference / size;
}

} // namespace livermark::tests
