#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>
#include <sstream>
#include <string>
#include <vector>

#include "results/result_file.hpp"
#include "tests/livermark_command.hpp"
#include "tests/same_bits.hpp"
#include "tests/small_bar.hpp"

namespace livermark {
namespace {

namespace fs = std::filesystem;

void write_pull(const fs::path &file, double pull, const std::string &more = "") {
    std::ofstream(file) << fmt::format(
        "title = \"pull\"\ntarget_peak_displacement = 0.001\n{}[[condition]]\npatch = \"x_min\"\n"
        "displacement = [0.0, 0.0, 0.0]\n[[condition]]\npatch = \"x_max\"\ntraction = [{:.1f}, 0.0, 0.0]\n",
        more, pull);
}

/// What is solved does not depend on who solves it, and neither does what is kept from one load case for another: the
/// third has the static answer of the first.
TEST(Jobs, GiveTheSameBits) {
    const auto folder = tests::folder_with_bar("jobs");
    write_pull(folder / "first.toml", 10.0);
    write_pull(folder / "second.toml", 12.0);
    write_pull(folder / "third.toml", 10.0);
    write_pull(folder / "fourth.toml", 14.0);
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
    const auto side_by_side = run(3);
    for (std::size_t r = 0; r < one_by_one.size(); ++r) {
        ASSERT_EQ(one_by_one[r].models.size(), side_by_side[r].models.size());
        for (std::size_t m = 0; m < one_by_one[r].models.size(); ++m) {
            const auto &a = one_by_one[r].models[m], &b = side_by_side[r].models[m];
            SCOPED_TRACE(a.name + " on " + one_by_one[r].problem.load_case.name);
            EXPECT_EQ(a.name, b.name);
            EXPECT_EQ(a.solution.solver, b.solution.solver);
            EXPECT_TRUE(tests::same_bits(a.solution.displacement, b.solution.displacement));
            EXPECT_TRUE(tests::same_bits(a.solution.reaction, b.solution.reaction));
        }
    }
}

TEST(Jobs, DoNotChangeTheOrderOfTheTable) {
    const auto folder = tests::folder_with_bar("jobs_table");
    write_pull(folder / "a.toml", 10.0);
    write_pull(folder / "b.toml", 12.0);
    const auto table = [&](int jobs) {
        const auto outcome = tests::livermark(
            fmt::format("run --body {0}/bar.toml --load-case {0}/b.toml {0}/a.toml --model lloyd --no-uncertainty "
                        "--markdown --jobs {1} --output {0}/runs",
                        folder.string(), jobs));
        EXPECT_EQ(outcome.status, 0) << outcome.output;
        std::string load_cases; // the times differ
        std::istringstream lines(outcome.output);
        for (std::string line; std::getline(lines, line);)
            if (line.starts_with("| bar | "))
                load_cases += line.substr(0, line.find(" |", 14)) + "\n";
        return load_cases;
    };
    const auto of_one = table(1);
    EXPECT_FALSE(of_one.empty());
    EXPECT_EQ(of_one, table(2));
}

} // namespace
} // namespace livermark
