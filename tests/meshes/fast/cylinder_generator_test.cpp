#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <numeric>

#include "meshes/generators/cylinder_generator.hpp"
#include "tests/bad_input.hpp"

namespace livermark {
namespace {

TEST(CylinderGenerator, FillsACylinderAndNamesItsSides) {
    constexpr double radius = 0.03, height = 0.08;
    const auto mesh = meshes::generate_cylinder(radius, height, 0.01);
    const auto volumes = core::tetrahedron_volumes(mesh);
    const double volume = std::accumulate(volumes.begin(), volumes.end(), 0.0);
    const double exact = std::numbers::pi * radius * radius * height;
    EXPECT_LT(volume, exact);
    EXPECT_GT(volume, 0.96 * exact);
    ASSERT_EQ(mesh.patch_names, (std::vector<std::string>{"side", "z_min", "z_max"}));
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        for (const int node : mesh.boundary_triangles[f]) {
            const auto &x = mesh.points[node];
            if (mesh.boundary_patch[f] == 0)
                EXPECT_NEAR(std::hypot(x.x(), x.y()), radius, 1e-9);
            else
                EXPECT_NEAR(x.z(), mesh.boundary_patch[f] == 1 ? 0.0 : height, 1e-9);
        }
}

TEST(CylinderGenerator, MakesTheSameMeshAgain) {
    const auto a = meshes::generate_cylinder(0.02, 0.03, 0.01), b = meshes::generate_cylinder(0.02, 0.03, 0.01);
    EXPECT_EQ(a.points, b.points);
    EXPECT_EQ(a.tetrahedra, b.tetrahedra);
}

TEST(CylinderGenerator, OfLengthsThatAreNoneIsRefused) {
    tests::expect_input_error([] { meshes::generate_cylinder(-0.03, 0.08, 0.01); }, {"radius", "positive"});
    tests::expect_input_error([] { meshes::generate_cylinder(0.03, std::nan(""), 0.01); }, {"height", "positive"});
    tests::expect_input_error([] { meshes::generate_cylinder(0.03, 0.08, 0.04); }, {"edges", "shorter"});
    tests::expect_input_error([] { meshes::generate_cylinder(30.0, 80.0, 0.01); },
                              {"a cylinder of 30 m radius and 80 m height", "tetrahedra", "lengths are in metres"});
}

} // namespace
} // namespace livermark
