#include <gtest/gtest.h>
#include <limits>

#include "core/load_case.hpp"

namespace livermark {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// Three boundary triangles: held in two components, pulled, and free.
core::LoadCase example() {
    core::LoadCase load_case;
    load_case.name = "example";
    load_case.condition = {core::FacetCondition::prescribed_displacement, core::FacetCondition::traction,
                           core::FacetCondition::free};
    load_case.value = {{0.0, 0.0, nan}, {1.0, 2.0, 3.0}, {nan, nan, nan}};
    load_case.constraint_names = {"base"};
    load_case.constraint = {0, -1, -1};
    return load_case;
}

TEST(StaticallyEqualLoadCases, MayDifferInNameAndInWhatComesAfterwards) {
    auto other = example();
    other.name = "other";
    other.release = core::Release{};
    EXPECT_TRUE(core::are_statically_equal(example(), other));
}

TEST(StaticallyEqualLoadCases, DifferInNothingThatActs) {
    auto held_in_three = example();
    held_in_three.value[0].z() = 0.0;
    EXPECT_FALSE(core::are_statically_equal(example(), held_in_three));
    auto pulled_harder = example();
    pulled_harder.value[1].y() = 2.5;
    EXPECT_FALSE(core::are_statically_equal(example(), pulled_harder));
    auto heavy = example();
    heavy.acceleration.z() = -9.81;
    EXPECT_FALSE(core::are_statically_equal(example(), heavy));
    EXPECT_FALSE(core::are_statically_equal(example(), core::without_tractions(example())));
}

} // namespace
} // namespace livermark
