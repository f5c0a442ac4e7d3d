#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <gtest/gtest.h>
#include <map>
#include <new>
#include <stdexcept>
#include <string>
#include <sys/wait.h>
#include <unistd.h>
#include <vector>

#include "core/support/input_error.hpp"
#include "core/support/processes/child_process.hpp"
#include "core/support/processes/own_process.hpp"
#include "tests/bad_input.hpp"
#include "tests/result_folder.hpp"

namespace livermark::support {
namespace {

TEST(Filter, TurnsAnInputThatFillsEveryBufferIntoItsOutput) {
    const std::string input(3'000'000, 'x');
    const auto outcome = run_filter({"cat"}, input);
    EXPECT_EQ(outcome.status, 0);
    EXPECT_TRUE(outcome.output == input) << outcome.output.size();
    EXPECT_TRUE(outcome.lines.empty());
}

TEST(Filter, NeedNotReadItsInput) {
    const auto outcome = run_filter({"sh", "-c", "exec <&-; echo done"}, std::string(3'000'000, 'x'));
    EXPECT_EQ(outcome.status, 0);
    EXPECT_EQ(outcome.output, "done\n");
}

TEST(Filter, KeepsErrorsApartFromTheOutput) {
    const auto outcome = run_filter({"sh", "-c", "cat; echo first >&2; echo >&2; echo last >&2; exit 3"}, "input");
    EXPECT_EQ(outcome.status, 3);
    EXPECT_EQ(outcome.output, "input");
    EXPECT_EQ(outcome.lines, (std::vector<std::string>{"first", "last"}));
}

TEST(Filter, SaysWhenThereIsNoSuchProgram) {
    const auto outcome = run_filter({"no_such_program_of_livermark"}, "input");
    EXPECT_NE(outcome.status, 0);
    tests::expect_one(outcome.lines, "no_such_program_of_livermark");
}

TEST(Filter, SaysWhenAProgramIsKilled) {
    EXPECT_EQ(run_filter({"sh", "-c", "kill -9 $$"}, "").status, -1);
}

/// In a process of its own, which a signal ends.
TEST(ScratchFolder, GoesWhenASignalEndsTheProcess) {
    for (const int signal : {SIGINT, SIGTERM}) {
        std::array<int, 2> ends{};
        ASSERT_EQ(pipe(ends.data()), 0);
        const pid_t child = fork();
        if (child == 0) {
            const ScratchFolder scratch;
            std::ofstream(scratch.path / "file") << "text";
            const auto path = scratch.path.string();
            if (write(ends[1], path.data(), path.size()) > 0)
                raise(signal);
            _exit(0);
        }
        close(ends[1]);
        std::string path(4096, '\0');
        const auto length = read(ends[0], path.data(), path.size());
        close(ends[0]);
        int status = 0;
        waitpid(child, &status, 0);
        ASSERT_GT(length, 0);
        path.resize(static_cast<std::size_t>(length));
        EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == signal);
        EXPECT_FALSE(std::filesystem::exists(path)) << path;
    }
}

TEST(ScratchFolder, SaysThatTmpdirIsWrong) {
    const char *before = std::getenv("TMPDIR");
    const std::string kept = before ? before : "";
    setenv("TMPDIR", "/nowhere/of/somebody", 1);
    tests::expect_input_error([] { const ScratchFolder scratch; }, {"TMPDIR: '/nowhere/of/somebody' is not a folder"});
    if (before)
        setenv("TMPDIR", kept.c_str(), 1);
    else
        unsetenv("TMPDIR");
}

/// A value that is worked out, so that no compiler leaves the work away.
volatile double spun = 0.0;

class OwnProcess : public tests::ResultFolder {
  protected:
    void SetUp() override {
        ResultFolder::SetUp();
        file_ = directory_ / "input.bin";
        std::ofstream(file_) << "input";
    }

    void expect_refused(const std::function<std::string()> &work, const std::vector<std::string> &parts,
                        const ReaderLimits &limits = {}) const {
        tests::expect_input_error([&] { in_own_process(file_, limits, work); }, parts);
    }

    std::filesystem::path file_;
};

TEST_F(OwnProcess, SendsBackWhatTheWorkReturns) {
    const std::string large(5'000'000, 'x');
    int here = 0;
    EXPECT_EQ(in_own_process(file_, {},
                             [&] {
                                 ++here;
                                 return large;
                             }),
              large);
    EXPECT_EQ(here, 0) << "what the work does is not seen here";
}

TEST_F(OwnProcess, PassesRefusalsOnAsTheyAre) {
    expect_refused([]() -> std::string { throw InputError("input.bin: no liver"); }, {"input.bin: no liver"});
}

TEST_F(OwnProcess, SaysWhichFileEndedALibrary) {
    for (const int signal : {SIGSEGV, SIGABRT, SIGFPE})
        expect_refused(
            [signal]() -> std::string {
                std::raise(signal);
                return {};
            },
            {"input.bin: it cannot be read (a library has broken off with ", "export it again"});
    expect_refused([]() -> std::string { throw std::runtime_error("in words\nfor programmers"); }, {"(in words)"});
}

TEST_F(OwnProcess, EndsWhatTakesTooLong) {
    expect_refused(
        []() -> std::string {
            for (;;)
                spun = spun + 1.0;
        },
        {"it takes more than 1 s"}, {.seconds = 1});
}

#ifndef __SANITIZE_ADDRESS__
TEST_F(OwnProcess, EndsWhatTakesTooMuchMemory) {
    expect_refused(
        [] {
            std::vector<char> much(std::size_t{1} << 30, 'x');
            return std::string(much.begin(), much.begin() + 10);
        },
        {"it takes more than 256 MB of memory"}, {.bytes = std::uint64_t{1} << 28});
}
#endif

TEST_F(OwnProcess, HasLimitsThatGrowWithTheFile) {
    const auto small = limits_for(file_, 1000.0);
    std::ofstream(file_) << std::string(3'000'000, 'x');
    const auto large = limits_for(file_, 1000.0), folder = limits_for(directory_, 1000.0);
    EXPECT_GT(large.seconds, small.seconds);
    EXPECT_GT(large.bytes, small.bytes);
    EXPECT_EQ(folder.bytes, large.bytes);
    EXPECT_LE(limits_for(file_, 1e9).bytes, std::uint64_t{16} << 30);
}

TEST(PackedBytes, ComeBackAsTheyWere) {
    Packer packer;
    packer.put(std::string("liver"));
    packer.put(std::vector<std::string>{"a", "", "b"});
    packer.put(std::vector<double>{1.5, -2.0});
    packer.put(7);
    const auto bytes = std::move(packer).bytes();
    Unpacker unpacker(bytes);
    std::string text;
    std::vector<std::string> texts;
    std::vector<double> numbers;
    int number = 0;
    unpacker.get(text);
    unpacker.get(texts);
    unpacker.get(numbers);
    unpacker.get(number);
    EXPECT_EQ(text, "liver");
    EXPECT_EQ(texts, (std::vector<std::string>{"a", "", "b"}));
    EXPECT_EQ(numbers, (std::vector<double>{1.5, -2.0}));
    EXPECT_EQ(number, 7);
    EXPECT_THROW(unpacker.get(number), std::runtime_error);
}

} // namespace
} // namespace livermark::support

namespace livermark {
namespace {

/// @return shape (I) the process that did each item
std::vector<std::string> processes(const std::vector<int> &group, int num_workers) {
    std::vector<std::string> process(group.size());
    support::run_in_process_pool(
        group, num_workers, [](int, const support::SendMessage &tell) { tell(std::to_string(getpid())); },
        [&](int item, const std::string &text) {
            EXPECT_TRUE(process[item].empty()) << "item " << item << " is done twice";
            process[item] = text;
        });
    return process;
}

TEST(SideBySide, DoesEachItemOnce) {
    const std::vector<int> group{0, 0, 2, 0, 2, 2, 1, 0, 2};
    for (const int num_workers : {1, 2, 3, 40})
        for (const auto &process : processes(group, num_workers))
            EXPECT_FALSE(process.empty());
    EXPECT_TRUE(processes({}, 2).empty());
}

TEST(SideBySide, OneWorkerGoesGroupByGroupInThisProcess) {
    const std::vector<int> group{1, 0, 1, 0};
    std::vector<int> order;
    support::run_in_process_pool(group, 1, [&](int item, const support::SendMessage &) { order.push_back(item); }, {});
    EXPECT_EQ(order, (std::vector<int>{1, 3, 0, 2}));
}

TEST(SideBySide, WorkersBeginGroupsOfTheirOwnAndThenHelp) {
    const auto two_groups = processes({0, 0, 0, 1, 1, 1}, 2);
    EXPECT_NE(two_groups[0], two_groups[3]);
    EXPECT_NE(two_groups[0], std::to_string(getpid()));
    const auto one_group = processes({0, 0}, 2);
    EXPECT_NE(one_group[0], one_group[1]);
}

/// An item of the last group has to see what those have left that it waits for; one of them waits for nobody.
TEST(SideBySide, ItemsWaitForOthers) {
    const std::vector<int> group{0, 0, 1, 2, 3, 3, 3};
    const std::vector<std::vector<int>> waits_for{{}, {}, {}, {}, {0, 1, 2}, {1}};
    for (const int num_workers : {1, 2, 3, 7}) {
        std::vector<int> begun, done;
        support::run_in_process_pool(
            group, num_workers,
            [](int item, const support::SendMessage &tell) {
                tell("begun");
                std::this_thread::sleep_for(std::chrono::milliseconds(item < 3 ? 20 : 0));
                tell("done");
            },
            [&](int item, const std::string &text) { (text == "begun" ? begun : done).push_back(item); }, waits_for);
        ASSERT_EQ(done.size(), group.size()) << num_workers;
        std::ranges::sort(begun);
        EXPECT_EQ(begun, (std::vector{0, 1, 2, 3, 4, 5, 6}));
        for (std::size_t first = 0; first < done.size(); ++first)
            for (std::size_t second = first + 1; second < done.size(); ++second)
                EXPECT_FALSE(static_cast<std::size_t>(done[first]) < waits_for.size() &&
                             std::ranges::count(waits_for[done[first]], done[second]) > 0)
                    << num_workers;
    }
}

TEST(SideBySide, TextsComeInTheirOrderAndWhole) {
    const std::vector<int> group{0, 1, 2};
    const std::string large(300'000, 'x'); // more than a pipe holds
    std::vector<std::vector<std::string>> told(group.size());
    support::run_in_process_pool(
        group, 3,
        [&](int item, const support::SendMessage &tell) {
            tell("");
            tell(large + std::to_string(item));
            tell("end");
        },
        [&](int item, const std::string &text) { told[item].push_back(text); });
    for (std::size_t item = 0; item < group.size(); ++item)
        EXPECT_EQ(told[item], (std::vector<std::string>{"", large + std::to_string(item), "end"}));
}

/// @return what the message is if the fourth item of many ends like this
template <class Fault> std::string message(int num_workers, const std::function<void()> &fault) {
    try {
        support::run_in_process_pool(std::vector<int>(50, 0), num_workers,
                                     [&](int item, const support::SendMessage &) {
                                         if (item == 3)
                                             fault();
                                     },
                                     {});
    } catch (const Fault &error) {
        return error.what();
    }
    return "no fault";
}

TEST(SideBySide, AFaultEndsTheWork) {
    for (const int num_workers : {1, 2}) {
        EXPECT_EQ(message<support::InputError>(num_workers, [] { throw support::InputError("no room"); }), "no room");
        EXPECT_EQ(message<std::runtime_error>(num_workers, [] { throw std::range_error("wrong"); }), "wrong");
    }
}

TEST(SideBySide, AWorkerThatIsKilledIsMissed) {
    const auto text = message<std::runtime_error>(2, [] { std::raise(SIGKILL); });
    tests::expect_part(text, "a worker ended before its work did (Killed), on item ");
}

/// The fourth of twelve items ends its process and the eighth finds no memory; the last one waits for both.
TEST(SideBySide, ALostWorkerCostsItsItemAlone) {
    const std::vector<int> group{0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 3};
    std::vector<std::vector<int>> waits_for(group.size());
    waits_for.back() = {3, 7};
    for (const int num_workers : {1, 2, 3}) {
        SCOPED_TRACE(num_workers);
        std::vector<int> done;
        std::map<int, std::string> lost;
        support::run_in_process_pool(
            group, num_workers,
            [&](int item, const support::SendMessage &tell) {
                if (item == 3 && num_workers > 1)
                    std::raise(SIGKILL);
                if (item == 7)
                    throw std::bad_alloc();
                tell("done");
            },
            [&](int item, const std::string &) {
                done.push_back(item);
                EXPECT_TRUE(item != 11 || lost.contains(7)) << "it has to wait";
            },
            waits_for, [&](int item, const std::string &how) { EXPECT_TRUE(lost.emplace(item, how).second); });
        std::map<int, std::string> expected{{7, "out of memory"}};
        if (num_workers > 1)
            expected.emplace(3, "Killed");
        EXPECT_EQ(lost, expected);
        EXPECT_EQ(done.size() + lost.size(), group.size());
        EXPECT_NE(std::ranges::find(done, 11), done.end());
    }
}

TEST(SideBySide, GoesOnWhereEveryItemEndsItsProcess) {
    int num_lost = 0;
    support::run_in_process_pool(
        std::vector<int>(20, 0), 3, [](int, const support::SendMessage &) { std::raise(SIGSEGV); }, {}, {},
        [&](int, const std::string &how) {
            EXPECT_EQ(how, "Segmentation fault");
            ++num_lost;
        });
    EXPECT_EQ(num_lost, 20);
}

} // namespace
} // namespace livermark
