#include "results/records/timings.hpp"

#include <filesystem>
#include <gtest/gtest.h>

#include "core/support/input_error.hpp"
#include "results/quantile.hpp"
#include "tests/samples/records/sample_timings.hpp"

namespace livermark::results {
namespace {

TEST(TimingsFile, MedianIsInTheMiddle) {
    EXPECT_EQ(median({3.0, 1.0, 2.0}), 2.0);
    EXPECT_EQ(median({4.0, 1.0, 2.0, 3.0}), 2.5);
    EXPECT_EQ(median({7.0}), 7.0);
}

TEST(TimingsFile, RefusesAPlaceThatIsNotThere) {
    const auto path = std::filesystem::temp_directory_path() / "no such folder" / "timings.h5";
    EXPECT_THROW(write_timings(path, tests::sample_timings()), support::InputError);
}

} // namespace
} // namespace livermark::results
