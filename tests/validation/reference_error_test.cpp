#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <gtest/gtest.h>
#include <memory>
#include <string>
#include <vector>

#include "core/error_norms.hpp"
#include "core/mesh/refinement.hpp"
#include "fem_reference/linear/linear_elasticity.hpp"
#include "load_cases/readers/load_case_reader.hpp"
#include "meshes/io/body_reader.hpp"
#include "studies/models/model_table.hpp"
#include "studies/run/run.hpp"

namespace livermark {
namespace {

using fem_reference::StaticSolver;
constexpr double tolerance = 1e-5; // of the iterations, as in the reference

/// Edges of tetrahedra below tools, half of what the reference has.
constexpr double longest_edge = 0.5 * core::longest_edge_below_tools;

/// The limit of three meshes that are all refined everywhere, and the last two at the rims and below tools as well.
core::Solution limit_of_uniform_meshes(const core::Problem &problem) {
    std::vector<std::unique_ptr<StaticSolver>> solvers;
    solvers.push_back(std::make_unique<StaticSolver>(problem.body, 2, fem_reference::SolverChoice::automatic,
                                                     fem_reference::Formulation::mixed));
    auto refined = core::refine(problem);
    std::vector<core::Solution> levels;
    std::vector<int> parent;
    for (int level = 0; level < 3; ++level) {
        if (level > 0) {
            auto bisected = core::refine_at_rims_and_tools(refined, longest_edge);
            refined = std::move(bisected.problem);
            parent = std::move(bisected.parent_tetrahedron);
        }
        solvers.push_back(std::make_unique<StaticSolver>(refined.body, *solvers.back(), tolerance, parent));
        levels.push_back(solvers.back()->solve(refined.load_case));
        levels.back().displacement.resize(problem.body->mesh.points.size());
    }
    return core::extrapolated(problem.body->mesh, problem.load_case, levels);
}

core::Problem on_the_healthy_liver(const std::string &load_case) {
    const std::filesystem::path root = LIVERMARK_SOURCE_DIR;
    const auto body = std::make_shared<const core::Body>(meshes::read_body(root / "meshes" / "liver_healthy.toml"));
    return {body, load_cases::read_load_case(root / "load_cases" / (load_case + ".toml"), body->mesh)};
}

void expect_within(const std::string &load_case, const char *what, double difference, double bar,
                   double other_difference) {
    constexpr double percent = 100.0;
    std::printf("%s, %s: %.3f %% off; bars of %.3f and %.3f %%\n", load_case.c_str(), what, percent * difference,
                percent * bar, percent * other_difference);
    EXPECT_LT(difference, bar + other_difference) << what;
}

/// Parameter: load case of liver_healthy.
class ReferenceError : public testing::TestWithParam<std::string> {};

} // namespace

/// Meshes that are refined everywhere, not at rims and below tools alone, find nothing that the error bars of the
/// reference leave out: in the displacement, in the energy, and so in the stiffness at the tool, and in the forces.
TEST_P(ReferenceError, ContainsWhatUniformRefinementFinds) {
    const auto &name = GetParam();
    const auto problem = on_the_healthy_liver(name);
    const auto models = models::all_models();
    const auto reference =
        std::ranges::find(models, core::Role::refined_reference, &core::Model::at_rest)->solve(problem);
    const auto limit = limit_of_uniform_meshes(problem);
    const auto off = core::compare(problem.body->mesh, problem.load_case, reference, limit, "uniform");
    const auto &bar = reference.observed_error.value(), &bar_of_limit = limit.observed_error.value();
    expect_within(name, "displacement", off.relative_l2, bar.relative_l2, bar_of_limit.relative_l2);
    expect_within(name, "energy", std::abs(off.energy_error), bar.energy, bar_of_limit.energy);
    if (problem.load_case.press_depth > 0.0) // the force is a result
        expect_within(name, "force", off.reaction_error, bar.reaction, bar_of_limit.reaction);
    if (off.tool && bar.stiffness && bar_of_limit.stiffness)
        expect_within(name, "stiffness at the tool", std::abs(off.tool->stiffness()), *bar.stiffness,
                      *bar_of_limit.stiffness);
    EXPECT_LT(bar.relative_l2, 0.005);
}

INSTANTIATE_TEST_SUITE_P(LoadCases, ReferenceError,
                         testing::Values("palpation", "traction", "indentation", "grasp", "breathing",
                                         "palpation_over_tumour"),
                         [](const auto &info) { return info.param; });

/// Parameter: large load case of liver_healthy, whose reference is stored.
class LargeReferenceError : public testing::TestWithParam<std::string> {};

/// The same of stored references of given loads, at the whole load: two meshes that are refined everywhere once, and
/// then once and twice at the rims. Their difference is taken as the bar of the second, as if errors halved. (Balls
/// that touch are in TouchedLiver.)
TEST_P(LargeReferenceError, ContainsWhatUniformRefinementFinds) {
    const auto &name = GetParam();
    const auto problem = on_the_healthy_liver(name);
    const auto models = studies::models_to_keep();
    studies::PreparedModels prepared{studies::SolutionCache(studies::stored_references_folder())};
    const auto model_of = [&](core::Role role) -> const core::Model & {
        return *std::ranges::find_if(
            models, [&](const core::Model &model) { return model.role_at_rest(core::Regime::large) == role; });
    };
    const auto reference = prepared.solve(model_of(core::Role::refined_reference), problem);
    ASSERT_TRUE(reference.solver.starts_with("stored")) << reference.solver;
    auto refined = core::refine(problem);
    refined.load_case.path = {0.5, 1.0};
    std::vector<core::Solution> levels;
    for (int level = 0; level < 2; ++level) {
        refined = core::refine_at_rims_and_tools(refined).problem;
        levels.push_back(model_of(core::Role::reference).solve(refined));
        ASSERT_EQ(levels.back().status, core::SolutionStatus::ok) << levels.back().message;
        levels.back().displacement.resize(problem.body->mesh.points.size());
        levels.back().path.clear();
    }
    const auto compare = [&](const core::Solution &solution, const core::Solution &other) {
        return core::compare(problem.body->mesh, problem.load_case, solution, other, "uniform");
    };
    const auto off = compare(reference, levels[1]), step = compare(levels[0], levels[1]);
    const auto &bar = reference.observed_error.value();
    expect_within(name, "displacement", off.relative_l2, bar.relative_l2, step.relative_l2);
    expect_within(name, "energy", std::abs(off.energy_error), bar.energy, std::abs(step.energy_error));
    expect_within(name, "stiffness at the tool", std::abs(off.tool.value().stiffness()), bar.stiffness.value(),
                  std::abs(step.tool.value().stiffness()));
    EXPECT_LT(std::abs(off.tool->stiffness()), *bar.stiffness);
    EXPECT_LT(*bar.stiffness, 0.01);
}

INSTANTIATE_TEST_SUITE_P(LoadCases, LargeReferenceError, testing::Values("large_traction", "large_retraction"),
                         [](const auto &info) { return info.param; });

} // namespace livermark
