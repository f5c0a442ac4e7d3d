#include <gtest/gtest.h>

#include <cmath>

#include "core/error_norms.hpp"
#include "core/support/toml_input.hpp"
#include "load_cases/places/selector.hpp"
#include "load_cases/readers/load_case_reader.hpp"
#include "meshes/io/body_reader.hpp"
#include "msm/spring_law.hpp"
#include "studies/models/model_table.hpp"

namespace livermark {
namespace {

std::vector<std::string> all_bodies() {
    return support::list_toml(LIVERMARK_SOURCE_DIR "/meshes");
}

class Relaxation : public testing::TestWithParam<std::string> {};

} // namespace

/// Time stepping under damping and Newton's method find the same rest, on every small load case that ships. Springs
/// that are pressed or pulled by centimetres fold, and have several places of rest near each other: then the two may
/// end in different ones, or creep from one to the next.
TEST_P(Relaxation, ComesToTheEquilibriumThatNewtonFinds) {
    const auto body = std::make_shared<const core::Body>(
        meshes::read_body(std::filesystem::path(LIVERMARK_SOURCE_DIR "/meshes") / (GetParam() + ".toml")));
    models::ModelOptions by_time_stepping;
    by_time_stepping.equilibrium = models::EquilibriumMethod::relaxation;
    const auto law = msm::all_spring_laws().front().name;
    const auto solve = [&](const std::string &model, const models::ModelOptions &options,
                           const core::Problem &problem) {
        const auto models = models::all_models(options);
        return std::ranges::find(models, model, &core::Model::name)->solve(problem);
    };
    int num_compared = 0;
    for (const auto &name : support::list_toml(LIVERMARK_SOURCE_DIR "/load_cases")) {
        core::Problem problem{body, {}};
        try {
            problem.load_case = load_cases::read_load_case(
                std::filesystem::path(LIVERMARK_SOURCE_DIR "/load_cases") / (name + ".toml"), body->mesh);
        } catch (const load_cases::NotOnBody &) {
            continue;
        }
        if (problem.load_case.regime == core::Regime::large)
            continue;
        const auto by_steps = models::all_models(by_time_stepping);
        const bool is_wanted = std::ranges::find(by_steps, law, &core::Model::name)->takes_part_in(problem);
        EXPECT_EQ(is_wanted, problem.load_case.press_depth == 0.0) << name;
        if (!is_wanted)
            continue;
        problem.load_case.release.reset();
        // As large as a run makes it.
        const auto baseline = solve(models::baseline_name(), {}, problem);
        double peak = 0.0;
        for (const auto &displacement : baseline.displacement)
            peak = std::max(peak, displacement.norm());
        problem.load_case = core::scaled(problem.load_case, problem.load_case.target_peak_displacement / peak);
        const auto expected = solve(law, {}, problem);
        const auto found = solve(law, by_time_stepping, problem);
        ASSERT_EQ(found.status, core::SolutionStatus::ok) << name << ": " << found.message;
        const auto comparison = core::compare(body->mesh, problem.load_case, found, expected, "Newton");
        EXPECT_LT(comparison.relative_l2, 1e-6) << name;
        EXPECT_LT(comparison.max_error_relative, 1e-6) << name;
        EXPECT_TRUE(found.solver.starts_with("dynamic relaxation")) << found.solver;
        RecordProperty(name, found.solver);
        ++num_compared;
    }
    EXPECT_GT(num_compared, 1);
}

INSTANTIATE_TEST_SUITE_P(Bodies, Relaxation, testing::ValuesIn(all_bodies()),
                         [](const auto &info) { return info.param; });

} // namespace livermark
