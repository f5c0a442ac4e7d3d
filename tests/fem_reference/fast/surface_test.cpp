#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <numeric>
#include <random>
#include <span>
#include <vector>

#include "fem_reference/hyperelastic/hyperelasticity.hpp"
#include "fem_reference/hyperelastic/surface.hpp"
#include "tests/fem_reference/hyperelastic_bodies.hpp"
#include "tests/samples/touch/jaws.hpp"

namespace livermark {
namespace {

using core::Vector3;
using hyperelastic::Matrix3;

/// Nearly incompressible, with a shear modulus of 1 Pa.
const core::Material rubber{1000.0, 2.9998, 0.4999};
const auto &law = hyperelastic::material_law("neo_hookean");
const Vector3 up = Vector3::UnitZ();

double root(const std::function<double(double)> &f, double low, double high) {
    const bool is_positive = f(high) > 0.0;
    for (int halving = 0; halving < 50; ++halving) {
        const double middle = 0.5 * (low + high);
        ((f(middle) > 0.0) == is_positive ? high : low) = middle;
    }
    return high;
}

/// F of a half space with two stretches along its surface and a pressure on it.
Matrix3 stretched(const core::Material &material, double x, double y, double pressure) {
    const Matrix3 along = Vector3(x, y, 1.0).asDiagonal();
    return hyperelastic::under_traction(law, {Vector3::Zero(), up, 1.0, along, material}, -pressure * up);
}

double impedance(const Matrix3 &f) {
    return hyperelastic::least_surface_impedance(hyperelastic::whole_tangent(law, rubber, f), up);
}

} // namespace

/// Biot 1963: a free surface wrinkles where it is compressed to these stretches.
TEST(SurfaceImpedance, VanishesAtBiotsLimits) {
    const auto in_plane_strain = [](double stretch) { return impedance(stretched(rubber, stretch, 1.0, 0.0)); };
    const auto uniaxial = [](double stretch) {
        return impedance(stretched(rubber, stretch, 1.0 / std::sqrt(stretch), 0.0));
    };
    const auto equibiaxial = [](double stretch) { return impedance(stretched(rubber, stretch, stretch, 0.0)); };
    EXPECT_NEAR(root(in_plane_strain, 0.5, 0.9), 0.5437, 1e-3);
    EXPECT_NEAR(root(uniaxial, 0.4, 0.9), 0.4437, 1e-3);
    EXPECT_NEAR(root(equibiaxial, 0.62, 0.9), 0.6661, 1e-3);
}

/// With u = curl of psi, psi = (A + B k z) exp(-k z) in a half space that is not stretched and bears p, the increments
/// of the shear and of the normal traction per area at rest vanish where (2 mu + p) A = 2 mu B and p B = (2 mu + p) A.
TEST(SurfaceImpedance, VanishesUnderADeadPressureOfTwoShearModuli) {
    const auto pressed = [](double pressure) { return -impedance(stretched(rubber, 1.0, 1.0, pressure)); };
    EXPECT_NEAR(root(pressed, 0.5, 3.0), 2.0 * rubber.shear_modulus(), 2e-3);
}

/// It depends on the surface, not on how it lies in space.
TEST(SurfaceImpedance, TurnsWithTheBody) {
    const Matrix3 turn = Eigen::AngleAxisd(0.7, Vector3(1.0, 2.0, 3.0).normalized()).toRotationMatrix();
    const auto f = stretched(rubber, 0.8, 0.7, 0.5);
    const auto turned = hyperelastic::whole_tangent(law, rubber, turn * f * turn.transpose());
    EXPECT_NEAR(hyperelastic::least_surface_impedance(turned, turn * up), impedance(f), 2e-2 * rubber.shear_modulus());
}

TEST(SurfaceImpedance, IsNoNumberWhereTheMaterialItselfIsNotElliptic) {
    const hyperelastic::Tangent softening = -hyperelastic::whole_tangent(law, rubber, Matrix3::Identity());
    hyperelastic::Tangent mixed = softening;
    mixed(0, 0) = mixed(4, 4) = 1.0;
    EXPECT_TRUE(std::isnan(hyperelastic::least_surface_impedance(mixed, up)));
}

TEST(SurfaceDeformation, UnderATractionBalancesItAndKeepsTheSurface) {
    Matrix3 f;
    f << 1.2, 0.1, 0.3, -0.1, 0.8, 0.2, 0.15, 0.05, 0.6;
    const hyperelastic::SurfacePoint point{Vector3::Zero(), up, 1.0, f, tests::soft_material};
    const Vector3 traction(200.0, -100.0, -1500.0);
    const auto balanced = hyperelastic::under_traction(law, point, traction);
    EXPECT_LT((hyperelastic::whole_stress(law, tests::soft_material, balanced) * up - traction).norm(), 1e-5);
    EXPECT_EQ(balanced.leftCols<2>(), f.leftCols<2>());
    EXPECT_GT(balanced.determinant(), 0.0);
}

/// Quadratic elements, of which u may be any quadratic function.
TEST(SurfaceDeformation, IsThatOfTheElements) {
    const auto body = tests::soft_block();
    const auto elements = tests::neo_hookean_elements(body, 2, fem_reference::Formulation::mixed);
    std::vector<double> displacement;
    for (const auto &x : elements.system().points)
        for (const double u : {2.0 * x.x() * x.y() + 0.1 * x.z(), x.z() * x.z(), -0.2 * x.x() + x.y() * x.y()})
            displacement.push_back(u);
    const auto surface = hyperelastic::surface_points(elements, displacement);
    ASSERT_EQ(surface.size(), body->mesh.boundary_triangles.size());
    double area = 0.0;
    Vector3 closed = Vector3::Zero();
    for (const auto &point : surface) {
        const auto &x = point.at_rest;
        Matrix3 expected;
        expected << 1.0 + 2.0 * x.y(), 2.0 * x.x(), 0.1, 0.0, 1.0, 2.0 * x.z(), -0.2, 2.0 * x.y(), 1.0;
        EXPECT_LT((point.deformation - expected).norm(), 1e-12);
        EXPECT_GT(point.normal.dot(x - 0.5 * tests::block_size), 0.0);
        area += point.area;
        closed += point.area * point.normal;
    }
    EXPECT_GE(area, 2.0 * (0.1 * 0.12 + 0.12 * 0.08 + 0.08 * 0.1) - 1e-12);
    EXPECT_LT(closed.norm(), 1e-15);
}

/// A pressure that keeps its direction, on one of six sides that do not stretch. At Poisson's ratio 0.45 the limit is a
/// little below two shear moduli.
TEST(SurfaceDeformation, TellsWhereALoadIsTooMuch) {
    const auto body = tests::soft_block();
    const auto elements = tests::neo_hookean_elements(body, 2, fem_reference::Formulation::mixed);
    auto load_case = tests::on_rollers(body->mesh);
    tests::pull(load_case, body->mesh, "z_max", {0.0, 0.0, -tests::soft_material.shear_modulus()});
    const std::vector<double> at_rest(elements.num_displacements(), 0.0);
    EXPECT_EQ(hyperelastic::unstable_part(elements, load_case, at_rest, 1.8), 0.0);
    EXPECT_EQ(hyperelastic::unstable_part(elements, load_case, at_rest, 2.0), 1.0);
    for (auto &condition : load_case.conditions)
        if (condition.kind == core::ConditionKind::traction)
            condition.kind = core::ConditionKind::pressure;
    EXPECT_EQ(hyperelastic::unstable_part(elements, load_case, at_rest, 2.0), 0.0) << "it follows";
}

namespace {

using hyperelastic::TouchingBall;

std::vector<double> differences(const TouchingBall &ball, const std::vector<double> &at,
                                const std::vector<double> &direction, double step) {
    std::vector<double> slope(at.size(), 0.0);
    for (const double sign : {1.0, -1.0}) {
        auto there = at;
        for (std::size_t dof = 0; dof < at.size(); ++dof)
            there[dof] += sign * step * direction[dof];
        std::vector<double> force(at.size(), 0.0);
        ball.add_forces(ball.tool().centre_at(1.0), there, force);
        for (std::size_t dof = 0; dof < at.size(); ++dof)
            slope[dof] -= sign * force[dof] / (2.0 * step);
    }
    return slope;
}

} // namespace

/// Some points stick, others slip, and multipliers are not zero.
TEST(TouchingBall, StiffnessIsTheDerivativeOfItsForces) {
    for (const int degree : {1, 2}) {
        const auto problem = tests::touched_block(0.3, {0.0006, 0.0, -0.002});
        const auto elements = tests::neo_hookean_elements(problem.body, degree);
        // Soft, so that no pressure is beyond what the stiffness takes.
        TouchingBall ball(elements.system(), *problem.body, problem.load_case, {.stiffness = 3.0});
        std::mt19937 generator(3);
        std::uniform_real_distribution<double> some(-1.0, 1.0);
        std::vector<double> state(elements.num_displacements()), direction(elements.num_displacements());
        for (std::size_t dof = 0; dof < state.size(); ++dof) {
            state[dof] = 1e-4 * some(generator);
            direction[dof] = some(generator);
        }
        ball.augment(ball.tool().centre_at(0.5), state);
        const auto sums = ball.sums(ball.tool().centre_at(1.0), state);
        ASSERT_GT(sums.slipping_area, 0.0);
        ASSERT_LT(sums.slipping_area, sums.area);
        hyperelastic::SurfaceStiffness stiffness;
        ball.add_stiffness(ball.tool().centre_at(1.0), state, stiffness);
        auto matrix = elements.zero_tangent();
        std::ranges::fill(matrix.stiffness.below, fem_reference::Block<double>{});
        std::ranges::fill(matrix.stiffness.diagonal, fem_reference::Block<double>{});
        stiffness.add_to(matrix.stiffness);
        std::vector<double> found(state.size());
        matrix.stiffness.multiply(std::span<const double>(direction), std::span<double>(found));
        stiffness.add_product(direction, found);
        const auto slope = differences(ball, state, direction, 1e-9);
        double difference = 0.0, size = 0.0;
        for (std::size_t dof = 0; dof < state.size(); ++dof) {
            difference += (found[dof] - slope[dof]) * (found[dof] - slope[dof]);
            size += slope[dof] * slope[dof];
        }
        EXPECT_GT(size, 0.0);
        EXPECT_LT(std::sqrt(difference / size), 1e-5);
    }
}

/// Forces balance; the surface does not go through the ball, and is not pulled.
TEST(TouchingBall, PressesWithWhatTheOtherSideHolds) {
    for (const double friction : {0.0, 0.3})
        for (const auto &kind : tests::hyperelastic_kinds) {
            const auto problem = tests::touched_block(friction, {0.0, 0.0, -0.006});
            const auto found = tests::touch(problem, kind, {0.5, 1.0});
            ASSERT_EQ(found.solution.status, core::SolutionStatus::ok) << found.solution.message;
            const auto &ball = *problem.load_case.touching;
            const Vector3 held = found.solution.reaction[0], pressed = found.solution.reaction[1];
            EXPECT_LT(pressed.z(), 0.0);
            EXPECT_LT((held + pressed).norm(), 1e-6 * pressed.norm());
            EXPECT_LT(found.points[0].reaction[1].norm(), pressed.norm());
            double nearest = 1.0;
            for (std::size_t node = 0; node < problem.body->mesh.points.size(); ++node)
                nearest = std::min(
                    nearest,
                    (problem.body->mesh.points[node] + found.solution.displacement[node] - ball.centre_at(1.0)).norm());
            EXPECT_GT(nearest, ball.shape.radius - 1e-4);
        }
}

/// Each jaw has the force of one ball on half of the block, and the other one is its mirror image. Both problems have
/// the same equilibria, which are found to residuals of 1e-9: the bound leaves what soft modes make of these.
TEST(TouchingBall, HasASecondJawThatIsItsMirrorImage) {
    constexpr double same_force = 1e-5, radius = 0.04;
    for (const auto &kind : tests::hyperelastic_kinds) {
        const tests::JawsAndHalf problems(tests::shaken_box_mesh(tests::touched_size, {3, 3, 2}), tests::soft_material,
                                          {.shape = radius,
                                           .start = {0.047, 0.052, tests::touched_size.z() + radius},
                                           .press = {0.0, 0.0, -0.004},
                                           .friction = kind.degree == 1 ? 0.3 : 0.0},
                                          {});
        const auto whole = tests::touch(problems.whole, kind, {0.5, 1.0});
        const auto half = tests::touch(problems.half, kind, {0.5, 1.0});
        ASSERT_EQ(whole.solution.status, core::SolutionStatus::ok) << whole.solution.message;
        ASSERT_EQ(half.solution.status, core::SolutionStatus::ok) << half.solution.message;
        ASSERT_EQ(whole.points.size(), half.points.size());
        for (std::size_t k = 0; k < whole.points.size(); ++k) {
            const auto &reaction = whole.points[k].reaction;
            ASSERT_EQ(reaction.size(), 3U);
            const Vector3 held = reaction[0], touch = reaction[1], other_jaw = reaction[2];
            const Vector3 alone = half.points[k].reaction.back();
            EXPECT_LT(touch.z(), 0.0);
            EXPECT_LT((other_jaw - tests::JawsAndHalf::mirrored(touch)).norm(), same_force * touch.norm());
            EXPECT_LT((held + touch + other_jaw).norm(), same_force * touch.norm());
            EXPECT_LT((touch - alone).norm(), same_force * alone.norm());
        }
    }
}

} // namespace livermark
