#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <string>

#include "app/live/scene.hpp"
#include "load_cases/readers/load_case_reader.hpp"
#include "msm/elastic_body.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark::live {
namespace {

using core::Vector3;

constexpr double radius = 0.012; // [m]

/// A box of 40 x 40 x 10 mm whose sides can be touched but for the bottom.
struct Box {
    core::TetraMesh mesh = tests::box_mesh({0.04, 0.04, 0.01}, {4, 4, 1});
    Surface surface = touchable_surface(mesh, [this] {
        std::vector<bool> is_constrained;
        for (const int patch : mesh.boundary_patch)
            is_constrained.push_back(mesh.patch_names[patch] == "z_min");
        return is_constrained;
    }());

    int node_at(const Vector3 &place) const {
        for (int i = 0; i < mesh.num_nodes(); ++i)
            if ((mesh.points[i] - place).norm() < 1e-9)
                return i;
        return -1;
    }
    /// In the middle of the top.
    int top_node() const { return node_at({0.02, 0.02, 0.01}); }

    Disc on_top(double disc_radius = radius) const {
        return disc_around(surface, mesh.points, place_of_node(surface, mesh.points, top_node()), disc_radius);
    }
    core::Vector3 outside(double ball, const Vector3 &centre) const {
        return live::outside(surface, ball, centre, [&](int node) { return mesh.points[node]; });
    }
};

void expect_on_top(const Box &box, const std::vector<int> &nodes) {
    ASSERT_FALSE(nodes.empty());
    for (const int node : nodes)
        EXPECT_NEAR(box.mesh.points[node].z(), 0.01, 1e-12);
}

TEST(LiveDisc, SpreadsAForceAsTheLoadCaseOfThatRadiusDoes) {
    const Box box;
    const core::Problem problem{
        .body = tests::make_body(box.mesh, {1060.0, 5e3, 0.45}),
        .load_case = load_cases::parse_load_case(
            "title = \"t\"\ntarget_peak_displacement = 0.001\n[[condition]]\npatch = \"z_min\"\n"
            "displacement = [0.0, 0.0, 0.0]\n[[condition]]\n"
            "disc = { point = [0.017, 0.022, 0.01], radius = 0.012, profile = \"round\" }\n"
            "force = [0.0, 0.0, -2.0]\n",
            "tool.toml", box.mesh)};
    const auto expected = msm::nodal_conditions(problem, std::vector<double>(box.mesh.points.size(), 0.0)).force;
    const Place place{.point = {0.017, 0.022, 0.01}, .outwards = Vector3::UnitZ(), .triangle = -1};
    const auto load = load_of(disc_around(box.surface, box.mesh.points, place, radius), {0.0, 0.0, -2.0});
    const auto on = [](const std::vector<int> &numbers, const std::vector<Vector3> &forces, std::size_t number) {
        const auto found = std::ranges::find(numbers, static_cast<int>(number)) - numbers.begin();
        return found == std::ssize(numbers) ? Vector3(Vector3::Zero()) : forces[found];
    };
    const auto tool = problem.load_case.round_loads().front();
    EXPECT_NEAR((load.shape.middle - tool.middle).norm(), 0.0, 1e-12);
    EXPECT_EQ(load.shape.radius, tool.radius);
    for (std::size_t i = 0; i < expected.size(); ++i)
        EXPECT_NEAR((on(load.nodes, load.nodal, i) - expected[i]).norm(), 0.0, 0.005 * 2.0) << i;
    for (std::size_t t = 0; t < box.surface.triangles.size(); ++t) {
        const int f = box.surface.facet[t];
        const Vector3 traction = problem.load_case.value[f];
        const Vector3 on_facet =
            problem.load_case.round_load_on(f) ? Vector3(box.surface.area[t] * traction) : Vector3::Zero();
        EXPECT_NEAR((on(load.triangles, load.facet, t) - on_facet).norm(), 0.0, 0.005 * 2.0) << t;
    }
}

TEST(LiveDisc, TakesWhatItSharesOutAndLeavesTheFarSideAlone) {
    const Box box;
    const auto disc = box.on_top(0.02); // reaches below the bottom
    expect_on_top(box, disc.nodes);
    const Vector3 force(0.3, -0.2, 1.0);
    const auto load = load_of(disc, force);
    Vector3 over_nodes = Vector3::Zero(), over_facets = Vector3::Zero();
    for (const auto &f : load.nodal)
        over_nodes += f;
    for (const auto &f : load.facet)
        over_facets += f;
    for (const auto &sum : {over_nodes, over_facets, load.total, mean_over(disc, [&](int) { return force; })})
        EXPECT_NEAR((sum - force).norm(), 0.0, 1e-12);
}

TEST(LiveDisc, IsOfItsTriangleAloneWhereTheMeshIsTooCoarseForIt) {
    const Box box;
    const Place place{
        .point = {0.012, 0.021, 0.01}, .outwards = Vector3::UnitZ(), .triangle = box.on_top().triangles.front()};
    const auto disc = disc_around(box.surface, box.mesh.points, place, 1e-5);
    EXPECT_EQ(disc.triangles.size(), 1U);
    EXPECT_EQ(disc.nodes.size(), 3U);
    const auto mean = mean_over(disc, [](int) { return Vector3(1.0, 2.0, 3.0); });
    EXPECT_NEAR((mean - Vector3(1.0, 2.0, 3.0)).norm(), 0.0, 1e-12);
}

/// Wherever it is put down, it is led from outside.
TEST(LiveBall, BeginsWhereItDoesNotReachIntoTheBody) {
    const Box box;
    const auto near = [](const Vector3 &found, const Vector3 &expected) {
        EXPECT_LT((found - expected).norm(), 2e-5 * radius) << found.transpose();
    };
    near(box.outside(radius, {0.02, 0.02, 0.05}), {0.02, 0.02, 0.05});
    near(box.outside(radius, {0.017, 0.022, 0.015}), {0.017, 0.022, 0.01 + radius});
    near(box.outside(radius, {0.017, 0.022, 0.009}), {0.017, 0.022, 0.01 + radius});
    near(box.outside(radius, {0.039, 0.022, 0.003}), {0.04 + radius, 0.022, 0.003});
    const Vector3 beside_edge = box.outside(radius, {0.042, 0.02, 0.012});
    near(beside_edge, Vector3(0.04, 0.02, 0.01) + radius * Vector3(1.0, 0.0, 1.0).normalized());
    for (const double x : {0.001, 0.02, 0.038})
        for (const double z : {0.001, 0.005, 0.009}) {
            const auto centre = box.outside(0.004, {x, 0.015, z});
            const Vector3 inside = centre.cwiseMax(Vector3::Zero()).cwiseMin(Vector3(0.04, 0.04, 0.01));
            EXPECT_GT((centre - inside).norm(), 0.00399) << x << ' ' << z;
        }
}

/// A ball that is pushed through the surface finds nothing to push.
TEST(LiveBall, TouchesNothingWhereItsCentreIsBelowTheSurface) {
    const Box box;
    std::vector<bool> is_constrained;
    for (const int patch : box.mesh.boundary_patch)
        is_constrained.push_back(box.mesh.patch_names[patch] == "z_min");
    auto ball =
        take_ball(touchable_body({.name = {}, .mesh = box.mesh, .materials = {{1060.0, 5e3, 0.45}}}, is_constrained),
                  radius, 0.3);
    const auto at_rest = [&](int node) { return box.mesh.points[node]; };
    const auto led_to = [&](double height) {
        const Proxy proxy{.position = {0.02, 0.02, 0.01 + height}};
        ball.steps_to_look = 0;
        lead(ball, box.surface, proxy, proxy.position, 1e-3, at_rest, at_rest);
        return !ball.is_below;
    };
    EXPECT_TRUE(led_to(0.9 * radius));
    EXPECT_TRUE(led_to(0.1 * radius)) << "it touches already";
    EXPECT_FALSE(led_to(-0.1 * radius));
    EXPECT_FALSE(led_to(0.1 * radius)) << "it would be thrown out";
    EXPECT_TRUE(led_to(0.9 * radius));
}

TEST(LiveProxy, ComesToItsTargetWithoutSwinging) {
    Proxy proxy{.target = {0.01, 0.0, 0.0}};
    double left = 0.01;
    for (int step = 0; step < 2000; ++step) {
        advance(proxy, Vector3::Zero(), 5e-4);
        EXPECT_LE(std::abs(proxy.target.x() - proxy.position.x()), left + 1e-12);
        left = std::abs(proxy.target.x() - proxy.position.x());
    }
    EXPECT_LT(left, 1e-8);
}

TEST(LiveProxy, IsKeptOffItsTargetByTheForceOverItsStiffness) {
    Proxy proxy;
    for (int step = 0; step < 2000; ++step)
        advance(proxy, {0.0, 2.0, 0.0}, 5e-4);
    EXPECT_NEAR(proxy.position.y(), 2.0 / coupling_stiffness, 1e-9);
}

TEST(LiveProxy, IsNeitherStrongerNorFasterThanItMayBe) {
    Proxy proxy{.target = {1.0, 0.0, 0.0}};
    advance(proxy, Vector3::Zero(), 1e-3);
    EXPECT_NEAR(proxy.velocity.x(), strongest_coupling / coupling_mass * 1e-3, 1e-12);
    follow(proxy, {9.0, 0.0, 0.0}, 1e-3);
    EXPECT_NEAR(proxy.target.x(), 1.0 + fastest_target * 1e-3, 1e-12);
}

} // namespace
} // namespace livermark::live
