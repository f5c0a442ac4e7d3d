// Left out where Bullet is not installed (Debian: libbullet-dev).
#include "benchmarks/peers/bullet_scene.hpp"

#include <BulletSoftBody/btDeformableLinearElasticityForce.h>
#include <BulletSoftBody/btDeformableMassSpringForce.h>
#include <BulletSoftBody/btDeformableNeoHookeanForce.h>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "benchmarks/peers/bullet_counterparts.hpp"
#include "interactive/elements/explicit_tetrahedra.hpp"
#include "interactive/method.hpp"
#include "tests/interactive/moving_scene.hpp"
#include "tests/oracles/equilibria.hpp"
#include "tests/oracles/slow_methods.hpp"

namespace livermark {
namespace {

namespace laws = benchmarks::bullet_laws;
using benchmarks::append_links;
using benchmarks::append_tetrahedra;
using benchmarks::BulletDeformable;
using benchmarks::BulletIterations;
using benchmarks::BulletPositionBased;
using benchmarks::positions_of;
using benchmarks::set_state;
using interactive::Field;
using tests::bar_scene;
using tests::noise;

/// Over the length of the motion since the start.
double distance(const Field &found, const Field &expected, const Field &start) {
    return (found - expected).norm() / (expected - start).norm();
}

template <class Law> std::unique_ptr<btDeformableLagrangianForce> bullet_law(double mu, double lambda) {
    return std::make_unique<Law>(static_cast<btScalar>(mu), static_cast<btScalar>(lambda), 0.0F);
}

std::unique_ptr<btDeformableLagrangianForce> bullet_linear(const interactive::Scene &scene) {
    const auto &material = scene.body->materials[0];
    return std::make_unique<btDeformableLinearElasticityForce>(static_cast<btScalar>(material.shear_modulus()),
                                                               static_cast<btScalar>(material.lame_lambda()),
                                                               static_cast<btScalar>(scene.mass_damping), 0.0F);
}

std::unique_ptr<btDeformableLagrangianForce> bullet_neo_hookean(const interactive::Scene &scene) {
    const auto &material = scene.body->materials[0];
    const auto law = laws::NeoHookean::for_small_strains(material.shear_modulus(), material.lame_lambda());
    return bullet_law<btDeformableNeoHookeanForce>(law.mu, law.lambda);
}

/// Stretched along the bar and thinned across it, so that no tetrahedron turns.
Field stretched(const interactive::Scene &scene) {
    return core::Vector3(1.05, 0.98, 0.97).asDiagonal() * interactive::rest_positions(scene);
}

/// Gravity on both.
struct Weight {
    explicit Weight(const interactive::Scene &scene) : forces(Field::Zero(3, scene.node_mass.size())) {
        for (Eigen::Index i = 0; i < forces.cols(); ++i)
            forces.col(i) = scene.node_mass[i] * acceleration;
    }
    core::Vector3 acceleration{2.0, 0.0, -9.81};
    Field forces; ///< shape (3, N) [N]
    btDeformableGravityForce bullet{benchmarks::to_bullet(acceleration)};
};

/// Positions are to 1e-7 of their size, and a step moves them by a hundredth of it.
constexpr double position_rounding = 1e-4;
constexpr double frame = 1.0 / 60.0;

/// As Bullet's.
std::unique_ptr<interactive::Simulation> without_preconditioner(const interactive::Scene &scene) {
    return std::make_unique<tests::Corotational>(scene, tests::Preconditioner::none);
}

/// Between 15 and 100 iterations conjugate gradients in single precision fall behind, by up to a hundredth at 25; then
/// they have converged.
TEST(BulletSteps, CorotationalOnesAreThoseOfCorotationalImplicitAfterAsManyIterations) {
    for (const int iterations : {1, 5, 15, 100}) {
        const auto scene = bar_scene(true, 0.45, 7.0);
        Weight weight(scene);
        const auto ours = without_preconditioner(scene);
        const Field x = stretched(scene), still = Field::Zero(3, x.cols());
        ours->set_state(x, still);
        ours->set_external_forces(weight.forces);
        Field targets = ours->targets();
        for (Eigen::Index c = 0; c < targets.cols(); ++c)
            targets.col(c) = x.col(scene.constrained_nodes[c]);
        ours->set_targets(targets);
        BulletDeformable bullet(scene, bullet_linear(scene),
                                {.implicit = true, .conjugate_gradients = iterations, .tolerance = 0.0});
        append_tetrahedra(*bullet.body, scene.body->mesh);
        bullet.world.addForce(bullet.body.get(), &weight.bullet);
        set_state(*bullet.body, x, still);
        ours->step(frame, iterations);
        bullet.step(frame);
        const double found = distance(positions_of(*bullet.body), ours->positions(), x);
        fmt::print("{} iterations: {:.1e}\n", iterations, found);
        EXPECT_LT(found, position_rounding);
    }
}

/// Bullet linearises where the velocity goes, ours where the body is.
TEST(BulletSteps, CorotationalOnesWithVelocityDifferByWhatLinearisationNeglects) {
    std::vector<double> found;
    for (const double h : {4e-3, 2e-3, 1e-3}) {
        const auto scene = bar_scene(true);
        const auto ours = without_preconditioner(scene);
        const Field x = stretched(scene);
        Field v = noise(x.cols(), 0.3, 3);
        Field targets = ours->targets();
        for (Eigen::Index c = 0; c < targets.cols(); ++c) {
            targets.col(c) = x.col(scene.constrained_nodes[c]);
            v.col(scene.constrained_nodes[c]).setZero();
        }
        ours->set_state(x, v);
        ours->set_targets(targets);
        BulletDeformable bullet(scene, bullet_linear(scene), {.implicit = true, .tolerance = 1e-12});
        append_tetrahedra(*bullet.body, scene.body->mesh);
        set_state(*bullet.body, x, v);
        ours->step(h, 300);
        bullet.step(h);
        found.push_back(distance(positions_of(*bullet.body), ours->positions(), x));
        fmt::print("h = {} s: {:.1e}\n", h, found.back());
    }
    EXPECT_LT(found[1], 0.5 * found[0]);
    EXPECT_LT(found[2], 0.5 * found[1]);
}

TEST(BulletSteps, ExplicitNeoHookeanOnesAreThoseOfCentralDifferencesWithItsLaw) {
    const auto scene = bar_scene(true);
    Weight weight(scene);
    benchmarks::BulletLawExplicit ours(scene);
    const Field x = ours.positions() + noise(ours.positions().cols(), 1e-3, 5), still = Field::Zero(3, x.cols());
    Field start = x;
    for (const int node : scene.constrained_nodes)
        start.col(node) = ours.positions().col(node);
    ours.set_state(start, still);
    ours.set_external_forces(weight.forces);
    BulletDeformable bullet(scene, bullet_neo_hookean(scene), {});
    append_tetrahedra(*bullet.body, scene.body->mesh);
    bullet.world.addForce(bullet.body.get(), &weight.bullet);
    set_state(*bullet.body, start, still);
    const double h =
        0.5 * interactive::critical_time_step_bound(benchmarks::tetrahedra_for_bullet(*scene.body), scene.node_mass);
    for (int s = 0; s < 50; ++s) {
        ours.step(h, 1);
        bullet.step(h);
    }
    const double found = distance(positions_of(*bullet.body), ours.positions(), start);
    fmt::print("after 50 steps: {:.1e}\n", found);
    EXPECT_LT(found, position_rounding);
}

/// A tool moves the end of the bar meanwhile.
TEST(BulletSteps, ImplicitNeoHookeanOnesComeToBackwardEulerAfterMoreIterationsThanBulletTakes) {
    const auto scene = bar_scene(true);
    benchmarks::BulletLawExplicit ours(scene); // for its energy, state and targets
    const Field x = ours.positions(), still = Field::Zero(3, x.cols());
    const Field targets = ours.targets().colwise() + core::Vector3(0.0, 0.0, 3e-3);
    ours.set_targets(targets);
    const auto expected = tests::backward_euler(ours, frame);
    ASSERT_TRUE(expected.converged);
    const auto distance_of = [&](const BulletIterations &iterations) {
        BulletDeformable bullet(scene, bullet_neo_hookean(scene), iterations);
        append_tetrahedra(*bullet.body, scene.body->mesh);
        set_state(*bullet.body, x, still);
        bullet.set_targets(scene, targets, frame);
        bullet.step(frame);
        return distance(positions_of(*bullet.body), expected.positions, x);
    };
    const double as_it_is = distance_of({.implicit = true});
    const double converged = distance_of({.implicit = true, .newton = 12, .tolerance = 1e-10});
    fmt::print("one iteration of Newton's method, Bullet's own: {:.1e}, twelve: {:.1e}\n", as_it_is, converged);
    EXPECT_LT(converged, position_rounding);
    EXPECT_GT(as_it_is, 10.0 * converged);
}

TEST(BulletSteps, ImplicitSpringsAreWhereFastMassSpringConverges) {
    const auto scene = bar_scene(true);
    Weight weight(scene);
    benchmarks::UniformMassSpring ours(scene);
    const Field x = ours.positions(), still = Field::Zero(3, x.cols());
    ours.set_external_forces(weight.forces);
    const auto expected = tests::backward_euler(ours, frame);
    ASSERT_TRUE(expected.converged);
    ours.step(frame, 400);
    EXPECT_LT(distance(ours.positions(), expected.positions, x), 1e-6);
    const auto stiffness = ours.energy().springs().stiffness[0];
    const auto distance_of = [&](const BulletIterations &iterations) {
        BulletDeformable bullet(
            scene, std::make_unique<btDeformableMassSpringForce>(static_cast<btScalar>(stiffness), 0.0F), iterations);
        append_links(*bullet.body, ours.energy().springs().edges, {1.0});
        bullet.world.addForce(bullet.body.get(), &weight.bullet);
        set_state(*bullet.body, x, still);
        bullet.step(frame);
        return distance(positions_of(*bullet.body), expected.positions, x);
    };
    const double as_it_is = distance_of({.implicit = true});
    const double converged = distance_of({.implicit = true, .newton = 12, .tolerance = 1e-10});
    fmt::print("one iteration of Newton's method, Bullet's own: {:.1e}, twelve: {:.1e}\n", as_it_is, converged);
    EXPECT_LT(converged, position_rounding);
    EXPECT_GT(as_it_is, 10.0 * converged);
}

/// Springs alone: below Poisson's ratio 1/4 xpbd_springs has no volumes.
constexpr double ratio_without_volumes = 0.2;

/// How far a step of btSoftBody is from that of xpbd_springs, over the length of the motion.
double distance_of_position_based(double noise_size, int iterations) {
    const auto scene = bar_scene(true, ratio_without_volumes);
    const auto ours = tests::slow_method("xpbd_springs").prepare(scene);
    Field x = ours->positions() + noise(ours->positions().cols(), noise_size, 9);
    for (const int node : scene.constrained_nodes)
        x.col(node) = ours->positions().col(node);
    const Field still = Field::Zero(3, x.cols());
    const auto [edges, parts] = benchmarks::links_as_compliant(scene, frame);
    BulletPositionBased bullet(scene, iterations);
    append_links(*bullet.body, edges, parts);
    set_state(*bullet.body, x, still);
    ours->set_state(x, still);
    ours->step(frame, iterations);
    bullet.step(frame);
    return distance(positions_of(*bullet.body), ours->positions(), x);
}

TEST(BulletSteps, PassOverLinksIsThatOfXpbdSpringsUpToTheSquareOfTheirStretch) {
    const double coarse = distance_of_position_based(1e-3, 1), fine = distance_of_position_based(2.5e-4, 1);
    fmt::print("springs stretched by a tenth: {:.1e}, by a quarter of that: {:.1e}\n", coarse, fine);
    EXPECT_LT(fine, 0.35 * coarse);
    EXPECT_LT(fine, 0.02);
}

TEST(BulletSteps, PassesWithoutMultipliersStiffenWithTheirNumber) {
    const double ten = distance_of_position_based(2.5e-4, 10);
    fmt::print("ten passes: {:.2f}\n", ten);
    EXPECT_GT(ten, 3.0 * distance_of_position_based(2.5e-4, 1));
}

} // namespace
} // namespace livermark
