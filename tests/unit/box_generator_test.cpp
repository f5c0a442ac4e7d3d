#include "meshes/box_generator.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "core/input_error.hpp"
#include "meshes/mesh_figures.hpp"

namespace livermark {

namespace {
const core::Vector3 size(0.3, 0.1, 0.08);
}

TEST(BoxGenerator, FillsTheBoxWithTetrahedraOfTheEdgeAskedFor) {
    for (const double edge : {0.05, 0.025}) {
        const auto figures = meshes::mesh_figures(meshes::generate_box(size, edge));
        EXPECT_NEAR(figures.volume, size.prod(), 1e-12 * size.prod());
        EXPECT_LT((figures.extent - size).norm(), 1e-12);
        EXPECT_NEAR(figures.mean_edge, edge, 0.15 * edge);
        EXPECT_GT(figures.smallest_quality, 0.1);
    }
}

TEST(BoxGenerator, SidesAreFlatPatchesWithOutwardNormals) {
    const auto mesh = meshes::generate_box(size, 0.04);
    const std::vector<std::string> names{"x_min", "x_max", "y_min", "y_max", "z_min", "z_max"};
    ASSERT_EQ(mesh.patch_names, names);
    std::array<core::Vector3, 6> area;
    area.fill(core::Vector3::Zero());
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        area[mesh.boundary_patch[f]] += core::area_vector(mesh, f);
    for (int side = 0; side < 6; ++side) {
        const int axis = side / 2;
        const core::Vector3 wanted =
            (side % 2 == 0 ? -1.0 : 1.0) * size.prod() / size[axis] * core::Vector3::Unit(axis);
        EXPECT_LT((area[side] - wanted).norm(), 1e-12 * wanted.norm()) << names[side];
    }
}

TEST(BoxGenerator, SameArgumentsGiveTheSameMesh) {
    const auto first = meshes::generate_box(size, 0.03);
    const auto second = meshes::generate_box(size, 0.03);
    EXPECT_EQ(first.points, second.points);
    EXPECT_EQ(first.tetrahedra, second.tetrahedra);
}

TEST(BoxGenerator, RefusesLengthsThatAreNotPositive) {
    EXPECT_THROW(meshes::generate_box({0.3, 0.0, 0.1}, 0.05), core::InputError);
    EXPECT_THROW(meshes::generate_box(size, -0.05), core::InputError);
    EXPECT_THROW(meshes::generate_box(size, std::numeric_limits<double>::infinity()), core::InputError);
    EXPECT_THROW(meshes::generate_box(size, std::numeric_limits<double>::quiet_NaN()), core::InputError);
}

} // namespace livermark
