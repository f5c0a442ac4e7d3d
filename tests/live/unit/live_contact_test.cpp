#include <gtest/gtest.h>
#include <numbers>
#include <random>

#include "live/contact.hpp"
#include "live/virtual_coupling.hpp"
#include "tests/test_meshes.hpp"

namespace livermark::live {
namespace {

using core::Vector3;

/// A box of 40 x 40 x 10 mm whose sides can all be touched.
struct Box {
    core::TetraMesh mesh = tests::box_mesh({0.04, 0.04, 0.01}, {4, 4, 1});
    Surface surface = touchable_surface(mesh, std::vector<bool>(mesh.boundary_triangles.size(), false));
    double modulus = 2e6; // [Pa/m]

    Load contact(const Sphere &sphere) const {
        const auto position_of = [&](int node) { return mesh.points[node]; };
        auto load = no_load(surface);
        add_contact(surface, near_triangles(surface, sphere, 0.0, position_of), sphere, modulus, position_of, load);
        return load;
    }
    /// A node in the middle of the top.
    int top_node() const {
        for (int i = 0; i < mesh.num_nodes(); ++i)
            if ((mesh.points[i] - Vector3(0.02, 0.02, 0.01)).norm() < 1e-9)
                return i;
        return -1;
    }
};

/// Of the pressure over a triangle, cut into four by the middles of its edges, and each of these again.
double contact_energy(const std::array<Vector3, 3> &corners, double area, const Sphere &sphere, double modulus,
                      int num_cuts = 2) {
    const auto &[a, b, c] = corners;
    if (num_cuts == 0) {
        const double depth = sphere.radius - ((a + b + c) / 3.0 - sphere.centre).norm();
        return depth > 0.0 ? 0.5 * modulus * area * depth * depth : 0.0;
    }
    const Vector3 ab = 0.5 * (a + b), bc = 0.5 * (b + c), ca = 0.5 * (c + a);
    double energy = 0.0;
    for (const auto &part : {std::array{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}})
        energy += contact_energy(part, area / 4.0, sphere, modulus, num_cuts - 1);
    return energy;
}

TEST(LiveContact, IsTheGradientOfAnEnergy) {
    Box box;
    std::mt19937 random(1);
    std::uniform_real_distribution<double> shift(-0.002, 0.002);
    for (auto &x : box.mesh.points)
        x += Vector3(shift(random), shift(random), shift(random));
    const Sphere sphere{{0.017, 0.022, 0.016}, 0.009};
    const auto load = box.contact(sphere);
    const auto energy = [&] {
        double sum = 0.0;
        for (std::size_t t = 0; t < box.surface.triangles.size(); ++t) {
            const auto [a, b, c] = box.surface.triangles[t];
            const auto &x = box.mesh.points;
            if ((x[b] - x[a]).cross(x[c] - x[a]).dot(sphere.centre - (x[a] + x[b] + x[c]) / 3.0) > 0.0)
                sum += contact_energy({x[a], x[b], x[c]}, box.surface.area[t], sphere, box.modulus);
        }
        return sum;
    };
    ASSERT_GT(load.nodes.size(), 3U);
    const double step = 1e-7;
    for (const int node : load.nodes)
        for (int axis = 0; axis < 3; ++axis) {
            double &x = box.mesh.points[node][axis];
            const double before = x;
            x = before + step;
            const double ahead = energy();
            x = before - step;
            const double behind = energy();
            x = before;
            EXPECT_NEAR(load.nodal[node][axis], -(ahead - behind) / (2.0 * step), 1e-5 * load.total.norm());
        }
}

TEST(LiveContact, PushesTheSideThatLooksAtTheSphereAndNoOther) {
    const Box box;
    const auto load = box.contact({{0.02, 0.02, 0.015}, 0.02}); // reaches below the bottom
    ASSERT_FALSE(load.triangles.empty());
    Vector3 sum = Vector3::Zero(), over_facets = Vector3::Zero();
    for (const int t : load.triangles) {
        over_facets += load.facet[t];
        for (const int node : box.surface.triangles[t])
            EXPECT_NEAR(box.mesh.points[node].z(), 0.01, 1e-12);
    }
    for (const int node : load.nodes)
        sum += load.nodal[node];
    EXPECT_LT(load.total.z(), -1.0);
    EXPECT_NEAR((sum - load.total).norm(), 0.0, 1e-12 * load.total.norm());
    EXPECT_NEAR((over_facets - load.total).norm(), 0.0, 1e-12 * load.total.norm());
}

/// A shallow cap of a sphere in a plane displaces p times the volume of the cap.
TEST(LiveContact, AddsUpToTheVolumeThatTheSphereTakes) {
    Box box;
    const double radius = 0.03, depth = 0.003;
    const auto load = box.contact({{0.02, 0.02, 0.01 + radius - depth}, radius});
    const double cap = std::numbers::pi * depth * depth * (radius - depth / 3.0);
    EXPECT_NEAR(-load.total.z(), 2e6 * cap, 0.1 * 2e6 * cap);
}

TEST(LiveContact, LeavesAloneWhatTheSphereDoesNotReach) {
    const Box box;
    EXPECT_TRUE(box.contact({{0.02, 0.02, 0.03}, 0.0199}).triangles.empty());
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

TEST(LiveGrip, HoldsTheSurfaceAroundItsNodeAndSharesTheForce) {
    const Box box;
    const auto grip = grip_around(box.surface, box.mesh.points, box.top_node(), 0.012);
    ASSERT_GT(grip.triangles.size(), 4U);
    for (const int t : grip.triangles)
        for (const int node : box.surface.triangles[t])
            EXPECT_NEAR(box.mesh.points[node].z(), 0.01, 1e-12) << "the far side is not held";
    const Vector3 force(0.3, -0.2, 1.0);
    auto load = no_load(box.surface);
    add_pull(grip, box.surface, force, load);
    EXPECT_NEAR((load.total - force).norm(), 0.0, 1e-12);
    const auto mean = mean_over(grip, box.surface, [&](int) { return force; });
    EXPECT_NEAR((mean - force).norm(), 0.0, 1e-12);
}

TEST(LiveGrip, HoldsTheTrianglesAtItsNodeHoweverSmallItIs) {
    const Box box;
    const auto grip = grip_around(box.surface, box.mesh.points, box.top_node(), 1e-3);
    EXPECT_GE(grip.triangles.size(), 4U);
}

} // namespace
} // namespace livermark::live
