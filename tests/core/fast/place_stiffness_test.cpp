#include "core/tool/tool_stiffness.hpp"

#include <cmath>
#include <gtest/gtest.h>

#include "tests/samples/test_meshes.hpp"

namespace livermark::core {
namespace {

/// A cube of 0.1 m held at the bottom, that is squeezed evenly.
struct SqueezedCube {
    TetraMesh mesh = tests::box_mesh({0.1, 0.1, 0.1}, {2, 2, 2});
    LoadCase load_case = tests::empty_load_case(mesh);
    Solution solution{};

    SqueezedCube() {
        tests::prescribe(load_case, mesh, "z_min", Vector3::Zero());
        for (const auto &point : mesh.points)
            solution.displacement.emplace_back(0.0, 0.0, -0.02 * point.z());
    }

    double stiffness() const { return stiffness_at(mesh, load_case, tool_places(mesh, load_case), 0, solution); }
};

TEST(PlaceStiffness, OfAGivenTractionIsForceOverDisplacement) {
    SqueezedCube cube;
    tests::pull(cube.load_case, cube.mesh, "z_max", {0.0, 0.0, -50.0});
    EXPECT_NEAR(cube.stiffness(), 50.0 * 0.01 / 0.002, 1e-9);
    cube.solution.load_work = 1.25 * 0.5 * 0.002; // with shape functions of the model itself
    EXPECT_NEAR(cube.stiffness(), 250.0 / 1.25, 1e-9);
}

TEST(PlaceStiffness, OfADepthIsTheReactionOverIt) {
    SqueezedCube cube;
    tests::press(cube.load_case, cube.mesh, "z_max", {0.0, 0.0, -1.0}, 0.002);
    cube.solution.reaction = {{0.0, 0.0, 0.6}, {0.0, 0.0, -0.6}};
    EXPECT_NEAR(cube.stiffness(), 300.0, 1e-9);
}

TEST(PlaceStiffness, OfAPrescribedDisplacementIsTheReactionAlongIt) {
    SqueezedCube cube;
    tests::prescribe(cube.load_case, cube.mesh, "z_max", {0.0, 0.0, -0.002});
    cube.solution.reaction = {{0.0, 0.0, 0.6}, {0.3, 0.0, -0.6}};
    EXPECT_NEAR(cube.stiffness(), 300.0, 1e-9);
}

TEST(PlaceStiffness, IsUnknownWhereATractionHasNoResultant) {
    SqueezedCube cube;
    tests::pull(cube.load_case, cube.mesh, "z_max", {0.0, 0.0, -50.0});
    auto pulls_up = false; // every other facet, all of one area
    for (std::size_t f = 0; f < cube.load_case.value.size(); ++f)
        if (cube.load_case.is_loaded(f))
            cube.load_case.value[f].z() *= (pulls_up = !pulls_up) ? -1.0 : 1.0;
    EXPECT_TRUE(std::isnan(cube.stiffness()));
}

} // namespace
} // namespace livermark::core
