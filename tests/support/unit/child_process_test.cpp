#include "support/child_process.hpp"

#include <gtest/gtest.h>

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

} // namespace
} // namespace livermark::support
