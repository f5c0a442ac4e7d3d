#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <gtest/gtest.h>
#include <map>
#include <stdexcept>
#include <string>

#include "core/error_norms.hpp"
#include "results/hdf5/result_file.hpp"

namespace livermark {
namespace {

/// Errors that a code of somebody else found on the healthy liver against its own quadratic neo-Hookean elements, with
/// four points of integration: relative L2 of the displacement, and reaction of the tool over that of its reference.
struct Found {
    double relative_l2, reaction;
};

const std::map<std::string, std::map<std::string, Found>> found_elsewhere{
    {"held_retraction",
     {{"fem_p1", {0.134, 1.43}},
      {"fem_p2p1", {0.100, 1.12}},
      {"fem_p1_neo_hookean", {0.077, 1.32}},
      {"lloyd", {0.084, 1.18}},
      {"van_gelder", {0.082, 1.11}},
      {"patch_nodal_volume", {0.051, 1.12}}}},
    {"flat_palpation",
     {{"fem_p1", {0.188, 1.29}},
      {"fem_p2p1", {0.098, 1.00}},
      {"lloyd", {0.236, 0.86}},
      {"van_gelder", {0.253, 0.74}},
      {"patch_nodal_volume", {0.077, 0.99}}}},
};

class LargeDeformations : public testing::TestWithParam<std::string> {
  protected:
    void SetUp() override {
        result = results::read_result(std::filesystem::path(std::getenv("LIVERMARK_VALIDATION_RUNS")) /
                                      "liver_healthy" / // NOLINT(concurrency-mt-unsafe)

                                      (GetParam() + ".h5"));
    }

    const results::ModelResult &find(const std::string &name) const {
        const auto found = std::ranges::find(result.models, name, &results::ModelResult::name);
        if (found == result.models.end())
            throw std::runtime_error(name + " is not in the result");
        return *found;
    }

    results::Result result;
};

TEST_P(LargeDeformations, AreWhatACodeOfSomebodyElseFound) {
    if (!found_elsewhere.contains(GetParam()))
        return; // that code pulled by a displacement
    const auto &measure = find("fem_p2_neo_hookean").solution;
    const auto tool = measure.reaction.size() - 1;
    for (const auto &[name, found] : found_elsewhere.at(GetParam())) {
        const auto &solution = find(name).solution;
        ASSERT_EQ(solution.status, core::SolutionStatus::ok) << name << ": " << solution.message;
        const auto comparison =
            core::compare(result.problem.body->mesh, result.problem.load_case, solution, measure, "fem_p2_neo_hookean");
        EXPECT_NEAR(comparison.relative_l2, found.relative_l2, 0.005) << name;
        EXPECT_NEAR(solution.reaction[tool].norm() / measure.reaction[tool].norm(), found.reaction, 0.015) << name;
    }
}

/// The two facts that the regime is there for.
TEST_P(LargeDeformations, ShowThatTheLinearJudgeIsWrongAndTheBestSpringsLessSo) {
    const auto &reference = find("fem_p2p1_neo_hookean");
    EXPECT_FALSE(reference.comparison);
    const bool ships = GetParam() == "large_traction";
    EXPECT_EQ(reference.solution.solver.starts_with("stored since"), ships) << reference.solution.solver;
    const auto &springs = *find("nodal_neo_hookean").comparison, &linear = *find("fem_p2p1").comparison;
    EXPECT_LT(find("fem_p2_neo_hookean").comparison->relative_l2, 0.04);
    EXPECT_LT(springs.relative_l2, linear.relative_l2);
    EXPECT_GT(linear.relative_l2, 0.09);
    EXPECT_LT(find("nodal_springs").comparison->relative_l2, linear.relative_l2);
}

TEST_P(LargeDeformations, KeepThePathOfEveryModel) {
    ASSERT_GT(result.models.size(), 1U);
    for (const auto &model : result.models) {
        ASSERT_EQ(model.solution.path.size(), result.problem.load_case.path.size()) << model.name;
        double last = 0.0;
        for (const auto &point : model.solution.path) {
            EXPECT_GT(point.strain_energy, last) << model.name;
            last = point.strain_energy;
        }
        EXPECT_NEAR(last, model.solution.strain_energy, 1e-6 * last) << model.name;
        const auto at_end = model.solution.path.back().reaction.back() - model.solution.reaction.back();
        EXPECT_LT(at_end.norm(), 1e-9 * model.solution.reaction.back().norm()) << model.name;
    }
}

INSTANTIATE_TEST_SUITE_P(OnTheHealthyLiver, LargeDeformations,
                         testing::Values("large_traction", "flat_palpation", "held_retraction"),
                         [](const auto &tested) { return tested.param; });

} // namespace
} // namespace livermark
