#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>
#include <sstream>
#include <string>
#include <vector>

#include "results/hdf5/result_file.hpp"
#include "tests/fem_reference/fem_test_bodies.hpp"
#include "tests/livermark_command.hpp"
#include "tests/same_bits.hpp"
#include "tests/samples/small_bar.hpp"

namespace livermark {
namespace {

namespace fs = std::filesystem;

/// Solutions do not depend on who solves them, and neither does what is kept from one load case for another: the
/// third has the static solution of the first.
TEST(Jobs, GiveTheSameBits) {
    const auto folder = tests::folder_with_bar("jobs", 0.02, tests::pressure_ratio);
    tests::write_pull(folder, "first", 10.0);
    tests::write_pull(folder, "second", 12.0);
    tests::write_pull(folder, "third", 10.0);
    tests::write_pull(folder, "fourth", 14.0);
    const std::vector<std::string> names{"first", "second", "third", "fourth"};
    const auto run = [&](int jobs) {
        std::string load_cases;
        for (const auto &name : names)
            load_cases += " " + (folder / (name + ".toml")).string();
        const auto runs = folder / fmt::format("runs_{}", jobs);
        const auto outcome =
            tests::livermark(fmt::format("run --body {} --load-case{} --amplitude 0.5,1 --jobs {} --output {}",
                                         (folder / "bar.toml").string(), load_cases, jobs, runs.string()));
        EXPECT_EQ(outcome.status, 0) << outcome.output;
        std::vector<results::Result> results;
        for (const auto &name : names)
            for (const auto *amplitude : {"0.5", "1"})
                results.push_back(results::read_result(runs / "bar" / fmt::format("{}@{}.h5", name, amplitude)));
        return results;
    };
    const auto one_by_one = run(1);
    const auto in_a_pool = run(3);
    for (std::size_t r = 0; r < one_by_one.size(); ++r) {
        ASSERT_EQ(one_by_one[r].models.size(), in_a_pool[r].models.size());
        for (std::size_t m = 0; m < one_by_one[r].models.size(); ++m) {
            const auto &a = one_by_one[r].models[m], &b = in_a_pool[r].models[m];
            SCOPED_TRACE(a.name + " on " + one_by_one[r].problem.load_case.name);
            EXPECT_EQ(a.name, b.name);
            EXPECT_EQ(a.solution.solver, b.solution.solver);
            EXPECT_TRUE(tests::same_bits(a.solution.displacement, b.solution.displacement));
            EXPECT_TRUE(tests::same_bits(a.solution.reaction, b.solution.reaction));
        }
    }
}

/// The solutions of load cases that are solved together are those of each alone, and a run that goes on solves what
/// lacks.
TEST(Jobs, LoadCasesTogetherHaveTheSolutionsOfEachAlone) {
    const auto folder = tests::folder_with_bar("jobs_together", 0.02, tests::pressure_ratio);
    const auto temporary = folder / "temporary";
    fs::create_directory(temporary);
    tests::write_pull(folder, "first", 10.0);
    tests::write_pull(folder, "second", 12.0);
    std::ofstream(folder / "third.toml")
        << "title = \"press\"\ntarget_peak_displacement = 0.001\n[[condition]]\npatch = \"x_max\"\n"
           "displacement = [-0.001, 0.0, 0.0]\n[[condition]]\npatch = \"x_min\"\n"
           "displacement = [0.0, 0.0, 0.0]\n";
    const auto run = [&](const std::string &load_cases, const std::string &runs) {
        std::string files, name;
        for (std::istringstream names(load_cases); names >> name;)
            files += fmt::format(" {}/{}.toml", folder.string(), name);
        const auto outcome = tests::run_command(fmt::format(
            "TMPDIR={} {} run --body {}/bar.toml --load-case{} --model fem_p2 --output {}/{}{}", temporary.string(),
            LIVERMARK_BINARY, folder.string(), files, folder.string(), runs, runs == "resumed" ? " --resume" : ""));
        EXPECT_EQ(outcome.status, 0) << outcome.output;
        EXPECT_TRUE(fs::is_empty(temporary));
    };
    const auto solution = [&](const std::string &runs, const std::string &load_case, const std::string &model) {
        const auto result = results::read_result(folder / runs / "bar" / (load_case + ".h5"));
        return std::ranges::find(result.models, model, &results::ModelResult::name)->solution;
    };
    run("first second third", "together");
    for (const std::string name : {"first", "second", "third"}) {
        run(name, "alone");
        for (const std::string model : {"fem_p2p1", "fem_p2p1_refined"}) {
            SCOPED_TRACE(name + " by " + model);
            const auto together = solution("together", name, model), alone = solution("alone", name, model);
            // Refined meshes are those of one load case.
            EXPECT_EQ(together.solver.find("3 load cases together") != std::string::npos, model == "fem_p2p1")
                << together.solver;
            EXPECT_EQ(alone.solver.find("together"), std::string::npos) << alone.solver;
            const double tolerance = model == "fem_p2p1" ? 1e-8 : 1e-5;
            EXPECT_LT(tests::relative_difference(together.displacement, alone.displacement), tolerance);
            EXPECT_LT(tests::relative_difference(together.reaction, alone.reaction), tolerance);
        }
    }
    run("first second third", "resumed");
    fs::remove(folder / "resumed" / "bar" / "second.h5");
    run("first second third", "resumed");
    EXPECT_EQ(solution("resumed", "second", "fem_p2p1").solver.find("together"), std::string::npos);
    EXPECT_NE(solution("resumed", "first", "fem_p2p1").solver.find("together"), std::string::npos);
}

/// Factors of load cases that constrain a little more than another one serve for both: solutions are those of each
/// alone but for rounding, and the same whoever solves them.
TEST(Jobs, LoadCasesThatShareAFactorHaveTheSolutionsOfEachAlone) {
    const auto folder = tests::folder_with_bar("jobs_shared", 0.01);
    tests::write_pull(folder, "pull", 10.0);
    std::ofstream(folder / "press.toml")
        << "title = \"press\"\ntarget_peak_displacement = 0.001\n[[condition]]\npatch = \"x_min\"\n"
           "displacement = [0.0, 0.0, 0.0]\n[[condition]]\n"
           "disc = { patch = \"x_max\", radius = 0.001 }\npush = 0.001\n";
    const auto solutions = [&](const std::string &load_cases, int jobs) {
        std::string files, name;
        for (std::istringstream names(load_cases); names >> name;)
            files += fmt::format(" {}/{}.toml", folder.string(), name);
        const auto outcome = tests::livermark(fmt::format(
            "run --body {0}/bar.toml --load-case{1} --model lloyd fem_p1 fem_p2 --reference-on-mesh --jobs {2} "
            "--output {0}/runs",
            folder.string(), files, jobs));
        EXPECT_EQ(outcome.status, 0) << outcome.output;
        const auto result = results::read_result(folder / "runs" / "bar" / "press.h5");
        std::vector<std::vector<core::Vector3>> displacement;
        for (const auto *model : {"fem_p1", "fem_p2", "lloyd"})
            displacement.push_back(
                std::ranges::find(result.models, model, &results::ModelResult::name)->solution.displacement);
        return displacement;
    };
    const auto shared = solutions("pull press", 1), in_a_pool = solutions("pull press", 2),
               alone = solutions("press", 1);
    for (std::size_t m = 0; m < shared.size(); ++m) {
        SCOPED_TRACE(m);
        EXPECT_TRUE(tests::same_bits(shared[m], in_a_pool[m]));
        EXPECT_FALSE(tests::same_bits(shared[m], alone[m])) << "no factor was shared";
        EXPECT_LT(tests::relative_difference(shared[m], alone[m]), 1e-10);
    }
}

TEST(Jobs, NeedNoPlaceForTemporaryFilesAndLeaveNoSolutions) {
    const auto folder = tests::folder_with_bar("jobs_temporary");
    tests::write_pull(folder, "a", 10.0);
    const auto outcome =
        tests::run_command(fmt::format("TMPDIR={0}/nowhere {1} run --body {0}/bar.toml --load-case {0}/a.toml --model "
                                       "lloyd --output {0}/runs",
                                       folder.string(), LIVERMARK_BINARY));
    EXPECT_EQ(outcome.status, 0) << outcome.output;
    EXPECT_TRUE(fs::exists(folder / "runs" / "bar" / "a.h5"));
    EXPECT_FALSE(fs::exists(folder / "runs" / ".solutions"));
}

TEST(Jobs, DoNotChangeTheOrderOfTheTable) {
    const auto folder = tests::folder_with_bar("jobs_table");
    tests::write_pull(folder, "a", 10.0);
    tests::write_pull(folder, "b", 12.0);
    const auto table = [&](int jobs) {
        const auto outcome = tests::livermark(
            fmt::format("run --body {0}/bar.toml --load-case {0}/b.toml {0}/a.toml --model lloyd --reference-on-mesh "
                        "--tables --markdown --jobs {1} --output {0}/runs",
                        folder.string(), jobs));
        EXPECT_EQ(outcome.status, 0) << outcome.output;
        std::string load_cases; // the times differ
        std::istringstream lines(outcome.output);
        for (std::string line; std::getline(lines, line);)
            if (line.starts_with("| bar | "))
                load_cases += line.substr(0, line.find(" |", 14)) + "\n";
        return load_cases;
    };
    const auto by_one = table(1);
    EXPECT_FALSE(by_one.empty());
    EXPECT_EQ(by_one, table(2));
}

/// A small bar of its own, so that nothing takes long.
class Resume : public testing::Test {
  protected:
    void SetUp() override {
        folder_ = tests::folder_with_bar("resume");
        for (const auto *name : {"first", "second"})
            tests::write_pull(folder_, name);
    }

    tests::Outcome run(const std::string &more) const {
        const auto at = [&](const char *name) { return (folder_ / name).string(); };
        return tests::livermark(
            fmt::format("run --body {} --load-case {} {} --model lloyd --reference-on-mesh --output {}{}",
                        at("bar.toml"), at("first.toml"), at("second.toml"), at("runs"), more));
    }

    fs::path file(const std::string &name) const { return folder_ / "runs" / "bar" / (name + ".h5"); }
    std::string created(const std::string &name) const { return results::read_result(file(name)).provenance.created; }

    fs::path folder_;
};

bool is_resumed(const tests::Outcome &outcome, const std::string &load_case) {
    return outcome.output.find("bar / " + load_case + " / lloyd, kept") != std::string::npos;
}

TEST_F(Resume, KeepsWhatIsThereAndComesToTheSameTable) {
    const auto whole = run("");
    ASSERT_EQ(whole.status, 0) << whole.output;
    fs::remove(file("second"));
    const auto first_time = created("first");
    const auto resumed = run(" --resume");
    EXPECT_EQ(resumed.status, 0) << resumed.output;
    EXPECT_TRUE(is_resumed(resumed, "first")) << resumed.output;
    EXPECT_FALSE(is_resumed(resumed, "second"));
    EXPECT_EQ(created("first"), first_time);
    EXPECT_EQ(results::read_result(file("second")).provenance.command.find("--resume"), std::string::npos);
    EXPECT_TRUE(is_resumed(run(" --resume"), "second"));
}

TEST_F(Resume, HoldsAgainWhatIsDamagedOrOtherwise) {
    ASSERT_EQ(run("").status, 0);
    fs::resize_file(file("first"), fs::file_size(file("first")) / 2);
    tests::write_pull(folder_, "second", 11.0);
    const auto resumed = run(" --resume");
    EXPECT_EQ(resumed.status, 0) << resumed.output;
    EXPECT_FALSE(is_resumed(resumed, "first"));
    EXPECT_FALSE(is_resumed(resumed, "second"));
    EXPECT_NO_THROW(results::read_result(file("first")));
    // Without it nothing is kept, and neither is what another command has made.
    EXPECT_FALSE(is_resumed(run(""), "first"));
    EXPECT_FALSE(is_resumed(run(" --young 6000 --resume"), "first"));
}

} // namespace
} // namespace livermark
