// Left out where Bullet is not installed (Debian: libbullet-dev).
#include "benchmarks/peers/bullet_scene.hpp"

#include <BulletSoftBody/btDeformableCorotatedForce.h>
#include <BulletSoftBody/btDeformableLinearElasticityForce.h>
#include <BulletSoftBody/btDeformableMassSpringForce.h>
#include <BulletSoftBody/btDeformableNeoHookeanForce.h>
#include <fmt/format.h>
#include <gtest/gtest.h>

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
using interactive::Matrix3;
using tests::bar_scene;
using tests::noise;

double distance(const Field &a, const Field &b) {
    return (a - b).norm() / b.norm();
}

/// The same between forces of Bullet and those of the same law in double precision, which it prints.
double rounding(const char *law, const Field &found, const Field &expected) {
    const double result = distance(found, expected);
    fmt::print("{}: forces of the same law to {:.1e}\n", law, result);
    return result;
}

/// The bar, bent by some 60 degrees and dented at random by up to 2 mm of its edges of 15 mm.
Field bent(const interactive::Scene &scene) {
    Field x = interactive::rest_positions(scene);
    constexpr double curvature = 18.0; // [1/m]
    for (Eigen::Index i = 0; i < x.cols(); ++i) {
        const double angle = curvature * x(0, i), radius = 1.0 / curvature - x(2, i);
        x(0, i) = radius * std::sin(angle);
        x(2, i) = 1.0 / curvature - radius * std::cos(angle);
    }
    return x + noise(x.cols(), 2e-3, 7);
}

template <class Density> Field forces(const std::vector<interactive::Tetrahedron> &tetrahedra, const Field &x) {
    Field f = Field::Zero(3, x.cols());
    for (const auto &t : tetrahedra)
        t.add_forces(Density{t.mu, t.lambda}.stress(t.gradient(x)), f);
    return f;
}

Field forces_of(BulletDeformable &bullet, bool keeps_rotations = false) {
    bullet.prepare_forces();
    bullet.evaluate_forces(keeps_rotations);
    return bullet.evaluated_forces();
}

template <class Law>
std::unique_ptr<BulletDeformable> bullet_tetrahedra(const interactive::Scene &scene, double mu, double lambda) {
    auto bullet = std::make_unique<BulletDeformable>(
        scene, std::make_unique<Law>(static_cast<btScalar>(mu), static_cast<btScalar>(lambda)),
        benchmarks::BulletIterations{});
    append_tetrahedra(*bullet->body, scene.body->mesh);
    return bullet;
}

struct BulletLaws : testing::Test {
    interactive::Scene scene = bar_scene(false);
    Field x = bent(scene);
    Field still = Field::Zero(3, x.cols());
    double mu = scene.body->materials[0].shear_modulus(), lambda = scene.body->materials[0].lame_lambda();
    std::vector<interactive::Tetrahedron> tetrahedra = interactive::tetrahedra_at_rest(*scene.body);
};

/// Bullet is in single precision; a force is the difference of stresses around a node.
constexpr double force_rounding = 1e-5;

TEST_F(BulletLaws, NeoHookeanForcesAreThoseOfTheStableEnergyWithItsLogarithm) {
    const auto law = laws::NeoHookean::for_small_strains(mu, lambda);
    const auto bullet = bullet_tetrahedra<btDeformableNeoHookeanForce>(scene, law.mu, law.lambda);
    set_state(*bullet->body, x, still);
    const auto found = forces_of(*bullet);
    const auto tuned = benchmarks::tetrahedra_for_bullet(*scene.body);
    EXPECT_LT(rounding("neo-Hookean", found, forces<laws::NeoHookean>(tuned, x)), force_rounding);
    // Of our methods, vertex_block_descent and xpbd_neo_hookean leave the logarithm out.
    const double without = distance(found, forces<interactive::densities::StableNeoHookean>(tetrahedra, x));
    const double tled = distance(found, forces<interactive::densities::NeoHookean>(tetrahedra, x));
    fmt::print("forces of Bullet's neo-Hookean law are {:.1f} % off those of vertex_block_descent, {:.1f} % off those "
               "of tled\n",
               100.0 * without, 100.0 * tled);
    EXPECT_GT(without, 100.0 * force_rounding); // it is another energy
}

TEST_F(BulletLaws, NeoHookeanLawNeedsOtherParametersThanThoseOfLame) {
    // At small strains, in double precision: the law is that of the material with its own parameters, and 25 % too soft
    // in shear with those of Lame.
    const auto tangent_of = [&](const auto &law) { return law.tangent(Matrix3::Identity()); };
    const auto material = tangent_of(interactive::densities::StableNeoHookean{mu, lambda});
    const auto tuned = tangent_of(laws::NeoHookean::for_small_strains(mu, lambda));
    const auto plain = tangent_of(laws::NeoHookean{mu, lambda});
    EXPECT_LT((tuned - material).norm(), 1e-12 * material.norm());
    EXPECT_NEAR(plain(1, 1) / material(1, 1), 0.75, 1e-12);
}

TEST_F(BulletLaws, NeoHookeanEnergyHasTheseForcesAndThisTangent) {
    const auto law = laws::NeoHookean::for_small_strains(mu, lambda);
    const Matrix3 f = tetrahedra[5].gradient(x);
    constexpr double step = 1e-6;
    for (int k = 0; k < 9; ++k) {
        Matrix3 more = f, less = f;
        more.data()[k] += step;
        less.data()[k] -= step;
        EXPECT_NEAR((law.value(more) - law.value(less)) / (2.0 * step), law.stress(f).data()[k], 1e-4 * mu);
        const Matrix3 slope = (law.stress(more) - law.stress(less)) / (2.0 * step);
        EXPECT_LT((interactive::densities::by_columns(slope) - law.tangent(f).col(k)).norm(), 1e-6 * lambda);
    }
}

TEST_F(BulletLaws, LinearElasticityHasOurCorotationalForcesOnceItHasTheRotations) {
    const auto bullet = bullet_tetrahedra<btDeformableLinearElasticityForce>(scene, mu, lambda);
    set_state(*bullet->body, x, still);
    const auto as_it_is = forces_of(*bullet);
    double largest_angle = 0.0;
    for (std::size_t t = 0; t < tetrahedra.size(); ++t) {
        const Matrix3 exact = interactive::densities::rotation(tetrahedra[t].gradient(x));
        auto &theirs = bullet->body->m_tetraScratches[static_cast<int>(t)].m_corotation;
        Matrix3 found;
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                found(i, j) = theirs[i][j];
        largest_angle = std::max(largest_angle, (found - exact).norm() / std::numbers::sqrt2);
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                theirs[i][j] = static_cast<btScalar>(exact(i, j));
    }
    const auto ours = forces<interactive::densities::Corotational>(tetrahedra, x);
    EXPECT_LT(rounding("linear elasticity, turned", forces_of(*bullet, true), ours), force_rounding);
    fmt::print("Bullet's rotations are up to {:.4f} rad off, its co-rotational forces {:.2f} %\n", largest_angle,
               100.0 * distance(as_it_is, ours));
    // It stops turning at 0.01: two thirds of the angle that is left, so 0.015 rad.
    EXPECT_LT(largest_angle, 0.02);
    EXPECT_GT(distance(as_it_is, ours), 10.0 * force_rounding);
}

/// Line search with this law compares energies that its forces do not know: that of linear elasticity without
/// rotations, where the strain of a turn by an angle a around z is (cos a - 1) (e_x e_x^T + e_y e_y^T).
TEST_F(BulletLaws, LinearElasticityHasTheEnergyOfLinearElasticityThatGrowsWhereTheBodyIsTurned) {
    const auto bullet = bullet_tetrahedra<btDeformableLinearElasticityForce>(scene, mu, lambda);
    constexpr double angle = 0.5;
    const Field turned =
        Eigen::AngleAxisd(angle, core::Vector3::UnitZ()).toRotationMatrix() * interactive::rest_positions(scene);
    set_state(*bullet->body, x, still);
    const double bent_forces = forces_of(*bullet).norm();
    set_state(*bullet->body, turned, still);
    EXPECT_LT(forces_of(*bullet).norm(), 1e-3 * bent_forces);
    double volume = 0.0;
    for (const auto &t : tetrahedra)
        volume += t.volume;
    const double expected = 2.0 * (mu + lambda) * std::pow(std::cos(angle) - 1.0, 2) * volume;
    EXPECT_NEAR(bullet->force->totalElasticEnergy(0.0F), expected, 1e-4 * expected);
}

TEST_F(BulletLaws, CorotatedForcesAreThoseOfItsEnergyWithAVolumeTermThatNoneOfOursHas) {
    const auto bullet = bullet_tetrahedra<btDeformableCorotatedForce>(scene, mu, lambda);
    set_state(*bullet->body, x, still);
    const auto found = forces_of(*bullet);
    EXPECT_LT(rounding("corotated", found, forces<laws::Corotated>(tetrahedra, x)), force_rounding);
    const double ours = distance(found, forces<interactive::densities::Corotational>(tetrahedra, x));
    fmt::print("forces of Bullet's corotated law are {:.1f} % off those of corotational_implicit\n", 100.0 * ours);
    // No derivatives: an implicit step of Bullet leaves it out of the matrix.
    btDeformableLagrangianForce::TVStack moves, changes;
    moves.resize(bullet->body->m_nodes.size(), btVector3(1e-3F, 0.0F, 0.0F));
    moves[0].setZero();
    changes.resize(moves.size(), btVector3(0.0F, 0.0F, 0.0F));
    bullet->force->addScaledElasticForceDifferential(1.0F, moves, changes);
    for (int i = 0; i < changes.size(); ++i)
        EXPECT_EQ(changes[i].length2(), 0.0F);
}

TEST_F(BulletLaws, SpringsHaveTheForcesOfFastMassSpringWithOneStiffness) {
    const auto springs = benchmarks::springs_of_mean_stiffness(*scene.body);
    BulletDeformable bullet(
        scene, std::make_unique<btDeformableMassSpringForce>(static_cast<btScalar>(springs.stiffness[0]), 0.0F), {});
    append_links(*bullet.body, springs.edges, {1.0});
    set_state(*bullet.body, x, still);
    Field ours = Field::Zero(3, x.cols());
    interactive::SpringEnergy(springs).add_forces(x, ours);
    EXPECT_LT(rounding("springs", forces_of(bullet), ours), force_rounding);
}

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

/// Distance of a step of btSoftBody from that of xpbd_springs, over the length of the motion.
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
