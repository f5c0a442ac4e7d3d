#include "studies/frequencies/frequencies.hpp"

#include <algorithm>
#include <cmath>

#include "studies/models/model_table.hpp"
#include "studies/run/run.hpp"
#include "tests/bad_input.hpp"
#include "tests/samples/small_bar.hpp"

namespace livermark::studies {
namespace {

StabilityOptions options_of_bar(const std::string &suite) {
    const auto folder = tests::folder_with_bar(suite);
    tests::write_pull(folder);
    StabilityOptions options;
    options.bodies = {(folder / "bar.toml").string()};
    options.load_case = (folder / "pull.toml").string();
    options.output = (folder / "runs").string();
    return options;
}

TEST(Stability, OfRunsIsAsPredictedFromTheLargestFrequency) {
    auto options = options_of_bar("stability_runs");
    options.integrators = {"symplectic_euler", "runge_kutta_4", "implicit_euler"};
    const auto found = find_stability(options, "test", {});
    ASSERT_EQ(found.records.size(), 1u);
    const auto &bar = found.records[0];
    ASSERT_EQ(bar.limits.size(), 3u);
    EXPECT_NEAR(bar.limits[0].undamped.predicted * bar.largest_frequency, 2.0, 1e-6);
    EXPECT_NEAR(bar.limits[1].undamped.predicted * bar.largest_frequency, std::sqrt(8.0), 1e-6);
    EXPECT_FALSE(bar.limits[2].undamped.has_number());
    for (const auto &limits : {bar.limits[0], bar.limits[1]}) {
        EXPECT_LT(std::abs(limits.undamped.difference()), largest_difference) << limits.integrator;
        EXPECT_LT(std::abs(limits.damped.difference()), largest_difference) << limits.integrator;
        EXPECT_LT(limits.damped.predicted, limits.undamped.predicted) << limits.integrator;
    }
    EXPECT_TRUE(is_as_predicted(bar));
    EXPECT_GE(bar.largest_frequency_bound, bar.largest_frequency);
    EXPECT_LT(bar.lowest_frequency, bar.largest_frequency);
    const auto read = results::read_stability(std::filesystem::path(options.output) / "bar" / "stability.lloyd.h5");
    EXPECT_EQ(read.largest_frequency, bar.largest_frequency);
}

TEST(Stability, KnowsTheSpringsOfEveryModelThatIsMadeOfThem) {
    auto options = options_of_bar("stability_of_models");
    options.integrators = {"symplectic_euler"};
    options.models = {"lloyd", "nodal_neo_hookean", "van_gelder_nodal_volume"};
    const auto found = find_stability(options, "test", {});
    ASSERT_EQ(found.records.size(), 3u);
    for (std::size_t m = 0; m < options.models.size(); ++m) {
        const auto &stability = found.records[m];
        EXPECT_EQ(stability.model, options.models[m]);
        EXPECT_TRUE(stability.spring_law.empty());
        EXPECT_TRUE(is_as_predicted(stability)) << stability.model;
        const auto read = results::read_stability(std::filesystem::path(options.output) / "bar" /
                                                  ("stability." + options.models[m] + ".h5"));
        EXPECT_EQ(read.model, options.models[m]);
        EXPECT_EQ(read.limits.at(0).damped.predicted, stability.limits.at(0).damped.predicted);
    }
    options.models.clear(); // the law of the same name gives the same springs
    options.no_observed = true;
    EXPECT_EQ(find_stability(options, "test", {}).records.at(0).largest_frequency, found.records[0].largest_frequency);
}

TEST(Stability, OfAModelIsTheStepOfItsResultFiles) {
    auto options = options_of_bar("stability_of_runs");
    options.integrators = {"symplectic_euler"};
    options.models = {"nodal_springs"};
    options.no_observed = true;
    const auto found = find_stability(options, "test", {});
    const auto known = models::all_models();
    const auto model = std::ranges::find(known, "nodal_springs", &core::Model::name);
    const auto problems = read_scaled_problems(options.bodies, options.load_case, {}).problems;
    const auto solution = model->solve(problems.at(0));
    EXPECT_NEAR(solution.explicit_steps->critical_time_step / found.records.at(0).limits.at(0).undamped.predicted, 1.0,
                1e-6);
}

TEST(Stability, WithoutRunsHasPredictionsOnlyAndIsNotContradicted) {
    auto options = options_of_bar("stability_predicted");
    options.no_observed = true;
    int num_steps = 0;
    const auto found = find_stability(options, "test", [&](int, int, const std::string &) { ++num_steps; });
    EXPECT_GT(num_steps, 1);
    for (const auto &limits : found.records.at(0).limits)
        EXPECT_TRUE(std::isnan(limits.undamped.observed)) << limits.integrator;
    EXPECT_TRUE(is_as_predicted(found.records[0]));
}

TEST(Stability, IsNotAsPredictedWhereARunDiffers) {
    results::Stability stability;
    stability.limits = {{"heun", {.predicted = 1.0, .observed = 0.985}, {.predicted = 1.0, .observed = 1.015}}};
    EXPECT_TRUE(is_as_predicted(stability));
    stability.limits[0].damped.observed = 1.03;
    EXPECT_FALSE(is_as_predicted(stability));
}

TEST(Stability, RefusesWhatThereIsNotAndTwins) {
    auto options = options_of_bar("stability_refused");
    const auto refuse = [&](std::vector<std::string> StabilityOptions::*list, std::vector<std::string> names,
                            const std::vector<std::string> &parts) {
        options.*list = std::move(names);
        tests::expect_input_error([&] { find_stability(options, "test", {}); }, parts);
    };
    refuse(&StabilityOptions::models, {"fem_p2"}, {"fem_p2", "nodal_springs"});
    refuse(&StabilityOptions::models, {"nodal_neo_hooke"}, {"did you mean 'nodal_neo_hookean'?"});
    refuse(&StabilityOptions::models, {"lloyd", "lloyd"}, {"'lloyd'", "twice"});
    options.models = StabilityOptions{}.models;
    refuse(&StabilityOptions::integrators, {"huen"}, {"'huen'", "did you mean 'heun'?"});
    refuse(&StabilityOptions::integrators, {"heun", "heun"}, {"'heun'", "twice"});
}

} // namespace
} // namespace livermark::studies
