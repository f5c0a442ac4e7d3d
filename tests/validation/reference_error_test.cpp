#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <gtest/gtest.h>
#include <memory>
#include <vector>

#include "core/error_norms.hpp"
#include "core/mesh/local_refinement.hpp"
#include "core/mesh/refinement.hpp"
#include "core/observed_error.hpp"
#include "fem_reference/linear/linear_elasticity.hpp"
#include "load_cases/readers/load_case_reader.hpp"
#include "meshes/io/body_reader.hpp"
#include "models/model_table.hpp"

namespace livermark {
namespace {

using fem_reference::StaticSolver;
constexpr double tolerance = 1e-5; // of the iterations, as in the reference

/// Of tetrahedra below tools, half of what the reference has.
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

/// Parameter: load case of liver_healthy.
class ReferenceError : public testing::TestWithParam<std::string> {};

} // namespace

/// Meshes that are refined everywhere, not at rims and below tools alone, find nothing that the error bars of the
/// reference leave out: in the displacement, in the energy, and so in the stiffness at the tool, and in the forces.
TEST_P(ReferenceError, ContainsWhatUniformRefinementFinds) {
    const auto &name = GetParam();
    const std::filesystem::path root = LIVERMARK_SOURCE_DIR;
    const auto body = std::make_shared<const core::Body>(meshes::read_body(root / "meshes" / "liver_healthy.toml"));
    core::Problem problem{body, load_cases::read_load_case(root / "load_cases" / (name + ".toml"), body->mesh)};
    const auto models = models::all_models();
    const auto reference =
        std::ranges::find(models, core::Role::refined_reference, &core::Model::at_rest)->solve(problem);
    const auto limit = limit_of_uniform_meshes(problem);
    const auto off = core::compare(body->mesh, problem.load_case, reference, limit, "uniform");
    const auto &bar = reference.observed_error.value(), &bar_of_limit = limit.observed_error.value();
    constexpr double percent = 100.0;
    const auto check = [&](const char *what, double difference, double of_reference, double of_limit) {
        std::printf("%s, %s: %.3f %% from the limit of uniform meshes; bars of %.3f and %.3f %%\n", name.c_str(), what,
                    percent * difference, percent * of_reference, percent * of_limit);
        EXPECT_LT(difference, of_reference + of_limit) << what;
    };
    check("displacement", off.relative_l2, bar.relative_l2, bar_of_limit.relative_l2);
    check("energy", std::abs(off.energy_error), bar.energy, bar_of_limit.energy);
    if (problem.load_case.press_depth > 0.0) // the force is a result
        check("force", off.reaction_error, bar.reaction, bar_of_limit.reaction);
    if (off.tool && bar.stiffness && bar_of_limit.stiffness)
        check("stiffness at the tool", std::abs(off.tool->stiffness()), *bar.stiffness, *bar_of_limit.stiffness);
    EXPECT_LT(bar.relative_l2, 0.005);
}

INSTANTIATE_TEST_SUITE_P(LoadCases, ReferenceError,
                         testing::Values("palpation", "traction", "indentation", "grasp", "breathing",
                                         "palpation_over_tumour"),
                         [](const auto &info) { return info.param; });

} // namespace livermark
