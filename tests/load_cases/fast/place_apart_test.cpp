#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <string>
#include <vector>

#include "load_cases/places/selector.hpp"
#include "load_cases/readers/load_case_reader.hpp"
#include "tests/bad_input.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

using core::Vector3;

/// Cube with 10 x 10 bricks, two facets each, on a side.
core::TetraMesh plain_block() {
    return tests::box_mesh({0.1, 0.1, 0.1}, {10, 10, 10});
}

/// The block held at x = 0, and one more condition.
core::LoadCase held_and(const std::string &condition) {
    return load_cases::parse_load_case(
        "title = \"t\"\ntarget_peak_displacement = 0.001\n[[condition]]\npatch = \"x_min\"\n"
        "displacement = [0.0, 0.0, 0.0]\n[[condition]]\n" +
            condition,
        "narrow.toml", plain_block());
}

int num_held(const core::LoadCase &load_case) {
    int num = 0;
    for (int f = 0; f < load_case.num_facets(); ++f)
        num += load_case.is_constrained(f) ? 1 : 0;
    return num;
}

TEST(PlacesApart, LoseNothingWhereTheyAreApart) {
    EXPECT_TRUE(held_and("patch = \"x_max\"\ndisplacement = [0.001, 0.0, 0.0]").yielded.empty());
    // A load beside a held place contradicts nothing, and neither does a component that is free there.
    EXPECT_TRUE(held_and("patch = \"z_max\"\npressure = 1.0").yielded.empty());
    EXPECT_TRUE(held_and("patch = \"z_max\"\ndisplacement = [\"free\", \"free\", 0.0]").yielded.empty());
}

TEST(PlacesApart, GiveUpTheFacetsWhoseNodesMoveOtherwise) {
    const auto mesh = plain_block();
    const auto load_case = held_and("name = \"plate\"\npatch = \"z_max\"\npush = 0.002");
    ASSERT_EQ(load_case.yielded.size(), 1U);
    EXPECT_EQ(load_case.yielded[0].name, "plate");
    EXPECT_NEAR(load_case.yielded[0].lost_area, 0.1, 1e-12); // one row of bricks of ten
    std::vector<Vector3> at_node(mesh.points.size(), Vector3::Constant(NAN));
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (load_case.is_constrained(f))
            for (const int node : mesh.boundary_triangles[f]) {
                EXPECT_TRUE(at_node[node].array().isNaN().all() || at_node[node] == load_case.value[f]);
                at_node[node] = load_case.value[f];
            }
    EXPECT_EQ(num_held(load_case), 200 + 180);
}

TEST(PlacesApart, GiveUpTheFacetsOfPlacesAboveAndKeepTheResultantOfADisc) {
    const auto mesh = plain_block();
    // On the edge of the held side: the disc faces x = 0 and its lower part is on a held band.
    const auto load_case = load_cases::parse_load_case(
        "title = \"t\"\ntarget_peak_displacement = 0.001\n[[condition]]\npatch = \"x_max\"\n"
        "displacement = [0.0, 0.0, 0.0]\n[[condition]]\nname = \"band\"\n"
        "edge = { between = [\"x_min\", \"z_min\"], width = 0.031, length = 0.2 }\ntraction = [1.0, 0.0, 0.0]\n"
        "[[condition]]\nname = \"finger\"\ndisc = { patch = \"x_min\", radius = 0.03 }\ntraction = [0.0, 0.0, 7.0]\n",
        "narrow.toml", mesh);
    ASSERT_EQ(load_case.yielded.size(), 1U);
    EXPECT_EQ(load_case.yielded[0].name, "finger");
    EXPECT_GT(load_case.yielded[0].lost_area, 0.02);
    EXPECT_LE(load_case.yielded[0].lost_area, 0.25);
    double force = 0.0;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (load_case.is_loaded(f))
            force += load_case.value[f].z() * area_vector(mesh, f).norm();
    EXPECT_NEAR(force, 7.0 * std::numbers::pi * 9e-4, 1e-12);
}

/// The block with a strip along the held side of the top, which is pushed.
core::LoadCase pushed_strip(double width) {
    auto mesh = plain_block();
    const auto top = load_cases::facets_of_patch("z_max", toml::table(), mesh);
    mesh.patch_names.emplace_back("strip");
    for (const int f : top)
        if (load_cases::facet_centroid(mesh, f).x() < width)
            mesh.boundary_patch[f] = static_cast<int>(mesh.patch_names.size()) - 1;
    return load_cases::parse_load_case("title = \"t\"\ntarget_peak_displacement = 0.001\n[[condition]]\n"
                                       "patch = \"x_min\"\ndisplacement = [0.0, 0.0, 0.0]\n[[condition]]\n"
                                       "patch = \"strip\"\npush = 0.001\n",
                                       "narrow.toml", mesh);
}

/// A strip of four rows of bricks loses one, which is a quarter, and one of three a third.
TEST(PlacesApart, DoNotFitWhereLessThanThreeQuartersAreLeft) {
    const auto fits = pushed_strip(0.04);
    ASSERT_EQ(fits.yielded.size(), 1U);
    EXPECT_NEAR(fits.yielded[0].lost_area, 0.25, 1e-9);
    std::string reason;
    try {
        pushed_strip(0.03);
    } catch (const load_cases::NotOnBody &error) {
        reason = error.reason();
    }
    tests::expect_part(reason, "it keeps 67 % of its area and needs 75 %");
}

} // namespace
} // namespace livermark
