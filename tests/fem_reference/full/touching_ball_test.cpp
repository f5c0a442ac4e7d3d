#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <numbers>
#include <vector>

#include "core/mesh/refinement.hpp"
#include "core/mesh/tetra_mesh.hpp"
#include "fem_reference/hyperelastic/hyperelasticity.hpp"
#include "fem_reference/hyperelastic/surface.hpp"
#include "fem_reference/linear/conditions.hpp"
#include "tests/fem_reference/hyperelastic_bodies.hpp"
#include "tests/samples/touch/sheared_column.hpp"
#include "tests/samples/touch/touched_layer.hpp"

namespace livermark {

namespace {

using core::Vector3;

/// A rigid ball on an elastic half-space below z = 0 (K. L. Johnson, Contact Mechanics, 1985, chapters 3, 4 and 7), in
/// metres: so shallow that strains and slopes are a hundredth.
struct HalfSpace {
    static constexpr double ball_radius = 1.0, depth = 1e-4, modulus = 5000.0;
    double poisson;

    double shear_modulus() const { return 0.5 * modulus / (1.0 + poisson); }
    double contact_radius() const { return std::sqrt(ball_radius * depth); }
    /// 4/3 E* sqrt(R) d^(3/2)
    double force() const {
        return 4.0 / 3.0 * modulus / (1.0 - poisson * poisson) * std::sqrt(ball_radius) * std::pow(depth, 1.5);
    }
    /// Way of the ball along the surface at which all of it slips: 3 mu P (2 - nu) / (16 G a).
    double way_to_slip(double friction) const {
        return 3.0 * friction * force() * (2.0 - poisson) / (16.0 * shear_modulus() * contact_radius());
    }

    /// Displacement by a force P into the half-space at the origin (Boussinesq).
    core::Vector3 pressed(double force, const core::Vector3 &x) const {
        const double down = -x.z(), rho = x.norm();
        const double along = down / std::pow(rho, 3) - (1.0 - 2.0 * poisson) / (rho * (rho + down));
        return force / (4.0 * std::numbers::pi * shear_modulus()) *
               core::Vector3(x.x() * along, x.y() * along,
                             -(2.0 * (1.0 - poisson) / rho + down * down / std::pow(rho, 3)));
    }
    /// Displacement by a force Q along x at the origin (Cerruti).
    core::Vector3 dragged(double force, const core::Vector3 &x) const {
        const double down = -x.z(), rho = x.norm(), sum = rho + down, cube = std::pow(rho, 3);
        const double rest = 1.0 - 2.0 * poisson;
        return force / (4.0 * std::numbers::pi * shear_modulus()) *
               core::Vector3(1.0 / rho + x.x() * x.x() / cube + rest * (1.0 / sum - x.x() * x.x() / (rho * sum * sum)),
                             x.x() * x.y() / cube - rest * x.x() * x.y() / (rho * sum * sum),
                             -(x.x() * down / cube + rest * x.x() / (rho * sum)));
    }
};

/// A rigid round punch on that half-space whose flat face ends in parabolas of a radius of curvature (I. N. Sneddon
/// 1965, The relation between load and penetration in the axisymmetric Boussinesq problem for a punch of arbitrary
/// profile, Int. J. Eng. Sci. 3; M. Ciavarella, D. A. Hills, G. Monno 1998, The influence of rounded edges on
/// indentation by a flat punch, Proc. Inst. Mech. Eng. C 212). It touches in a radius c = a / cos(phi).
struct RoundedPunch {
    double size, edge_radius; ///< a, r [m]

    double contact_radius(double phi) const { return size / std::cos(phi); }
    /// c^2 / r (sin(phi) - phi cos(phi))
    double depth(double phi) const {
        return std::pow(contact_radius(phi), 2) / edge_radius * (std::sin(phi) - phi * std::cos(phi));
    }
    /// Force over E*: 2 c^2 / r (c (sin(phi) - sin(phi)^3 / 3) - a (phi + sin(phi) cos(phi)) / 2) [m^2]. Without edges
    /// it is Boussinesq's 2 a d.
    double force(double phi) const {
        const double c = contact_radius(phi), sine = std::sin(phi);
        return 2.0 * c * c / edge_radius *
               (c * (sine - std::pow(sine, 3) / 3.0) - 0.5 * size * (phi + sine * std::cos(phi)));
    }
    double phi_at(double depth_to_reach) const {
        double low = 0.0, high = 1.5;
        for (int halving = 0; halving < 60; ++halving)
            (depth(0.5 * (low + high)) < depth_to_reach ? low : high) = 0.5 * (low + high);
        return low;
    }
};

hyperelastic::Elements with_four_points(const std::shared_ptr<const core::Body> &body) {
    return tests::neo_hookean_elements(body, 2, fem_reference::Formulation::displacement,
                                       hyperelastic::TetrahedronRule::four_points);
}

/// A tool on a box of a half-space near the contact, whose bricks have edges of a quarter of its depth.
/// @param lowest      corner of the box
/// @param refined_in  radii of contact within which the mesh is refined, again and again
core::Problem cut_out(const HalfSpace &space, const Vector3 &box, const Vector3 &lowest,
                      const std::array<int, 3> &bricks, const Vector3 &press, double friction,
                      const std::vector<double> &refined_in, const core::ToolShape &shape) {
    auto mesh = tests::box_mesh(box, bricks);
    for (auto &point : mesh.points)
        point += lowest;
    const auto body = tests::make_body(std::move(mesh), {1000.0, HalfSpace::modulus, space.poisson});
    auto load_case = tests::empty_load_case(body->mesh);
    for (const auto *patch : {"x_min", "x_max", "y_min", "y_max", "z_min"})
        tests::prescribe(load_case, body->mesh, patch, Vector3::Zero());
    load_case.conditions.push_back({"touch", core::ConditionKind::touch});
    load_case.touching = core::TouchingTool{.shape = shape,
                                            .start = {0.0, 0.0, shape.radius},
                                            .press = press,
                                            .friction = friction,
                                            .constraint = load_case.num_constraints() - 1};
    core::Problem problem{body, load_case};
    for (const double radii : refined_in) {
        const core::InteriorPlace contact{Vector3::Zero(), space.contact_radius()};
        problem = core::refine_near_places(problem, std::span(&contact, 1), radii).problem;
    }
    return problem;
}

/// The quarter of the half-space that is left between two planes of symmetry, cut out near the contact.
struct CutOut {
    HalfSpace space;
    double size;  ///< [m] from the contact to the outer faces
    double force; ///< that outer faces are displaced by [N]
    core::Problem problem;

    /// @param size_in_radii  of contact
    /// @param refined_in     radii of contact within which the mesh is refined, again and again
    CutOut(const HalfSpace &of, double size_in_radii, const std::vector<double> &refined_in,
           const core::ToolShape &shape, double whole_force)
        : space(of), size(size_in_radii * space.contact_radius()), force(whole_force) {
        problem = cut_out(space, Vector3::Constant(size), {0.0, 0.0, -size}, {4, 4, 4}, {0.0, 0.0, -HalfSpace::depth},
                          0.0, refined_in, shape);
    }

    /// Symmetry, and on the outer faces the far field at the whole load.
    fem_reference::DofConditions conditions(const fem_reference::ElasticSystem &system) const {
        auto conditions = tests::no_conditions(system);
        const double rounding = 1e-9 * size;
        for (std::size_t node = 0; node < system.points.size(); ++node) {
            const Vector3 &x = system.points[node];
            const bool is_outer = x.x() > size - rounding || x.y() > size - rounding || x.z() < -size + rounding;
            if (is_outer)
                Vector3::Map(&conditions.prescribed[3 * node]) = space.pressed(force, x);
            if (x.x() < rounding)
                conditions.prescribed[3 * node] = 0.0;
            if (x.y() < rounding)
                conditions.prescribed[3 * node + 1] = 0.0;
        }
        return conditions;
    }
};

struct Found {
    hyperelastic::FollowedPath path;
    std::size_t unknowns;
};

Found solve(const CutOut &cut) {
    const auto elements = with_four_points(cut.problem.body);
    hyperelastic::TouchingBall ball(elements.system(), *cut.problem.body, cut.problem.load_case);
    const auto conditions = cut.conditions(elements.system());
    return {hyperelastic::follow(elements, conditions, cut.problem.load_case.num_constraints(), {},
                                 {.fractions = {1.0}, .tolerance = 1e-7}, &ball),
            3 * elements.system().points.size()};
}

/// Relative errors of force and radius of contact.
struct HertzErrors {
    double force, radius, radius_by_area;
};

HertzErrors errors_on(const std::vector<double> &refined_in) {
    const HalfSpace space{.poisson = 0.3};
    const CutOut cut(space, 8.0, refined_in, HalfSpace::ball_radius, space.force());
    const auto [path, unknowns] = solve(cut);
    EXPECT_EQ(path.status, core::SolutionStatus::ok) << path.message;
    if (path.points.empty())
        return {};
    const auto &touch = path.points.back().touch;
    const HertzErrors errors{-4.0 * touch.force.z() / space.force() - 1.0, touch.radius / space.contact_radius() - 1.0,
                             std::sqrt(4.0 * touch.area / std::numbers::pi) / space.contact_radius() - 1.0};
    fmt::print("Hertz: {} unknowns, force {:+.3f} %, radius by pressure {:+.3f} %, by area {:+.3f} %, sunk in "
               "{:.1e} of the depth\n",
               unknowns, 100.0 * errors.force, 100.0 * errors.radius, 100.0 * errors.radius_by_area,
               touch.sunk_in / HalfSpace::depth);
    return errors;
}

} // namespace

/// Within a hundredth, also on a mesh with edges that are twice as long below the ball.
TEST(Hertz, ForceAndRadiusOfContactAreThoseOfTheClosedForm) {
    const auto coarse = errors_on({5.0, 3.2, 2.0}), fine = errors_on({5.0, 3.2, 2.0, 1.5});
    for (const auto &errors : {coarse, fine}) {
        EXPECT_LT(std::abs(errors.force), 0.01);
        EXPECT_LT(std::abs(errors.radius), 0.01);
    }
    EXPECT_LT(std::abs(fine.radius_by_area), 0.01);
    EXPECT_LT(std::abs(fine.force), std::abs(coarse.force));
}

namespace {

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
    auto conditions = tests::no_conditions(system);
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
    auto problem = shear.problem({3, 3, 2}, {penalty, penalty}, beyond);
    const auto elements = with_four_points(problem.body);
    const auto &ball = *problem.load_case.touching;
    const hyperelastic::ContactSettings settings{
        .stiffness = penalty * std::sqrt(ball.shape.radius * ball.press.norm()) / tests::SimpleShear::young_modulus,
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
    HalfSpace space{.poisson = 0.49};
    double friction = 0.3, way; ///< of the ball, over that at which everything slips
    double size = 8.0 * space.contact_radius();

    /// Q / (mu P), Cattaneo 1938 and Mindlin 1949
    double drag() const { return 1.0 - std::pow(1.0 - way, 1.5); }
    /// c / a
    double stick_radius() const { return std::cbrt(1.0 - drag()); }

    core::Problem problem() const {
        return cut_out(space, {2.0 * size, size, size}, {-size, 0.0, -size}, {8, 4, 4},
                       {way * space.way_to_slip(friction), 0.0, -HalfSpace::depth}, friction, {5.0, 3.2, 2.0},
                       HalfSpace::ball_radius);
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
    const auto elements = with_four_points(problem.body);
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

namespace {

/// A plate as wide as Hertz's contact would be, which is a hundred times its depth, on the half-space without friction.
/// @param force_over_modulus  that is expected, over E* [m^2]
/// @return relative error of the force
double error_of_punch(core::ToolFace face, double edge_over_size, double force_over_modulus,
                      const std::vector<double> &refined_in) {
    const HalfSpace space{.poisson = 0.3};
    const core::ToolShape plate(face, space.contact_radius(), edge_over_size * space.contact_radius(),
                                {0.0, 0.0, -1.0});
    const double expected = HalfSpace::modulus / (1.0 - space.poisson * space.poisson) * force_over_modulus;
    const auto [path, unknowns] = solve(CutOut(space, 8.0, refined_in, plate, expected));
    EXPECT_EQ(path.status, core::SolutionStatus::ok) << path.message;
    if (path.points.empty())
        return 1.0;
    const auto &touch = path.points.back().touch;
    const double error = -4.0 * touch.force.z() / expected - 1.0;
    fmt::print("{} punch, edges of {:g} of its size: {} unknowns, force {:+.2f} %, area {:.3f} of the face, sunk in "
               "{:.1e} of the depth\n",
               core::to_string(face), edge_over_size, unknowns, 100.0 * error,
               4.0 * touch.area / std::pow(plate.size, 2) / (face == core::ToolFace::round ? std::numbers::pi : 4.0),
               touch.sunk_in / HalfSpace::depth);
    return error;
}

} // namespace

/// Forces of a round plate with an edge of a tenth of its size, which are 0.6 % above those of a sharp one: Sneddon's,
/// and Boussinesq's 2 E* a d.
TEST(Punch, ForceOfARoundPlateIsThatOfTheClosedForms) {
    const double size = HalfSpace{.poisson = 0.3}.contact_radius();
    const RoundedPunch punch{size, 0.1 * size};
    const double rounded = punch.force(punch.phi_at(HalfSpace::depth)), sharp = 2.0 * size * HalfSpace::depth;
    EXPECT_NEAR(rounded / sharp, 1.0062, 1e-4);
    const double coarse = error_of_punch(core::ToolFace::round, 0.1, rounded, {5.0, 3.2, 2.0});
    const double fine = error_of_punch(core::ToolFace::round, 0.1, rounded, {5.0, 3.2, 2.0, 1.5});
    EXPECT_LT(std::abs(coarse), 0.05); // pressure is singular at a sharp edge, and a mesh smears it
    EXPECT_LT(std::abs(fine), 0.02);
    EXPECT_LT(std::abs(fine), 0.5 * std::abs(coarse));
    EXPECT_LT(std::abs((1.0 + fine) * rounded / sharp - 1.0), 0.03);
}

/// A square of sides L with a flat face has 0.36679 pi E* L d: the capacitance of a square plate (F. H. Read 1997,
/// Improved extrapolation technique in the boundary element method to find the capacitances of the unit square and
/// cube, J. Comput. Phys. 133), as both have a density over the distance whose sum is constant on the face.
TEST(Punch, ForceOfASquarePlateIsThatOfACapacitor) {
    const double size = HalfSpace{.poisson = 0.3}.contact_radius();
    EXPECT_LT(std::abs(error_of_punch(core::ToolFace::square, 0.02,
                                      0.36679 * std::numbers::pi * 2.0 * size * HalfSpace::depth, {5.0, 3.2, 2.0})),
              0.03);
}

/// A bar between a plate and rollers, all without friction, of a neo-Hookean material: stretched by l along it and by s
/// across, with mu (s - 1 / s) + lambda ln(l s^2) / s = 0, and the traction mu (l - 1 / l) + lambda ln(l s^2) / l.
TEST(Punch, PlateThatCoversABarPressesItEvenly) {
    const Vector3 size(0.03, 0.03, 0.1);
    const auto body = tests::make_body(tests::shaken_box_mesh(size, {2, 2, 5}), tests::soft_material);
    constexpr double stretch = 0.9;
    const double mu = tests::soft_material.shear_modulus(), lambda = tests::soft_material.lame_lambda();
    double low = 1.0, high = 1.2;
    for (int halving = 0; halving < 60; ++halving) {
        const double s = 0.5 * (low + high);
        (mu * (s - 1.0 / s) + lambda * std::log(stretch * s * s) / s < 0.0 ? low : high) = s;
    }
    const double traction =
        mu * (stretch - 1.0 / stretch) + lambda * std::log(stretch * low * low) / stretch; // on the area at rest
    for (const auto face : {core::ToolFace::round, core::ToolFace::square})
        for (const auto &kind : tests::hyperelastic_kinds) {
            auto load_case = tests::on_rollers(body->mesh);
            load_case.regime = core::Regime::large;
            load_case.touching = core::TouchingTool{.shape = {face, 0.05, 0.005, {0.0, 0.0, -1.0}},
                                                    .start = {0.015, 0.015, size.z() + 0.005},
                                                    .press = {0.0, 0.0, (stretch - 1.0) * size.z()},
                                                    .constraint = load_case.num_constraints()};
            load_case.conditions.push_back({"touch", core::ConditionKind::touch});
            const auto found = tests::touch({body, load_case}, kind, {0.5, 1.0});
            ASSERT_EQ(found.solution.status, core::SolutionStatus::ok) << found.solution.message;
            const auto &force = found.solution.reaction.back();
            EXPECT_NEAR(force.z() / (traction * size.x() * size.y()), 1.0, 0.003);
            EXPECT_LT(force.head<2>().norm(), 1e-9);
            for (std::size_t i = 0; i < body->mesh.points.size(); ++i)
                EXPECT_LT((found.solution.displacement[i] -
                           body->mesh.points[i].cwiseProduct(Vector3(low - 1.0, low - 1.0, stretch - 1.0)))
                              .norm(),
                          1e-4);
        }
}

using hyperelastic::TouchingBall;

/// Every point that the ball drags along is on the cone of friction, and so is their sum where the surface is flat.
TEST(TouchingBall, SlidesWithCoulombsForce) {
    const auto problem = tests::touched_block(0.3, {0.0, 0.0, -0.003}, {0.02, 0.0, 0.0});
    const auto found = tests::touch(problem, {.degree = 2}, {0.25, 0.5, 0.625, 0.75, 0.875, 1.0});
    ASSERT_EQ(found.solution.status, core::SolutionStatus::ok) << found.solution.message;
    const auto along = [&](std::size_t point) {
        const auto &force = found.points[point].reaction[1];
        return force.x() / -force.z();
    };
    EXPECT_GT(along(2), 0.1);
    // The normals lean by half the slope of the contact, at most.
    EXPECT_NEAR(along(5), 0.3, 0.06);
    const auto smooth =
        tests::touch(tests::touched_block(0.0, {0.0, 0.0, -0.003}, {0.02, 0.0, 0.0}), {.degree = 2}, {0.5, 1.0});
    EXPECT_NEAR(smooth.points[1].reaction[1].x() / smooth.points[1].reaction[1].z(), 0.0, 0.06);
}

/// A ball of one and a half edges sinks in by most of its radius, with friction, in three load steps. Each of them is
/// found, though points begin to touch, to stick and to slip again and again.
TEST(TouchingBall, NewtonsMethodFollowsADeepPressInFewIterations) {
    const Vector3 size(0.048, 0.048, 0.032);
    const auto body = tests::make_body(tests::shaken_box_mesh(size, {6, 6, 4}), {1060.0, 5000.0, 0.45});
    auto load_case = tests::held(body->mesh, "z_min");
    constexpr double radius = 0.012;
    load_case.touching = core::TouchingTool{.shape = radius,
                                            .start = {0.0231, 0.0253, size.z() + radius},
                                            .press = {0.0, 0.0, -0.01},
                                            .friction = 0.3,
                                            .constraint = load_case.num_constraints()};
    load_case.conditions.push_back({"touch", core::ConditionKind::touch});
    load_case.regime = core::Regime::large;
    const auto found = tests::touch({body, load_case}, {.degree = 2, .formulation = fem_reference::Formulation::mixed},
                                    {0.1, 0.3, 1.0});
    ASSERT_EQ(found.solution.status, core::SolutionStatus::ok) << found.solution.message;
    std::size_t num_solves = 0;
    for (const auto &step : found.steps) {
        EXPECT_TRUE(step.converged);
        num_solves += step.linear_iterations.size();
    }
    fmt::print("{} load steps and augmentations, {} linear solves\n", found.steps.size(), num_solves);
    EXPECT_LT(num_solves, 70);
}

/// Without augmentation the ball sinks in by what the penalty lets it, so the force errs by 1 / penalty; with it a soft
/// penalty will do.
TEST(TouchingBall, ForceConvergesWithThePenaltyAndAugmentationReplacesIt) {
    const auto problem = tests::touched_block(0.0, {0.0, 0.0, -0.004});
    const auto elements = tests::neo_hookean_elements(problem.body);
    const auto conditions = fem_reference::dof_conditions(problem.load_case, elements.system());
    const auto force = [&](const hyperelastic::ContactSettings &settings) {
        TouchingBall ball(elements.system(), *problem.body, problem.load_case, settings);
        const auto found =
            hyperelastic::follow(elements, conditions, 2, {}, {.fractions = {0.5, 1.0}, .tolerance = 1e-9}, &ball);
        EXPECT_EQ(found.status, core::SolutionStatus::ok) << found.message;
        return found.points.back().touch.force.norm();
    };
    const auto penalty = [&](double stiffness) { return force({.stiffness = stiffness, .max_augmentations = 0}); };
    const double a = penalty(10.0), b = penalty(20.0), c = penalty(40.0), limit = penalty(4000.0);
    EXPECT_LT(a, b);
    EXPECT_LT(b, c);
    EXPECT_NEAR((limit - a) / (limit - b), 2.0, 0.4);
    EXPECT_NEAR(force({.stiffness = 20.0, .sunk_in = 1e-4, .max_augmentations = 8}), limit, 0.01 * limit);
    EXPECT_LT(std::abs(force({.stiffness = 20.0, .sunk_in = 1e-4, .max_augmentations = 8}) - limit),
              0.2 * std::abs(b - limit));
}

/// The penalty lets the ball in, so that the force is that of a lesser depth: Hertz's grows with the depth to the power
/// of 1.5. Augmentation adds what is missing, and leaves a thousandth of the depth. Where elements are larger than the
/// circle of contact few points bear the ball, and more is let in.
TEST(TouchingBall, AugmentationAddsTheForceOfWhatThePenaltyLetIn) {
    double coarsest = 0.0;
    for (const int bricks_down : {2, 3, 4}) {
        constexpr double depth = 1e-3;
        const auto problem = tests::TouchedLayer{.poisson_ratio = 0.45, .bricks_down = bricks_down}.problem(depth);
        const auto elements = tests::neo_hookean_elements(problem.body);
        const auto conditions = fem_reference::dof_conditions(problem.load_case, elements.system());
        const auto touch = [&](int max_augmentations) {
            TouchingBall ball(elements.system(), *problem.body, problem.load_case,
                              {.max_augmentations = max_augmentations});
            const auto found =
                hyperelastic::follow(elements, conditions, 2, {}, {.fractions = {0.5, 1.0}, .tolerance = 1e-9}, &ball);
            EXPECT_EQ(found.status, core::SolutionStatus::ok) << found.message;
            return found.points.back().touch;
        };
        const auto penalty = touch(0), augmented = touch(hyperelastic::ContactSettings{}.max_augmentations);
        const double added = augmented.force.norm() / penalty.force.norm() - 1.0;
        const double missing = 1.5 * penalty.sunk_in / depth, left = 1.5 * augmented.sunk_in / depth;
        const auto facet = core::touched_facets(*problem.body, problem.load_case).front();
        fmt::print(
            "circle of contact {:.2f} edges: augmentation adds {:.2f} % of force, let in {:.2f} %, left {:.2f} %\n",
            core::circle_of_contact(*problem.load_case.touching, 1.0) / facet.side, 100.0 * added, 100.0 * missing,
            100.0 * left);
        EXPECT_NEAR(added, missing - left, 0.3 * missing);
        EXPECT_LT(left, 2e-3);
        coarsest = std::max(coarsest, added);
    }
    EXPECT_LT(coarsest, 0.06);
}

} // namespace livermark
