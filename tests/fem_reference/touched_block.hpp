#pragma once

#include <vector>

#include "tests/fem_reference/hyperelastic_bodies.hpp"

namespace livermark::tests {

inline const core::Vector3 touched_size{0.1, 0.1, 0.06};

/// A block that stands on its bottom; a ball comes from above.
inline core::Problem touched_block(double friction, const core::Vector3 &press,
                                   const core::Vector3 &slide = core::Vector3::Zero()) {
    const auto body = make_body(shaken_box_mesh(touched_size, {3, 3, 2}), soft_material);
    auto load_case = empty_load_case(body->mesh);
    prescribe(load_case, body->mesh, "z_min", core::Vector3::Zero());
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
