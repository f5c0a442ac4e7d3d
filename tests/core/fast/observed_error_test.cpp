#include "core/observed_error.hpp"

#include <gtest/gtest.h>
#include <stdexcept>
#include <vector>

#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

using core::ObservedError;
using core::Vector3;

constexpr ObservedError narrow{.order = 1.0,
                               .difference = 1e-3,
                               .relative_l2 = 1e-3,
                               .energy = 1e-3,
                               .reaction = 1e-3,
                               .load_fraction = 1.0,
                               .stiffness = 1e-3};
constexpr ObservedError wide{.order = 1.0,
                             .difference = 1e-2,
                             .relative_l2 = 0.01,
                             .energy = 0.02,
                             .reaction = 0.03,
                             .load_fraction = 0.6,
                             .stiffness = 0.04};

/// A cube that is pushed to a depth.
struct Pressed {
    core::TetraMesh mesh = tests::box_mesh({0.1, 0.1, 0.1}, {2, 2, 2});
    core::LoadCase load_case = tests::empty_load_case(mesh);

    Pressed() {
        tests::prescribe(load_case, mesh, "z_min", Vector3::Zero());
        tests::prescribe(load_case, mesh, "z_max", {0.0, 0.0, -0.01});
    }

    core::Solution solution(double scale, const ObservedError &error) const {
        core::Solution result;
        for (const auto &point : mesh.points)
            result.displacement.emplace_back(0.0, 0.0, -scale * point.z());
        result.reaction = {{0.0, 0.0, scale}, {0.0, 0.0, -scale}};
        result.strain_energy = scale;
        result.observed_error = error;
        return result;
    }
};

} // namespace

/// The other solution is 1 / 1.25 of the first, so the first is a quarter of the other off.
TEST(WidenedError, IsTheDistanceAndTheOtherErrorTogether) {
    const Pressed pressed;
    const auto error =
        core::widened(pressed.mesh, pressed.load_case, pressed.solution(1.25, narrow), pressed.solution(1.0, wide));
    EXPECT_NEAR(error.relative_l2, 0.26, 1e-12);
    EXPECT_NEAR(error.energy, 0.27, 1e-12);
    EXPECT_NEAR(error.reaction, 0.28, 1e-12);
    ASSERT_TRUE(error.stiffness);
    EXPECT_NEAR(*error.stiffness, 0.29, 1e-12);
    EXPECT_EQ(error.load_fraction, 0.6);
    EXPECT_EQ(error.order, narrow.order);
}

TEST(WidenedError, NeverShrinks) {
    const Pressed pressed;
    const auto error =
        core::widened(pressed.mesh, pressed.load_case, pressed.solution(1.0, wide), pressed.solution(1.0, narrow));
    EXPECT_EQ(error, wide);
}

TEST(WidenedError, NeedsErrorsThatWereObserved) {
    const Pressed pressed;
    auto unknown = pressed.solution(1.0, wide);
    unknown.observed_error.reset();
    const auto known = pressed.solution(1.0, wide);
    EXPECT_THROW(core::widened(pressed.mesh, pressed.load_case, known, unknown), std::invalid_argument);
    EXPECT_THROW(core::widened(pressed.mesh, pressed.load_case, unknown, known), std::invalid_argument);
}

} // namespace livermark
