#include "support/processes/child_process.hpp"

#include <array>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "support/input_error.hpp"

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
    EXPECT_NE(outcome.lines[0].find("no_such_program_of_livermark"), std::string::npos);
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
    try {
        const ScratchFolder scratch;
        ADD_FAILURE() << scratch.path;
    } catch (const InputError &error) {
        EXPECT_NE(std::string(error.what()).find("TMPDIR: '/nowhere/of/somebody' is not a folder"), std::string::npos)
            << error.what();
    }
    if (before)
        setenv("TMPDIR", kept.c_str(), 1);
    else
        unsetenv("TMPDIR");
}

} // namespace
} // namespace livermark::support
