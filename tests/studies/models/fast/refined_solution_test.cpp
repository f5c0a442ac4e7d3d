#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <memory>
#include <utility>
#include <vector>

#include "core/support/input_error.hpp"
#include "studies/models/model_table.hpp"
#include "studies/models/refined_solution.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

/// On each level 1 + error, at the cost of a second; an error that is not positive is a level without a solution.
core::Solution on_level(const core::TetraMesh &mesh, double error) {
    core::Solution solution;
    solution.displacement.assign(mesh.points.size(), core::Vector3(1.0 + error, 0.0, 0.0));
    solution.strain_energy = 1.0 + error;
    solution.solve_seconds = 1.0;
    if (error <= 0.0) {
        solution.status = core::SolutionStatus::not_converged;
        solution.message = "it folds";
    }
    return solution;
}

core::Problem box_along_a_path() {
    core::Problem problem{tests::make_body(tests::box_mesh({0.1, 0.1, 0.1}, {1, 1, 1}), {1000.0, 5000.0, 0.45}), {}};
    problem.load_case.path = {0.5, 1.0};
    return problem;
}

struct Outcome {
    core::Solution solution;
    int num_levels = 0;
};

Outcome refine(std::array<double, 4> errors, double goal) {
    const auto problem = box_along_a_path();
    const auto &mesh = problem.body->mesh;
    Outcome outcome;
    outcome.solution = models::solve_refined(problem, {.goal = goal, .finest_level = 3}, [&](int level) {
        EXPECT_EQ(level, outcome.num_levels);
        ++outcome.num_levels;
        return on_level(mesh, errors[level]);
    });
    return outcome;
}

} // namespace

TEST(RefinedSolution, GoesOnUntilTheErrorIsKnownToBeSmallEnough) {
    const std::array errors{0.08, 0.04, 0.02, 0.01};
    const auto rough = refine(errors, 0.05), fine = refine(errors, 0.008);
    EXPECT_EQ(rough.num_levels, 3);
    EXPECT_EQ(fine.num_levels, 4);
    EXPECT_EQ(fine.solution.solve_seconds, 4.0);
    EXPECT_NEAR(fine.solution.displacement[0].x(), 1.0, 1e-3);
    EXPECT_LT(fine.solution.observed_error.value().relative_l2, rough.solution.observed_error.value().relative_l2);
}

/// The displacement alone would be good enough on three.
TEST(RefinedSolution, GoesOnUntilTheEnergyIsKnownAsWell) {
    const auto problem = box_along_a_path();
    int num_levels = 0;
    const auto solution = models::solve_refined(problem, {.goal = 0.02, .finest_level = 3}, [&](int level) {
        ++num_levels;
        auto result = on_level(problem.body->mesh, 0.08 * std::pow(0.5, level));
        result.strain_energy = 1.0 + 4.0 * (result.strain_energy - 1.0);
        return result;
    });
    EXPECT_EQ(num_levels, 4);
    EXPECT_LT(solution.observed_error.value().relative_l2, 0.01);
    EXPECT_LT(solution.observed_error->energy, 0.025);
}

TEST(RefinedSolution, StopsAtTheFinestLevelAndSaysWhatIsLeft) {
    const auto outcome = refine({0.08, 0.04, 0.02, 0.01}, 1e-9);
    EXPECT_EQ(outcome.num_levels, 4);
    EXPECT_GT(outcome.solution.observed_error.value().relative_l2, 1e-3);
}

TEST(RefinedSolution, TakesWhatComesBeforeALevelWithoutASolution) {
    const auto two_levels = refine({0.08, 0.04, 0.0, 0.0}, 1e-9);
    EXPECT_EQ(two_levels.num_levels, 3);
    EXPECT_EQ(two_levels.solution.status, core::SolutionStatus::ok);
    EXPECT_EQ(two_levels.solution.displacement[0].x(), 1.04);
    EXPECT_FALSE(two_levels.solution.observed_error);
    EXPECT_TRUE(two_levels.solution.solver.ends_with("on the next mesh it folds")) << two_levels.solution.solver;
    const auto three_levels = refine({0.08, 0.04, 0.02, 0.0}, 1e-9);
    EXPECT_TRUE(three_levels.solution.observed_error);
    const auto none = refine({0.0, 0.0, 0.0, 0.0}, 1e-9);
    EXPECT_EQ(none.num_levels, 1);
    EXPECT_EQ(none.solution.status, core::SolutionStatus::not_converged);
}

/// The path of the levels that have no solution to the whole load ends at a half of it.
TEST(RefinedSolution, HasAnErrorThatIsObservedWhereThreeLevelsHaveComeTo) {
    const auto problem = box_along_a_path();
    const auto &mesh = problem.body->mesh;
    constexpr std::array errors{0.08, 0.04, 0.02};
    for (const int num_whole : {1, 2}) {
        const auto solution = models::solve_refined(problem, {.goal = 0.01, .finest_level = 3}, [&](int level) {
            auto result = on_level(mesh, level < num_whole ? errors.at(level) : 0.0);
            result.path.resize(level < num_whole ? 2 : 1);
            for (auto &point : result.path)
                point.displacement.assign(mesh.points.size(),
                                          Eigen::Vector3f(static_cast<float>(1.0 + errors.at(level)), 0.0F, 0.0F));
            return result;
        });
        EXPECT_EQ(solution.status, core::SolutionStatus::ok);
        EXPECT_NEAR(solution.displacement[0].x(), 1.0 + errors.at(num_whole - 1), 1e-12);
        ASSERT_TRUE(solution.observed_error);
        EXPECT_EQ(solution.observed_error->load_fraction, 0.5);
        EXPECT_NEAR(solution.observed_error->relative_l2, errors.at(num_whole - 1), 0.004);
    }
}

} // namespace livermark

namespace livermark::models {
namespace {

/// Models share what they have in common on a body only as long as they are of one table.
struct Elements {
    explicit Elements(const std::shared_ptr<const core::Body> &body)
        : on_mesh(support::find_named(models, "fem_p2p1", "model").prepare(body, nullptr)),
          refined(support::find_named(models, "fem_p2p1_refined", "model").prepare(body, nullptr)) {}

    std::vector<core::Model> models = all_models();
    std::unique_ptr<core::PreparedModel> on_mesh, refined;
};

core::LoadCase pulled(const core::TetraMesh &mesh, const core::Vector3 &traction) {
    auto load_case = tests::empty_load_case(mesh);
    tests::prescribe(load_case, mesh, "x_min", core::Vector3::Zero());
    tests::pull(load_case, mesh, "x_max", traction);
    return load_case;
}

/// The refined elements begin with what those on the mesh found last, if it is of the same load cases.
TEST(SharedElements, FindTheSolutionsOfElementsThatAreAlone) {
    const auto body = tests::make_body(tests::box_mesh({0.06, 0.05, 0.04}, {3, 2, 2}), {1000.0, 5000.0, 0.45});
    const auto along = pulled(body->mesh, {10.0, 0.0, 0.0}), across = pulled(body->mesh, {0.0, 5.0, 0.0});
    using LoadCases = std::vector<core::LoadCase>;
    const LoadCases first{along, across}, second{across, along}, fewer{along};
    const std::vector<std::pair<LoadCases, LoadCases>> turns{{first, first}, {first, second}, {second, fewer}};
    Elements shared(body);
    for (const auto &[before, load_cases] : turns) {
        const auto on_mesh = shared.on_mesh->solve(before);
        const auto refined = shared.refined->solve(load_cases);
        const auto alone = Elements(body).refined->solve(load_cases);
        const auto on_mesh_alone = Elements(body).on_mesh->solve(before);
        for (std::size_t c = 0; c < before.size(); ++c)
            EXPECT_EQ(on_mesh[c].displacement, on_mesh_alone[c].displacement);
        ASSERT_EQ(refined.size(), load_cases.size());
        for (std::size_t c = 0; c < load_cases.size(); ++c) {
            EXPECT_EQ(refined[c].status, core::SolutionStatus::ok) << refined[c].message;
            EXPECT_EQ(refined[c].displacement, alone[c].displacement);
            EXPECT_EQ(refined[c].strain_energy, alone[c].strain_energy);
        }
    }
}

} // namespace
} // namespace livermark::models
