#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <functional>
#include <gtest/gtest.h>
#include <iterator>
#include <set>
#include <sstream>
#include <string>
#include <unistd.h>
#include <vector>

#include "results/hdf5/result_file.hpp"
#include "tests/child.hpp"
#include "tests/listening_sockets.hpp"
#include "tests/livermark_command.hpp"
#include "tests/same_bits.hpp"
#include "tests/samples/small_bar.hpp"

namespace livermark {
namespace {

using tests::same_bits;

namespace fs = std::filesystem;

/// A bar under several loads, and the command that runs them; the same in every folder that it works in, so that
/// results are of the same command.
class PulledBar {
  public:
    PulledBar(const std::string &suite, double edge, int num_loads) : folder_(tests::folder_with_bar(suite, edge)) {
        for (int l = 0; l < num_loads; ++l)
            load_cases_.push_back(tests::write_pull(folder_, fmt::format("pull_{}", l), 10.0 + l));
    }

    tests::ChildEnd run(const std::vector<std::string> &more, tests::ChildOptions how) const {
        std::vector<std::string> words{LIVERMARK_BINARY, "run", "--body", (folder_ / "bar.toml").string(),
                                       "--load-case"};
        words.insert(words.end(), load_cases_.begin(), load_cases_.end());
        words.insert(words.end(), {"--static", "--reference-on-mesh", "--output", "runs"});
        words.insert(words.end(), more.begin(), more.end());
        if (how.folder.empty())
            how.folder = folder_;
        return tests::run_child(words, how);
    }

    std::size_t num_results() const {
        std::error_code error;
        const auto results = folder_ / "runs" / "bar";
        return static_cast<std::size_t>(std::distance(fs::directory_iterator(results, error), {}));
    }
    const fs::path &folder() const { return folder_; }

  private:
    fs::path folder_;
    std::vector<std::string> load_cases_;
};

constexpr int num_load_cases = 6;

/// A run of cheap models on a small bar: most of its time goes by between the first result file and the last.
class KilledRun : public testing::Test {
  protected:
    tests::ChildEnd run(const fs::path &place, std::vector<std::string> more,
                        const std::function<bool()> &killed_when = {}) const {
        fs::create_directories(place);
        more.insert(more.end(), {"--model", "lloyd"});
        return bar_.run(more, {.folder = place, .killed_when = killed_when});
    }

    static fs::path results_of(const fs::path &place) { return place / "runs" / "bar"; }

    PulledBar bar_{"killed_run", 0.008, num_load_cases};
    const fs::path &folder_ = bar_.folder();
};

std::vector<fs::path> files_with(const fs::path &folder, const std::string &extension) {
    std::vector<fs::path> files;
    std::error_code error;
    for (const auto &entry : fs::directory_iterator(folder, error))
        if (entry.path().extension() == extension)
            files.push_back(entry.path());
    return files;
}

/// Solutions that wait for their benchmark case.
/// @param model  "name.", or "" for all
std::size_t num_solutions(const fs::path &place, const std::string &model = "") {
    std::size_t number = 0;
    std::error_code error;
    for (auto entry = fs::recursive_directory_iterator(place / "runs" / ".solutions", error);
         !error && entry != fs::recursive_directory_iterator(); entry.increment(error))
        number += entry->path().extension() == ".solution" &&
                  entry->path().filename().string().find(model) != std::string::npos;
    return number;
}

/// All but when it was made and how long it took.
void expect_same(const results::Result &a, const results::Result &b) {
    EXPECT_EQ(a.provenance.command, b.provenance.command);
    EXPECT_TRUE(same_bits(a.problem.body->mesh.points, b.problem.body->mesh.points));
    EXPECT_EQ(a.problem.load_case.definition, b.problem.load_case.definition);
    ASSERT_EQ(a.models.size(), b.models.size());
    for (std::size_t m = 0; m < a.models.size(); ++m) {
        const auto &x = a.models[m];
        const auto &y = b.models[m];
        SCOPED_TRACE(x.name);
        EXPECT_EQ(x.name, y.name);
        EXPECT_EQ(x.solution.status, y.solution.status);
        EXPECT_EQ(x.solution.solver, y.solution.solver);
        EXPECT_TRUE(same_bits(x.solution.displacement, y.solution.displacement));
        EXPECT_TRUE(same_bits(x.solution.reaction, y.solution.reaction));
        EXPECT_TRUE(same_bits(x.solution.strain_energy, y.solution.strain_energy));
        ASSERT_EQ(x.solution.springs.has_value(), y.solution.springs.has_value());
        if (x.solution.springs) {
            EXPECT_TRUE(same_bits(x.solution.springs->stiffness, y.solution.springs->stiffness));
            EXPECT_TRUE(same_bits(x.solution.springs->node_mass, y.solution.springs->node_mass));
        }
        ASSERT_EQ(x.comparison.has_value(), y.comparison.has_value());
        if (x.comparison) {
            EXPECT_TRUE(same_bits(x.comparison->relative_l2, y.comparison->relative_l2));
            EXPECT_TRUE(same_bits(x.comparison->error, y.comparison->error));
        }
    }
}

TEST_F(KilledRun, LeavesWholeFilesAndIsResumedToTheSameResults) {
    const auto undisturbed = folder_ / "undisturbed";
    const auto whole = run(undisturbed, {});
    ASSERT_EQ(whole.status, 0) << whole.errors;
    ASSERT_EQ(files_with(results_of(undisturbed), ".h5").size(), std::size_t{num_load_cases});

    // By what it has written and not by the clock, which says little on a busy machine: between two files, and within
    // one.
    int num_killed = 0;
    std::size_t num_left = 0, num_kept = 0;
    for (int moment = 0; moment < 2 * num_load_cases; ++moment) {
        SCOPED_TRACE(moment);
        const auto place = folder_ / fmt::format("killed_{}", moment);
        const auto killed = run(place, {}, [&] {
            const bool has_enough = files_with(results_of(place), ".h5").size() >= std::size_t(moment / 2);
            return has_enough && (moment % 2 == 0 || !files_with(results_of(place), ".partial").empty());
        });
        num_killed += killed.signal == SIGKILL ? 1 : 0;
        const auto left = files_with(results_of(place), ".h5");
        for (const auto &file : left)
            EXPECT_NO_THROW(results::read_result(file)) << file;
        num_left += left.size();

        // What a run leaves that is killed while it writes: nobody takes it for a result.
        fs::create_directories(results_of(place));
        std::ofstream(results_of(place) / "pull_0.h5.1.partial") << "half a file";
        const auto resumed = run(place, {"--resume"});
        EXPECT_EQ(resumed.status, 0) << resumed.errors;
        for (const auto &file : left)
            num_kept +=
                resumed.errors.find(fmt::format("bar / {} / lloyd, kept", file.stem().string())) != std::string::npos;
        const auto completed = files_with(results_of(place), ".h5");
        ASSERT_EQ(completed.size(), std::size_t{num_load_cases});
        for (const auto &file : completed)
            expect_same(results::read_result(file), results::read_result(results_of(undisturbed) / file.filename()));
    }
    EXPECT_GE(num_killed, num_load_cases) << "most runs ended before they could be killed";
    EXPECT_EQ(num_kept, num_left) << "whole files were made again";
    EXPECT_GT(num_left, 0u);
    const auto table = tests::run_child({LIVERMARK_BINARY, "table", "killed_0"}, {.folder = folder_});
    EXPECT_EQ(table.status, 0);
    EXPECT_EQ(table.errors, "");
    RecordProperty("killed", num_killed);
    RecordProperty("kept", static_cast<int>(num_kept));
}

/// A solution of a model is not solved again, also where no load case has a result yet, and what several load cases
/// are solved together for is the same to the last bit.
TEST_F(KilledRun, LosesNoSolution) {
    tests::write_bar_body(folder_, tests::pressure_ratio); // so that they are solved together
    constexpr std::size_t num_cases = 2 * num_load_cases;
    const auto run_on = [&](const fs::path &place, std::vector<std::string> more,
                            const std::function<bool()> &killed_when = {}) {
        more.insert(more.end(), {"--amplitude", "0.5,1"});
        return run(place, more, killed_when);
    };
    const auto undisturbed = folder_ / "undisturbed";
    ASSERT_EQ(run_on(undisturbed, {}).status, 0);
    int num_killed = 0;
    bool was_killed_before_a_result = false, was_killed_with_results = false;
    // The baseline scales six load cases, then two models solve twelve.
    for (std::size_t enough = 1; enough < num_load_cases + 2 * num_cases; enough += 7)
        for (const std::string jobs : {"1", "2"}) {
            SCOPED_TRACE(fmt::format("{} solutions, {} jobs", enough, jobs));
            const auto place = folder_ / fmt::format("killed_with_{}_{}", enough, jobs);
            std::size_t most = 0; // those of load cases with a result go
            const auto killed = run_on(place, {"--jobs", jobs}, [&] {
                most = std::max(most, num_solutions(place) + 3 * files_with(results_of(place), ".h5").size());
                return most >= enough;
            });
            num_killed += killed.signal == SIGKILL ? 1 : 0;
            const auto left = num_solutions(place, "lloyd."), done = files_with(results_of(place), ".h5").size();
            was_killed_before_a_result |= killed.signal == SIGKILL && done == 0;
            was_killed_with_results |= killed.signal == SIGKILL && done > 0;
            const auto resumed = run_on(place, {"--resume", "--jobs", jobs == "1" ? "2" : "1"});
            EXPECT_EQ(resumed.status, 0) << resumed.errors;
            // Between the result and the end of its solutions a load case has both, with each of two workers.
            const auto kept = tests::count(resumed.errors, " / lloyd, kept");
            EXPECT_GE(kept, std::max(left, done)) << resumed.errors;
            EXPECT_GE(kept + 2, std::min(left + done, num_cases)) << resumed.errors;
            EXPECT_EQ(tests::count(resumed.errors, " / lloyd"), num_cases) << resumed.errors;
            EXPECT_FALSE(fs::exists(place / "runs" / ".solutions"));
            const auto completed = files_with(results_of(place), ".h5");
            ASSERT_EQ(completed.size(), num_cases);
            for (const auto &file : completed)
                expect_same(results::read_result(file),
                            results::read_result(results_of(undisturbed) / file.filename()));
        }
    EXPECT_GE(num_killed, 5) << "most runs ended before they could be killed";
    EXPECT_TRUE(was_killed_before_a_result);
    EXPECT_TRUE(was_killed_with_results);
    RecordProperty("killed", num_killed);
}

TEST_F(KilledRun, LeavesNothingToAnotherCommand) {
    const auto kill_with_two = [&](const char *name) {
        auto place = folder_ / name;
        EXPECT_EQ(run(place, {"--jobs", "1"}, [&] { return num_solutions(place, "lloyd.") >= 2; }).signal, SIGKILL);
        return place;
    };
    EXPECT_EQ(tests::count(run(kill_with_two("begun_anew"), {"--jobs", "1"}).errors, ", kept"), 0U);
    EXPECT_EQ(
        tests::count(run(kill_with_two("stiffer"), {"--jobs", "1", "--young", "6000", "--resume"}).errors, ", kept"),
        0U);
}

using Clock = std::chrono::steady_clock;

/// From where the program hardly starts to where it has enough. OpenBLAS waits for ever for the memory that it is not
/// given.
TEST(TooLittleMemory, EndsARunWithASentence) {
    const PulledBar bar("too_little_memory", 0.012, 3);
    int num_said = 0;
    for (const char *jobs : {"1", "2"})
        for (std::uint64_t megabytes = 560;; megabytes += 40) {
            SCOPED_TRACE(fmt::format("{} MB for each process, {} at once", megabytes, jobs));
            fs::remove_all(bar.folder() / "runs");
            const auto start = Clock::now();
            const auto end = bar.run({"--model", "lloyd", "--jobs", jobs},
                                     {.address_space = megabytes << 20,
                                      .killed_when = [=] { return Clock::now() - start > std::chrono::minutes(1); }});
            ASSERT_EQ(end.signal, 0) << "it hangs or crashes: " << end.errors;
            if (end.status == 0) {
                EXPECT_EQ(bar.num_results(), 3U);
                break;
            }
            if (end.status == 127)
                continue; // what loads its libraries has no memory for them
            EXPECT_EQ(end.status, 1) << end.errors;
            if (end.errors.find("too little memory; take --jobs 1, or a mesh of fewer tetrahedra") != std::string::npos)
                ++num_said;
            EXPECT_GT(tests::count(end.errors, "livermark: "), 0U) << end.errors;
            ASSERT_LT(megabytes, 4000U);
        }
    EXPECT_GT(num_said, 0);
}

TEST(KilledWorker, CostsItsLoadCaseAlone) {
    const PulledBar bar("killed_worker", 0.005, 3);
    constexpr std::size_t num_to_kill = 4;
    std::set<pid_t> before, killed;
    // The workers are the children of the program, which is the only child.
    const auto kill_some = [&] {
        if (killed.size() == num_to_kill)
            return false;
        std::set<pid_t> workers;
        for (const auto process : tests::descendants(getpid()))
            if (std::ifstream status(fmt::format("/proc/{}/stat", process)); status) {
                const std::string text((std::istreambuf_iterator<char>(status)), {});
                char state = 0; // whatever it is: a program that waits for a disk is no worker either
                pid_t parent = 0;
                std::istringstream(text.substr(text.rfind(") ") + 1)) >> state >> parent;
                if (parent != 0 && parent != getpid())
                    workers.insert(process);
            }
        for (const auto worker : workers)
            if (before.contains(worker) && killed.size() < num_to_kill && killed.insert(worker).second)
                kill(worker, SIGKILL);
        before = workers;
        return false;
    };
    const auto end = bar.run({"--jobs", "2"}, {.killed_when = kill_some});
    ASSERT_EQ(killed.size(), num_to_kill);
    ASSERT_EQ(end.signal, 0);
    const auto num_told =
        tests::count(end.errors, "its process was killed, most likely because memory ran out; take --jobs 1");
    EXPECT_GT(num_told, 0U) << end.errors;
    EXPECT_EQ(tests::count(end.errors, "livermark: bar / pull_") +
                  tests::count(end.errors, "livermark: failed: bar / pull_"),
              num_told)
        << end.errors;
    const auto num_failed = tests::count(end.errors, "livermark: failed: ");
    EXPECT_EQ(bar.num_results() + num_failed, 3U) << end.errors;
    EXPECT_EQ(end.status, num_failed > 0 ? 1 : 0);
}

TEST(TemporaryFolders, OfARunGoWhenASignalEndsIt) {
    const PulledBar bar("ended_run", 0.005, 3);
    const auto temporary = bar.folder() / "temporary";
    fs::create_directory(temporary);
    const char *before = std::getenv("TMPDIR");
    const std::string kept = before ? before : "";
    for (const int signal : {SIGINT, SIGTERM}) {
        setenv("TMPDIR", temporary.c_str(), 1);
        const auto end = bar.run({"--jobs", "2"}, {.killed_when = [&] { return num_solutions(bar.folder()) > 0; }, //
                                                   .kill_signal = signal});
        if (before)
            setenv("TMPDIR", kept.c_str(), 1);
        else
            unsetenv("TMPDIR");
        EXPECT_EQ(end.signal, signal);
        EXPECT_TRUE(fs::is_empty(temporary)) << fs::directory_iterator(temporary)->path();
    }
}

} // namespace
} // namespace livermark
