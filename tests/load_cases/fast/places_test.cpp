#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <numbers>
#include <string>
#include <vector>

#include "load_cases/places/selector.hpp"
#include "load_cases/readers/load_case_reader.hpp"
#include "tests/bad_input.hpp"
#include "tests/golden.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

using core::Vector3;

/// A cube of 0.1 m with a lump around (0.07, 0.03, 0.05) m.
core::TetraMesh lumpy_block() {
    auto mesh = tests::box_mesh({0.1, 0.1, 0.1}, {10, 10, 10});
    mesh.region_names.emplace_back("lump");
    for (int t = 0; t < mesh.num_tetrahedra(); ++t) {
        Vector3 centroid = Vector3::Zero();
        for (const int node : mesh.tetrahedra[t])
            centroid += 0.25 * mesh.points[node];
        mesh.region[t] = (centroid - Vector3(0.07, 0.03, 0.05)).lpNorm<Eigen::Infinity>() < 0.02 ? 1 : 0;
    }
    return mesh;
}

/// The same cut open from above between x = 0.04 and 0.06 m, down to z = 0.03 m.
core::TetraMesh slotted_block() {
    auto mesh = tests::box_mesh({0.1, 0.1, 0.1}, {10, 10, 10});
    std::erase_if(mesh.tetrahedra, [&](const auto &nodes) {
        Vector3 centroid = Vector3::Zero();
        for (const int node : nodes)
            centroid += 0.25 * mesh.points[node];
        return std::abs(centroid.x() - 0.05) < 0.01 && centroid.z() > 0.03;
    });
    mesh.region.assign(mesh.tetrahedra.size(), 0);
    mesh.boundary_triangles = core::outer_faces(mesh.tetrahedra);
    mesh.boundary_patch.assign(mesh.boundary_triangles.size(), 0);
    mesh.patch_names = {"surface"};
    return mesh;
}

load_cases::Selection select(const std::string &condition, const core::TetraMesh &mesh) {
    return load_cases::select_facets(support::parse_toml(condition, "place.toml"), mesh,
                                     core::with_free_surface({}, mesh));
}

/// Area of the facets times what a load of 1 Pa is on them [m^2].
double loaded_area(const load_cases::Selection &selection, const core::TetraMesh &mesh) {
    const auto shares = load_cases::load_shares(selection, mesh);
    double area = 0.0;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        area += shares[f] * area_vector(mesh, f).norm();
    return area;
}

/// All of them face the same way, and their centroids are around a place.
void expect_around(const load_cases::Selection &selection, const core::TetraMesh &mesh, const Vector3 &place,
                   const Vector3 &normal, double radius) {
    ASSERT_FALSE(selection.facets.empty());
    for (const int f : selection.facets) {
        EXPECT_LT((area_vector(mesh, f).normalized() - normal).norm(), 1e-9);
        EXPECT_LT((load_cases::facet_centroid(mesh, f) - place).norm(), radius);
    }
}

// A facet's centroid is up to 7 mm from the place on its side of a brick of 10 mm.
constexpr double disc_radius = 0.02;
constexpr double reach = disc_radius + 0.008;

TEST(Selectors, DiscOverARegionIsWhereTheDirectionLeavesTheBody) {
    const auto mesh = lumpy_block();
    const auto up = select(R"(disc = { region = "lump", direction = [0, 0, 2], radius = 0.02 })", mesh);
    expect_around(up, mesh, {0.07, 0.03, 0.1}, Vector3::UnitZ(), reach);
    EXPECT_EQ(up.name, "disc over lump");
    const auto left = select(R"(disc = { region = "lump", direction = [-1, 0, 0], radius = 0.02 })", mesh);
    expect_around(left, mesh, {0.0, 0.03, 0.05}, -Vector3::UnitX(), reach);
}

TEST(Selectors, DiscAtAPointIsAtTheNearestFacetUnlessADirectionLeadsElsewhere) {
    const auto mesh = lumpy_block();
    expect_around(select("disc = { point = [0.05, 0.09, 0.05], radius = 0.02 }", mesh), mesh, {0.05, 0.1, 0.05},
                  Vector3::UnitY(), reach);
    expect_around(select("disc = { point = [0.05, 0.09, 0.05], direction = [0, -1, 0], radius = 0.02 }", mesh), mesh,
                  {0.05, 0.0, 0.05}, -Vector3::UnitY(), reach);
}

TEST(Selectors, DiscAtAPointMayBeItsRadiusOffTheSurface) {
    const auto mesh = lumpy_block();
    expect_around(select("disc = { point = [0.05, 0.05, 0.119], radius = 0.02 }", mesh), mesh, {0.05, 0.05, 0.1},
                  Vector3::UnitZ(), reach);
    expect_around(select("disc = { point = [0.05, 0.05, 0.2], direction = [0, 0, -1], radius = 0.02 }", mesh), mesh,
                  {0.05, 0.05, 0.0}, -Vector3::UnitZ(), reach);
}

TEST(Selectors, DiscAtAPointInTheMiddleOfTheBodyIsTakenForOneInMetres) {
    auto mesh = lumpy_block();
    for (auto &point : mesh.points)
        point -= Vector3(0.05, 0.05, 0.05);
    tests::expect_input_error(
        [&] { select("disc = { point = [0.0, 0.0, 5e-5], radius = 0.02 }", mesh); },
        {"multiplied by 1000 it is near the surface", "correct it, or the 'unit' of the load case"});
}

TEST(Selectors, PatchesThatShareFacetsHaveAllOfThem) {
    auto mesh = lumpy_block();
    const auto top = select("patch = \"z_max\"", mesh).facets;
    for (std::size_t f = 0; f < top.size(); f += 2)
        mesh.boundary_patch[top[f]] = static_cast<int>(mesh.patch_names.size());
    mesh.patch_names.emplace_back("lid+z_max");
    EXPECT_EQ(select("patch = \"z_max\"", mesh).facets, top);
    EXPECT_EQ(select("patch = \"lid\"", mesh).facets.size(), top.size() / 2);
    tests::expect_input_error([&] { select("patch = \"lit\"", mesh); }, {"it has x_min, x_max", "z_max, lid;"});
}

TEST(Selectors, DirectionLeadsToTheLastExitAndTheOppositeIsTheFirst) {
    const auto mesh = slotted_block();
    expect_around(select("disc = { point = [0.02, 0.05, 0.07], direction = [1, 0, 0], radius = 0.02 }", mesh), mesh,
                  {0.1, 0.05, 0.07}, Vector3::UnitX(), reach);
    expect_around(select("disc = { point = [-0.01, 0.05, 0.07], opposite = true, radius = 0.02 }", mesh), mesh,
                  {0.04, 0.05, 0.07}, Vector3::UnitX(), reach);
}

TEST(Selectors, DiscHasTheResultantOfItsCircle) {
    const auto mesh = lumpy_block();
    const auto disc = select(R"(disc = { region = "lump", direction = [0, 0, 1], radius = 0.02 })", mesh);
    EXPECT_NEAR(loaded_area(disc, mesh), std::numbers::pi * 4e-4, 1e-15);
}

TEST(Selectors, SeveralPatchesAreOnePlace) {
    const auto mesh = lumpy_block();
    const auto place = select(R"(patches = ["z_max", "x_min", "z_max"])", mesh);
    EXPECT_EQ(place.facets.size(), 400u);
    EXPECT_TRUE(std::ranges::is_sorted(place.facets));
    EXPECT_NEAR(load_cases::area_of(place.facets, mesh), 0.02, 1e-15);
}

TEST(Selectors, EdgeIsOnBothPatchesNearWhereTheyMeet) {
    const auto mesh = lumpy_block();
    const auto place = select(R"(edge = { between = ["x_max", "z_max"], width = 0.012, length = 0.06 })", mesh);
    int num_above = 0;
    for (const int f : place.facets) {
        const Vector3 centroid = load_cases::facet_centroid(mesh, f);
        num_above += area_vector(mesh, f).z() > 0.0;
        EXPECT_LT(std::hypot(centroid.x() - 0.1, centroid.z() - 0.1), 0.012);
        EXPECT_LT(std::abs(centroid.y() - 0.05), 0.03);
    }
    EXPECT_GT(num_above, 5);
    EXPECT_GT(std::ssize(place.facets) - num_above, 5);
}

const std::string constrained = R"(title = "t"
target_peak_displacement = 0.001
[[condition]]
patch = "x_min"
displacement = [0.0, 0.0, 0.0]
[[condition]]
)";

core::LoadCase parse_condition(const std::string &condition, const core::TetraMesh &mesh) {
    return load_cases::parse_load_case(constrained + condition, "held.toml", mesh);
}

TEST(Selectors, RestIsAllThatIsNotTaken) {
    const auto mesh = lumpy_block();
    const auto load_case =
        parse_condition("patch = \"y_max\"\ntraction = [1, 0, 0]\n[[condition]]\nrest = true\npressure = 2.0\n", mesh);
    int num_pressed = 0;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f) {
        EXPECT_FALSE(load_case.is_free(f));
        num_pressed += std::abs(load_case.value[f].norm() - 2.0) < 1e-12;
    }
    EXPECT_EQ(num_pressed, 800);
}

TEST(Effects, PushMovesTheWholePlaceAgainstItsMeanNormalUnderItsName) {
    const auto mesh = lumpy_block();
    const std::string corner = R"(edge = { between = ["x_max", "z_max"], width = 0.012, length = 0.06 })";
    const auto place = select(corner, mesh);
    Vector3 area = Vector3::Zero();
    for (const int f : place.facets)
        area += area_vector(mesh, f);
    EXPECT_GT(area.normalized().dot(Vector3(1.0, 0.0, 1.0).normalized()), 0.9);
    const auto load_case = parse_condition("name = \"corner\"\n" + corner + "\npush = 0.002\n", mesh);
    EXPECT_EQ(load_case.constraint_names(), (std::vector<std::string>{"x_min", "corner"}));
    for (const int f : place.facets) {
        EXPECT_EQ(load_case.constraint_on(f), 1);
        EXPECT_LT((load_case.value[f] + 0.002 * area.normalized()).norm(), 1e-15);
    }
}

TEST(Effects, TangentialTractionHasNoPartAlongTheNormal) {
    const auto mesh = lumpy_block();
    const auto load_case = parse_condition("patches = [\"y_max\", \"z_max\"]\ntangential_traction = [1, 2, 3]\n", mesh);
    int num_above = 0, num_beside = 0;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (load_case.is_loaded(f)) {
            const bool above = area_vector(mesh, f).z() > 1e-9;
            ++(above ? num_above : num_beside);
            EXPECT_LT((load_case.value[f] - (above ? Vector3(1, 2, 0) : Vector3(1, 0, 3))).norm(), 1e-12);
        }
    EXPECT_EQ(num_above, 200); // two facets for each of 10 x 10 bricks
    EXPECT_EQ(num_beside, 200);
}

TEST(Effects, TorqueIsTheMomentOfItsTractionsWithoutAResultant) {
    const auto mesh = lumpy_block();
    for (const Vector3 &torque : {Vector3(0.3, 0.0, 0.0), Vector3(0.0, 0.1, -0.2)}) {
        const auto load_case = parse_condition(
            fmt::format("patch = \"x_max\"\ntorque = [{}, {}, {}]\n", torque.x(), torque.y(), torque.z()), mesh);
        Vector3 force = Vector3::Zero(), moment = Vector3::Zero();
        for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
            if (load_case.is_loaded(f)) {
                const Vector3 on_facet = area_vector(mesh, f).norm() * load_case.value[f];
                force += on_facet;
                moment += load_cases::facet_centroid(mesh, f).cross(on_facet);
            }
        EXPECT_LT(force.norm(), 1e-12);
        EXPECT_LT((moment - torque).norm(), 1e-12);
    }
}

TEST(Selectors, WhatTheBodyLacksIsToldFromWhatIsWrittenWrongly) {
    const auto mesh = lumpy_block();
    EXPECT_THROW(select("patch = \"lobe\"", mesh), load_cases::NotOnBody);
    EXPECT_THROW(select("disc = { region = \"tumour_1\", radius = 0.01 }", mesh), load_cases::NotOnBody);
    try {
        select("disc = { region = \"lump\", radius = -0.01 }", mesh);
        FAIL() << "the radius was accepted";
    } catch (const load_cases::NotOnBody &error) {
        FAIL() << error.what();
    } catch (const support::InputError &) {
    }
}

const std::vector<std::string> bad_places{
    "disc = { region = \"lmp\", radius = 0.01 }",
    "disc = { radius = 0.01 }",
    "disc = { patch = \"z_max\", region = \"lump\", radius = 0.01 }",
    "disc = { patch = \"z_max\", direction = [0, 0, 1], radius = 0.01 }",
    "disc = { region = \"lump\", direction = [0, 0, 0], radius = 0.01 }",
    "disc = { point = [0.15, 0.15, 0.15], direction = [0, 0, 1], radius = 0.01 }",
    "disc = { point = [50, 50, 110], radius = 0.01 }",
    "disc = { point = [5, 5, 11], radius = 0.01 }",
    "disc = { point = [0.05, 0.05, 0.13], radius = 0.01 }",
    "disc = { point = [50, 50, 110], direction = [0, 0, -1], radius = 0.01 }",
    "disc = { patch = \"z_max\", radius = 10 }",
    "edge = { between = [\"z_max\", \"x_max\"], width = 10, length = 0.01 }",
    "disc = { patch = \"z_max\", radius = 0.01, opposite = \"yes\" }",
    "disc = { pacth = \"z_max\", radius = 0.01 }",
    "patches = \"z_max\"",
    "patches = [\"z_max\", \"lobe\"]",
    "edge = { between = [\"z_max\"], width = 0.01, length = 0.01 }",
    "edge = { between = [\"z_max\", \"z_min\"], width = 0.01, length = 0.01 }",
    "edge = { between = [\"z_max\", \"x_max\"], width = 0.01, length = 0 }",
    "disc = { patch = \"x_max\", radius = 1e-6 }\ntorque = [1, 0, 0]\n[[condition]]\npatch = \"y_max\"",
    "rest = false",
    "rest = true\npressure = 1.0\n[[condition]]\nrest = true",
    "rest = true\npressure = 1.0\n[[condition]]\npatch = \"z_max\"",
    ""};

TEST(Selectors, RefuseBadPlacesWithPlaceAndRemedy) {
    std::string refusals;
    for (const auto &condition : bad_places)
        refusals +=
            tests::refusal(condition, [&] { parse_condition(condition + "\npressure = 1.0\n", lumpy_block()); });
    tests::expect_golden("refusals_of_places", refusals);
}

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
