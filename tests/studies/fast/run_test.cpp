#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "meshes/io/body_reader.hpp"
#include "results/one_reference.hpp"
#include "results/records/springs.hpp"
#include "studies/models/model_table.hpp"
#include "studies/run/run.hpp"
#include "tests/bad_input.hpp"
#include "tests/samples/records/sample_records.hpp"
#include "tests/samples/small_bar.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark::studies {
namespace {

constexpr double target_peak = 0.0015; // m

/// A box under a pressure, a body force and a displacement that is not zero.
core::Problem driven_box() {
    const auto body = tests::make_body(tests::box_mesh({0.1, 0.08, 0.06}, {4, 3, 3}), {1060.0, 5000.0, 0.45});
    auto load_case = tests::empty_load_case(body->mesh);
    load_case.scale_to_target = true;
    load_case.target_peak_displacement = target_peak;
    load_case.acceleration = {0.0, 0.1, -0.2};
    tests::prescribe(load_case, body->mesh, "x_min", {0.0, 0.0, 0.0});
    tests::prescribe(load_case, body->mesh, "x_max", {0.0004, 0.0, 0.0});
    tests::pull(load_case, body->mesh, "y_max", {0.0, -20.0, 0.0});
    return {body, std::move(load_case)};
}

const core::Model baseline = baseline_of(choose_models({}, {}, false));

double peak_of(const core::Solution &solution) {
    double peak = 0.0;
    for (const auto &displacement : solution.displacement)
        peak = std::max(peak, displacement.norm());
    return peak;
}

TEST(LoadScaling, BringsTheBaselineToTheTarget) {
    PreparedModels prepared;
    const auto problem = driven_box();
    const auto scaled = scaled_to_target(problem, baseline, prepared);
    EXPECT_NEAR(peak_of(baseline.solve(scaled)), target_peak, 5e-6 * target_peak);
    EXPECT_FALSE(scaled.load_case.scale_to_target);
    EXPECT_TRUE(
        core::are_statically_equal(scaled.load_case, core::scaled(problem.load_case, scaled.load_case.load_scale)));
    EXPECT_GT(std::abs(scaled.load_case.load_scale - 1.0), 0.01);
}

/// Machines whose baselines differ in the last digits have the same load.
TEST(LoadScaling, IsTheSameWhateverTheLastDigits) {
    PreparedModels prepared;
    auto problem = driven_box();
    const auto scale = scaled_to_target(problem, baseline, prepared).load_case.load_scale;
    problem.load_case.target_peak_displacement *= 1.0 + 1e-9;
    EXPECT_EQ(scaled_to_target(problem, baseline, prepared).load_case.load_scale, scale);
    EXPECT_EQ(std::stod(fmt::format("{:.5e}", scale)), scale);
}

TEST(LoadScaling, LeavesALoadCaseAloneThatDoesNotAskForItAndNeedsALoadThatMovesTheBaseline) {
    PreparedModels prepared;
    auto problem = driven_box();
    problem.load_case.scale_to_target = false;
    EXPECT_EQ(scaled_to_target(problem, baseline, prepared).load_case.load_scale, 1.0);
    problem.load_case = core::scaled(std::move(problem.load_case), 0.0);
    problem.load_case.scale_to_target = true;
    EXPECT_THROW(scaled_to_target(problem, baseline, prepared), std::runtime_error);
}

core::Problem pressed_box() {
    const auto body = tests::make_body(tests::box_mesh({0.1, 0.1, 0.1}, {1, 1, 1}), {1e3, 5e3, 0.3});
    auto load_case = tests::empty_load_case(body->mesh);
    load_case.name = "press";
    tests::prescribe(load_case, body->mesh, "x_min", {0.0, 0.0, 0.0});
    tests::pull(load_case, body->mesh, "x_max", {-10.0, 0.0, 0.0});
    return {body, std::move(load_case)};
}

TEST(Amplitudes, MultiplyTheLoadAndStandInTheName) {
    const auto problem = pressed_box();
    const auto found = at_amplitudes(problem, std::vector{0.5, 10.0});
    ASSERT_EQ(found.size(), 2u);
    EXPECT_EQ(found[0].load_case.name, "press@0.5");
    EXPECT_EQ(found[1].load_case.name, "press@10");
    EXPECT_TRUE(core::are_statically_equal(found[1].load_case, core::scaled(problem.load_case, 10.0)));
    EXPECT_EQ(found[0].body, problem.body);
    const auto none = at_amplitudes(problem, {});
    ASSERT_EQ(none.size(), 1u);
    EXPECT_EQ(none[0].load_case.name, "press");
}

/// A result of springs with a nonlinearity at each of two amplitudes.
std::vector<results::Result> results_with(const std::vector<double> &amplitudes,
                                          const std::vector<double> &nonlinearity) {
    std::vector<results::Result> results;
    const auto problems = at_amplitudes(pressed_box(), amplitudes);
    for (std::size_t a = 0; a < problems.size(); ++a) {
        auto &result = results.emplace_back();
        result.problem = problems[a];
        result.models.resize(2);
        result.models[0].name = "springs";
        result.models[0].solution.nonlinearity = nonlinearity[a];
        result.models[1].name = "linear"; // its nonlinearity is not a number
    }
    return results;
}

TEST(Nonlinearity, IsFairUpToTheLastAmplitudeBeforeTheFirstThatIsTooLarge) {
    const std::vector amplitudes{0.1, 1.0, 10.0};
    const auto found = nonlinearity_by_amplitude(results_with(amplitudes, {0.004, 0.04, 0.4}), amplitudes);
    ASSERT_EQ(found.rows.size(), 1u);
    const auto &row = found.rows[0];
    EXPECT_EQ(std::vector(row.begin() + 1, row.end()),
              (std::vector<std::string>{"press", "springs", "0.40", "4.00", "40.00", "x 1"}));
    // One that is fair again later is not fair up to there.
    const auto again = nonlinearity_by_amplitude(results_with(amplitudes, {0.06, 0.04, 0.01}), amplitudes);
    EXPECT_EQ(again.rows.at(0).back(), "none");
}

TEST(Nonlinearity, HasADashWhereAProblemFailedAndTheStatusWhereAModelDid) {
    const std::vector amplitudes{1.0, 2.0, 4.0};
    auto results = results_with(amplitudes, {0.01, 0.01, 0.01});
    results[2].models[0].solution.status = core::SolutionStatus::not_converged;
    results.erase(results.begin() + 1);
    const auto row = nonlinearity_by_amplitude(results, amplitudes).rows.at(0);
    EXPECT_EQ(row.at(4), "-");
    EXPECT_EQ(row.at(5), core::to_string(core::SolutionStatus::not_converged));
}

using core::Vector3;

const std::shared_ptr<const core::Body> bar_body =
    tests::make_body(tests::box_mesh({0.1, 0.05, 0.05}, {3, 1, 1}), {1e3, 5e3, 0.3});

core::Problem pulled_bar() {
    auto load_case = tests::empty_load_case(bar_body->mesh);
    load_case.name = "pull";
    tests::prescribe(load_case, bar_body->mesh, "x_min", Vector3::Zero());
    tests::pull(load_case, bar_body->mesh, "x_max", {10.0, 0.0, 0.0});
    return {bar_body, std::move(load_case)};
}

/// With the role that a model of this name has.
core::Model named(std::string name) {
    core::Model model;
    const auto known = models::all_models();
    if (const auto found = std::ranges::find(known, name, &core::Model::name); found != known.end())
        model.at_rest = found->at_rest;
    model.name = std::move(name);
    return model;
}

/// The bar, stretched by 1 % times a factor; no solution if that is zero.
core::Solution stretched(double factor) {
    core::Solution solution;
    if (factor == 0.0)
        solution.status = core::SolutionStatus::not_converged;
    for (const auto &point : bar_body->mesh.points)
        solution.displacement.push_back(0.01 * factor * point);
    solution.reaction.assign(1, Vector3(-factor, 0.0, 0.0));
    solution.strain_energy = factor * factor;
    return solution;
}

/// @param models  names, with the factor by which the solution of each is stretched
results::Result evaluated(const std::vector<std::pair<std::string, double>> &models) {
    std::vector<core::Model> all;
    for (const auto &[name, factor] : models)
        all.push_back(named(name));
    const auto solve = [&](const core::Model &model, const core::Problem &) {
        const auto found = std::ranges::find(models, model.name, &std::pair<std::string, double>::first);
        return stretched(found->second);
    };
    return evaluate(pulled_bar(), all, solve, {});
}

const results::ModelResult &of(const results::Result &result, const std::string &name) {
    return *std::ranges::find(result.models, name, &results::ModelResult::name);
}

TEST(BenchmarkCase, ComparesEveryModelWithTheBestReferenceThatFindsASolution) {
    using Factors = std::vector<std::pair<std::string, double>>;
    struct Case {
        Factors models;
        std::string reference;
        Factors errors; ///< of those that are compared
    };
    for (const auto &[models, reference, errors] :
         {Case{{{"springs", 1.1}, {"fem_p2p1", 1.0}, {"fem_p2", 0.9}}, "fem_p2p1", {{"springs", 0.1}, {"fem_p2", 0.1}}},
          // The refined one where that on the mesh is not good enough.
          Case{{{"fem_p2p1", 1.02}, {"fem_p2p1_refined", 1.0}, {"springs", 0.5}},
               "fem_p2p1_refined",
               {{"springs", 0.5}, {"fem_p2p1", 0.02}}},
          Case{{{"fem_p2p1", 1.002}, {"fem_p2p1_refined", 1.0}, {"springs", 0.5}}, "fem_p2p1", {}},
          Case{{{"fem_p2p1", 0.0}, {"fem_p2", 1.0}, {"springs", 1.2}}, "fem_p2", {{"springs", 0.2}}}}) {
        const auto result = evaluated(models);
        EXPECT_EQ(of(result, "springs").comparison->reference, reference);
        EXPECT_FALSE(of(result, reference).comparison);
        for (const auto &[model, error] : errors)
            EXPECT_NEAR(of(result, model).comparison->relative_l2, error, 1e-12) << model << " by " << reference;
    }
}

TEST(BenchmarkCase, SaysHowFarTheReferenceIsFromTheRefinedOne) {
    const auto result = evaluated({{"fem_p2p1", 1.002}, {"fem_p2p1_refined", 1.0}, {"springs", 0.5}});
    EXPECT_EQ(result.reference_uncertainty->reference, "fem_p2p1");
    EXPECT_NEAR(result.reference_uncertainty->refinement_difference, 0.002, 1e-12);
    const auto not_good_enough = evaluated({{"fem_p2p1", 1.02}, {"fem_p2p1_refined", 1.0}, {"springs", 0.5}});
    EXPECT_EQ(not_good_enough.reference_uncertainty->reference, "fem_p2p1_refined");
    EXPECT_FALSE(evaluated({{"springs", 1.1}, {"fem_p2p1", 1.0}, {"fem_p2", 0.9}}).reference_uncertainty);
}

TEST(BenchmarkCase, ComparesNothingWithoutAReference) {
    const auto result = evaluated({{"fem_p2p1", 0.0}, {"fem_p2", 0.0}, {"springs", 1.2}});
    EXPECT_FALSE(of(result, "springs").comparison);
    EXPECT_EQ(of(result, "fem_p2").solution.status, core::SolutionStatus::not_converged);
}

/// Under a large load, whose reference comes to half of it and has no solution beyond.
TEST(BenchmarkCase, ComparesThePartOfThePathThatTheReferenceHasReached) {
    auto problem = pulled_bar();
    problem.load_case.regime = core::Regime::large;
    problem.load_case.path = {0.25, 0.5, 1.0};
    const auto on_path = [&](double factor, std::size_t num_points) {
        auto solution = stretched(factor);
        for (std::size_t k = 0; k < num_points; ++k) {
            auto &point = solution.path.emplace_back();
            for (const auto &displacement : solution.displacement)
                point.displacement.push_back((problem.load_case.path[k] * displacement).cast<float>());
            point.reaction = {problem.load_case.path[k] * solution.reaction[0]};
            point.strain_energy = factor;
        }
        if (num_points < problem.load_case.path.size()) {
            solution.status = core::SolutionStatus::not_converged;
            solution.message = "no equilibrium beyond 60 % of the load";
        }
        return solution;
    };
    std::vector<core::Model> models;
    for (const auto *name : {"fem_p2p1_neo_hookean", "fem_p2p1_neo_hookean_refined", "springs", "weak_springs"}) {
        models.push_back(named(name));
        models.back().judges = core::Regime::large;
    }
    const auto result =
        evaluate(problem, models,
                 [&](const core::Model &model, const core::Problem &) {
                     return on_path(model.name == "springs" ? 1.1 : 1.0, model.name == "springs"        ? 3
                                                                         : model.name == "weak_springs" ? 1
                                                                                                        : 2);
                 },
                 {});
    EXPECT_EQ(results::reference_of(result), "fem_p2p1_neo_hookean");
    EXPECT_EQ(results::compared_part(result), 0.5);
    EXPECT_FALSE(results::counts_in_means(result));
    EXPECT_NEAR(of(result, "springs").comparison->relative_l2, 0.1, 1e-6);
    EXPECT_FALSE(of(result, "weak_springs").comparison) << "it has not come so far";
    EXPECT_FALSE(result.reference_uncertainty);
    EXPECT_EQ(results::shown_status(of(result, "springs"), result), "ok to 50 %");
    EXPECT_EQ(results::shown_status(of(result, "fem_p2p1_neo_hookean"), result), "not_converged");
    const auto remarks = results::result_remarks({&result, 1});
    ASSERT_EQ(remarks.size(), 1u);
    EXPECT_NE(remarks[0].find("models are compared at 50 % of the load"), std::string::npos) << remarks[0];
    EXPECT_NE(remarks[0].find("fem_p2p1_neo_hookean, fem_p2p1_neo_hookean_refined, weak_springs: no equilibrium beyond "
                              "60 % of the load"),
              std::string::npos)
        << remarks[0];
}

TEST(BenchmarkCase, LeavesOutModelsOfAnotherRegime) {
    auto models = std::vector{named("fem_p2p1"), named("springs")};
    models[1].only = core::Regime::large;
    const auto result =
        evaluate(pulled_bar(), models, [](const core::Model &, const core::Problem &) { return stretched(1.0); }, {});
    ASSERT_EQ(result.models.size(), 1u);
    EXPECT_EQ(result.models[0].name, "fem_p2p1");
}

std::vector<std::string> names_of(const std::vector<core::Model> &models) {
    std::vector<std::string> names;
    for (const auto &model : models)
        names.push_back(model.name);
    return names;
}

bool has(const std::vector<std::string> &names, const std::string &name) {
    return std::ranges::find(names, name) != names.end();
}

TEST(ChosenModels, HaveWhatJudgesThemBesideThem) {
    const auto models = choose_models({"lloyd"}, {}, true);
    const auto names = names_of(models);
    for (const auto *name : {"lloyd", "fem_p2", "fem_p2p1", "fem_p2p1_refined"})
        EXPECT_TRUE(has(names, name)) << name;
    for (const auto *name : {"van_gelder", "fem_p1"})
        EXPECT_FALSE(has(names, name)) << name;
    EXPECT_TRUE(std::ranges::find(models, "fem_p2", &core::Model::name)->only_moving) << "judges motion alone";
    EXPECT_TRUE(has(names_of(choose_models({"fem_p1"}, {}, true)), "fem_p1"));
    EXPECT_EQ(baseline_of(choose_models({}, {}, true)).name, "fem_p1");
}

TEST(ChosenModels, HaveSomeOnlyIfTheyAreNamed) {
    for (const std::string name : {"fem_p2p1_refined", "tled"}) { // without uncertainty, and a method for motion
        EXPECT_FALSE(has(names_of(choose_models({}, {}, false)), name)) << name;
        EXPECT_TRUE(has(names_of(choose_models({name}, {}, false)), name)) << name;
    }
    EXPECT_FALSE(has(names_of(choose_models({}, {}, true)), "tled"));
}

/// A bar of the user's own, and a load case that pulls at it.
RunOptions pull_of_a_bar(const std::string &more = "") {
    const auto folder = tests::folder_with_bar("run_task", 0.03);
    RunOptions options;
    options.bodies = {(folder / "bar.toml").string()};
    options.load_cases = {tests::write_pull(folder, "pull", 1.0, more)};
    return options;
}

TEST(RunInput, HasTheSpringsOfACalibrationBesideTheModelsAskedFor) {
    auto options = pull_of_a_bar();
    const auto file = std::filesystem::path(options.bodies.front()).parent_path() / "springs.h5";
    results::write_calibration(file, tests::sample_calibration(meshes::read_body(options.bodies.front(), {})));
    options.calibration = file.string();
    for (const auto &models : {std::vector<std::string>{"lloyd"}, {}}) {
        options.models = models;
        const auto names = names_of(read_run(options).models);
        EXPECT_TRUE(has(names, "lloyd"));
        EXPECT_TRUE(has(names, "calibrated_nodal_volume"));
    }
}

/// One that names no regime is small, which --regime does not change.
TEST(RunInput, RefusesALoadCaseOfAnotherRegimeThanThatAskedFor) {
    auto options = pull_of_a_bar();
    options.regimes = {core::Regime::large};
    EXPECT_EQ(read_run(options).problems.size(), 1U) << "nobody asked";
    options.has_asked_for_regime = true;
    tests::expect_input_error([&] { read_run(options); },
                              {"--regime large: load case pull is of the small regime, as is each that names none",
                               "write regime = \"large\" into its file, or leave --regime out"});
    options.regimes = {core::Regime::small, core::Regime::large};
    EXPECT_EQ(read_run(options).problems.size(), 1U);
    auto large = pull_of_a_bar("regime = \"large\"\n");
    large.has_asked_for_regime = true;
    tests::expect_input_error([&] { read_run(large); }, {"--regime small: load case pull is of the large regime"});
    large.regimes = {core::Regime::large};
    EXPECT_EQ(read_run(large).problems.front().load_case.regime, core::Regime::large);
}

TEST(ChosenModels, AreRefusedWithTheNearestName) {
    tests::expect_input_error([] { choose_models({"loyd"}, {}, true); }, {"no model 'loyd'", "did you mean 'lloyd'?"});
}

} // namespace
} // namespace livermark::studies
