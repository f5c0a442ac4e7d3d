#pragma once

#include <algorithm>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "app/live/scene.hpp"
#include "core/mesh/tetra_mesh.hpp"
#include "meshes/cutting/cut.hpp"
#include "tests/app/live/box_scene.hpp"

namespace livermark::live {

using meshes::BladeCut;
using meshes::HalfSpaceCut;
using meshes::RegionCut;

/// The box with a lesion inside, four times as stiff, 2 cm from the free end.
struct SickBox : BoxScene {
    SickBox() {
        body = *tests::make_body(tests::box_mesh({0.06, 0.03, 0.03}, {12, 6, 6}), {1060.0, 5e3, 0.45});
        auto &mesh = body.mesh;
        mesh.region_names = {"soft", "lesion"};
        mesh.region.assign(mesh.tetrahedra.size(), 0);
        for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
            Vector3 middle = Vector3::Zero();
            for (const int node : mesh.tetrahedra[t])
                middle += 0.25 * mesh.points[node];
            mesh.region[t] = (middle - Vector3(0.04, 0.015, 0.0225)).lpNorm<Eigen::Infinity>() < 0.005 ? 1 : 0;
        }
        body.materials.push_back({1060.0, 2e4, 0.45});
        is_constrained.clear();
        for (const int patch : mesh.boundary_patch)
            is_constrained.push_back(mesh.patch_names[patch] == "x_min");
        node = node_at({0.05, 0.02, 0.03});
    }
};

/// So short that none is divided, with and without a cut.
inline Settings short_steps(const std::string &springs) {
    auto chosen = settings(springs);
    chosen.time_step = 5e-5;
    return chosen;
}

inline CutRequest around_lesion(double margin) {
    return {.tool = RegionCut{"lesion", margin}};
}
inline CutRequest beyond(double x) {
    return {.tool = HalfSpaceCut{{x, 0.0, 0.0}, {1.0, 0.0, 0.0}}};
}
/// Across the box, from above through so much of its height, 1 mm thick.
inline CutRequest blade(double x, double depth) {
    const double low = 0.03 - depth, high = 0.04;
    return {
        .tool = BladeCut{
            {Vector3(x, -0.01, high), Vector3(x, 0.04, high), Vector3(x, 0.04, low), Vector3(x, -0.01, low)}, 0.001}};
}

/// The same without thickness.
inline CutRequest parting(double x, double depth) {
    auto request = blade(x, depth);
    std::get<BladeCut>(request.tool).thickness = 0.0;
    return request;
}

inline void expect_same(const Frame &is, const Frame &should) {
    ASSERT_EQ(is.displacement.size(), should.displacement.size());
    for (std::size_t i = 0; i < is.displacement.size(); ++i)
        ASSERT_EQ(is.displacement[i], should.displacement[i]) << i;
    EXPECT_EQ(is.force, should.force);
    EXPECT_EQ(is.tool, should.tool);
}

inline double volume_of_body(const core::TetraMesh &mesh) {
    double sum = 0.0;
    for (const double volume : core::tetrahedron_volumes(mesh))
        sum += volume;
    return sum;
}

} // namespace livermark::live
