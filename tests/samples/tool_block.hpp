#pragma once

#include "core/problem.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark::tests {

/// A block that is held at one end. A tool presses on the other end, slides and lets go, in fifteen frames.
inline core::Problem tool_block() {
    const auto body = make_body(box_mesh({0.06, 0.03, 0.03}, {4, 2, 2}), {1060.0, 5e3, 0.45});
    auto load_case = empty_load_case(body->mesh);
    load_case.name = "tool_block";
    load_case.regime = core::Regime::large;
    load_case.target_peak_displacement = 0.006;
    prescribe(load_case, body->mesh, "x_min", core::Vector3::Zero());
    prescribe(load_case, body->mesh, "x_max", {-0.006, 0.0, 0.0});
    load_case.tool = core::ToolMotion{.constraint = 1,
                                      .press_until = 0.1,
                                      .slide = {0.0, 0.004, 0.0},
                                      .slide_from = 0.12,
                                      .slide_until = 0.2,
                                      .release_at = 0.22,
                                      .num_frames = 15,
                                      .frame_interval = 0.02,
                                      .mass_damping = 20.0};
    return {body, load_case};
}

} // namespace livermark::tests
