#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

#include "models/model_table.hpp"
#include "support/known_names.hpp"
#include "tests/test_meshes.hpp"

namespace livermark::models {
namespace {

constexpr double young = 5000.0, poisson = 0.45;

/// Displacement along a force of one newton on a point of a body without end, at some distance [m/N].
/// (Kelvin 1848; A. E. H. Love, A Treatise on the Mathematical Theory of Elasticity, 1927, article 130)
/// @param cosine  of the angle between the force and the way to the point
double kelvin(double distance, double cosine) {
    const double shear = young / (2.0 * (1.0 + poisson));
    return (3.0 - 4.0 * poisson + cosine * cosine) / (16.0 * std::numbers::pi * shear * (1.0 - poisson) * distance);
}

/// A ball's weight is alike on all sides, so outside of it the field is nearly that of a point. What holds the block at
/// its sides takes away the same everywhere near the force, and nothing of differences.
TEST(Compliance, InALargeBlockIsThatOfKelvin) {
    constexpr double radius = 0.01, side = 0.4;
    const auto body = tests::make_body(tests::box_mesh({side, side, side}, {16, 16, 16}), {1000.0, young, poisson});
    core::Problem problem{body, tests::empty_load_case(body->mesh)};
    for (const auto *patch : {"x_min", "x_max", "y_min", "y_max", "z_min", "z_max"})
        tests::prescribe(problem.load_case, body->mesh, patch, core::Vector3::Zero());
    const core::Vector3 middle(0.205, 0.195, 0.2);
    std::vector<core::InteriorPlace> places{{middle, radius}};
    for (const double distance : {0.03, 0.04, 0.06})
        for (const auto &way : {core::Vector3::UnitX(), core::Vector3::UnitY()})
            places.push_back({middle + distance * way, radius});
    const auto models = all_models();
    const auto found =
        support::find_named(models, std::string("fem_p2p1_refined"), "model").compliance(problem, places).matrix;
    const auto along = [&](int place) { return found(3 * place, 0); }; // for a force along x
    const double ahead = along(1) - along(5), beside = along(2) - along(6);
    EXPECT_NEAR(ahead, kelvin(0.03, 1.0) - kelvin(0.06, 1.0), 0.03 * ahead);
    EXPECT_NEAR(beside, kelvin(0.03, 0.0) - kelvin(0.06, 0.0), 0.03 * beside);
    EXPECT_NEAR(along(3) - along(5), kelvin(0.04, 1.0) - kelvin(0.06, 1.0), 0.03 * ahead);
}

} // namespace
} // namespace livermark::models
