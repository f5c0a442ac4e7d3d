#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

#include "core/support/input_error.hpp"
#include "studies/models/model_table.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark::models {
namespace {

constexpr double young = 5000.0, poisson = 0.45;

/// Mean over a ball of the displacement along a force of one newton that is spread over another ball, both with the
/// weight of a place, in a body without end [m/N]. Kelvin's field u = c (3 - 4 nu + cos^2) / d of a point force is
/// biharmonic, so the mean over a ball is u + <r^2> / 6 of its Laplacian c (2 - 6 cos^2) / d^3, and <r^2> is a third of
/// the radius squared. (A. E. H. Love, A Treatise on the Mathematical Theory of Elasticity, 1927, article 130)
/// @param cosine  of the angle between the force and the way to the other ball
double kelvin(double distance, double cosine, double radius) {
    const double shear = young / (2.0 * (1.0 + poisson));
    const double c = 1.0 / (16.0 * std::numbers::pi * shear * (1.0 - poisson));
    const double square = cosine * cosine;
    return c * ((3.0 - 4.0 * poisson + square) / distance +
                radius * radius / 9.0 * (2.0 - 6.0 * square) / std::pow(distance, 3));
}

/// What holds the block at its sides takes away nearly the same everywhere near the force, and little of differences.
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
    EXPECT_NEAR(ahead, kelvin(0.03, 1.0, radius) - kelvin(0.06, 1.0, radius), 0.02 * ahead);
    EXPECT_NEAR(beside, kelvin(0.03, 0.0, radius) - kelvin(0.06, 0.0, radius), 0.02 * beside);
    EXPECT_NEAR(along(3) - along(5), kelvin(0.04, 1.0, radius) - kelvin(0.06, 1.0, radius), 0.02 * ahead);
}

} // namespace
} // namespace livermark::models
