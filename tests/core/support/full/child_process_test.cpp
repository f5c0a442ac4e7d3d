#include <array>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
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
    ASSERT_EQ(outcome.lines.size(), 1U);
    tests::expect_part(outcome.lines[0], "no_such_program_of_livermark");
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
