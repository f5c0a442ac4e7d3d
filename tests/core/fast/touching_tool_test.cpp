#include <Eigen/Eigenvalues>
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <vector>

#include "core/load_case.hpp"
#include "core/tool/touching_tool.hpp"

namespace livermark {
namespace {

using core::Vector3;

constexpr double ball_radius = 0.012;
const core::ContactLaw law{.penalty = 2e7, .tangential_penalty = 1e7, .friction = 0.3};
const core::ContactLaw smooth{.penalty = 2e7, .tangential_penalty = 1e7, .friction = 0.0};

/// Faces of 12 mm with edges of 3 mm, across no axis of coordinates.
const Vector3 pressed_along(0.2, -0.1, -0.9);
const core::ToolShape disc(core::ToolFace::round, ball_radius, 0.003, pressed_along),
    square(core::ToolFace::square, ball_radius, 0.003, pressed_along);

/// @param height  above the flat [m]
Vector3 at_plate(const core::ToolShape &plate, double along_side, double along_other, double height) {
    return along_side * plate.side + along_other * plate.axis.cross(plate.side) + height * plate.axis;
}

struct Place {
    core::ToolShape shape;
    Vector3 from_centre;
};

/// Inside a tool by 0.3 mm, near each kind of place of its surface: a ball, the face of a plate, its edge all around,
/// a corner, flanks.
std::vector<Place> places_inside() {
    constexpr double deep = 0.0027, beside = ball_radius + 0.6 * deep, before = 0.8 * deep, flank = ball_radius + deep;
    std::vector<Place> places{{ball_radius, 0.0117 * Vector3(0.2, -0.3, -0.9).normalized()}};
    for (const auto &plate : {disc, square})
        for (const Vector3 &place : {at_plate(plate, 0.002, 0.003, deep), at_plate(plate, 0.002, 0.003, -0.0001),
                                     at_plate(plate, beside, 0.001, before), at_plate(plate, 0.0, -flank, -0.001)})
            places.push_back({plate, place});
    places.push_back({disc, at_plate(disc, 0.8 * beside, -0.6 * beside, before)});
    const double corner = ball_radius + 0.6 * deep / std::sqrt(2.0);
    places.push_back({square, at_plate(square, corner, -corner, before)});
    places.push_back({square, at_plate(square, corner, corner, -0.001)});
    return places;
}

struct Case {
    core::ContactLaw law;
    Place place;
    core::ContactMemory memory;
};

/// Without friction, sticking and slipping, each with a multiplier and without one.
std::vector<Case> touching_cases() {
    std::vector<Case> cases;
    for (const auto &place : places_inside())
        for (const double multiplier : {0.0, 900.0}) {
            const auto &inside = place.from_centre;
            cases.push_back({smooth, place, {multiplier, inside}});
            cases.push_back({law, place, {multiplier, inside + Vector3(2e-5, 3e-5, 1e-5)}});
            cases.push_back({law, place, {multiplier, inside + Vector3(4e-3, 6e-3, -2e-3)}});
        }
    return cases;
}

core::Contact touch(const Case &at, const Vector3 &from_centre) {
    return core::touch(at.law, at.place.shape, from_centre, at.memory);
}

TEST(TouchingTool, GapAndNormalAreThoseOfABall) {
    const auto outside = core::gap_to(ball_radius, {0.0, 0.0, -0.015}),
               inside = core::gap_to(ball_radius, {0.009, 0.0, 0.0});
    EXPECT_NEAR(outside.size, 0.003, 1e-15);
    EXPECT_EQ(outside.normal, Vector3(0.0, 0.0, -1.0));
    EXPECT_NEAR(inside.size, -0.003, 1e-15);
    const core::TouchingTool ball{.shape = ball_radius, .start = {0.0, 0.0, 0.05}, .press = {0.0, 0.0, -0.01}};
    EXPECT_NEAR((ball.centre_at(0.5) - Vector3(0.0, 0.0, 0.045)).norm(), 0.0, 1e-15);
    auto sliding = ball;
    sliding.slide = {0.004, 0.0, 0.0};
    EXPECT_NEAR((sliding.centre_at(0.25) - Vector3(0.0, 0.0, 0.045)).norm(), 0.0, 1e-15);
    EXPECT_NEAR((sliding.centre_at(0.75) - Vector3(0.002, 0.0, 0.04)).norm(), 0.0, 1e-15);
    EXPECT_NEAR((ball.first_point() - Vector3(0.0, 0.0, 0.038)).norm(), 0.0, 1e-15);
}

TEST(TouchingTool, GapToAPlateIsThatOfItsFaceEdgesAndFlanks) {
    for (const auto &plate : {disc, square}) {
        EXPECT_NEAR(plate.axis.norm(), 1.0, 1e-15);
        EXPECT_NEAR(plate.side.dot(plate.axis), 0.0, 1e-15);
        const auto gap = [&](double side, double other, double height) {
            return core::gap_to(plate, at_plate(plate, side, other, height)).size;
        };
        EXPECT_NEAR(gap(0.0, 0.0, 0.004), 0.001, 1e-15);
        EXPECT_NEAR(gap(0.001, 0.002, -0.001), -0.004, 1e-15); // behind the face
        EXPECT_NEAR(gap(ball_radius + 0.003, 0.0, 0.004), 0.002, 1e-15);
        EXPECT_NEAR(gap(0.0, ball_radius + 0.004, -0.05), 0.001, 1e-15);
        const double farthest = plate.reach() - plate.radius;
        EXPECT_NEAR(gap(farthest / std::sqrt(2.0), farthest / std::sqrt(2.0), 0.003), 0.0, 1e-15);
        EXPECT_TRUE(core::is_outside(plate, at_plate(plate, 0.0, 0.0, 0.004), 0.0009));
        EXPECT_FALSE(core::is_outside(plate, at_plate(plate, 0.0, 0.0, 0.004), 0.0011));
    }
    EXPECT_NEAR(core::gap_to(square, at_plate(square, ball_radius + 0.004, ball_radius + 0.003, -0.01)).size, 0.002,
                1e-15);
}

TEST(TouchingTool, NormalIsTheSlopeOfTheGapAndBendsAsItSays) {
    for (const auto &[shape, from_centre] : places_inside()) {
        const auto gap = core::gap_to(shape, from_centre);
        EXPECT_LT(gap.size, 0.0);
        EXPECT_NEAR(gap.normal.norm(), 1.0, 1e-14);
        const Eigen::Matrix3d bends = core::bend(shape, from_centre, gap) / gap.distance;
        constexpr double step = 1e-8;
        for (int k = 0; k < 3; ++k) {
            const auto more = core::gap_to(shape, from_centre + step * Vector3::Unit(k)),
                       less = core::gap_to(shape, from_centre - step * Vector3::Unit(k));
            EXPECT_NEAR((more.size - less.size) / (2.0 * step), gap.normal[k], 1e-7);
            EXPECT_LT(((more.normal - less.normal) / (2.0 * step) - bends.col(k)).norm(), 1e-5 / shape.radius);
        }
    }
}

TEST(TouchingTool, DoesNothingWithoutContact) {
    const Vector3 outside(0.0, 0.001, 0.0125);
    const core::ContactMemory memory{0.0, {0.001, 0.0, 0.0125}};
    const auto contact = core::touch(law, ball_radius, outside, memory);
    EXPECT_FALSE(contact.touches());
    EXPECT_EQ(contact.traction(), Vector3::Zero());
    EXPECT_TRUE(core::contact_stiffness(law, ball_radius, outside, memory, contact).all().isZero(0.0));
    EXPECT_EQ(core::after_step(law, outside, memory, contact).anchor, outside);
    // What augmentation has added pulls nothing: pressures are never negative.
    EXPECT_EQ(core::touch(law, ball_radius, outside, {100.0, outside}).pressure, 0.0);
}

TEST(TouchingTool, TractionIsTheGradientOfItsEnergyWithoutFriction) {
    for (const auto &at : touching_cases()) {
        if (at.law.friction > 0.0)
            continue;
        const auto energy = [&](const Vector3 &d) { return core::contact_energy(at.law, touch(at, d), at.memory); };
        constexpr double step = 1e-7;
        const Vector3 traction = touch(at, at.place.from_centre).traction();
        for (int k = 0; k < 3; ++k) {
            const Vector3 along = step * Vector3::Unit(k);
            EXPECT_NEAR(-(energy(at.place.from_centre + along) - energy(at.place.from_centre - along)) / (2.0 * step),
                        traction[k], 1e-6 * traction.norm());
        }
    }
}

TEST(TouchingTool, StiffnessIsTheDerivativeOfTheTraction) {
    int slipping = 0, sticking = 0;
    for (const auto &at : touching_cases()) {
        const auto contact = touch(at, at.place.from_centre);
        ASSERT_TRUE(contact.touches());
        slipping += contact.slips ? 1 : 0;
        sticking += contact.slips ? 0 : 1;
        const auto stiffness =
            core::contact_stiffness(at.law, at.place.shape, at.place.from_centre, at.memory, contact);
        constexpr double step = 1e-9;
        for (int k = 0; k < 3; ++k) {
            const Vector3 along = step * Vector3::Unit(k);
            const Vector3 slope = (touch(at, at.place.from_centre + along).traction() -
                                   touch(at, at.place.from_centre - along).traction()) /
                                  (2.0 * step);
            EXPECT_LT((stiffness.all().col(k) + slope).norm(), 1e-5 * law.penalty);
        }
        EXPECT_LT((stiffness.positive - stiffness.positive.transpose()).norm(), 1e-12 * law.penalty);
        const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> modes(stiffness.positive);
        EXPECT_GT(modes.eigenvalues()[0], -1e-12 * law.penalty);
    }
    EXPECT_EQ(slipping, 2 * static_cast<int>(places_inside().size()));
    EXPECT_EQ(sticking, 2 * slipping);
}

TEST(TouchingTool, FrictionStaysInTheConeAndOpposesTheSlip) {
    for (const auto &at : touching_cases()) {
        const auto contact = touch(at, at.place.from_centre);
        const double most = at.law.friction * contact.pressure;
        EXPECT_LE(contact.friction.norm(), most * (1.0 + 1e-14));
        EXPECT_NEAR(contact.friction.dot(contact.gap.normal), 0.0, 1e-12 * contact.pressure);
        if (contact.slips) {
            EXPECT_NEAR(contact.friction.norm(), most, 1e-12 * most);
        }
        EXPECT_LE(contact.friction.dot(at.place.from_centre - at.memory.anchor), 0.0);
    }
}

/// A point that is dragged along a plane of contact moves back under the elastic part of its slip, then sticks.
TEST(TouchingTool, AnchorIsDraggedBySlipAndStaysOtherwise) {
    const Vector3 rest(0.0, 0.0, -0.0119);
    core::ContactMemory memory{0.0, rest};
    const Vector3 moved = rest + Vector3(1e-3, 0.0, 0.0);
    const auto slipping = core::touch(law, ball_radius, moved, memory);
    ASSERT_TRUE(slipping.slips);
    memory = core::after_step(law, moved, memory, slipping);
    // The same place again is on the cone, neither beyond it nor inside.
    const auto again = core::touch(law, ball_radius, moved, memory);
    EXPECT_LT((again.friction - slipping.friction).norm(), 1e-3 * slipping.friction.norm());
    const Vector3 back = moved - Vector3(2e-5, 0.0, 0.0);
    const auto sticking = core::touch(law, ball_radius, back, memory);
    EXPECT_FALSE(sticking.slips);
    EXPECT_EQ(core::after_step(law, back, memory, sticking).anchor, memory.anchor);
}

TEST(TouchingTool, IsPartOfWhatALoadCaseDoes) {
    core::LoadCase load_case;
    load_case.conditions = {{"base"}};
    load_case.condition_on = {0, -1};
    load_case.value = {Vector3::Zero(), Vector3::Zero()};
    EXPECT_FALSE(core::is_driven(load_case));
    EXPECT_FALSE(load_case.may_touch(1));
    auto pressed = load_case;
    pressed.touching = core::TouchingTool{.shape = ball_radius, .start = {0.0, 0.0, 1.0}, .press = {0.0, 0.0, -0.01}};
    EXPECT_TRUE(core::is_driven(pressed));
    EXPECT_FALSE(pressed.may_touch(0));
    EXPECT_TRUE(pressed.may_touch(1));
    EXPECT_FALSE(core::are_statically_equal(load_case, pressed));
    auto half = core::scaled(pressed, 0.5);
    EXPECT_FALSE(core::are_statically_equal(half, pressed));
    EXPECT_EQ(half.touching->press, Vector3(0.0, 0.0, -0.005));
    EXPECT_EQ(half.touching->start, pressed.touching->start);
    half.touching->press *= 2.0;
    EXPECT_TRUE(core::are_statically_equal(half, pressed));
}

/// Points that reflection takes into each other have the same gap, each to its jaw, and opposite normals.
TEST(TouchingTool, SecondJawIsThePointReflectionOfTheFirst) {
    core::TouchingTool ball{.shape = ball_radius,
                            .start = {0.01, 0.02, 0.062},
                            .press = {0.001, 0.002, -0.009},
                            .friction = 0.3,
                            .constraint = 2};
    EXPECT_FALSE(ball.is_for_other_jaw(ball.press));
    ASSERT_EQ(ball.contacts().size(), 1U);
    const auto alone = ball;
    const Vector3 between(0.012, 0.021, 0.03);
    ball.between = between;
    EXPECT_NE(ball, alone);
    for (const double part : {0.0, 0.3, 1.0}) {
        const Vector3 centre = ball.centre_at(part), other = ball.other_centre(centre);
        EXPECT_LT((0.5 * (centre + other) - between).norm(), 1e-15);
        EXPECT_LT((other - ball.other_centre(ball.start) + part * ball.press).norm(), 1e-15) << "it closes";
        for (const Vector3 &point : {Vector3(0.01, 0.02, 0.055), Vector3(0.014, 0.015, 0.045)}) {
            const auto gap = core::gap_to(ball.shape, point - centre),
                       reflected = core::gap_to(ball.shape, 2.0 * between - point - other);
            EXPECT_NEAR(reflected.size, gap.size, 1e-15);
            EXPECT_LT((reflected.normal + gap.normal).norm(), 1e-12);
        }
    }
    const Vector3 across = ball.press.unitOrthogonal();
    EXPECT_TRUE(ball.is_for_other_jaw(ball.press + across)) << "it looks the way that the first jaw presses";
    EXPECT_FALSE(ball.is_for_other_jaw(across - ball.press));
    const auto contacts = ball.contacts();
    ASSERT_EQ(contacts.size(), 2U);
    EXPECT_EQ(contacts[0].constraint, 2);
    EXPECT_EQ(contacts[1].constraint, 3);
    EXPECT_EQ(contacts[0].middle, ball.first_point());
    EXPECT_LT((0.5 * (contacts[0].middle + contacts[1].middle) - between).norm(), 1e-15);
    EXPECT_EQ(contacts[1].press, -ball.press);
    EXPECT_EQ(contacts[1].radius, contacts[0].radius);
}

TEST(FacetSoftness, FadesAsTheCircleOfContactGrowsOverTheFacet) {
    const core::FacetSoftness stays{.at_first = 0.42}, fades{.at_first = 0.25, .fades_at = 0.6};
    EXPECT_EQ(stays.at(0.0), 0.42);
    EXPECT_EQ(stays.at(3.0), 0.42);
    EXPECT_EQ(fades.at(0.0), 0.25);
    EXPECT_NEAR(fades.at(0.6), 0.25 / std::numbers::e, 0.25e-12); // to as many digits as are kept
    EXPECT_EQ(fades.at(5.0), core::FacetSoftness::least);
    const core::TouchedFacet facet{.side = 0.01, .modulus = 6000.0, .softness = fades};
    EXPECT_NEAR(facet.penalty(0.006), 6000.0 / (0.01 * fades.at(0.6)), 1e-6);
    EXPECT_EQ(facet.tangential_penalty(), facet.penalty(0.0));
}

} // namespace
} // namespace livermark
