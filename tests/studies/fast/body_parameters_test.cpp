#include "studies/parameters/body_parameters.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <numeric>

#include "msm/springs/spring_network.hpp"
#include "studies/msm_choice.hpp"
#include "tests/bad_input.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark::studies {
namespace {

constexpr double rounding = 1e-9;

/// A box that is constrained at x_min, with a stiff and heavy lump in it or without.
core::Problem lumpy_box(bool has_lump, double young_modulus = 5e3) {
    auto mesh = tests::box_mesh({0.1, 0.08, 0.06}, {4, 3, 3});
    mesh.region_names = {"parenchyma", "tumour_1"};
    for (std::size_t t = 60; t < 90; ++t)
        mesh.region[t] = has_lump ? 1 : 0;
    auto body = std::make_shared<core::Body>();
    body->mesh = std::move(mesh);
    body->materials = {{1000.0, young_modulus, 0.25}, {1200.0, 4.0 * young_modulus, 0.25}};
    auto load_case = tests::empty_load_case(body->mesh);
    tests::prescribe(load_case, body->mesh, "x_min", {0.0, 0.0, 0.0});
    return {body, std::move(load_case)};
}

BodyParameters parameters(const core::Problem &problem, const DampingChoice &choice = {},
                          const std::string &law = "lloyd") {
    return body_parameters(problem, find_spring_law(law), choice);
}

void expect_close(double value, double expected) {
    EXPECT_NEAR(value / expected, 1.0, rounding) << value << " is not " << expected;
}

TEST(Spread, IsThatOfTheValues) {
    const auto odd = spread_of({3.0, -1.0, 10.0});
    EXPECT_EQ(odd.number, 3);
    EXPECT_EQ(odd.sum, 12.0);
    EXPECT_EQ(odd.mean, 4.0);
    EXPECT_EQ(odd.median, 3.0);
    EXPECT_EQ(odd.smallest, -1.0);
    EXPECT_EQ(odd.largest, 10.0);
    EXPECT_EQ(spread_of({4.0, 1.0, 2.0, 9.0}).median, 3.0);
}

TEST(BodyParameters, HaveTheMassTheVolumeAndTheSpringsOfTheMesh) {
    for (const bool has_lump : {false, true}) {
        const auto problem = lumpy_box(has_lump);
        const auto &body = *problem.body;
        const auto volumes = core::tetrahedron_volumes(body.mesh);
        double mass = 0.0, of_lump = 0.0, modulus = 0.0;
        for (std::size_t t = 0; t < volumes.size(); ++t) {
            const auto &material = body.materials[body.mesh.region[t]];
            mass += material.density * volumes[t];
            modulus += material.young_modulus * volumes[t];
            of_lump += body.mesh.region[t] == 1 ? volumes[t] : 0.0;
        }
        const auto found = parameters(problem);
        EXPECT_EQ(found.node_mass.number, body.mesh.num_nodes());
        expect_close(found.node_mass.sum, mass);
        expect_close(found.volume, std::accumulate(volumes.begin(), volumes.end(), 0.0));
        expect_close(found.mean_young_modulus, modulus / found.volume);
        EXPECT_NEAR(found.tumour_volume, of_lump, 1e-12 * found.volume);
        EXPECT_EQ(found.stiffness.number, static_cast<int>(core::edge_table(body.mesh.tetrahedra).edges.size()));
    }
}

TEST(BodyParameters, DampersGoWithStiffnessAndMass) {
    const auto found = parameters(lumpy_box(true));
    for (const auto part : {&Spread::sum, &Spread::mean, &Spread::median, &Spread::smallest, &Spread::largest}) {
        expect_close(found.dashpot.*part, found.damping.beta * found.stiffness.*part);
        expect_close(found.ground_damper.*part, found.damping.alpha * found.node_mass.*part);
    }
}

TEST(BodyParameters, DampingHasTheRatioThatWasAskedFor) {
    const auto problem = lumpy_box(false);
    const double first = parameters(problem).modes.angular_frequency.front();
    const double last = parameters(problem).modes.angular_frequency.back();
    const auto by_mass = parameters(problem, {.kind = DampingKind::mass, .ratio = 0.1, .frequencies = {}});
    expect_close(by_mass.damping.alpha, 2.0 * 0.1 * first);
    EXPECT_EQ(by_mass.damping.beta, 0.0);
    const auto by_stiffness = parameters(problem, {.kind = DampingKind::stiffness, .ratio = 0.1, .frequencies = {}});
    expect_close(by_stiffness.damping.beta, 2.0 * 0.1 / first);
    EXPECT_EQ(by_stiffness.damping.alpha, 0.0);
    const auto by_both = parameters(problem, {.ratio = 0.1, .frequencies = {2.0, 9.0}});
    for (const double frequency : {2.0, 9.0})
        expect_close(by_both.damping.ratio(2.0 * std::numbers::pi * frequency), 0.1);
    const auto by_modes = parameters(problem, {.ratio = 0.1, .frequencies = {}});
    expect_close(by_modes.damping.ratio(first), 0.1);
    expect_close(by_modes.damping.ratio(last), 0.1);
}

TEST(BodyParameters, FollowYoungsModulus) {
    const auto soft = parameters(lumpy_box(true)),
               stiff = parameters(lumpy_box(true, 20e3)); // four times as stiff, the lump too
    expect_close(stiff.stiffness.sum, 4.0 * soft.stiffness.sum);
    expect_close(stiff.frequency(0), 2.0 * soft.frequency(0));
    expect_close(stiff.critical_time_step, 0.5 * soft.critical_time_step);
    expect_close(soft.critical_time_step * soft.largest_angular_frequency, std::sqrt(8.0));
    EXPECT_NE(parameters(lumpy_box(true), {}, "lloyd_edge").stiffness.sum, soft.stiffness.sum);
}

TEST(BodyParameters, WithoutTumoursAreThoseOfOneMaterial) {
    const auto problem = lumpy_box(true);
    auto healthy = without_tumours(*problem.body);
    ASSERT_TRUE(healthy);
    const auto found = parameters({std::make_shared<const core::Body>(std::move(*healthy)), problem.load_case});
    const auto expected = parameters(lumpy_box(false));
    EXPECT_EQ(found.stiffness.sum, expected.stiffness.sum);
    EXPECT_EQ(found.node_mass.sum, expected.node_mass.sum);
    EXPECT_EQ(found.modes.angular_frequency, expected.modes.angular_frequency);
}

TEST(BodyParameters, OfABodyWithoutTumoursOrOfTumoursOnlyHaveNoHealthyTwin) {
    auto body = *lumpy_box(false).body;
    body.mesh.region_names = {"parenchyma", "cyst"};
    EXPECT_FALSE(without_tumours(body));
    body.mesh.region_names = {"tumour_1", "tumour_2"};
    EXPECT_FALSE(without_tumours(body));
}

TEST(BodyParameters, RefuseADampingThatCannotBe) {
    const auto problem = lumpy_box(false);
    const auto refuses = [&](const DampingChoice &choice, const std::string &part) {
        tests::expect_input_error([&] { parameters(problem, choice); }, {part});
    };
    refuses({.ratio = -1.0, .frequencies = {}}, "the damping ratio is -1; it has to be zero or more");
    refuses({.ratio = 0.1, .frequencies = {2.0, 2.0}}, "frequencies that differ");
    refuses({.ratio = 0.1, .frequencies = {0.0, 2.0}}, "has to be positive");
    refuses({.kind = DampingKind::mass, .frequencies = {1.0, 2.0}}, "for --damping rayleigh");
    tests::expect_input_error([&] { parameters(problem, {}, "loyd"); }, {"did you mean 'lloyd'?"});
}

} // namespace
} // namespace livermark::studies
