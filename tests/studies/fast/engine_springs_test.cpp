#include <cmath>
#include <filesystem>
#include <gtest/gtest.h>
#include <string>

#include "core/support/files.hpp"
#include "msm/engine_parameters.hpp"
#include "studies/exchange/engine_springs.hpp"
#include "tests/bad_input.hpp"
#include "tests/samples/small_bar.hpp"

namespace livermark::studies {
namespace {

namespace fs = std::filesystem;

results::EngineProblem solved_problem(double l2, double tool) {
    results::EngineProblem problem;
    problem.body = "bar";
    problem.load_case = "pull";
    problem.relative_l2 = l2;
    problem.stiffness_at_tool = tool;
    return problem;
}

TEST(EngineSprings, ErrorsAreMediansOfSizesAndTheWorstWithItsSign) {
    results::EngineEntry entry;
    entry.engine = "jolt";
    entry.version = "1.1.0";
    entry.settings["substeps"] = 20;
    entry.problems = {solved_problem(0.1, 0.2), solved_problem(0.3, -0.5), solved_problem(0.2, 0.1),
                      solved_problem(9.0, 9.0), results::EngineProblem{}};
    entry.problems[3].outcome = results::failed_outcome;
    entry.problems[4].kind = results::in_motion;
    entry.problems[4].in_contact = 0.17;
    const auto errors = errors_of(entry);
    EXPECT_EQ(errors.settings, "substeps = 20");
    EXPECT_DOUBLE_EQ(errors.relative_l2.median, 0.2);
    EXPECT_DOUBLE_EQ(errors.stiffness_at_tool.median, 0.2);
    EXPECT_DOUBLE_EQ(errors.stiffness_at_tool.worst, -0.5);
    EXPECT_EQ(errors.stiffness_at_tool.number, 3U) << "one has failed, and one is in motion";
    EXPECT_DOUBLE_EQ(errors.in_contact.median, 0.17);
    EXPECT_EQ(errors.force.number, 0U);
    EXPECT_TRUE(std::isnan(errors.force.median));
    EXPECT_EQ(errors.num_failed, 1U);
}

TEST(EngineSprings, EveryEngineHasItsFileWithUnitsAndMeanings) {
    const auto folder = tests::folder_with_bar("engine_springs", 0.02, 0.45);
    EngineSpringsOptions options{.body = (folder / "bar.toml").string(),
                                 .engine = {},
                                 .material = {},
                                 .choices = {},
                                 .output = (folder / "out").string()};
    for (const auto &engine : msm::all_engines()) {
        options.engine = engine.name;
        const auto written = write_engine_springs(options, "test");
        ASSERT_EQ(written.files.size(), written.parameters.text ? 2U : 1U);
        EXPECT_EQ(written.files[0], folder / "out" / ("bar." + engine.name + ".json"));
        const auto text = support::read_text(written.files[0]);
        for (const auto &array : written.parameters.arrays)
            EXPECT_NE(text.find("\"" + array.name + "\":{\"unit\":"), std::string::npos) << array.name;
        EXPECT_EQ(text.find("nan"), std::string::npos);
        EXPECT_EQ(text.find("inf"), std::string::npos);
    }
    EXPECT_TRUE(fs::exists(folder / "out" / "bar.mujoco.xml"));
    options.engine = "unity";
    tests::expect_input_error([&] { write_engine_springs(options, "test"); },
                              {"no engine 'unity'", "known are: bullet, godot, jolt"});
}

TEST(EngineSprings, AnEngineThatWasNotRunHasNoErrors) {
    EXPECT_FALSE(measured_errors("an_engine_that_nobody_wrote"));
    EngineSprings springs;
    springs.body = "a \"body\"";
    springs.parameters.engine = "jolt";
    springs.parameters.arrays = {{"edges", "", "ends", std::vector<int>{0, 1, 1, 2}, 2},
                                 {"mass", "kg", "of nodes", std::vector<double>{0.5, 1e-7}, 1}};
    const auto text = engine_springs_text(springs, "test");
    EXPECT_NE(text.find(R"("body": "a \"body\"")"), std::string::npos) << text;
    EXPECT_NE(text.find(R"("shape":[2,2],"values":[[0,1],[1,2]])"), std::string::npos) << text;
    EXPECT_NE(text.find(R"("shape":[2],"values":[0.5,1e-07])"), std::string::npos) << text;
    EXPECT_NE(text.find(R"("errors": null)"), std::string::npos) << text;
}

} // namespace
} // namespace livermark::studies
