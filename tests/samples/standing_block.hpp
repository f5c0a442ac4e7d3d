#pragma once

#include <cmath>
#include <limits>
#include <vector>

#include "core/problem.hpp"
#include "tests/samples/even_foundation.hpp"
#include "tests/samples/test_meshes.hpp"

/// A block on springs along the normal of its bottom, whose two sides at the origin slide: its stress is the same
/// everywhere, and as it becomes small the bottom moves up by u with E (top - u) / L + traction = k u.
namespace livermark::tests::standing {

inline constexpr double young_modulus = 5e3; ///< E [Pa]
inline constexpr double stiffness = 1.5e5;   ///< k [N/m^3]
inline const core::Vector3 size{0.04, 0.03, 0.05};

inline std::vector<int> bottom(const core::TetraMesh &mesh) {
    std::vector<int> facets;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (mesh.patch_names[mesh.boundary_patch[f]] == "z_min")
            facets.push_back(f);
    return facets;
}

/// @param top       by which the top is moved up [m]
/// @param traction  on the bottom, upwards [Pa]
inline core::Problem block(double top, double traction, double poisson_ratio = 0.3) {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    const auto body = make_body(box_mesh(size, {2, 2, 3}), {1060.0, young_modulus, poisson_ratio});
    auto load_case = empty_load_case(body->mesh);
    load_case.regime = core::Regime::large;
    load_case.path = {0.5, 1.0};
    prescribe(load_case, body->mesh, "x_min", {0.0, nan, nan});
    prescribe(load_case, body->mesh, "y_min", {nan, 0.0, nan});
    prescribe(load_case, body->mesh, "z_max", {nan, nan, top});
    pull(load_case, body->mesh, "z_min", {0.0, 0.0, traction});
    load_case.foundation = tests::even_foundation(bottom(body->mesh), stiffness, true);
    return {body, load_case};
}

/// u [m]
inline double expected(double top, double traction) {
    return (young_modulus * top / size.z() + traction) / (young_modulus / size.z() + stiffness);
}

/// Displacement of the bottom, upwards, in the mean [m].
/// @param displacement  shape (N) [m]
inline double moved_up(const core::TetraMesh &mesh, const std::vector<core::Vector3> &displacement) {
    double moved = 0.0, area = 0.0;
    for (const int f : bottom(mesh)) {
        const double here = core::area_vector(mesh, f).norm();
        area += here;
        for (const int node : mesh.boundary_triangles[f])
            moved += here / 3.0 * displacement[node].z();
    }
    return moved / area;
}

/// Force that is left upwards of the reactions, the traction and the springs, over that of the springs.
/// @param reaction  shape (P) [N]
inline double out_of_balance(const core::Problem &problem, const std::vector<core::Vector3> &displacement,
                             const std::vector<core::Vector3> &reaction) {
    const auto &mesh = problem.body->mesh;
    const double area = size.x() * size.y(), springs = stiffness * area * moved_up(mesh, displacement);
    double left = area * problem.load_case.value[bottom(mesh).front()].z() - springs;
    for (const auto &force : reaction)
        left += force.z();
    return std::abs(left / springs);
}

/// Loads of a block, as its top and traction: see block().
struct Drive {
    double top, traction;
};
inline constexpr Drive drives[] = {{8e-4, 0.0}, {0.0, 80.0}}; ///< strains of a hundredth

} // namespace livermark::tests::standing
