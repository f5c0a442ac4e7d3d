#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>
#include <string>

#include "core/support/files.hpp"
#include "results/hdf5/result_file.hpp"
#include "results/records/engine_entry.hpp"
#include "tests/livermark_command.hpp"
#include "tests/samples/small_bar.hpp"

namespace livermark {
namespace {

namespace fs = std::filesystem;

/// Writes what a model of the suite found for a result file as somebody else's solution.
/// @return its relative L2 error there
double write_solution_of(const std::string &model, const fs::path &result_file, const fs::path &solution) {
    const auto result = results::read_result(result_file);
    for (const auto &[name, summary, source, found, comparison] : result.models) {
        if (name != model)
            continue;
        std::ofstream csv(solution);
        csv << "x,y,z,ux,uy,uz\n";
        for (std::size_t i = 0; i < found.displacement.size(); ++i) {
            const auto &x = result.problem.body->mesh.points[i];
            const auto &u = found.displacement[i];
            csv << fmt::format("{},{},{},{},{},{}\n", x.x(), x.y(), x.z(), u.x(), u.y(), u.z());
        }
        return comparison.value().relative_l2;
    }
    ADD_FAILURE() << "there is no " << model << " in " << result_file;
    return 0.0;
}

TEST(EntryCommand, ScoresEachProblemAndSaysWhichOnesFailed) {
    const auto folder = tests::folder_with_bar("entry");
    tests::write_pull(folder, "pull");
    tests::write_pull(folder, "strong_pull", 20.0);
    const auto run = tests::livermark(
        fmt::format("run {0}/bar.toml --load-case {0}/pull.toml --model lloyd --reference-on-mesh --output {0}/runs",
                    folder.string()));
    ASSERT_EQ(run.status, 0) << run.output;
    const double error = write_solution_of("lloyd", folder / "runs" / "bar" / "pull.h5", folder / "pull.csv");
    std::ofstream(folder / "jelly.toml")
        << "engine = \"jelly\"\nversion = \"1.0\"\nmachine = \"a laptop\"\n[settings]\nsubsteps = 20\n"
           "[[problem]]\nbody = \"bar.toml\"\nload_case = \"pull.toml\"\nsolution = \"pull.csv\"\nsetup_seconds = 2.5\n"
           "[[problem]]\nbody = \"bar.toml\"\nload_case = \"strong_pull.toml\"\nsolution = \"nowhere.csv\"\n"
           "[[problem]]\nvariant = 2\nload_case = \"press_and_slide\"\ncannot = \"It has no tool.\"\n";
    const auto scored =
        tests::livermark(fmt::format("score --entry {0}/jelly.toml --reference-on-mesh --output {0}", folder.string()));
    tests::expect_outcome(scored, 1, {"jelly 1.0", "nowhere.csv", "It has no tool.", "jelly.json"});

    const auto entry = results::read_engine_entry(folder / "jelly.json");
    EXPECT_EQ(results::engine_entry_text(entry), support::read_text(folder / "jelly.json"));
    EXPECT_EQ(entry.settings["substeps"], 20);
    EXPECT_FALSE(entry.livermark.empty());
    ASSERT_EQ(entry.problems.size(), 3U);
    const auto &pull = entry.problems[0];
    EXPECT_TRUE(pull.is_scored()) << pull.message;
    EXPECT_EQ(pull.body, "bar");
    EXPECT_EQ(pull.regime, "small");
    EXPECT_EQ(pull.digest.size(), 16U);
    EXPECT_EQ(pull.setup_seconds, 2.5);
    EXPECT_NEAR(pull.relative_l2, error, 1e-9);
    EXPECT_TRUE(std::isfinite(pull.stiffness_at_tool));
    EXPECT_TRUE(std::isnan(pull.force));
    EXPECT_TRUE(entry.problems[1].has_failed());
    EXPECT_EQ(entry.problems[2].outcome, results::cannot_outcome);
    EXPECT_EQ(entry.problems[2].kind, results::in_motion);
    EXPECT_TRUE(fs::exists(folder / "bar" / "pull.jelly.h5"));
}

TEST(EntryCommand, GoesWithoutABody) {
    const auto folder = tests::folder_with_bar("entry_words").string();
    tests::expect_outcome(tests::livermark(fmt::format("score --entry {0}/mine.toml {0}/bar.toml", folder)), 2,
                          {"--entry goes without --body"});
    tests::expect_outcome(tests::livermark(fmt::format("score --entry {0}/mine.toml", folder)), 2, {"mine.toml"});
    tests::expect_outcome(tests::livermark("score"), 2, {"--body is required"});
    tests::expect_outcome(tests::livermark("export --board 7 beam"), 2, {"--board goes without --body"});
}

TEST(BoardCommand, WritesProblemsThatAnEntryListsOnce) {
    const auto folder = tests::folder_with_bar("board") / "board";
    const auto exported = tests::livermark(fmt::format("export --board 7 -o {}", folder.string()));
    ASSERT_EQ(exported.status, 0) << exported.output;
    const auto entry = support::read_text(folder / "entry.toml");
    EXPECT_EQ(tests::count(entry, "[[problem]]"), 8U);
    std::size_t num_problems = 0;
    for (const auto &file : fs::recursive_directory_iterator(folder))
        if (const auto name = file.path().filename().string();
            name.ends_with(".problem.h5") || name.ends_with(".scene.h5")) {
            const auto load_case = name.substr(0, name.find('.'));
            EXPECT_NE(entry.find(
                          fmt::format("solution = \"{}/{}.", file.path().parent_path().filename().string(), load_case)),
                      std::string::npos)
                << file.path();
            ++num_problems;
        }
    EXPECT_EQ(num_problems, 8U);
    tests::expect_outcome(tests::livermark(fmt::format("export --board 7 -o {}", folder.string())), 2,
                          {"there is an entry already"});
    // Nothing is solved yet, so everything is said to have failed, and nothing stops.
    const auto scored = tests::livermark(fmt::format("score --entry {}/entry.toml", folder.string()));
    EXPECT_EQ(scored.status, 1) << scored.output;
    const auto scores = results::read_engine_entry(folder / "mine.json");
    EXPECT_EQ(scores.board, 7);
    ASSERT_EQ(scores.problems.size(), 8U);
    for (const auto &problem : scores.problems)
        EXPECT_TRUE(problem.has_failed()) << problem.load_case;
}

} // namespace
} // namespace livermark
