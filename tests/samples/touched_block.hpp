#pragma once

#include "core/problem.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark::tests {

/// A block, and the ball that touches it.
struct TouchedBlock {
    core::Vector3 size{0.04, 0.04, 0.02}; ///< [m]
    std::array<int, 3> bricks{6, 6, 2};
    double poisson_ratio = 0.3;
    core::ToolShape shape = 0.02;        ///< a ball [m]
    core::Vector3 press{0, 0, -3e-3};    ///< [m]
    core::Vector3 aside{1e-4, 2e-4, 0.}; ///< of the ball from the middle of the block's top, where no node is [m]
    double friction = 0.0;
    std::vector<double> path{0.25, 0.5, 0.75, 1.0};
};

/// Plates of a half width of 12 mm and edges of 3 mm.
inline core::ToolShape pressing_plate(core::ToolFace face) {
    return {face, 0.012, 0.003, {0.0, 0.0, -1.0}};
}

/// A block that lies on a floor which holds it, and a ball or plate that presses on its top.
inline core::Problem touched_block(const TouchedBlock &block = {}) {
    const auto body = make_body(box_mesh(block.size, block.bricks), {1060.0, 5e3, block.poisson_ratio});
    auto load_case = empty_load_case(body->mesh);
    load_case.name = "touched_block";
    load_case.regime = core::Regime::large;
    load_case.path = block.path;
    prescribe(load_case, body->mesh, "z_min", core::Vector3::Zero());
    const core::Vector3 top(0.5 * block.size.x(), 0.5 * block.size.y(), block.size.z() + block.shape.radius);
    load_case.touching = core::TouchingTool{.shape = block.shape,
                                            .start = top + block.aside,
                                            .press = block.press,
                                            .friction = block.friction,
                                            .constraint = load_case.num_constraints()};
    load_case.conditions.push_back({"touch", core::ConditionKind::touch});
    return {body, load_case};
}

/// The same, with a ball that presses within 0.1 s, slides along x, and is taken away.
inline core::Problem slid_block(const TouchedBlock &block = {}, double slide = 3e-3) {
    auto problem = touched_block(block);
    problem.load_case.path = {1.0};
    problem.load_case.tool = core::ToolMotion{.constraint = problem.load_case.touching->constraint,
                                              .press_until = 0.1,
                                              .slide = {slide, 0.0, 0.0},
                                              .slide_from = 0.12,
                                              .slide_until = 0.2,
                                              .release_at = 0.24,
                                              .num_frames = 15,
                                              .frame_interval = 0.02,
                                              .mass_damping = 40.0};
    return problem;
}

} // namespace livermark::tests
