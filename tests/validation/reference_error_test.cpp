#include <array>
#include <cstdio>
#include <gtest/gtest.h>
#include <memory>
#include <vector>

#include "core/error_norms.hpp"
#include "core/local_refinement.hpp"
#include "core/observed_error.hpp"
#include "core/refinement.hpp"
#include "fem_reference/linear/linear_elasticity.hpp"
#include "load_cases/load_case_reader.hpp"
#include "meshes/body_reader.hpp"
#include "models/model_table.hpp"
#include "tests/turns.hpp"

namespace livermark {
namespace {

using fem_reference::StaticSolver;
constexpr double tolerance = 1e-5; // of the iterations, as in the reference

/// The limit of three meshes that are all refined everywhere, and the last two at the rims as well.
core::Solution limit_of_uniform_meshes(const core::Problem &problem) {
    std::vector<std::unique_ptr<StaticSolver>> solvers;
    solvers.push_back(std::make_unique<StaticSolver>(problem.body, 2, fem_reference::SolverChoice::automatic,
                                                     fem_reference::Formulation::mixed));
    auto refined = core::refine(problem);
    std::vector<core::Solution> levels;
    std::vector<int> parent;
    for (int level = 0; level < 3; ++level) {
        if (level > 0) {
            auto bisected = core::refine_at_rims(refined);
            refined = std::move(bisected.problem);
            parent = std::move(bisected.parent_tetrahedron);
        }
        solvers.push_back(std::make_unique<StaticSolver>(refined.body, *solvers.back(), tolerance, parent));
        levels.push_back(solvers.back()->solve(refined.load_case));
        levels.back().displacement.resize(problem.body->mesh.points.size());
    }
    return core::extrapolated(problem.body->mesh, problem.load_case, levels);
}

/// Parameter: load case.
class ReferenceError : public testing::TestWithParam<const char *> {};

} // namespace

/// Meshes that are refined everywhere, not at rims alone, find nothing that the error bar of the reference leaves out.
TEST_P(ReferenceError, ContainsWhatUniformRefinementFinds) {
    if (!tests::has_its_turn(std::string(GetParam()) == "palpation" ? 0 : 1, 2))
        GTEST_SKIP() << tests::not_its_turn;
    const std::filesystem::path root = LIVERMARK_SOURCE_DIR;
    const auto body = std::make_shared<const core::Body>(meshes::read_body(root / "meshes" / "liver_healthy.toml"));
    core::Problem problem{
        body, load_cases::read_load_case(root / "load_cases" / (std::string(GetParam()) + ".toml"), body->mesh)};
    const auto models = models::all_models();
    const auto reference = std::ranges::find(models, models::references[0].refined, &core::Model::name)->solve(problem);
    const auto limit = limit_of_uniform_meshes(problem);
    const auto difference = core::compare(body->mesh, problem.load_case, reference, limit, "uniform").relative_l2;
    const double bar = reference.observed_error.value().relative_l2;
    const double bar_of_limit = limit.observed_error.value().relative_l2;
    constexpr double percent = 100.0;
    std::printf("%s: %.2f %% from the limit of uniform meshes; bars of %.2f and %.2f %%\n", GetParam(),
                percent * difference, percent * bar, percent * bar_of_limit);
    EXPECT_LT(difference, bar + bar_of_limit);
    EXPECT_LT(bar, 0.005);
}

INSTANTIATE_TEST_SUITE_P(LoadCases, ReferenceError, testing::Values("palpation", "traction"),
                         [](const auto &info) { return std::string(info.param); });

} // namespace livermark
