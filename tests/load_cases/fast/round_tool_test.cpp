#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <string>

#include "load_cases/places/selector.hpp"
#include "load_cases/readers/load_case_reader.hpp"
#include "tests/bad_input.hpp"
#include "tests/fem_reference/fem_test_bodies.hpp"
#include "tests/golden.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

using core::Vector3;

constexpr double radius = 0.02; // m
const Vector3 size(0.1, 0.1, 0.1);

/// Two meshes of one cube, with other nodes.
std::array<core::TetraMesh, 2> two_meshes() {
    return {tests::shaken_box_mesh(size, {10, 10, 10}), tests::box_mesh(size, {13, 14, 12})};
}

core::LoadCase with_tool(const std::string &profile, const std::string &effect, const core::TetraMesh &mesh) {
    return load_cases::parse_load_case(
        "title = \"t\"\ntarget_peak_displacement = 0.001\n[[condition]]\npatch = \"z_min\"\n"
        "displacement = [0.0, 0.0, 0.0]\n[[condition]]\nname = \"tool\"\n"
        "disc = { patch = \"z_max\", radius = 0.02, profile = \"" +
            profile + "\" }\n" + effect + "\n",
        "tool.toml", mesh);
}

/// Sums of the forces on the nodes of quadratic elements, about the middle of the side.
struct Resultant {
    Vector3 force = Vector3::Zero();
    Vector3 first_moment = Vector3::Zero(); ///< sum of the size of a force times its place
    double second_moment = 0.0;             ///< and times the square of its distance
};

Resultant resultant(const core::LoadCase &load_case, const core::TetraMesh &mesh) {
    Resultant result;
    const Vector3 middle(0.05, 0.05, 0.1);
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (load_case.is_loaded(f)) {
            const Vector3 force = area_vector(mesh, f).norm() * load_case.value[f];
            result.force += force;
            const auto corners = core::corners_of(mesh, f);
            const auto parts = core::quadratic_parts(load_case.round_load_on(f), corners);
            for (std::size_t k = 0; k < 6; ++k) {
                const Vector3 place = k < 3 ? corners[k] : Vector3(0.5 * (corners[k - 3] + corners[(k - 2) % 3]));
                result.first_moment += parts[k] * force.norm() * (place - middle);
                result.second_moment += parts[k] * force.norm() * (place - middle).squaredNorm();
            }
        }
    return result;
}

TEST(RoundTool, PressesWithTheSameForceInTheSameMiddleOnEveryMesh) {
    const double force = 600.0 * std::numbers::pi * radius * radius;
    for (const auto &mesh : two_meshes()) {
        const auto pressed = resultant(with_tool("round", "pressure = 600.0", mesh), mesh);
        EXPECT_LT((pressed.force + force * Vector3::UnitZ()).norm(), 1e-12 * force);
        // Quadratic functions are integrated as they are; the second moment of Hertz's pressure is 2/5 F a^2.
        EXPECT_LT(pressed.first_moment.norm(), 1e-3 * force * radius);
        EXPECT_NEAR(pressed.second_moment, 0.4 * force * radius * radius, 1e-3 * force * radius * radius);
    }
}

/// Two jaws are one instrument, and so one newton.
TEST(RoundTool, PressesToADepthWithOneNewtonOnEveryMesh) {
    for (const auto &mesh : two_meshes()) {
        const auto one = with_tool("round", "press = 0.004", mesh);
        EXPECT_EQ(one.press_depth, 0.004);
        EXPECT_EQ(one.constraint_names(), (std::vector<std::string>{"z_min", "tool"}));
        const auto pressed = resultant(one, mesh);
        EXPECT_LT((pressed.force + Vector3::UnitZ()).norm(), 1e-12);
        EXPECT_NEAR(pressed.second_moment, 0.4 * radius * radius, 1e-3 * radius * radius);
        EXPECT_LT((core::press_resultants(one, mesh)[1] + Vector3::UnitZ()).norm(), 1e-12);

        const auto two = with_tool("round",
                                   "press_along = [0.0, 0.003, -0.004]\n[[condition]]\npatch = \"x_max\"\n"
                                   "press_along = [-0.005, 0.0, 0.0]",
                                   mesh);
        EXPECT_DOUBLE_EQ(two.press_depth, 0.005);
        const auto resultants = core::press_resultants(two, mesh);
        EXPECT_LT((resultants[1] - Vector3(0.0, 0.3, -0.4)).norm(), 1e-12);
        EXPECT_LT((resultants[2] - Vector3(-0.5, 0.0, 0.0)).norm(), 1e-12);
    }
}

/// The function on the facets that is nearest to the paraboloid has its mean.
TEST(RoundTool, SinksInAsDeepOnTheMeanOnEveryMesh) {
    for (const auto &mesh : two_meshes()) {
        const auto load_case = with_tool("round", "push = 0.004", mesh);
        ASSERT_EQ(load_case.node_factor.size(), mesh.points.size());
        double mean = 0.0, wanted = 0.0, area = 0.0;
        for (int f = 0; f < mesh.num_boundary_triangles(); ++f) {
            if (load_case.constraint_on(f) != 1)
                continue;
            EXPECT_LT((load_case.value[f] + 0.004 * Vector3::UnitZ()).norm(), 1e-12);
            const auto &corners = mesh.boundary_triangles[f];
            const double part = area_vector(mesh, f).norm();
            area += part;
            for (std::size_t k = 0; k < 3; ++k) {
                mean += part / 3.0 * load_case.factor_at(corners[k]);
                const Vector3 side = 0.5 * (mesh.points[corners[k]] + mesh.points[corners[(k + 1) % 3]]);
                const double ratio = (side - Vector3(0.05, 0.05, 0.1)).norm() / radius;
                wanted += part / 3.0 * (1.0 - 0.5 * ratio * ratio); // the rule is exact for quadratic functions
            }
        }
        EXPECT_NEAR(mean / area, wanted / area, 1e-3);
        EXPECT_NEAR(area, std::numbers::pi * radius * radius, 0.15 * area);
        const auto [shallowest, deepest] = std::ranges::minmax(load_case.node_factor);
        EXPECT_GE(shallowest, 0.0);
        EXPECT_LT(shallowest, 0.6);
        EXPECT_LT(deepest, 1.2);
    }
}

TEST(RoundTool, AFlatOneLeavesWhatIsPrescribedAsItIs) {
    const auto mesh = two_meshes()[0];
    EXPECT_TRUE(with_tool("flat", "push = 0.004", mesh).node_factor.empty());
    EXPECT_TRUE(with_tool("round", "pressure = 10.0", mesh).node_factor.empty());
}

TEST(RoundTool, KeepsApartFromWhatMovesItsNodesOtherwise) {
    const auto mesh = two_meshes()[0];
    const std::string beside = "displacement = [0.0, 0.0, -0.001]\n[[condition]]\nname = \"second\"\ndisc = { point = "
                               "[0.085, 0.07, 0.1], radius = 0.02, profile = \"round\" }\n";
    // Each other component is free, but a node has one factor.
    const auto load_case = with_tool("round", beside + "displacement = [0.002, \"free\", \"free\"]", mesh);
    ASSERT_EQ(load_case.yielded.size(), 1U);
    std::vector<int> owner(mesh.points.size(), -1);
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (load_case.constraint_on(f) >= 1)
            for (const int node : mesh.boundary_triangles[f]) {
                EXPECT_TRUE(owner[node] < 0 || owner[node] == load_case.constraint_on(f));
                owner[node] = load_case.constraint_on(f);
            }
}

TEST(RoundTool, RefusesWhatItCannotDo) {
    const auto mesh = two_meshes()[0];
    std::string refusals;
    const std::string beside = "press = 0.001\n[[condition]]\npatch = \"x_max\"\n";
    for (const auto &[profile, effect] : {std::pair<const char *, std::string>{"pointed", "push = 0.001"},
                                          {"round", "torque = [0.0, 0.0, 0.1]"},
                                          {"round", "press = 0.0"},
                                          {"round", beside + "press = 0.002"},
                                          {"round", beside + "traction = [1.0, 0.0, 0.0]"},
                                          {"round", beside + "displacement = [0.001, 0.0, 0.0]"},
                                          {"flat", "tangential_force = [0.0, 0.0, 0.0]"}})
        refusals += tests::refusal(profile + std::string(": ") + effect, [&] { with_tool(profile, effect, mesh); });
    refusals += tests::refusal("nothing held", [&] {
        load_cases::parse_load_case("[[condition]]\npatch = \"z_max\"\npress = 0.001\n", "tool.toml", mesh);
    });
    tests::expect_golden("refusals_of_round_tools", refusals);
}

TEST(Forces, HaveTheResultantThatIsGivenOnEveryMesh) {
    for (const auto &mesh : two_meshes()) {
        const Vector3 force(0.5, -0.2, 1.0);
        const auto pulled = resultant(with_tool("round", "force = [0.5, -0.2, 1.0]", mesh), mesh);
        EXPECT_LT((pulled.force - force).norm(), 1e-12);
        const auto dragged = resultant(with_tool("flat", "tangential_force = [0.5, -0.2, 0.0]", mesh), mesh);
        EXPECT_NEAR(dragged.force.dot(Vector3(0.5, -0.2, 0.0).normalized()), std::hypot(0.5, 0.2), 1e-12);
        EXPECT_NEAR(dragged.force.z(), 0.0, 1e-12);
        EXPECT_THROW(with_tool("flat", "tangential_force = [0.0, 0.0, 1.0]", mesh), load_cases::NotOnBody);
    }
}

} // namespace
} // namespace livermark
