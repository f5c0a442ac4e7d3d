#include <gtest/gtest.h>

#include "tests/samples/random_needles.hpp"
#include "tests/studies/random_insertions.hpp"
#include "tests/studies/some_tissue.hpp"

namespace livermark::studies {
namespace {

TEST(RandomNeedles, InTheBeamBalanceTheirWork) {
    const auto failed = tests::drive_random_needles("beam", "x_min", 3, 30);
    EXPECT_EQ(failed, std::vector<std::string>{});
}

TEST(RandomNeedles, InLiversBalanceTheirWork) {
    EXPECT_EQ(tests::drive_random_needles("liver_healthy", "posterior", 3, 6), std::vector<std::string>{});
    EXPECT_EQ(tests::drive_random_needles("liver_tumours", "posterior", 3, 6), std::vector<std::string>{});
}

TEST(RandomNeedles, InStepsInTheBeamBalanceTheirWork) {
    EXPECT_EQ(tests::step_random_needles("beam", "x_min", 5, 8), std::vector<std::string>{});
}

TEST(RandomNeedles, InRandomTissueBalanceTheirWork) {
    EXPECT_EQ(tests::drive_into_some_tissue(11, 60, 0.002), std::vector<std::string>{});
}

} // namespace
} // namespace livermark::studies
