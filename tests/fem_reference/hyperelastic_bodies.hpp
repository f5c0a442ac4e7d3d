#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "fem_reference/hyperelastic/hyperelasticity.hpp"
#include "tests/fem_reference/fem_test_bodies.hpp"

/// Bodies that the tests of hyperelastic paths hold and pull.
namespace livermark::tests {

inline constexpr double free_component = std::numeric_limits<double>::quiet_NaN();
inline const core::Material soft_material{1000.0, 5000.0, 0.45, {{"mooney_rivlin", {0.1}}, {"yeoh", {0.05, 0.02}}}};

/// Every kind of hyperelastic elements.
inline const std::array<hyperelastic::Discretisation, 3> hyperelastic_kinds{
    {{.degree = 1}, {.degree = 2}, {.degree = 2, .formulation = fem_reference::Formulation::mixed}}};

/// A block of 100 x 120 x 80 mm.
inline const core::Vector3 block_size{0.1, 0.12, 0.08}; ///< [m]
inline std::shared_ptr<const core::Body> soft_block() {
    return make_body(shaken_box_mesh(block_size, {2, 2, 2}), soft_material);
}

/// @param rule  of quadratic elements
inline hyperelastic::Elements
neo_hookean_elements(const std::shared_ptr<const core::Body> &body, int degree = 2,
                     fem_reference::Formulation formulation = fem_reference::Formulation::displacement,
                     hyperelastic::TetrahedronRule rule = hyperelastic::TetrahedronRule::fourteen_points) {
    return {body, degree, formulation, hyperelastic::material_law("neo_hookean"),
            degree == 1 ? hyperelastic::TetrahedronRule::one_point : rule};
}

/// A body whose three sides at the origin slide.
inline core::LoadCase on_rollers(const core::TetraMesh &mesh) {
    auto load_case = empty_load_case(mesh);
    prescribe(load_case, mesh, "x_min", {0.0, free_component, free_component});
    prescribe(load_case, mesh, "y_min", {free_component, 0.0, free_component});
    prescribe(load_case, mesh, "z_min", {free_component, free_component, 0.0});
    return load_case;
}

/// A bar that is clamped at one end.
struct Bar {
    std::shared_ptr<const core::Body> body = make_body(shaken_box_mesh({0.1, 0.03, 0.03}, {5, 2, 2}), soft_material);
    core::LoadCase clamped = [this] {
        auto load_case = held(body->mesh);
        return load_case;
    }();

    core::LoadCase pulled(const core::Vector3 &traction) const {
        auto load_case = clamped;
        pull(load_case, body->mesh, "x_max", traction);
        return load_case;
    }
};

/// Shape (T) [Pa], on one patch alone.
inline std::vector<double> pressure_on(const core::TetraMesh &mesh, const std::string &patch, double pressure) {
    std::vector<double> result(mesh.boundary_triangles.size(), 0.0);
    for (std::size_t f = 0; f < result.size(); ++f)
        if (mesh.patch_names[mesh.boundary_patch[f]] == patch)
            result[f] = pressure;
    return result;
}

inline double largest(const std::vector<core::Vector3> &displacement) {
    double result = 0.0;
    for (const auto &u : displacement)
        result = std::max(result, u.norm());
    return result;
}

inline const core::Vector3 touched_size{0.1, 0.1, 0.06};

/// A block that stands on its bottom; a ball comes from above.
inline core::Problem touched_block(double friction, const core::Vector3 &press,
                                   const core::Vector3 &slide = core::Vector3::Zero()) {
    const auto body = make_body(shaken_box_mesh(touched_size, {3, 3, 2}), soft_material);
    auto load_case = held(body->mesh, "z_min");
    constexpr double radius = 0.04;
    load_case.touching = core::TouchingTool{.shape = radius,
                                            .start = {0.047, 0.052, touched_size.z() + radius},
                                            .press = press,
                                            .slide = slide,
                                            .friction = friction,
                                            .constraint = load_case.num_constraints()};
    load_case.conditions.push_back({"touch", core::ConditionKind::touch});
    load_case.regime = core::Regime::large;
    return {body, load_case};
}

inline hyperelastic::PathSolution touch(const core::Problem &problem, const hyperelastic::Discretisation &kind,
                                        const std::vector<double> &fractions) {
    return hyperelastic::solve(problem, hyperelastic::material_law("neo_hookean"), kind,
                               {.fractions = fractions, .tolerance = 1e-9});
}

} // namespace livermark::tests
