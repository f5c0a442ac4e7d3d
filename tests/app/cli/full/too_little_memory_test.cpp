#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <set>
#include <sstream>
#include <string>
#include <unistd.h>
#include <vector>

#include "tests/child.hpp"
#include "tests/listening_sockets.hpp"
#include "tests/samples/small_bar.hpp"

namespace livermark {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr int num_load_cases = 3;

/// A bar under several loads, and the command that runs them.
class PulledBar {
  public:
    PulledBar(const std::string &suite, double edge) : folder_(tests::folder_with_bar(suite, edge)) {
        for (int l = 0; l < num_load_cases; ++l)
            std::ofstream(folder_ / fmt::format("pull_{}.toml", l)) << fmt::format(
                "title = \"pull\"\ntarget_peak_displacement = 0.001\n[[condition]]\npatch = \"x_min\"\n"
                "displacement = [0.0, 0.0, 0.0]\n[[condition]]\npatch = \"x_max\"\ntraction = [{}.0, 0.0, 1.0]\n",
                10 + l);
    }

    tests::ChildEnd run(const std::vector<std::string> &more, const tests::ChildOptions &how) const {
        std::vector<std::string> words{LIVERMARK_BINARY, "run", "--body", (folder_ / "bar.toml").string(),
                                       "--load-case"};
        for (int l = 0; l < num_load_cases; ++l)
            words.push_back((folder_ / fmt::format("pull_{}.toml", l)).string());
        for (const char *word : {"--static", "--reference-on-mesh", "--output"})
            words.emplace_back(word);
        words.push_back((folder_ / "runs").string());
        words.insert(words.end(), more.begin(), more.end());
        return tests::run_child(words, how);
    }

    std::size_t num_results() const {
        std::error_code error;
        const auto results = folder_ / "runs" / "bar";
        return static_cast<std::size_t>(std::distance(fs::directory_iterator(results, error), {}));
    }

    /// Of one model, which wait for the benchmark cases.
    bool has_solutions() const {
        std::error_code error;
        auto entry = fs::recursive_directory_iterator(folder_ / "runs" / ".solutions", error);
        return std::any_of(fs::begin(entry), fs::end(entry),
                           [](const auto &file) { return file.path().extension() == ".solution"; });
    }
    const fs::path &folder() const { return folder_; }

  private:
    fs::path folder_;
};

std::size_t count(const std::string &text, const std::string &part) {
    std::size_t number = 0;
    for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1))
        ++number;
    return number;
}

/// From where the program hardly starts to where it has enough. OpenBLAS waits for ever for the memory that it is not
/// given.
TEST(TooLittleMemory, EndsARunWithASentence) {
    const PulledBar bar("too_little_memory", 0.012);
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
                EXPECT_EQ(bar.num_results(), num_load_cases);
                break;
            }
            if (end.status == 127)
                continue; // what loads its libraries has no memory for them
            EXPECT_EQ(end.status, 1) << end.errors;
            if (end.errors.find("too little memory; take --jobs 1, or a mesh of fewer tetrahedra") != std::string::npos)
                ++num_said;
            EXPECT_GT(count(end.errors, "livermark: "), 0U) << end.errors;
            ASSERT_LT(megabytes, 4000U);
        }
    EXPECT_GT(num_said, 0);
}

TEST(KilledWorker, CostsItsLoadCaseAlone) {
    const PulledBar bar("killed_worker", 0.005);
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
        count(end.errors, "its process was killed, most likely because memory ran out; take --jobs 1");
    EXPECT_GT(num_told, 0U) << end.errors;
    EXPECT_EQ(count(end.errors, "livermark: bar / pull_") + count(end.errors, "livermark: failed: bar / pull_"),
              num_told)
        << end.errors;
    const auto num_failed = count(end.errors, "livermark: failed: ");
    EXPECT_EQ(bar.num_results() + num_failed, num_load_cases) << end.errors;
    EXPECT_EQ(end.status, num_failed > 0 ? 1 : 0);
}

TEST(TemporaryFolders, OfARunGoWhenASignalEndsIt) {
    const PulledBar bar("ended_run", 0.005);
    const auto temporary = bar.folder() / "temporary";
    fs::create_directory(temporary);
    const char *before = std::getenv("TMPDIR");
    const std::string kept = before ? before : "";
    for (const int signal : {SIGINT, SIGTERM}) {
        setenv("TMPDIR", temporary.c_str(), 1);
        const auto end = bar.run({"--jobs", "2"}, {.killed_when = [&] { return bar.has_solutions(); }, //
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
