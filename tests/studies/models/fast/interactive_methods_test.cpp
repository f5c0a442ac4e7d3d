#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <stdexcept>
#include <string>
#include <tuple>

#include "fem_reference/hyperelastic/hyperelasticity.hpp"
#include "interactive/method.hpp"
#include "msm/elastic_body.hpp"
#include "studies/models/model_table.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

using core::Vector3;

core::Solution solve(const std::string &name, const core::Problem &problem) {
    for (const auto &model : models::all_models())
        if (model.name == name)
            return model.solve(problem);
    throw std::invalid_argument("no model " + name);
}

/// A block that is constrained at one end, moved at the other, and has a weight.
core::Problem moved_block(core::Regime regime, const Vector3 &move, double acceleration) {
    const auto body = tests::make_body(tests::box_mesh({0.1, 0.05, 0.05}, {6, 3, 3}), {1060.0, 5e3, 0.45});
    auto load_case = tests::empty_load_case(body->mesh);
    load_case.regime = regime;
    if (regime == core::Regime::large)
        load_case.path = {0.5, 1.0};
    tests::prescribe(load_case, body->mesh, "x_min", Vector3::Zero());
    tests::prescribe(load_case, body->mesh, "x_max", move);
    load_case.acceleration = {0.0, 0.0, -acceleration};
    return {body, load_case};
}

double distance(const std::vector<Vector3> &a, const std::vector<Vector3> &b) {
    const auto expected = msm::to_unknowns(b);
    return (msm::to_unknowns(a) - expected).norm() / expected.norm();
}

/// Lumped loads and consistent ones differ on a few nodes; a traction-free case has none. With four points for each
/// element of second order in both.
TEST(InteractiveMethods, TledAndQuadraticTetrahedraHaveTheEquilibriumOfNeoHookeanFiniteElements) {
    const auto problem = moved_block(core::Regime::large, {0.01, -0.02, 0.015}, 0.0);
    const auto quadratic = hyperelastic::solve(problem, hyperelastic::material_law("neo_hookean"),
                                               {.degree = 2, .rule = hyperelastic::TetrahedronRule::four_points});
    const auto on_quadratic = solve("tled_quadratic", problem);
    const auto linear = solve("fem_p1_neo_hookean", problem), on_linear = solve("tled", problem);
    for (const auto &[expected, found] : {std::tie(linear, on_linear), std::tie(quadratic.solution, on_quadratic)}) {
        ASSERT_EQ(expected.status, core::SolutionStatus::ok) << expected.message;
        ASSERT_EQ(found.status, core::SolutionStatus::ok) << found.message;
        EXPECT_LT(distance(found.displacement, expected.displacement), 1e-7);
        EXPECT_LT(distance(found.reaction, expected.reaction), 1e-7);
        EXPECT_NEAR(found.strain_energy, expected.strain_energy, 1e-7 * expected.strain_energy);
    }
    ASSERT_EQ(on_linear.path.size(), 2U);
    const double half = linear.path[0].strain_energy;
    EXPECT_NEAR(on_linear.path[0].strain_energy, half, 1e-7 * half);
    const auto usual = solve("fem_p2_neo_hookean", problem);                  // fourteen points
    EXPECT_LT(distance(on_quadratic.displacement, usual.displacement), 1e-4); // 5.6e-5
    EXPECT_LT(distance(on_quadratic.reaction, usual.reaction), 1e-4);         // 7.3e-5
}

/// All of them are linear elasticity where strains are small, and so have the same Lame parameters; but for springs.
struct TetrahedralMethod : testing::TestWithParam<const char *> {};

TEST_P(TetrahedralMethod, IsLinearElasticityWhereStrainsAreSmall) {
    const auto problem = moved_block(core::Regime::small, {1e-7, -2e-7, 1.5e-7}, 1e-6);
    const auto expected = solve("fem_p1", problem);
    const auto found = solve(GetParam(), problem);
    ASSERT_EQ(found.status, core::SolutionStatus::ok) << found.message;
    EXPECT_LT(distance(found.displacement, expected.displacement), 1e-4);
    EXPECT_LT(distance(found.reaction, expected.reaction), 1e-4);
}

INSTANTIATE_TEST_SUITE_P(All, TetrahedralMethod,
                         testing::Values("corotational_implicit", "tled", "xpbd_neo_hookean", "vertex_block_descent",
                                         "projective_dynamics"));

TEST(InteractiveMethods, LeaveOutProblemsWithSlidingPlaces) {
    auto problem = moved_block(core::Regime::large, {0.01, 0.0, 0.0}, 0.0);
    const auto models = models::all_models();
    const auto &model = *std::ranges::find(models, "tled", &core::Model::name);
    EXPECT_TRUE(model.takes_part_in(problem));
    for (auto &value : problem.load_case.value)
        value.x() = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(model.takes_part_in(problem));
}

TEST(InteractiveMethods, JoinARunOnlyWhenTheyAreNamed) {
    for (const auto &method : interactive::all_methods()) {
        const auto models = models::all_models();
        const auto model = std::ranges::find(models, method.name, &core::Model::name);
        ASSERT_NE(model, models.end()) << method.name;
        EXPECT_TRUE(model->only_when_named) << method.name;
    }
}

} // namespace
} // namespace livermark
