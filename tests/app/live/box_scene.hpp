#pragma once

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
    /// In the middle of the top, 1 cm from the free end.
    int node = node_at({0.05, 0.02, 0.03});

    int node_at(const Vector3 &place) const {
        for (int i = 0; i < body.mesh.num_nodes(); ++i)
            if ((body.mesh.points[i] - place).norm() < 1e-9)
                return i;
        return -1;
    }
    /// Of no triangle that can be touched.
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

inline Settings settings(const std::string &law = "patch") {
    return {.springs = law, .young_modulus = 5e3, .poisson_ratio = 0.45, .damping = {40.0, 0.0}};
}

} // namespace livermark::live
