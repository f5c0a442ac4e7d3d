#include <array>
#include <cmath>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <numbers>
#include <vector>

#include "core/mesh/local_refinement.hpp"
#include "fem_reference/hyperelastic/paths/load_path.hpp"
#include "tests/fem_reference/half_space.hpp"
#include "tests/fem_reference/hyperelastic_bodies.hpp"
#include "tests/samples/touch/sheared_column.hpp"

namespace livermark {

namespace {

using core::Vector3;

hyperelastic::FollowedPath follow_ball(const core::Problem &problem, const hyperelastic::Elements &elements,
                                       const fem_reference::DofConditions &conditions,
                                       const hyperelastic::ContactSettings &settings) {
    hyperelastic::TouchingBall ball(elements.system(), *problem.body, problem.load_case, settings);
    return hyperelastic::follow(elements, conditions, problem.load_case.num_constraints(), {},
                                {.fractions = {0.5, 1.0}, .tolerance = 1e-7}, &ball);
}

/// @param of  displacement at the whole load, NaN where it is free: Vector3 -> Vector3
template <class Displacement>
fem_reference::DofConditions prescribed(const fem_reference::ElasticSystem &system, const Displacement &of) {
    fem_reference::DofConditions conditions;
    const auto num_dofs = 3 * system.points.size();
    conditions.prescribed.assign(num_dofs, tests::free_component);
    conditions.constraint.assign(num_dofs, -1);
    conditions.load.assign(num_dofs, 0.0);
    for (std::size_t node = 0; node < system.points.size(); ++node)
        Vector3::Map(&conditions.prescribed[3 * node]) = of(system.points[node]);
    return conditions;
}

/// A flat that presses and shears a column.
struct ShearedColumn {
    tests::SimpleShear shear;
    hyperelastic::TouchSums touch;
    double largest_difference; ///< of a node from the closed form, over the largest displacement
    double penalty;            ///< [Pa/m]
};

ShearedColumn shear_column(double part_of_slip, double beyond) {
    constexpr double penalties = 100.0;
    const tests::SimpleShear shear(part_of_slip);
    const double penalty = penalties * shear.modulus() / tests::SimpleShear::height;
    auto problem = shear.problem({3, 3, 2}, penalty, beyond);
    const hyperelastic::Elements elements(problem.body, 2, fem_reference::Formulation::displacement,
                                          hyperelastic::material_law("neo_hookean"),
                                          hyperelastic::TetrahedronRule::four_points);
    const auto &ball = *problem.load_case.touching;
    const hyperelastic::ContactSettings settings{.stiffness = penalty * std::sqrt(ball.radius * ball.press.norm()) /
                                                              tests::SimpleShear::young_modulus,
                                                 .max_augmentations = 0};
    const auto path = follow_ball(problem, elements,
                                  prescribed(elements.system(),
                                             [&](const Vector3 &x) {
                                                 return shear.is_held(x) ? shear.displacement(x)
                                                                         : Vector3::Constant(tests::free_component);
                                             }),
                                  settings);
    EXPECT_EQ(path.status, core::SolutionStatus::ok) << path.message;
    ShearedColumn found{shear, {}, 0.0, penalty};
    if (path.points.empty())
        return found;
    found.touch = path.points.back().touch;
    const auto &displacement = path.points.back().state.displacement;
    for (std::size_t node = 0; node < elements.system().points.size(); ++node) {
        const auto expected = shear.displacement(elements.system().points[node]);
        found.largest_difference =
            std::max(found.largest_difference, (Vector3::Map(&displacement[3 * node]) - expected).norm());
    }
    found.largest_difference /= shear.displacement({0.0, 0.0, tests::SimpleShear::height}).norm();
    return found;
}

/// The part of the half-space on one side of the plane along which a ball is dragged, cut out near the contact.
struct DraggedHalfSpace {
    tests::HalfSpace space{.poisson = 0.49};
    double friction = 0.3, way; ///< of the ball, over that at which everything slips
    double size = 8.0 * space.contact_radius();

    /// Q / (mu P), Cattaneo 1938 and Mindlin 1949
    double drag() const { return 1.0 - std::pow(1.0 - way, 1.5); }
    /// c / a
    double stick_radius() const { return std::cbrt(1.0 - drag()); }

    core::Problem problem() const {
        constexpr int bricks = 4;
        auto mesh = tests::box_mesh({2.0 * size, size, size}, {2 * bricks, bricks, bricks});
        for (auto &point : mesh.points)
            point -= Vector3(size, 0.0, size);
        const auto body = tests::make_body(std::move(mesh), {1000.0, tests::HalfSpace::modulus, space.poisson});
        auto load_case = tests::empty_load_case(body->mesh);
        for (const auto *patch : {"x_min", "x_max", "y_min", "y_max", "z_min"})
            tests::prescribe(load_case, body->mesh, patch, Vector3::Zero());
        load_case.conditions.push_back({"touch", core::ConditionKind::touch});
        load_case.touching =
            core::TouchingTool{.radius = tests::HalfSpace::ball_radius,
                               .start = {0.0, 0.0, tests::HalfSpace::ball_radius},
                               .press = {way * space.way_to_slip(friction), 0.0, -tests::HalfSpace::depth},
                               .friction = friction,
                               .constraint = load_case.num_constraints() - 1};
        core::Problem problem{body, load_case};
        for (const double radii : {5.0, 3.2, 2.0}) {
            const core::InteriorPlace contact{Vector3::Zero(), space.contact_radius()};
            problem = core::refine_near_places(problem, std::span(&contact, 1), radii).problem;
        }
        return problem;
    }

    /// Symmetry, and on the outer faces what both forces do far away.
    Vector3 displacement(const Vector3 &x) const {
        const double rounding = 1e-9 * size;
        if (std::abs(x.x()) > size - rounding || x.y() > size - rounding || x.z() < -size + rounding) {
            Vector3 far = space.pressed(space.force(), x) + space.dragged(drag() * friction * space.force(), x);
            if (x.y() < rounding)
                far.y() = 0.0;
            return far;
        }
        return {tests::free_component, x.y() < rounding ? 0.0 : tests::free_component, tests::free_component};
    }
};

} // namespace

TEST(StickAndSlip, AColumnSticksBelowTheConeOfFriction) {
    const auto found = shear_column(0.5, 1.0);
    EXPECT_EQ(found.touch.slipping_area, 0.0);
    EXPECT_NEAR(found.touch.friction.x() / found.shear.shear_force(), 1.0, 0.005);
    EXPECT_NEAR(-found.touch.force.z() / found.shear.normal_force(), 1.0, 0.005);
    EXPECT_NEAR(found.touch.friction.x() / -found.touch.force.z(), 0.5 * tests::SimpleShear::friction, 0.002);
    EXPECT_LT(found.largest_difference, 0.002);
}

/// The flat goes on to twice the way at which the column begins to slip, and the column stays there.
TEST(StickAndSlip, AColumnSlipsWithTheForceOfTheCone) {
    const auto found = shear_column(1.0, 2.0);
    EXPECT_NEAR(found.touch.slipping_area, found.touch.area, 1e-12);
    EXPECT_NEAR(found.touch.friction.x() / -found.touch.force.z(), tests::SimpleShear::friction, 1e-5);
    EXPECT_NEAR(found.touch.friction.x() / found.shear.shear_force(), 1.0, 0.005);
    EXPECT_LT(found.largest_difference, 0.002);
}

/// A ball that is pressed in and dragged by half of what lets all of it slip: the ring between c and a slips. Forces
/// are those of the closed form. The radius that sticks is printed: it counts points that slip, and needs a finer mesh.
/// Poisson's ratio is near 1/2, where pressing alone drags nothing along the surface, as the closed form assumes.
TEST(StickAndSlip, OfADraggedBallIsThatOfCattaneoAndMindlin) {
    const DraggedHalfSpace half{.way = 0.5};
    const auto problem = half.problem();
    const hyperelastic::Elements elements(problem.body, 2, fem_reference::Formulation::displacement,
                                          hyperelastic::material_law("neo_hookean"),
                                          hyperelastic::TetrahedronRule::four_points);
    // Friction has no multipliers: a soft penalty would let points that stick go along.
    hyperelastic::TouchingBall ball(elements.system(), *problem.body, problem.load_case, {.stiffness = 400.0});
    const auto path = hyperelastic::follow(
        elements, prescribed(elements.system(), [&](const Vector3 &x) { return half.displacement(x); }),
        problem.load_case.num_constraints(), {}, {.fractions = {1.0}, .tolerance = 1e-7}, &ball);
    ASSERT_EQ(path.status, core::SolutionStatus::ok) << path.message;
    const auto &touch = path.points.back().touch;
    const double pressed = -2.0 * touch.force.z() / half.space.force() - 1.0;
    const double dragged = 2.0 * touch.force.x() / (half.friction * half.space.force()) / half.drag() - 1.0;
    const double sticking = std::sqrt(2.0 * (touch.area - touch.slipping_area) / std::numbers::pi) /
                                (half.stick_radius() * half.space.contact_radius()) -
                            1.0;
    fmt::print("Cattaneo and Mindlin: {} unknowns, force down {:+.2f} %, along {:+.2f} %, radius that sticks {:+.2f} "
               "%\n",
               3 * elements.system().points.size(), 100.0 * pressed, 100.0 * dragged, 100.0 * sticking);
    EXPECT_LT(std::abs(pressed), 0.01);
    EXPECT_LT(std::abs(dragged), 0.01);
}

} // namespace livermark
