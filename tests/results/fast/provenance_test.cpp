#include "results/records/result.hpp"

#include <chrono>
#include <ctime>
#include <fmt/chrono.h>
#include <gtest/gtest.h>
#include <regex>

namespace livermark::results {
namespace {

bool matches(const std::string &text, const char *pattern) {
    return std::regex_match(text, std::regex(pattern));
}

TEST(Provenance, SaysWhatRunsAndWhere) {
    const Provenance provenance = current_provenance("livermark run --body liver");
    EXPECT_EQ(provenance.command, "livermark run --body liver");
    EXPECT_TRUE(matches(provenance.software_version, R"(\d+\.\d+\.\d+)")) << provenance.software_version;
    EXPECT_TRUE(matches(provenance.git_commit, "[0-9a-f]{40}(-dirty)?|unknown")) << provenance.git_commit;
    EXPECT_TRUE(matches(provenance.compiler, R"(\w+ \d+\..*)")) << provenance.compiler;
    EXPECT_FALSE(provenance.cpu.empty());
    EXPECT_GE(provenance.threads, 1);
#ifdef NDEBUG
    EXPECT_NE(provenance.build_type, "Debug");
#else
    EXPECT_EQ(provenance.build_type, "Debug");
#endif
}

TEST(Provenance, IsOfNowInUtc) {
    const auto text = [](std::time_t time) { return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(time)); };
    const std::string before = text(std::time(nullptr));
    const std::string created = current_provenance("").created;
    EXPECT_TRUE(matches(created, R"(\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ)")) << created;
    EXPECT_GE(created, before);
    EXPECT_LE(created, text(std::time(nullptr) + 1));
}

} // namespace
} // namespace livermark::results
