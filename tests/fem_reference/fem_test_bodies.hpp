#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "core/problem.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark::tests {

inline const core::Vector3 rod_size{0.1, 0.08, 0.06}; ///< [m]

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

/// A rod of 100 x 80 x 60 mm, some of whose tetrahedra are ten times as stiff: constrained at one end, with a side that
/// is moved along its normal; hanging, and nothing pulls at it yet.
/// @param mesh       of size rod_size, from box_mesh() or the like
/// @param poisson    of the soft part and of the stiff part
/// @param is_stiff   whether a tetrahedron is, by its number
template <class IsStiff>
core::Problem constrained_rod(core::TetraMesh mesh, const std::array<double, 2> &poisson, IsStiff &&is_stiff) {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    mesh.region_names = {"soft", "stiff"};
    for (int t = 0; t < mesh.num_tetrahedra(); ++t)
        mesh.region[t] = is_stiff(t) ? 1 : 0;
    auto body = std::make_shared<core::Body>();
    body->name = "rod";
    body->mesh = std::move(mesh);
    body->materials = {{1060.0, 5000.0, poisson[0]}, {1060.0, 50000.0, poisson[1]}};
    auto load_case = empty_load_case(body->mesh);
    prescribe(load_case, body->mesh, "x_min", core::Vector3::Zero());
    prescribe(load_case, body->mesh, "y_min", {nan, 0.001, nan});
    load_case.acceleration = {0.1, 0.2, -0.5};
    return {body, load_case};
}

/// The same, shaken, every fifth tetrahedron stiff.
inline core::Problem shaken_rod(double poisson_ratio, const std::array<int, 3> &bricks) {
    return constrained_rod(shaken_box_mesh(rod_size, bricks), {poisson_ratio, poisson_ratio},
                           [](int t) { return t % 5 == 0; });
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
