#include <gtest/gtest.h>

#include "tests/samples/random_needles.hpp"
#include "tests/studies/insertions.hpp"

namespace livermark::studies {
namespace {

/// A thousand needles in all.
TEST(RandomNeedles, OfAThousandAllBalanceTheirWork) {
    EXPECT_EQ(tests::drive_random_needles("beam", "x_min", 11, 334), std::vector<std::string>{});
    EXPECT_EQ(tests::drive_random_needles("liver_healthy", "posterior", 12, 333), std::vector<std::string>{});
    EXPECT_EQ(tests::drive_random_needles("liver_tumours", "posterior", 13, 333), std::vector<std::string>{});
}

TEST(RandomNeedles, InStepsInLiversBalanceTheirWork) {
    EXPECT_EQ(tests::step_random_needles("liver_healthy", "posterior", 14, 40), std::vector<std::string>{});
    EXPECT_EQ(tests::step_random_needles("liver_tumours", "posterior", 15, 40), std::vector<std::string>{});
}

} // namespace
} // namespace livermark::studies
