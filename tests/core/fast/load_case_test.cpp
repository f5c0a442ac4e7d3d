#include "core/load_case.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

TEST(Release, KeepsAtMostFiftyOneFramesAndTheFirst) {
    for (const int num_steps : {1, 49, 50, 51, 99, 100, 101, 300, 1'000'000}) {
        const core::Release release{.num_steps = num_steps, .output_interval = 0.1, .damping = {}, .probes = {}};
        int count = 0;
        for (int record = 0; record <= num_steps; ++record)
            count += release.is_frame(record) ? 1 : 0;
        EXPECT_EQ(release.num_frames(), count) << num_steps;
        EXPECT_TRUE(release.is_frame(0));
        EXPECT_LE(count, 51) << num_steps;
        EXPECT_GE(count, std::min(num_steps + 1, 26)) << num_steps;
    }
}

TEST(LoadScaling, MultipliesAllThatDrivesAndLeavesTheRest) {
    const auto mesh = tests::box_mesh({0.1, 0.1, 0.1}, {1, 1, 1});
    auto load_case = tests::empty_load_case(mesh);
    tests::prescribe(load_case, mesh, "x_min", {0.0, nan, 0.001});
    tests::pull(load_case, mesh, "x_max", {10.0, 0.0, -4.0});
    load_case.acceleration = {0.0, 0.0, -9.81};
    const auto twice = core::scaled(core::scaled(load_case, 0.5), 4.0);
    EXPECT_EQ(twice.load_scale, 2.0);
    EXPECT_EQ(twice.acceleration, core::Vector3(0.0, 0.0, -19.62));
    EXPECT_EQ(twice.condition_on, load_case.condition_on);
    EXPECT_EQ(twice.conditions, load_case.conditions);
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (load_case.is_loaded(f)) {
            EXPECT_EQ(twice.value[f], core::Vector3(20.0, 0.0, -8.0));
        } else if (load_case.is_constrained(f)) {
            EXPECT_EQ(twice.value[f].x(), 0.0);
            EXPECT_TRUE(std::isnan(twice.value[f].y()));
            EXPECT_EQ(twice.value[f].z(), 0.002);
        }
}

TEST(LoadScaling, DeepensWhatPressesAndLeavesItsNewton) {
    const auto mesh = tests::box_mesh({0.1, 0.2, 0.1}, {2, 2, 2});
    auto load_case = tests::empty_load_case(mesh);
    tests::prescribe(load_case, mesh, "x_min", core::Vector3::Zero());
    tests::press(load_case, mesh, "x_max", {0.0, 3.0, -4.0}, 0.002);
    const auto twice = core::scaled(load_case, 2.0);
    EXPECT_EQ(twice.press_depth, 0.004);
    EXPECT_FALSE(core::are_statically_equal(load_case, twice));
    for (const auto &pressed : {load_case, twice}) {
        const auto resultants = core::press_resultants(pressed, mesh);
        ASSERT_EQ(resultants.size(), 2U);
        EXPECT_EQ(resultants[0], core::Vector3::Zero());
        EXPECT_LT((resultants[1] - core::Vector3(0.0, 0.6, -0.8)).norm(), 1e-14);
        EXPECT_TRUE(core::is_driven(pressed));
    }
    const auto held = core::without_tractions(load_case);
    EXPECT_EQ(held.press_depth, 0.0);
    EXPECT_EQ(core::press_resultants(held, mesh), (std::vector<core::Vector3>(2, core::Vector3::Zero())));
}

TEST(LoadScaling, NothingDrivesWhatIsOnlyConstrained) {
    const auto mesh = tests::box_mesh({0.1, 0.1, 0.1}, {1, 1, 1});
    auto load_case = tests::empty_load_case(mesh);
    tests::prescribe(load_case, mesh, "x_min", {0.0, nan, 0.0});
    EXPECT_FALSE(core::is_driven(load_case));
    auto pulled = load_case, moved = load_case, hung = load_case;
    tests::pull(pulled, mesh, "x_max", {0.0, 0.0, -4.0});
    tests::prescribe(moved, mesh, "x_max", {nan, -0.001, nan});
    hung.acceleration = {0.0, 0.0, -9.81};
    for (const auto &driven : {pulled, moved, hung})
        EXPECT_TRUE(core::is_driven(driven));
}

/// Three boundary triangles: constrained in two components, pulled, and free.
core::LoadCase example() {
    core::LoadCase load_case;
    load_case.name = "example";
    load_case.conditions = {{"base"}, {"end", core::ConditionKind::traction}};
    load_case.condition_on = {0, 1, -1};
    load_case.value = {{0.0, 0.0, nan}, {1.0, 2.0, 3.0}, {nan, nan, nan}};
    return load_case;
}

TEST(StaticallyEqualLoadCases, MayDifferInNameAndInWhatComesAfterwards) {
    auto other = example();
    other.name = "other";
    other.release = core::Release{};
    EXPECT_TRUE(core::are_statically_equal(example(), other));
}

TEST(StaticallyEqualLoadCases, DifferInNothingThatActs) {
    auto constrained_in_three = example();
    constrained_in_three.value[0].z() = 0.0;
    EXPECT_FALSE(core::are_statically_equal(example(), constrained_in_three));
    auto pulled_harder = example();
    pulled_harder.value[1].y() = 2.5;
    EXPECT_FALSE(core::are_statically_equal(example(), pulled_harder));
    auto heavy = example();
    heavy.acceleration.z() = -9.81;
    EXPECT_FALSE(core::are_statically_equal(example(), heavy));
    EXPECT_FALSE(core::are_statically_equal(example(), core::without_tractions(example())));
}

TEST(LoadCasesThatHoldTheSame, MayDifferInLoadsAndInHowFarTheyMove) {
    auto other = core::without_tractions(example());
    other.value[0].x() = 0.25;
    other.acceleration.z() = -9.81;
    EXPECT_TRUE(core::constrain_the_same(example(), other));
    other.value[0].z() = 0.0;
    EXPECT_FALSE(core::constrain_the_same(example(), other));
    other = example();
    other.conditions[1].kind = core::ConditionKind::displacement;
    EXPECT_FALSE(core::constrain_the_same(example(), other));
    EXPECT_TRUE(core::constrains_all_of(other, example()));
    EXPECT_FALSE(core::constrains_all_of(example(), other));
}

} // namespace
} // namespace livermark
