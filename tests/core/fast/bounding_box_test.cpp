#include "core/mesh/bounding_box.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <vector>

namespace livermark::core {
namespace {

TEST(BoundingBox, TouchesThePointsOnEverySide) {
    const std::vector<Vector3> points{{1.0, -2.0, 3.0}, {-1.0, 5.0, 3.5}, {0.0, 0.0, 7.0}};
    const auto box = bounding_box(points);
    EXPECT_EQ(box.min(), Vector3(-1.0, -2.0, 3.0));
    EXPECT_EQ(box.max(), Vector3(1.0, 5.0, 7.0));
    EXPECT_DOUBLE_EQ(extent(points), std::sqrt(4.0 + 49.0 + 16.0));
    EXPECT_EQ(extent(std::vector{points[1]}), 0.0);
    EXPECT_TRUE(bounding_box({}).isEmpty());
}

} // namespace
} // namespace livermark::core
