#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "core/error_norms.hpp"
#include "fem_reference/hyperelastic/hyperelasticity.hpp"
#include "fem_reference/linear/linear_elasticity.hpp"
#include "tests/fem_reference/verification/fem_test_bodies.hpp"

namespace livermark {

namespace {

using core::Vector3;
using fem_reference::Formulation;
using hyperelastic::Discretisation;

constexpr double free_component = std::numeric_limits<double>::quiet_NaN();
const core::Material path_material{1000.0, 5000.0, 0.45};
const std::array<Discretisation, 3> kinds{
    {{.degree = 1}, {.degree = 2}, {.degree = 2, .formulation = Formulation::mixed}}};

/// A body whose three sides at the origin slide.
core::LoadCase on_rollers(const core::TetraMesh &mesh) {
    auto load_case = tests::empty_load_case(mesh);
    tests::prescribe(load_case, mesh, "x_min", {0.0, free_component, free_component});
    tests::prescribe(load_case, mesh, "y_min", {free_component, 0.0, free_component});
    tests::prescribe(load_case, mesh, "z_min", {free_component, free_component, 0.0});
    return load_case;
}

/// The zero of a function that grows, by bisection to the last bit.
template <class Function> double zero_of(const Function &function, double low, double high) {
    for (int i = 0; i < 200; ++i) {
        const double middle = 0.5 * (low + high);
        (function(middle) < 0.0 ? low : high) = middle;
    }
    return low;
}

/// A bar that is clamped at one end.
struct Bar {
    std::shared_ptr<const core::Body> body =
        tests::make_body(tests::shaken_box_mesh({0.1, 0.03, 0.03}, {5, 2, 2}), path_material);
    core::LoadCase clamped = [this] {
        auto load_case = tests::empty_load_case(body->mesh);
        tests::prescribe(load_case, body->mesh, "x_min", Vector3::Zero());
        return load_case;
    }();

    core::LoadCase pulled(const Vector3 &traction) const {
        auto load_case = clamped;
        tests::pull(load_case, body->mesh, "x_max", traction);
        return load_case;
    }
};

/// Shape (T) [Pa], on one patch alone.
std::vector<double> pressure_on(const core::TetraMesh &mesh, const std::string &patch, double pressure) {
    std::vector<double> result(mesh.boundary_triangles.size(), 0.0);
    for (std::size_t f = 0; f < result.size(); ++f)
        if (mesh.patch_names[mesh.boundary_patch[f]] == patch)
            result[f] = pressure;
    return result;
}

double largest(const std::vector<Vector3> &displacement) {
    double result = 0.0;
    for (const auto &u : displacement)
        result = std::max(result, u.norm());
    return result;
}

const hyperelastic::MaterialLaw &neo_hookean() {
    return hyperelastic::material_law("neo_hookean");
}

} // namespace

/// Stretched by half with free sides: t of the sides solves mu (t - 1 / t) + lambda ln(s t^2) / t = 0, and the force
/// per area at rest is mu (s - 1 / s) + lambda ln(s t^2) / s.
TEST(HyperelasticPath, UniaxialStretchIsExact) {
    const Vector3 size(0.1, 0.12, 0.08);
    const auto body = tests::make_body(tests::shaken_box_mesh(size, {2, 2, 2}), path_material);
    const double mu = path_material.shear_modulus(), lambda = path_material.lame_lambda();
    for (const double stretch : {0.6, 1.5}) {
        const double side =
            zero_of([&](double t) { return mu * (t - 1.0 / t) + lambda * std::log(stretch * t * t) / t; }, 0.3, 3.0);
        const double stress = mu * (stretch - 1.0 / stretch) + lambda * std::log(stretch * side * side) / stretch;
        auto load_case = on_rollers(body->mesh);
        tests::prescribe(load_case, body->mesh, "x_max", {(stretch - 1.0) * size.x(), free_component, free_component});
        for (const auto &kind : kinds) {
            const auto found = hyperelastic::solve({body, load_case}, neo_hookean(), kind, {.tolerance = 1e-12});
            ASSERT_EQ(found.solution.status, core::SolutionStatus::ok) << found.solution.message;
            ASSERT_EQ(found.points.size(), 5U);
            std::vector<Vector3> expected;
            for (const auto &x : body->mesh.points)
                expected.emplace_back((stretch - 1.0) * x.x(), (side - 1.0) * x.y(), (side - 1.0) * x.z());
            EXPECT_LT(tests::relative_difference(found.solution.displacement, expected), 1e-12);
            EXPECT_NEAR(found.solution.reaction[3].x(), stress * size.y() * size.z(),
                        1e-12 * std::abs(stress) * size.y() * size.z());
            EXPECT_NEAR(found.points.back().smallest_jacobian, stretch * side * side, 1e-12);
        }
    }
}

/// Under the same pressure from all sides a body shrinks by s in each direction, with
/// mu (s - 1 / s) + lambda ln(s^3) / s = -p s^2; a dead pressure is per area at rest and has no s^2.
TEST(HyperelasticPath, FollowerPressureActsOnTheDeformedArea) {
    const auto body = tests::make_body(tests::shaken_box_mesh({0.1, 0.12, 0.08}, {2, 2, 2}), path_material);
    const double mu = path_material.shear_modulus(), lambda = path_material.lame_lambda(), p = 4000.0;
    const double side =
        zero_of([&](double s) { return mu * (s - 1.0 / s) + lambda * std::log(s * s * s) / s + p * s * s; }, 0.3, 3.0);
    ASSERT_LT(side, 0.95);
    std::vector<double> pressure;
    for (const int patch : body->mesh.boundary_patch)
        pressure.push_back(body->mesh.patch_names[patch].ends_with("max") ? p : 0.0);
    std::vector<Vector3> expected;
    for (const auto &x : body->mesh.points)
        expected.emplace_back((side - 1.0) * x);
    for (const auto &kind : kinds) {
        const auto found =
            hyperelastic::solve({body, on_rollers(body->mesh)}, neo_hookean(), kind, {.tolerance = 1e-13}, pressure);
        ASSERT_EQ(found.solution.status, core::SolutionStatus::ok) << found.solution.message;
        EXPECT_LT(tests::relative_difference(found.solution.displacement, expected), 1e-12);
    }
}

/// A quarter turn of all that is prescribed turns the solution with it and stores nothing.
TEST(HyperelasticPath, RigidMotionStoresNothing) {
    const auto body = tests::make_body(tests::shaken_box_mesh({0.1, 0.12, 0.08}, {2, 2, 2}), path_material);
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(1.5, Vector3(1.0, 1.0, 0.0).normalized()).toRotationMatrix();
    for (const auto &kind : kinds) {
        const auto rule = kind.degree == 1 ? hyperelastic::TetrahedronRule::one_point : kind.rule;
        const hyperelastic::Elements elements(body, kind.degree, kind.formulation, neo_hookean(), rule);
        auto state = elements.rest();
        for (int node = 0; node < elements.system().num_nodes(); ++node)
            Vector3::Map(&state.displacement[3 * node]) =
                turn * elements.system().points[node] - elements.system().points[node];
        const auto forces = elements.internal_forces(state);
        EXPECT_LT(forces.energy, 1e-12 * path_material.young_modulus * 1e-3);
        for (const double force : forces.force)
            EXPECT_LT(std::abs(force), 1e-13 * path_material.young_modulus * 1e-2);
    }
}

/// As the load goes to zero, so does the difference from linear elements of the same kind, over the solution in
/// proportion to the load.
TEST(HyperelasticPath, IsLinearElasticityUnderSmallLoads) {
    const Bar bar;
    for (const auto &kind : kinds) {
        fem_reference::StaticSolver linear(bar.body, kind.degree, fem_reference::SolverChoice::automatic,
                                           kind.formulation);
        const auto difference = [&](double traction) {
            const auto load_case = bar.pulled({0.0, 0.5 * traction, traction});
            const auto large = hyperelastic::solve({bar.body, load_case}, neo_hookean(), kind);
            const auto small = linear.solve(load_case);
            EXPECT_EQ(large.solution.status, core::SolutionStatus::ok) << large.solution.message;
            const auto comparison = core::compare(bar.body->mesh, small, large.solution, "hyperelastic");
            EXPECT_NEAR(large.solution.nonlinearity, comparison.relative_l2, 1e-6 + 1e-3 * comparison.relative_l2);
            return comparison.relative_l2;
        };
        const double at_one = difference(1.0), at_tenth = difference(0.1);
        RecordProperty(fmt::format("differences_of_degree_{}_{}", kind.degree, kind.formulation == Formulation::mixed),
                       fmt::format("{:.3e} {:.3e}", at_one, at_tenth));
        EXPECT_LT(at_tenth, 3e-3);
        EXPECT_NEAR(at_one / at_tenth, 10.0, 1.0);
    }
}

/// The mark of a consistent tangent: what is out of balance is squared by each iteration, until rounding. A block is
/// pulled and sheared by a third, under a dead load, and pressed under a pressure that follows its side, whose load
/// stiffness is not symmetric.
TEST(HyperelasticPath, NewtonConvergesQuadratically) {
    const auto body = tests::make_body(tests::shaken_box_mesh({0.1, 0.12, 0.08}, {2, 2, 2}), path_material);
    const auto &mesh = body->mesh;
    auto clamped = tests::empty_load_case(mesh);
    tests::prescribe(clamped, mesh, "x_min", Vector3::Zero());
    auto pulled = clamped;
    tests::pull(pulled, mesh, "x_max", {1500.0, 500.0, 0.0});
    const auto none = std::vector<double>{};
    const auto pressed = pressure_on(mesh, "x_max", 1000.0);
    for (const auto *const pressure : {&none, &pressed})
        for (const auto &kind : kinds) {
            const auto found = hyperelastic::solve({body, pressure->empty() ? pulled : clamped}, neo_hookean(), kind,
                                                   {.fractions = {0.5, 1.0}, .tolerance = 1e-12}, *pressure);
            ASSERT_EQ(found.solution.status, core::SolutionStatus::ok) << found.solution.message;
            EXPECT_GT(largest(found.solution.displacement), 0.015);
            for (const auto &step : found.steps) {
                ASSERT_TRUE(step.converged);
                const auto &r = step.residuals;
                RecordProperty(fmt::format("residuals_{}_{}_{}_{}", pressure->empty() ? "dead" : "follower",
                                           kind.degree, kind.formulation == Formulation::mixed ? "mixed" : "",
                                           step.fraction),
                               fmt::format("{:.1e}", fmt::join(r, " ")));
                EXPECT_LE(r.size(), 7U);
                for (std::size_t k = 0; k + 1 < r.size(); ++k)
                    if (r[k] < 1e-2) {
                        EXPECT_LT(r[k + 1], std::max(10.0 * r[k] * r[k], 1e-12))
                            << fmt::format("{:.1e}", fmt::join(r, " "));
                    }
            }
        }
}

/// Bent by more than its thickness in two load steps, a slender bar is harder: what is soft and what is stiff are far
/// apart. Once near, a few iterations are enough there too.
TEST(HyperelasticPath, BendsSlenderBarsInFewSteps) {
    const Bar bar;
    const auto none = std::vector<double>{};
    const auto pressed = pressure_on(bar.body->mesh, "z_min", 30.0);
    for (const auto *const pressure : {&none, &pressed})
        for (const auto &kind : kinds) {
            const auto found =
                hyperelastic::solve({bar.body, pressure->empty() ? bar.pulled({0.0, 0.0, 60.0}) : bar.clamped},
                                    neo_hookean(), kind, {.fractions = {0.5, 1.0}, .tolerance = 1e-11}, *pressure);
            ASSERT_EQ(found.solution.status, core::SolutionStatus::ok) << found.solution.message;
            EXPECT_GT(largest(found.solution.displacement), 0.01);
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

/// Neighbouring solutions of one energy: where nothing locks, displacements alone and the mixed formulation agree.
TEST(HyperelasticPath, MixedElementsAgreeWithDisplacementsAlone) {
    const auto body = tests::make_body(tests::shaken_box_mesh({0.1, 0.03, 0.03}, {6, 3, 3}), {1000.0, 5000.0, 0.35});
    auto load_case = tests::empty_load_case(body->mesh);
    tests::prescribe(load_case, body->mesh, "x_min", Vector3::Zero());
    tests::prescribe(load_case, body->mesh, "x_max", {0.02, 0.0, 0.03});
    const auto alone = hyperelastic::solve({body, load_case}, neo_hookean(), kinds[1]);
    const auto mixed = hyperelastic::solve({body, load_case}, neo_hookean(), kinds[2]);
    ASSERT_EQ(alone.solution.status, core::SolutionStatus::ok) << alone.solution.message;
    ASSERT_EQ(mixed.solution.status, core::SolutionStatus::ok) << mixed.solution.message;
    const auto comparison = core::compare(body->mesh, alone.solution, mixed.solution, "mixed");
    EXPECT_LT(comparison.relative_l2, 5e-3);
    EXPECT_LT(comparison.reaction_error, 2e-2);
    for (const auto *const solution : {&alone, &mixed})
        for (const auto &point : solution->points) // without other loads, the ends pull against each other
            EXPECT_LT((point.reaction[0] + point.reaction[1]).norm(), 1e-8 * point.reaction[0].norm());
}

/// What a path cannot reach, it says: a bar that is pushed to less than nothing.
TEST(HyperelasticPath, GivesUpAndSaysSo) {
    const auto body = tests::make_body(tests::shaken_box_mesh({0.1, 0.12, 0.08}, {2, 2, 2}), path_material);
    auto load_case = on_rollers(body->mesh);
    tests::prescribe(load_case, body->mesh, "x_max", {-0.11, 0.0, 0.0});
    const auto found = hyperelastic::solve({body, load_case}, neo_hookean(), kinds[0]);
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
    const auto free = hyperelastic::solve({bar.body, load_case}, neo_hookean(), kinds[0]);
    EXPECT_EQ(free.solution.status, core::SolutionStatus::not_converged);
    EXPECT_NE(free.solution.message.find("free to move"), std::string::npos);
    EXPECT_TRUE(free.solution.displacement.front().hasNaN());
    const core::Problem problem{bar.body, bar.clamped};
    EXPECT_THROW(hyperelastic::solve(problem, neo_hookean(), kinds[0], {.fractions = {0.5, 0.4, 1.0}}),
                 std::invalid_argument);
    EXPECT_THROW(hyperelastic::solve(problem, neo_hookean(), kinds[0], {.fractions = {0.5}}), std::invalid_argument);
    EXPECT_THROW(hyperelastic::solve(problem, neo_hookean(), kinds[0], {}, std::vector{1.0}), std::invalid_argument);
}

} // namespace livermark
