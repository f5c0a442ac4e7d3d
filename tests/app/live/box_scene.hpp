#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/live/parameters.hpp"
#include "app/live/scene.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark::live {

using core::Vector3;

/// A box of 60 x 30 x 30 mm that is constrained at x = 0.
struct BoxScene {
    core::Body body = *tests::make_body(tests::box_mesh({0.06, 0.03, 0.03}, {6, 3, 3}), {1060.0, 5e3, 0.45});
    std::vector<bool> is_constrained = [this] {
        std::vector<bool> constrained;
        for (const int patch : body.mesh.boundary_patch)
            constrained.push_back(body.mesh.patch_names[patch] == "x_min");
        return constrained;
    }();
    std::optional<core::Foundation> foundation{}; ///< below facets that are not constrained
    /// In the middle of the top, 1 cm from the free end.
    int node = node_at({0.05, 0.02, 0.03});

    int node_at(const Vector3 &place) const {
        for (int i = 0; i < body.mesh.num_nodes(); ++i)
            if ((body.mesh.points[i] - place).norm() < 1e-9)
                return i;
        return -1;
    }
    /// Node of no triangle that can be touched.
    int constrained_node() const { return node_at({0.0, 0.01, 0.01}); }

    Tool pull(const Vector3 &by) const {
        return {.kind = ToolKind::pull, .target = body.mesh.points[node] + by, .radius = 0.012, .node = node};
    }
    Tool poke(double depth) const {
        return {.kind = ToolKind::probe,
                .target = body.mesh.points[node] + Vector3(0.0, 0.0, 0.008 - depth),
                .radius = 0.008};
    }
};

/// A body that a ball or plate of a load case presses which is that of the tool.
/// @param start, press  of its centre [m]
inline core::Problem touched_by_ball(const core::Body &body, const std::vector<bool> &is_constrained, const Tool &tool,
                                     const Vector3 &start, const Vector3 &press) {
    core::LoadCase load_case;
    load_case.regime = core::Regime::large;
    load_case.path = {0.25, 0.5, 0.75, 1.0};
    load_case.conditions = {{"held", core::ConditionKind::displacement}, {"touch", core::ConditionKind::touch}};
    load_case.value.assign(is_constrained.size(), Vector3::Zero());
    for (const bool is_held : is_constrained)
        load_case.condition_on.push_back(is_held ? 0 : -1);
    load_case.touching = core::TouchingTool{shape_of(tool), start, press, Vector3::Zero(), tool.friction, 1};
    return {std::make_shared<core::Body>(body), load_case};
}

inline Settings settings(const std::string &law = "patch") {
    return {.springs = law, .young_modulus = 5e3, .poisson_ratio = 0.45, .damping = {40.0, 0.0}};
}

/// Frame after so much time with a tool.
inline Frame moved(Scene &scene, const Tool &tool, double seconds, double time_step) {
    auto frame = scene.move(tool, 0);
    for (int left = static_cast<int>(seconds / time_step); left > 0; left -= 1000)
        frame = scene.move(tool, std::min(left, 1000));
    return frame;
}

/// Relative distance of two fields.
inline double distance(const std::vector<Vector3> &a, const std::vector<Vector3> &b) {
    double square = 0.0, size = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        square += (a[i] - b[i]).squaredNorm();
        size += b[i].squaredNorm();
    }
    return std::sqrt(square / size);
}

} // namespace livermark::live
