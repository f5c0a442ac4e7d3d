#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "core/error_norms.hpp"
#include "fem_reference/hyperelastic/hyperelasticity.hpp"
#include "tests/fem_reference/hyperelastic_bodies.hpp"

namespace livermark {

namespace {

using core::Vector3;
using fem_reference::Formulation;
using tests::Bar;
using tests::free_component;

const hyperelastic::MaterialLaw &neo_hookean() {
    return hyperelastic::material_law("neo_hookean");
}

} // namespace

/// A quarter turn of all that is prescribed turns the solution with it and stores nothing.
TEST(HyperelasticPath, RigidMotionStoresNothing) {
    const auto body = tests::soft_block();
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(1.5, Vector3(1.0, 1.0, 0.0).normalized()).toRotationMatrix();
    for (const auto &kind : tests::hyperelastic_kinds) {
        const auto rule = kind.degree == 1 ? hyperelastic::TetrahedronRule::one_point : kind.rule;
        const hyperelastic::Elements elements(body, kind.degree, kind.formulation, neo_hookean(), rule);
        auto state = elements.rest();
        for (int node = 0; node < elements.system().num_nodes(); ++node)
            Vector3::Map(&state.displacement[3 * node]) =
                turn * elements.system().points[node] - elements.system().points[node];
        const auto forces = elements.internal_forces(state);
        EXPECT_LT(forces.energy, 1e-12 * tests::soft_material.young_modulus * 1e-3);
        for (const double force : forces.force)
            EXPECT_LT(std::abs(force), 1e-13 * tests::soft_material.young_modulus * 1e-2);
    }
}

/// Bent by more than its thickness in two load steps, a slender bar is harder: what is soft and what is stiff are far
/// apart. Once near, a few iterations are enough there too.
TEST(HyperelasticPath, BendsSlenderBarsInFewSteps) {
    const Bar bar;
    const auto none = std::vector<double>{};
    const auto pressed = tests::pressure_on(bar.body->mesh, "z_min", 30.0);
    for (const auto *const pressure : {&none, &pressed})
        for (const auto &kind : tests::hyperelastic_kinds) {
            const auto found =
                hyperelastic::solve({bar.body, pressure->empty() ? bar.pulled({0.0, 0.0, 60.0}) : bar.clamped},
                                    neo_hookean(), kind, {.fractions = {0.5, 1.0}, .tolerance = 1e-11}, *pressure);
            ASSERT_EQ(found.solution.status, core::SolutionStatus::ok) << found.solution.message;
            EXPECT_GT(tests::largest(found.solution.displacement), 0.01);
            ASSERT_EQ(found.steps.size(), 2U);
            for (const auto &step : found.steps) {
                const auto &r = step.residuals;
                RecordProperty(fmt::format("residuals_{}_{}_{}_{}", pressure->empty() ? "dead" : "follower",
                                           kind.degree, kind.formulation == Formulation::mixed ? "mixed" : "",
                                           step.fraction),
                               fmt::format("{:.1e}", fmt::join(r, " ")));
                const auto near = std::ranges::find_if(r, [](double value) { return value < 1e-3; });
                EXPECT_LE(r.end() - near, 4) << fmt::format("{:.1e}", fmt::join(r, " "));
            }
        }
}

/// What presses to a depth is a load: the one that it reports, at each part of the way.
TEST(HyperelasticPath, PressesWithTheForceThatMovesAsFar) {
    const Bar bar;
    const Vector3 direction = Vector3(1.0, -1.0, 4.0).normalized();
    auto pressed = bar.clamped;
    tests::press(pressed, bar.body->mesh, "x_max", direction, 0.03);
    for (const auto &kind : tests::hyperelastic_kinds) {
        const auto found = hyperelastic::solve({bar.body, pressed}, neo_hookean(), kind,
                                               {.fractions = {0.5, 1.0}, .tolerance = 1e-10});
        ASSERT_EQ(found.solution.status, core::SolutionStatus::ok) << found.solution.message;
        ASSERT_EQ(found.points.size(), 2U);
        EXPECT_EQ(found.steps.size(), 2U);
        for (const auto &point : found.points) {
            const double force = point.reaction[1].norm();
            EXPECT_LT((point.reaction[1] - force * direction).norm(), 1e-12 * force);
            EXPECT_LT((point.reaction[0] + point.reaction[1]).norm(), 1e-8 * force);
            const auto expected =
                hyperelastic::solve({bar.body, bar.pulled(force / (0.03 * 0.03) * direction)}, neo_hookean(), kind,
                                    {.fractions = {0.5, 1.0}, .tolerance = 1e-10});
            ASSERT_EQ(expected.solution.status, core::SolutionStatus::ok) << expected.solution.message;
            EXPECT_LT(tests::relative_difference(point.displacement, expected.solution.displacement), 1e-6);
        }
        EXPECT_GT(found.solution.nonlinearity, 0.05);
        for (const auto &step : found.steps)
            EXPECT_LE(step.residuals.size(), 9U) << fmt::format("{:.1e}", fmt::join(step.residuals, " "));
    }
}

/// Neighbouring solutions of one energy: where nothing locks, displacements alone and the mixed formulation agree.
TEST(HyperelasticPath, MixedElementsAgreeWithDisplacementsAlone) {
    const auto body = tests::make_body(tests::shaken_box_mesh({0.1, 0.03, 0.03}, {6, 3, 3}), {1000.0, 5000.0, 0.35});
    auto load_case = tests::empty_load_case(body->mesh);
    tests::prescribe(load_case, body->mesh, "x_min", Vector3::Zero());
    tests::prescribe(load_case, body->mesh, "x_max", {0.02, 0.0, 0.03});
    const auto alone = hyperelastic::solve({body, load_case}, neo_hookean(), tests::hyperelastic_kinds[1]);
    const auto mixed = hyperelastic::solve({body, load_case}, neo_hookean(), tests::hyperelastic_kinds[2]);
    ASSERT_EQ(alone.solution.status, core::SolutionStatus::ok) << alone.solution.message;
    ASSERT_EQ(mixed.solution.status, core::SolutionStatus::ok) << mixed.solution.message;
    const auto comparison = core::compare(body->mesh, load_case, alone.solution, mixed.solution, "mixed");
    EXPECT_LT(comparison.relative_l2, 5e-3);
    EXPECT_LT(comparison.reaction_error, 2e-2);
    for (const auto *const solution : {&alone, &mixed})
        for (const auto &point : solution->points) // without other loads, the ends pull against each other
            EXPECT_LT((point.reaction[0] + point.reaction[1]).norm(), 1e-8 * point.reaction[0].norm());
}

/// What a path cannot reach, it says: a bar that is pushed to less than nothing.
TEST(HyperelasticPath, GivesUpAndSaysSo) {
    const auto body = tests::soft_block();
    auto load_case = tests::on_rollers(body->mesh);
    tests::prescribe(load_case, body->mesh, "x_max", {-0.11, 0.0, 0.0});
    const auto found = hyperelastic::solve({body, load_case}, neo_hookean(), tests::hyperelastic_kinds[0]);
    EXPECT_EQ(found.solution.status, core::SolutionStatus::not_converged);
    EXPECT_NE(found.solution.message.find("finds no equilibrium beyond"), std::string::npos) << found.solution.message;
    ASSERT_FALSE(found.points.empty());
    EXPECT_LT(found.points.back().fraction, 1.0);
    EXPECT_GT(found.points.back().smallest_jacobian, 0.0);
    EXPECT_EQ(found.solution.displacement, found.points.back().displacement);
}

TEST(HyperelasticPath, RefusesWhatHasNoSolution) {
    const Bar bar;
    auto load_case = tests::empty_load_case(bar.body->mesh);
    tests::prescribe(load_case, bar.body->mesh, "x_min", {0.0, 0.0, free_component});
    const auto free = hyperelastic::solve({bar.body, load_case}, neo_hookean(), tests::hyperelastic_kinds[0]);
    EXPECT_EQ(free.solution.status, core::SolutionStatus::not_converged);
    EXPECT_NE(free.solution.message.find("free to move"), std::string::npos);
    EXPECT_TRUE(free.solution.displacement.front().hasNaN());
    const core::Problem problem{bar.body, bar.clamped};
    EXPECT_THROW(
        hyperelastic::solve(problem, neo_hookean(), tests::hyperelastic_kinds[0], {.fractions = {0.5, 0.4, 1.0}}),
        std::invalid_argument);
    EXPECT_THROW(hyperelastic::solve(problem, neo_hookean(), tests::hyperelastic_kinds[0], {.fractions = {0.5}}),
                 std::invalid_argument);
    EXPECT_THROW(hyperelastic::solve(problem, neo_hookean(), tests::hyperelastic_kinds[0], {}, std::vector{1.0}),
                 std::invalid_argument);
    const hyperelastic::Elements elements(bar.body, 1, fem_reference::Formulation::displacement, neo_hookean(),
                                          hyperelastic::TetrahedronRule::one_point);
    const auto conditions = fem_reference::dof_conditions(bar.clamped, elements.system());
    EXPECT_THROW(hyperelastic::follow(elements, conditions, 0, {}), std::invalid_argument)
        << "the reaction of the clamped end has no place in the result";
}

} // namespace livermark
