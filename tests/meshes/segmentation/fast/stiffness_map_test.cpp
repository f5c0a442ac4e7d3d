#include "meshes/segmentation/images/stiffness_map.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <gtest/gtest.h>
#include <limits>

#include "tests/bad_input.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark::segmentation {
namespace {

using core::Vector3;

constexpr float hole = std::numeric_limits<float>::quiet_NaN();

/// A map around a box of 40 x 30 x 20 mm whose axes are turned against it.
StiffnessMap map_of(const std::function<double(const Vector3 &)> &modulus) {
    StiffnessMap map{.name = "map", .grid = {}, .modulus = {}};
    auto &grid = map.grid;
    grid.size = {40, 36, 20};
    grid.spacing = {0.0016, 0.0017, 0.0028};
    grid.direction = Eigen::AngleAxisd(0.4, Vector3(1.0, 2.0, -1.0).normalized()).toRotationMatrix();
    grid.origin =
        Vector3(0.02, 0.015, 0.01) - grid.direction * (grid.spacing.cwiseProduct(Vector3(39.0, 35.0, 19.0)) / 2.0);
    for (int k = 0; k < grid.size[2]; ++k)
        for (int j = 0; j < grid.size[1]; ++j)
            for (int i = 0; i < grid.size[0]; ++i)
                map.modulus.push_back(
                    static_cast<float>(modulus(to_world(grid, grid.spacing.cwiseProduct(Vector3(i, j, k))))));
    return map;
}

core::Body box(double poisson_ratio = 0.45) {
    return *tests::make_body(tests::box_mesh({0.04, 0.03, 0.02}, {8, 6, 4}), {1060.0, 5e3, poisson_ratio});
}

Vector3 middle_of(const core::TetraMesh &mesh, std::size_t t) {
    Vector3 middle = Vector3::Zero();
    for (const int node : mesh.tetrahedra[t])
        middle += 0.25 * mesh.points[node];
    return middle;
}

double linear(const Vector3 &place) {
    return 3000.0 + 4e4 * place.x() - 2e4 * place.y() + 5e4 * place.z();
}

TEST(StiffnessMap, OfALinearFieldIsItsValueInTheMiddleOfATetrahedron) {
    const auto body = box();
    const auto mapped = mapped_modulus(map_of(linear), body);
    ASSERT_EQ(mapped.young_modulus.size(), body.mesh.tetrahedra.size());
    for (std::size_t t = 0; t < mapped.young_modulus.size(); ++t)
        EXPECT_NEAR(mapped.young_modulus[t], linear(middle_of(body.mesh, t)), 1e-5 * 3000.0);
}

TEST(StiffnessMap, OfAShearModulusFollowsPoissonsRatio) {
    auto map = map_of([](const Vector3 &) { return 2000.0; });
    map.is_shear = true;
    EXPECT_NEAR(mapped_modulus(map, box(0.45)).young_modulus.front(), 2.9 * 2000.0, 1e-3);
    EXPECT_NEAR(mapped_modulus(map, box(0.25)).young_modulus.front(), 2.5 * 2000.0, 1e-3);
}

TEST(StiffnessMap, LeavesHolesOpenAndSaysHowLargeTheyAre) {
    const auto body = box();
    const auto mapped =
        mapped_modulus(map_of([](const Vector3 &place) { return place.x() < 0.01 ? hole : linear(place); }), body);
    double open = 0.0, whole = 0.0;
    const auto volumes = core::tetrahedron_volumes(body.mesh);
    for (std::size_t t = 0; t < volumes.size(); ++t) {
        const bool is_open = std::isnan(mapped.young_modulus[t]);
        const double x = middle_of(body.mesh, t).x();
        EXPECT_TRUE(is_open ? x < 0.0125 : x > 0.0075) << x;
        whole += volumes[t];
        open += is_open ? volumes[t] : 0.0;
    }
    EXPECT_NEAR(open / whole, 0.25, 0.05);
    EXPECT_NE(mapped.remarks.back().find("of the body has no value in it"), std::string::npos) << mapped.remarks.back();
}

TEST(StiffnessMap, BesideTheBodyIsRefused) {
    auto map = map_of(linear);
    map.grid.origin.x() += 0.1;
    tests::expect_input_error([&] { mapped_modulus(map, box()); },
                              {"it has values in 0 % of the body", "the body at x 0 to 40, y 0 to 30, z 0 to 20 mm",
                               "in the same coordinates"});
}

/// An image of NRRD in text, as somebody writes it by hand.
class StiffnessImage : public testing::Test {
  protected:
    void write(const std::string &values) const {
        std::ofstream(path_)
            << "NRRD0004\ntype: float\ndimension: 3\nspace: left-posterior-superior\nsizes: 2 2 2\n"
               "space directions: (20,0,0) (0,20,0) (0,0,20)\nspace origin: (0,0,0)\nencoding: ascii\n\n"
            << values << '\n';
    }
    ~StiffnessImage() override { std::filesystem::remove(path_); }

    const std::filesystem::path path_ = std::filesystem::path(testing::TempDir()) / "stiffness_map.nrrd";
};

TEST_F(StiffnessImage, IsReadInItsUnit) {
    write("2.5 3.5 0 4 2 nan -1 3");
    const auto map = read_stiffness_map(path_, {.is_shear = true, .pascals = 1e3});
    EXPECT_TRUE(map.is_shear);
    ASSERT_EQ(map.modulus.size(), 8u);
    EXPECT_FLOAT_EQ(map.modulus[0], 2500.0F);
    EXPECT_FLOAT_EQ(map.modulus[7], 3000.0F);
    for (const std::size_t v : {2, 5, 6})
        EXPECT_TRUE(std::isnan(map.modulus[v])) << v;
    EXPECT_NEAR(map.grid.spacing.x(), 0.02, 1e-9);
}

TEST_F(StiffnessImage, InAnotherUnitOrOfNothingIsRefused) {
    write("2.5 3.5 1 4 2 3 2 3");
    tests::expect_input_error([&] { read_stiffness_map(path_, {.is_shear = true, .pascals = 1.0}); },
                              {"half of its values are below", "say with --unit whether they are in Pa or kPa"});
    write("2500 3500 1000 4000 2000 3000 2000 3000");
    tests::expect_input_error([&] { read_stiffness_map(path_, {.is_shear = false, .pascals = 1e3}); }, {"--unit"});
    write("0 0 0 0 0 0 0 0");
    tests::expect_input_error([&] { read_stiffness_map(path_, {}); }, {"no voxel has a positive value"});
}

} // namespace
} // namespace livermark::segmentation
