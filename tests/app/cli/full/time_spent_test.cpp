#include <filesystem>
#include <gtest/gtest.h>
#include <sstream>

#include "tests/livermark_command.hpp"

namespace livermark {
namespace {

TEST(TimeSpent, IsThatOfTheStages) {
    const auto folder = std::filesystem::path(testing::TempDir()) / "livermark_time_spent";
    const auto outcome = tests::livermark("run --body beam --load-case beam_stretch --model lloyd --reference-on-mesh "
                                          "--tables "
                                          "--output " +
                                          folder.string());
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    const auto at = outcome.output.find("Time spent: ");
    ASSERT_NE(at, std::string::npos) << outcome.output;
    std::istringstream words(outcome.output.substr(at + 12));
    double total = 0.0;
    words >> total;
    EXPECT_GT(total, 0.0);

    double sum = 0.0;
    std::string line;
    while (std::getline(words, line))
        if (std::istringstream row(line); line.starts_with("fem_p2p1 ") || line.starts_with("fem_p2 ") ||
                                          line.starts_with("fem_p1 ") || line.starts_with("lloyd ")) {
            std::string model;
            double seconds = 0.0;
            row >> model >> seconds;
            sum += seconds;
        }
    EXPECT_GT(sum, 0.3 * total) << outcome.output;
    EXPECT_LE(sum, total + 0.5) << outcome.output; // each is rounded to a tenth
}

} // namespace
} // namespace livermark
