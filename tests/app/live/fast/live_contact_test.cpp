#include <cmath>
#include <gtest/gtest.h>
#include <string>

#include "app/live/contact.hpp"
#include "load_cases/readers/load_case_reader.hpp"
#include "msm/nodal_conditions.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark::live {
namespace {

using core::Vector3;

constexpr double radius = 0.012; // [m]

/// A box of 40 x 40 x 10 mm whose sides can be touched but for the bottom, and what its nodes have moved by.
struct Box {
    core::TetraMesh mesh = tests::box_mesh({0.04, 0.04, 0.01}, {4, 4, 1});
    Surface surface = touchable_surface(mesh, [this] {
        std::vector<bool> is_constrained;
        for (const int patch : mesh.boundary_patch)
            is_constrained.push_back(mesh.patch_names[patch] == "z_min");
        return is_constrained;
    }());
    std::vector<Vector3> displacement = std::vector<Vector3>(mesh.points.size(), Vector3::Zero());

    int node_at(const Vector3 &place) const {
        for (int i = 0; i < mesh.num_nodes(); ++i)
            if ((mesh.points[i] - place).norm() < 1e-9)
                return i;
        return -1;
    }
    /// In the middle of the top.
    int top_node() const { return node_at({0.02, 0.02, 0.01}); }

    Disc disc(const Place &place, double of_radius) const {
        return disc_around(surface, mesh.points, triangles_around(surface, mesh.points, place.point, of_radius, 0.0),
                           place, of_radius);
    }
    Disc on_top(double of_radius = radius) const {
        return disc(place_of_node(surface, mesh.points, top_node()), of_radius);
    }
    Vector3 press(SphereContact &contact, const Sphere &sphere, int times = 1) const {
        Vector3 found = Vector3::Zero();
        for (int i = 0; i < times; ++i)
            found =
                penetration(contact, surface, mesh.points, sphere, 0.5, [&](int node) { return displacement[node]; });
        return found;
    }
    /// Where the middle of a disc is now.
    Vector3 now(const Disc &disc) const {
        return disc.place.point + mean_over(disc, [&](int node) { return displacement[node]; });
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
    SphereContact contact;
    box.press(contact, {{0.017, 0.022, 0.01 + 0.9 * radius}, radius});
    auto load = no_load(box.surface);
    put_force(contact.disc, {0.0, 0.0, -2.0}, load);
    const auto tool = problem.load_case.round_loads().front();
    EXPECT_NEAR((load.shape.middle - tool.middle).norm(), 0.0, 1e-12);
    EXPECT_EQ(load.shape.radius, tool.radius);
    for (std::size_t i = 0; i < expected.size(); ++i)
        EXPECT_NEAR((load.nodal[i] - expected[i]).norm(), 0.0, 0.005 * 2.0) << i;
    for (std::size_t t = 0; t < box.surface.triangles.size(); ++t) {
        const int f = box.surface.facet[t];
        const Vector3 traction = problem.load_case.value[f];
        const Vector3 on_facet =
            problem.load_case.round_load_on(f) ? Vector3(box.surface.area[t] * traction) : Vector3::Zero();
        EXPECT_NEAR((load.facet[t] - on_facet).norm(), 0.0, 0.005 * 2.0) << t;
    }
}

TEST(LiveDisc, TakesWhatItSharesOutAndLeavesTheFarSideAlone) {
    const Box box;
    const auto disc = box.on_top(0.02); // reaches below the bottom
    expect_on_top(box, disc.nodes);
    const Vector3 force(0.3, -0.2, 1.0);
    auto load = no_load(box.surface);
    put_force(disc, {9.0, 9.0, 9.0}, load);
    put_force(disc, force, load);
    Vector3 over_nodes = Vector3::Zero(), over_facets = Vector3::Zero();
    for (const auto &f : load.nodal)
        over_nodes += f;
    for (const auto &f : load.facet)
        over_facets += f;
    for (const auto &sum : {over_nodes, over_facets, load.total, mean_over(disc, [&](int) { return force; })})
        EXPECT_NEAR((sum - force).norm(), 0.0, 1e-12);
    const auto normal = mean_normal(disc, box.surface, [&](int node) { return box.mesh.points[node]; });
    EXPECT_NEAR((normal - Vector3::UnitZ()).norm(), 0.0, 1e-12);
}

TEST(LiveDisc, IsOfItsTriangleAloneWhereTheMeshIsTooCoarseForIt) {
    const Box box;
    const Place place{
        .point = {0.012, 0.021, 0.01}, .outwards = Vector3::UnitZ(), .triangle = box.on_top().triangles.front()};
    const auto disc = box.disc(place, 1e-5);
    EXPECT_EQ(disc.triangles.size(), 1U);
    EXPECT_EQ(disc.nodes.size(), 3U);
    const auto mean = mean_over(disc, [](int) { return Vector3(1.0, 2.0, 3.0); });
    EXPECT_NEAR((mean - Vector3(1.0, 2.0, 3.0)).norm(), 0.0, 1e-12);
}

TEST(LiveContact, IsTheGradientOfAnEnergy) {
    Box box;
    SphereContact contact;
    const Sphere sphere{{0.017, 0.022, 0.019}, radius};
    for (std::size_t i = 0; i < box.displacement.size(); ++i)
        box.displacement[i] = 5e-4 * Vector3(std::sin(1.0 * i), std::cos(2.0 * i), std::sin(3.0 * i));
    const auto found = box.press(contact, sphere, 100);
    ASSERT_TRUE(contact.touches);
    const auto &disc = contact.disc;
    const auto energy = [&] {
        const double depth = sphere.radius - (box.now(disc) - sphere.centre).norm();
        return 0.5 * depth * depth;
    };
    const double step = 1e-7;
    for (std::size_t k = 0; k < disc.nodes.size(); ++k)
        for (int axis = 0; axis < 3; ++axis) {
            double &u = box.displacement[disc.nodes[k]][axis];
            const double before = u;
            u = before + step;
            const double ahead = energy();
            u = before - step;
            const double behind = energy();
            u = before;
            EXPECT_NEAR(disc.weight[k] * found[axis], -(ahead - behind) / (2.0 * step), 1e-5 * found.norm());
        }
}

TEST(LiveContact, GoesAlongUnderASphereThatSlides) {
    Box box;
    SphereContact contact;
    for (int i = 0; i < box.mesh.num_nodes(); ++i) // sheared and stretched
        box.displacement[i] = {0.3 * box.mesh.points[i].z(), 0.5 * box.mesh.points[i].y(), 0.0};
    Sphere sphere{{0.015, 0.020, 0.02}, radius};
    for (int step = 0; step < 100; ++step) {
        sphere.centre += Vector3(1e-4, 1e-4, 0.0);
        box.press(contact, sphere);
        EXPECT_TRUE(contact.touches);
        EXPECT_LT((box.now(contact.disc) - sphere.centre).head<2>().norm(), 5e-4);
    }
    const auto found = box.press(contact, sphere, 50);
    EXPECT_NEAR((box.now(contact.disc) - sphere.centre).head<2>().norm(), 0.0, 2e-4 * radius);
    EXPECT_NEAR((found - Vector3(0.0, 0.0, -0.002)).norm(), 0.0, 1e-5);
}

TEST(LiveContact, LeavesAloneWhatTheSphereDoesNotReachOrHasItsCentreIn) {
    const Box box;
    for (const double height : {0.01 + 1.001 * radius, 0.01 - 0.001}) {
        SphereContact contact;
        EXPECT_TRUE(box.press(contact, {{0.02, 0.02, height}, radius}).isZero(0.0)) << height;
        EXPECT_FALSE(contact.touches);
    }
}

TEST(LiveContact, LosesASphereThatSlidesOffTheRimAndFindsTheSide) {
    const Box box;
    SphereContact contact;
    Sphere sphere{{0.035, 0.02, 0.02}, radius};
    box.press(contact, sphere);
    ASSERT_TRUE(contact.touches);
    double last = 0.002;
    for (int step = 0; step < 400; ++step) {
        sphere.centre += Vector3(5e-5, 0.0, 0.0);
        const double depth = box.press(contact, sphere).norm();
        EXPECT_NEAR(depth, last, 1e-4) << "it does not jump";
        last = depth;
    }
    EXPECT_FALSE(contact.touches);
    sphere.centre.z() = 0.005;
    sphere.centre.x() = 0.04 + radius - 0.001;
    const auto found = box.press(contact, sphere, 20);
    EXPECT_NEAR((found - Vector3(-0.001, 0.0, 0.0)).norm(), 0.0, 1e-5);
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
