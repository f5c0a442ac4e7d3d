#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <numeric>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "msm/springs/springs.hpp"
#include "msm/statics/load_path.hpp"
#include "msm/statics/surface_contact.hpp"
#include "tests/samples/touch/jaws.hpp"
#include "tests/samples/touched_block.hpp"

namespace livermark {
namespace {

using core::Vector3;
using Field = std::vector<Vector3>;

/// Nodes here and there, some inside a ball that has come.
Field bumpy(const core::Problem &problem) {
    auto positions = problem.body->mesh.points;
    for (std::size_t i = 0; i < positions.size(); ++i)
        positions[i] += 1e-3 * Vector3(std::sin(3.0 * static_cast<double>(i)), std::cos(5.0 * static_cast<double>(i)),
                                       std::sin(7.0 * static_cast<double>(i)));
    return positions;
}

struct Touched {
    explicit Touched(const tests::TouchedBlock &block, const char *springs = nullptr,
                     std::optional<double> softness = {})
        : Touched(tests::touched_block(block), springs, softness) {}

    explicit Touched(core::Problem touched, const char *springs = nullptr, std::optional<double> softness = {})
        : problem(std::move(touched)),
          body(springs ? msm::coupled_springs_with_volume(*problem.body, msm::find_coupled_springs(springs))
                       : msm::ElasticBody(msm::spring_network(*problem.body, msm::all_spring_laws().front()))) {
        const auto conditions = msm::nodal_conditions(problem, body.node_mass);
        const msm::RestStiffness rest(body, problem.body->mesh.points, conditions.displacement);
        if (softness)
            body.softness = {.at_first = *softness};
        path = msm::follow_path(body, problem, body.node_mass, rest);
        EXPECT_EQ(path.end.status, core::SolutionStatus::ok) << path.end.message;
    }

    Vector3 force() const { return path.points.back().reaction.back(); }

    core::Problem problem;
    msm::ElasticBody body;
    msm::FollowedPath path;
};

const core::ToolShape shapes_that_touch[] = {0.02, tests::pressing_plate(core::ToolFace::round),
                                             tests::pressing_plate(core::ToolFace::square)};

class ShapesInContact : public testing::TestWithParam<core::ToolShape> {};

TEST_P(ShapesInContact, HaveAnEnergyWhoseDerivativesAreTheirForcesAndTheirHessian) {
    tests::TouchedBlock block;
    block.shape = GetParam();
    block.friction = 0.4;
    block.bricks = {6, 6, 1};
    const auto problem = tests::touched_block(block);
    msm::SurfaceContact contact(problem);
    contact.move_ball(1.0);
    auto x = bumpy(problem);
    contact.update(x); // with bounds of friction that are not zero
    for (auto &point : x)
        point += Vector3(4e-4, -2e-4, 1e-4);
    Field gradient(x.size(), Vector3::Zero());
    contact.add_gradient(x, gradient);
    const auto hessian = contact.hessian(x, msm::Tangent::exact);
    constexpr double h = 1e-7;
    int num_touched = 0;
    for (std::size_t i = 0; i < x.size(); ++i)
        for (int c = 0; c < 3; ++c) {
            auto more = x, less = x;
            more[i][c] += h;
            less[i][c] -= h;
            const double slope = (contact.energy(more) - contact.energy(less)) / (2.0 * h);
            EXPECT_NEAR(slope, gradient[i][c], 1e-6 + 1e-5 * std::abs(slope));
            num_touched += slope != 0.0 ? 1 : 0;
            Field up(x.size(), Vector3::Zero()), down = up;
            contact.add_gradient(more, up);
            contact.add_gradient(less, down);
            for (int r = 0; r < 3; ++r) {
                const double column = (up[i][r] - down[i][r]) / (2.0 * h);
                const auto row = static_cast<Eigen::Index>(3 * i) + r, at = static_cast<Eigen::Index>(3 * i) + c;
                EXPECT_NEAR(column, hessian.coeff(row, at), 1e-3 + 1e-4 * std::abs(column));
            }
        }
    EXPECT_GT(num_touched, 20);
    const Eigen::VectorXd u = Eigen::VectorXd::LinSpaced(hessian.rows(), -1.0, 2.0);
    Eigen::VectorXd product = Eigen::VectorXd::Zero(u.size());
    contact.add_hessian_product(x, u, product);
    EXPECT_LT((product - hessian * u).norm(), 1e-12 * product.norm());
    Vector3 sum = Vector3::Zero();
    for (const auto &force : gradient)
        sum -= force;
    EXPECT_LT((sum - contact.forces(x).at(0)).norm(), 1e-12 * sum.norm());
}

INSTANTIATE_TEST_SUITE_P(SurfaceContact, ShapesInContact, testing::ValuesIn(shapes_that_touch),
                         [](const auto &shape) { return std::string(core::to_string(shape.param.face)); });

/// The floor bears the force of the ball, and it pushes and does not pull.
void expect_balance(const Touched &touched) {
    ASSERT_EQ(touched.path.points.size(), 4U);
    double before = 0.0;
    for (const auto &point : touched.path.points) {
        EXPECT_LT((point.reaction[0] + point.reaction[1]).norm(), 1e-6 * point.reaction[1].norm());
        EXPECT_LT(point.reaction[1].z(), before);
        before = point.reaction[1].z();
    }
}

/// As the depth to a power of 1.5 where the block is large, and more where its floor is near.
void expect_power_of_depth(const Touched &touched) {
    const double power = std::log(touched.force().z() / touched.path.points[1].reaction[1].z()) / std::log(2.0);
    EXPECT_GT(power, 1.3);
    EXPECT_LT(power, 2.2);
}

TEST(SurfaceContact, IsBorneByWhatHoldsTheBody) {
    for (const auto &shape : shapes_that_touch) {
        tests::TouchedBlock block;
        block.shape = shape;
        expect_balance(Touched(block));
    }
    const Touched coupled(tests::TouchedBlock{}, "nodal_neo_hookean");
    expect_balance(coupled);
    expect_power_of_depth(coupled);
}

/// A flat surface that has come straight into a ball: p = eps g, and the integral of p n . e over it, with z0 from its
/// plane to the centre, is pi eps z0 (R - z0)^2.
TEST(SurfaceContact, IntegratesPressureOverFacetsOfAnySize) {
    double coarse_error = 0.0;
    for (const int bricks : {4, 12}) {
        tests::TouchedBlock block;
        block.bricks = {bricks, bricks, 2};
        const auto problem = tests::touched_block(block);
        const auto &material = problem.body->materials.front();
        msm::SurfaceContact contact(problem);
        contact.move_ball(1.0);
        const double side = block.size.x() / bricks, mean_side = side * (2.0 + std::numbers::sqrt2) / 3.0;
        const double eps = material.young_modulus / core::FacetSoftness{}.at_first /
                           (1.0 - material.poisson_ratio * material.poisson_ratio) / mean_side;
        const double depth = -block.press.z(), to_centre = block.shape.radius - depth;
        const double expected = std::numbers::pi * eps * to_centre * depth * depth;
        const double error = -contact.forces(problem.body->mesh.points).at(0).z() / expected - 1.0;
        EXPECT_LT(std::abs(error), 0.02);
        coarse_error = bricks == 4 ? error : coarse_error;
        if (bricks == 12) {
            EXPECT_LT(std::abs(error), 0.002);
            EXPECT_NE(error, coarse_error);
        }
    }
}

/// Forces go to nodes as the shape functions say, so the sum of their moments is that of the points'.
TEST(SurfaceContact, WithoutFrictionHasNoMomentAboutTheCentreOfTheBall) {
    const auto problem = tests::touched_block();
    msm::SurfaceContact contact(problem);
    contact.move_ball(1.0);
    const auto x = bumpy(problem);
    Field gradient(x.size(), Vector3::Zero());
    contact.add_gradient(x, gradient);
    const Vector3 centre = problem.load_case.touching->centre_at(1.0);
    Vector3 moment = Vector3::Zero();
    double size = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i) {
        moment += (x[i] - centre).cross(gradient[i]);
        size += (x[i] - centre).norm() * gradient[i].norm();
    }
    EXPECT_GT(size, 0.0);
    EXPECT_LT(moment.norm(), 1e-13 * size);
}

/// The same body with its nodes in another order, and the corners of its facets too.
TEST(SurfaceContact, DoesNotDependOnTheNumbersOfNodes) {
    tests::TouchedBlock block;
    block.friction = 0.4;
    const auto problem = tests::touched_block(block);
    auto body = *problem.body;
    const int num_nodes = body.mesh.num_nodes();
    const auto other = [&](int node) { return (5 * node + 3) % num_nodes; };
    ASSERT_EQ(std::gcd(5, num_nodes), 1);
    for (int i = 0; i < num_nodes; ++i)
        body.mesh.points[other(i)] = problem.body->mesh.points[i];
    for (auto &tetrahedron : body.mesh.tetrahedra)
        std::ranges::transform(tetrahedron, tetrahedron.begin(), other);
    for (auto &facet : body.mesh.boundary_triangles) {
        std::ranges::transform(facet, facet.begin(), other);
        std::ranges::rotate(facet, facet.begin() + 1);
    }
    const core::Problem renumbered{std::make_shared<const core::Body>(body), problem.load_case};
    msm::SurfaceContact contact(problem), again(renumbered);
    const auto x = bumpy(problem);
    auto y = x;
    for (int i = 0; i < num_nodes; ++i)
        y[other(i)] = x[i];
    contact.move_ball(1.0);
    again.move_ball(1.0);
    contact.update(x);
    again.update(y);
    Field gradient(x.size(), Vector3::Zero()), there = gradient;
    contact.add_gradient(x, gradient);
    again.add_gradient(y, there);
    double size = 0.0;
    for (const auto &force : gradient)
        size = std::max(size, force.norm());
    for (int i = 0; i < num_nodes; ++i)
        EXPECT_LT((there[other(i)] - gradient[i]).norm(), 1e-12 * size);
    EXPECT_NEAR(again.energy(y), contact.energy(x), 1e-12 * contact.energy(x));
}

/// The stiffer the penalty, the less is inside the ball, down to the least softness.
TEST(SurfaceContact, SinksInByLessWhereItIsStiffer) {
    double before = 5e-3;
    for (const double softness : {1.0, 0.1, core::FacetSoftness::least}) {
        const Touched touched(tests::TouchedBlock{}, nullptr, softness);
        msm::SurfaceContact contact(touched.problem);
        contact.move_ball(1.0);
        const double depth =
            contact.depth(msm::moved(touched.problem.body->mesh.points, touched.path.end.displacement));
        EXPECT_GT(depth, 0.0);
        EXPECT_LT(depth, 0.4 * before);
        before = depth;
    }
}

/// A ball that comes down obliquely: friction resists its slide, as far as the cone goes.
TEST(SurfaceContact, KeepsFrictionWithinItsCone) {
    tests::TouchedBlock block;
    block.press = {4e-3, 0.0, -3e-3};
    const auto along = [&](double friction) {
        block.friction = friction;
        const auto force = Touched(block).force();
        return -force.x() / force.z();
    };
    const double none = along(0.0), some = along(0.2), much = along(3.0);
    EXPECT_NEAR(none, 0.0, 0.1); // the shape of what it sinks into
    EXPECT_GT(some, none + 0.1);
    EXPECT_LT(some, none + 0.25);
    EXPECT_GT(much, 2.0 * some); // it sticks
}

/// Jaws on a block of two halves, or the first of them on one half.
tests::JawsAndHalf jaws_on_blocks(double friction) {
    const tests::TouchedBlock block;
    auto ball = tests::touched_block(block).load_case.touching.value();
    ball.friction = friction;
    const auto upper = tests::box_mesh(block.size, block.bricks);
    return {upper, {1060.0, 5e3, block.poisson_ratio}, ball, {0.5, 1.0}};
}

/// Forces are equal but for rounding and the tolerances of searches: 1e-9 of residuals, and 1e-6 of tractions from one
/// bound of friction to the next. The bound leaves a hundred times the larger one.
constexpr double same_force = 1e-4;

void expect_mirror_image(const core::PathPoint &point) {
    const auto &touch = point.reaction[1], &other_jaw = point.reaction[2];
    EXPECT_LT(touch.z(), 0.0);
    EXPECT_LT((other_jaw - tests::JawsAndHalf::mirrored(touch)).norm(), same_force * touch.norm());
    EXPECT_LT((point.reaction[0] + touch + other_jaw).norm(), same_force * touch.norm());
}

/// Two-node springs have an energy that is a sum over tetrahedra.
TEST(Jaws, OfSpringsPressEachHalfOfABlockAsOneBallPressesItAlone) {
    for (const double friction : {0.0, 0.3}) {
        const auto problems = jaws_on_blocks(friction);
        const Touched whole(problems.whole), half(problems.half);
        ASSERT_EQ(whole.path.points.size(), 2U);
        ASSERT_EQ(half.path.points.size(), 2U);
        for (std::size_t k = 0; k < whole.path.points.size(); ++k) {
            const auto &reaction = whole.path.points[k].reaction;
            ASSERT_EQ(reaction.size(), 3U);
            expect_mirror_image(whole.path.points[k]);
            const auto &alone = half.path.points[k].reaction.back();
            EXPECT_LT((reaction[1] - alone).norm(), same_force * alone.norm());
        }
        const double depth = -problems.half.load_case.touching->press.z();
        for (int i = 0; i < problems.half.body->mesh.num_nodes(); ++i)
            EXPECT_LT((whole.path.end.displacement[i] - half.path.end.displacement[i]).norm(), same_force * depth);
    }
}

/// Means around nodes take tetrahedra of both halves.
TEST(Jaws, OnCoupledSpringsPressWithMirrorImages) {
    const Touched whole(jaws_on_blocks(0.0).whole, "nodal_neo_hookean");
    ASSERT_EQ(whole.path.points.size(), 2U);
    for (const auto &point : whole.path.points)
        expect_mirror_image(point);
    EXPECT_LT(whole.path.points[1].reaction[1].z(), whole.path.points[0].reaction[1].z());
}

} // namespace
} // namespace livermark
