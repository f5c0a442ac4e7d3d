#include <gtest/gtest.h>

#include "meshes/io/body_reader.hpp"
#include "tests/cut_checks.hpp"

namespace livermark {

class RandomCutsOfShippedBodies : public testing::TestWithParam<const char *> {};

/// A thousand of the three bodies together.
TEST_P(RandomCutsOfShippedBodies, AreCleanOrRefused) {
    const auto body = meshes::read_body(std::string(LIVERMARK_SOURCE_DIR "/meshes/") + GetParam() + ".toml");
    const auto tried = tests::try_random_cuts(body, 334, 2);
    EXPECT_EQ(tried.num_cut + tried.num_refused, 334);
    EXPECT_GT(tried.num_cut, 150);
    for (const auto &fault : tried.faults)
        ADD_FAILURE() << fault;
}

INSTANTIATE_TEST_SUITE_P(Bodies, RandomCutsOfShippedBodies, testing::Values("liver_healthy", "liver_tumours", "beam"));

} // namespace livermark
