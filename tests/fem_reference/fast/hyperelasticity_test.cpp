#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <numbers>
#include <random>

#include "core/error_norms.hpp"
#include "fem_reference/dynamics/relaxing_solver.hpp"
#include "fem_reference/hyperelastic/hyperelasticity.hpp"
#include "meshes/generators/box_generator.hpp"
#include "tests/fem_reference/fem_test_bodies.hpp"
#include "tests/fem_reference/hyperelastic_bodies.hpp"
#include "tests/not_a_number.hpp"
#include "tests/samples/lagrange_elements.hpp"
#include "tests/samples/standing_block.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {

namespace {

using core::Vector3;
using fem_reference::Formulation;
using tests::Bar;
using tests::free_component;

const hyperelastic::MaterialLaw &neo_hookean() {
    return hyperelastic::material_law("neo_hookean");
}

} // namespace

/// A quarter turn of all that is prescribed turns the solution with it and stores nothing.
TEST(HyperelasticPath, RigidMotionStoresNothing) {
    const auto body = tests::soft_block();
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(1.5, Vector3(1.0, 1.0, 0.0).normalized()).toRotationMatrix();
    for (const auto &kind : tests::hyperelastic_kinds) {
        const auto elements = tests::neo_hookean_elements(body, kind.degree, kind.formulation);
        auto state = elements.rest();
        for (int node = 0; node < elements.system().num_nodes(); ++node)
            Vector3::Map(&state.displacement[3 * node]) =
                turn * elements.system().points[node] - elements.system().points[node];
        const auto forces = elements.internal_forces(state);
        EXPECT_LT(forces.energy, 1e-12 * tests::soft_material.young_modulus * 1e-3);
        for (const double force : forces.force)
            EXPECT_LT(std::abs(force), 1e-13 * tests::soft_material.young_modulus * 1e-2);
    }
}

/// Bent by more than its thickness in two load steps, a slender bar is harder: what is soft and what is stiff are far
/// apart. Once near, a few iterations are enough there too.
/// The mean of a pressed and a pulled block: their strains make errors in opposite directions.
TEST(HyperelasticPath, OnAFoundationGoesAsFarAsTheClosedForm) {
    namespace standing = tests::standing;
    for (const auto &kind : tests::hyperelastic_kinds) {
        const auto moved_up = [&](double top, double traction) {
            const auto problem = standing::block(top, traction);
            const auto found = hyperelastic::solve(problem, neo_hookean(), kind,
                                                   {.fractions = problem.load_case.path, .tolerance = 1e-9});
            const auto &solution = found.solution;
            EXPECT_EQ(solution.status, core::SolutionStatus::ok) << solution.message;
            EXPECT_LT(standing::out_of_balance(problem, solution.displacement, solution.reaction), 1e-6);
            return standing::moved_up(problem.body->mesh, solution.displacement);
        };
        for (const auto &[top, traction] : standing::drives) {
            const double expected = standing::expected(top, traction);
            EXPECT_NEAR(0.5 * (moved_up(top, traction) - moved_up(-top, -traction)), expected, 2e-3 * expected);
        }
    }
}

TEST(HyperelasticPath, BendsSlenderBarsInFewSteps) {
    const Bar bar;
    const auto none = std::vector<double>{};
    const auto pressed = tests::pressure_on(bar.body->mesh, "z_min", 30.0);
    for (const auto *const pressure : {&none, &pressed})
        for (const auto &kind : tests::hyperelastic_kinds) {
            const auto found =
                hyperelastic::solve({bar.body, pressure->empty() ? bar.pulled({0.0, 0.0, 60.0}) : bar.clamped},
                                    neo_hookean(), kind, {.fractions = {0.5, 1.0}, .tolerance = 1e-11}, *pressure);
            ASSERT_EQ(found.solution.status, core::SolutionStatus::ok) << found.solution.message;
            EXPECT_GT(tests::largest(found.solution.displacement), 0.01);
            ASSERT_EQ(found.steps.size(), 2U);
            for (const auto &step : found.steps) {
                const auto &r = step.residuals;
                const auto near = std::ranges::find_if(r, [](double value) { return value < 1e-3; });
                EXPECT_LE(r.end() - near, 4) << fmt::format("{:.1e}", fmt::join(r, " "));
            }
        }
}

/// A press to a depth is a load: the one that it reports, at each part of the way.
TEST(HyperelasticPath, PressesWithTheForceThatMovesAsFar) {
    const Bar bar;
    const Vector3 direction = Vector3(1.0, -1.0, 4.0).normalized();
    auto pressed = bar.clamped;
    tests::press(pressed, bar.body->mesh, "x_max", direction, 0.03);
    for (const auto &kind : tests::hyperelastic_kinds) {
        const auto found = hyperelastic::solve({bar.body, pressed}, neo_hookean(), kind,
                                               {.fractions = {0.5, 1.0}, .tolerance = 1e-10});
        ASSERT_EQ(found.solution.status, core::SolutionStatus::ok) << found.solution.message;
        ASSERT_EQ(found.points.size(), 2U);
        EXPECT_EQ(found.steps.size(), 2U);
        for (const auto &point : found.points) {
            const double force = point.reaction[1].norm();
            EXPECT_LT((point.reaction[1] - force * direction).norm(), 1e-12 * force);
            EXPECT_LT((point.reaction[0] + point.reaction[1]).norm(), 1e-8 * force);
            const auto expected =
                hyperelastic::solve({bar.body, bar.pulled(force / (0.03 * 0.03) * direction)}, neo_hookean(), kind,
                                    {.fractions = {0.5, 1.0}, .tolerance = 1e-10});
            ASSERT_EQ(expected.solution.status, core::SolutionStatus::ok) << expected.solution.message;
            EXPECT_LT(tests::relative_difference(point.displacement, expected.solution.displacement), 1e-6);
        }
        EXPECT_GT(found.solution.nonlinearity, 0.05);
        for (const auto &step : found.steps)
            EXPECT_LE(step.residuals.size(), 9U) << fmt::format("{:.1e}", fmt::join(step.residuals, " "));
    }
}

/// Neighbouring solutions of one energy: where nothing locks, displacements alone and the mixed formulation agree.
TEST(HyperelasticPath, MixedElementsAgreeWithDisplacementsAlone) {
    const auto body = tests::make_body(tests::shaken_box_mesh({0.1, 0.03, 0.03}, {6, 3, 3}), {1000.0, 5000.0, 0.35});
    auto load_case = tests::held(body->mesh);
    tests::prescribe(load_case, body->mesh, "x_max", {0.02, 0.0, 0.03});
    const auto alone = hyperelastic::solve({body, load_case}, neo_hookean(), tests::hyperelastic_kinds[1]);
    const auto mixed = hyperelastic::solve({body, load_case}, neo_hookean(), tests::hyperelastic_kinds[2]);
    ASSERT_EQ(alone.solution.status, core::SolutionStatus::ok) << alone.solution.message;
    ASSERT_EQ(mixed.solution.status, core::SolutionStatus::ok) << mixed.solution.message;
    const auto comparison = core::compare(body->mesh, load_case, alone.solution, mixed.solution, "mixed");
    EXPECT_LT(comparison.relative_l2, 5e-3);
    EXPECT_LT(comparison.reaction_error, 2e-2);
    for (const auto *const solution : {&alone, &mixed})
        for (const auto &point : solution->points) // without other loads, the ends pull against each other
            EXPECT_LT((point.reaction[0] + point.reaction[1]).norm(), 1e-8 * point.reaction[0].norm());
}

/// A path says what it cannot reach: a bar that is pushed to less than nothing.
TEST(HyperelasticPath, GivesUpAndSaysSo) {
    const auto body = tests::soft_block();
    auto load_case = tests::on_rollers(body->mesh);
    tests::prescribe(load_case, body->mesh, "x_max", {-0.11, 0.0, 0.0});
    const auto found = hyperelastic::solve({body, load_case}, neo_hookean(), tests::hyperelastic_kinds[0]);
    EXPECT_EQ(found.solution.status, core::SolutionStatus::not_converged);
    EXPECT_NE(found.solution.message.find("finds no equilibrium beyond"), std::string::npos) << found.solution.message;
    ASSERT_FALSE(found.points.empty());
    EXPECT_LT(found.points.back().fraction, 1.0);
    EXPECT_GT(found.points.back().smallest_jacobian, 0.0);
    EXPECT_EQ(found.solution.displacement, found.points.back().displacement);
}

TEST(HyperelasticPath, RefusesWhatHasNoSolution) {
    const Bar bar;
    auto load_case = tests::empty_load_case(bar.body->mesh);
    tests::prescribe(load_case, bar.body->mesh, "x_min", {0.0, 0.0, free_component});
    const auto free = hyperelastic::solve({bar.body, load_case}, neo_hookean(), tests::hyperelastic_kinds[0]);
    EXPECT_EQ(free.solution.status, core::SolutionStatus::not_converged);
    EXPECT_NE(free.solution.message.find("free to move"), std::string::npos);
    EXPECT_TRUE(free.solution.displacement.front().hasNaN());
    const core::Problem problem{bar.body, bar.clamped};
    EXPECT_THROW(
        hyperelastic::solve(problem, neo_hookean(), tests::hyperelastic_kinds[0], {.fractions = {0.5, 0.4, 1.0}}),
        std::invalid_argument);
    EXPECT_THROW(hyperelastic::solve(problem, neo_hookean(), tests::hyperelastic_kinds[0], {.fractions = {0.5}}),
                 std::invalid_argument);
    EXPECT_THROW(hyperelastic::solve(problem, neo_hookean(), tests::hyperelastic_kinds[0], {}, std::vector{1.0}),
                 std::invalid_argument);
    const auto elements = tests::neo_hookean_elements(bar.body, 1);
    const auto conditions = fem_reference::dof_conditions(bar.clamped, elements.system());
    EXPECT_THROW(hyperelastic::follow(elements, conditions, 0, {}), std::invalid_argument)
        << "the reaction of the clamped end has no place in the result";
}

namespace {

/// Rivlin's problem of flexure: a block 0 <= X <= H, |Y| <= L / 2 of incompressible material, kept in plane strain, is
/// bent to a sector of a tube by its ends alone. With the angle per length c,
///     r^2 = a^2 + 2 X / c,   theta = c Y,   x = r cos(theta) - a,   y = r sin(theta),   z = Z,
/// and the curved sides are free of traction if a b = 1 / c^2, b^2 = a^2 + 2 H / c. Then for W = mu / 2 (I1 - 3)
///     sigma_rr = mu (c^2 (r^2 - a^2) / 2 + (1 / r^2 - 1 / a^2) / (2 c^2)),   M = - integral of r sigma_rr dr,
/// the moment of an end per width.
/// (R. S. Rivlin 1949, Large elastic deformations of isotropic materials V. The problem of flexure, Proc. R. Soc. Lond.
/// A 195, 463-473)
struct Flexure {
    double height = 0.02, length = 0.06;        ///< H, L [m]
    double c = std::numbers::pi / 2.0 / length; ///< by a quarter turn
    double a = std::sqrt(std::hypot(height / c, 1.0 / (c * c)) - height / c);
    double b = std::sqrt(a * a + 2.0 * height / c);

    Vector3 displacement(const Vector3 &x) const {
        const double r = std::sqrt(a * a + 2.0 * x.x() / c), theta = c * (x.y() - 0.5 * length);
        return Vector3(r * std::cos(theta) - a, r * std::sin(theta) + 0.5 * length, x.z()) - x;
    }
    Eigen::Matrix3d gradient(const Vector3 &x) const {
        const double r = std::sqrt(a * a + 2.0 * x.x() / c), theta = c * (x.y() - 0.5 * length);
        Eigen::Matrix3d f;
        f << std::cos(theta) / (c * r), -c * r * std::sin(theta), 0.0, //
            std::sin(theta) / (c * r), c * r * std::cos(theta), 0.0,   //
            0.0, 0.0, 1.0;
        return f - Eigen::Matrix3d::Identity();
    }
    /// [N m / m]
    double moment(double mu) const {
        const double a2 = a * a, b2 = b * b, c2 = c * c;
        return -mu * (c2 / 2.0 * ((b2 * b2 - a2 * a2) / 4.0 - a2 * (b2 - a2) / 2.0) +
                      (std::log(b / a) - (b2 - a2) / (2.0 * a2)) / (2.0 * c2));
    }
    /// [J / m]
    double energy(double mu) const {
        const double a2 = a * a, b2 = b * b;
        return 0.5 * mu * length * c * (c * c * (b2 * b2 - a2 * a2) / 4.0 + std::log(b / a) / (c * c) - (b2 - a2));
    }
};

struct Outcome {
    tests::RelativeError error;
    double moment = 0.0; ///< over the exact one
    double energy = 0.0;
};

Outcome bend(Formulation formulation, double edge) {
    const Flexure exact;
    const double width = 0.01;
    const core::Material material{1000.0, 5000.0, 0.4999};
    const auto body = tests::make_body(meshes::generate_box({exact.height, exact.length, width}, edge), material);
    const auto elements = tests::neo_hookean_elements(body, 2, formulation);
    const auto &system = elements.system();
    auto conditions = tests::no_conditions(system);
    const auto is_at = [](double value, double wanted) { return std::abs(value - wanted) < 1e-9; };
    for (int node = 0; node < system.num_nodes(); ++node) {
        const Vector3 &x = system.points[node];
        if (is_at(x.z(), 0.0) || is_at(x.z(), width))
            conditions.prescribed[3 * node + 2] = 0.0;
        if (is_at(x.y(), 0.0) || is_at(x.y(), exact.length))
            Vector3::Map(&conditions.prescribed[3 * node]) = exact.displacement(x);
    }
    const auto path = hyperelastic::follow(elements, conditions, 0, {}, {.fractions = {0.25, 0.5, 0.75, 1.0}});
    EXPECT_EQ(path.status, core::SolutionStatus::ok) << path.message;
    if (path.status != core::SolutionStatus::ok)
        return {};
    const auto &end = path.points.back();
    const auto force = elements.internal_forces(end.state).force;
    double moment = 0.0; // about the axis of the tube
    for (int node = 0; node < system.num_nodes(); ++node)
        if (is_at(system.points[node].y(), exact.length)) {
            const Vector3 arm = system.points[node] + Vector3::Map(&end.state.displacement[3 * node]) +
                                Vector3(exact.a, -0.5 * exact.length, 0.0);
            moment += arm.cross(Vector3::Map(&force[3 * node])).z();
        }
    const double mu = material.shear_modulus();
    const tests::ElasticField field{[&](const Vector3 &x) { return exact.displacement(x); },
                                    [&](const Vector3 &x) { return exact.gradient(x); },
                                    {}};
    return {tests::relative_error(system, end.state.displacement, field), moment / (exact.moment(mu) * width),
            end.strain_energy / (exact.energy(mu) * width)};
}

} // namespace

/// Poisson's ratio of 0.4999 is compressible by 2e-4 of the strains, and the solution is that near. Displacements alone
/// lock: the same mesh is ten times as far off.
TEST(HyperelasticFlexure, MixedElementsBendAsRivlinSays) {
    const Flexure exact;
    EXPECT_NEAR(exact.a * exact.b * exact.c * exact.c, 1.0, 1e-14);
    const auto coarse = bend(Formulation::mixed, 0.010), fine = bend(Formulation::mixed, 0.006);
    const auto locked = bend(Formulation::displacement, 0.010);
    EXPECT_LT(fine.error.l2, 2e-3);
    EXPECT_LT(fine.error.l2, 0.5 * coarse.error.l2);
    EXPECT_NEAR(fine.moment, 1.0, 5e-3);
    EXPECT_NEAR(fine.energy, 1.0, 5e-3);
    EXPECT_GT(locked.error.h1, 2.0 * coarse.error.h1);
}

namespace {

using hyperelastic::Matrix3;

constexpr double newton_tolerance = 1e-10;

Matrix3 random_matrix(std::mt19937 &generator, double size) {
    std::uniform_real_distribution<double> number(-size, size);
    Matrix3 matrix;
    for (double &entry : matrix.reshaped())
        entry = number(generator);
    return matrix;
}

/// A cube on rollers that is stretched in a second, and held.
core::Problem cube_held_stretched(double strain) {
    const auto mesh = tests::box_mesh({0.1, 0.1, 0.1}, {1, 1, 1});
    auto load_case = tests::empty_load_case(mesh);
    load_case.regime = core::Regime::large;
    tests::prescribe(load_case, mesh, "x_min", {0.0, tests::nan, tests::nan});
    tests::prescribe(load_case, mesh, "y_min", {tests::nan, 0.0, tests::nan});
    tests::prescribe(load_case, mesh, "z_min", {tests::nan, tests::nan, 0.0});
    tests::prescribe(load_case, mesh, "x_max", {0.1 * strain, tests::nan, tests::nan});
    load_case.slow_history = {.relaxation = {.name = "two", .moduli = {0.3, 0.4}, .times = {0.4, 7.0}},
                              .times = {0.0, 0.25, 0.5, 0.75, 1.0, 2.0, 4.0, 8.0, 30.0},
                              .factors = {0.0, 0.25, 0.5, 0.75, 1.0, 1.0, 1.0, 1.0, 1.0}};
    return {tests::make_body(mesh, {1060.0, 5000.0, 0.45}), load_case};
}

core::Solution solve_slowly(const core::Problem &problem, const hyperelastic::Discretisation &discretisation) {
    return hyperelastic::solve_history(problem, hyperelastic::material_law("neo_hookean"), discretisation,
                                       newton_tolerance);
}

const std::array<hyperelastic::Discretisation, 3> relaxing_elements{
    {{.degree = 1}, {.degree = 2}, {.degree = 2, .formulation = Formulation::mixed}}};

} // namespace

TEST(IsochoricPart, HasTheDerivativesOfItsEnergy) {
    const auto &material = tests::soft_material;
    std::mt19937 generator(7);
    for (const auto &law : hyperelastic::all_materials()) {
        const Matrix3 f = Matrix3::Identity() + random_matrix(generator, 0.25);
        const Matrix3 half = random_matrix(generator, 900.0);
        const Matrix3 remembered = half + half.transpose();
        const hyperelastic::IsochoricPart part{law, material, 0.6, remembered};
        const auto stress = part.stress(f);
        const auto tangent = part.tangent(f);
        constexpr double step = 1e-6;
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) {
                Matrix3 more = f, less = f;
                more(i, j) += step;
                less(i, j) -= step;
                EXPECT_NEAR((part.energy(more) - part.energy(less)) / (2.0 * step), stress(i, j), 1e-4) << law.name;
                const Matrix3 slope = (part.stress(more) - part.stress(less)) / (2.0 * step);
                for (int k = 0; k < 3; ++k)
                    for (int l = 0; l < 3; ++l)
                        EXPECT_NEAR(slope(k, l), tangent(3 * k + l, 3 * i + j), 1e-3) << law.name;
            }
        EXPECT_NEAR(stress.cwiseProduct(f).sum(), 0.0, 1e-9) << "no pressure is in it";
    }
}

TEST(RelaxingHyperelasticity, IsLinearAtSmallStrains) {
    constexpr double strain = 1e-5;
    const auto problem = cube_held_stretched(strain);
    fem_reference::StaticSolver solver(problem.body, 2);
    const auto linear = fem_reference::RelaxingSolver(problem.body, solver, fem_reference::SolverChoice::automatic)
                            .solve(problem.load_case, 1);
    for (const auto &elements : relaxing_elements) {
        const auto solution = solve_slowly(problem, elements);
        ASSERT_EQ(solution.status, core::SolutionStatus::ok) << solution.message;
        ASSERT_EQ(solution.path.size(), linear.path.size());
        for (std::size_t k = 1; k < linear.path.size(); ++k) {
            const double expected = linear.path[k].reaction.back().x();
            EXPECT_NEAR(solution.path[k].reaction.back().x(), expected, 20.0 * strain * expected);
            EXPECT_NEAR(solution.path[k].work, linear.path[k].work, 20.0 * strain * linear.path[k].work);
            EXPECT_NEAR(solution.path[k].strain_energy, linear.path[k].strain_energy,
                        20.0 * strain * linear.path[k].strain_energy);
            EXPECT_NEAR(solution.path[k].dissipated_energy, linear.path[k].dissipated_energy,
                        20.0 * strain * linear.path[k].strain_energy);
        }
    }
}

TEST(RelaxingHyperelasticity, InfiniteTimesAreTheElasticBody) {
    auto problem = cube_held_stretched(0.3);
    problem.load_case.slow_history->relaxation.times = {std::numeric_limits<double>::infinity(),
                                                        std::numeric_limits<double>::infinity()};
    for (const auto &elements : relaxing_elements) {
        const auto elastic = hyperelastic::solve(problem, hyperelastic::material_law("neo_hookean"), elements,
                                                 {.fractions = {0.25, 0.5, 0.75, 1.0}, .tolerance = newton_tolerance});
        const auto solution = solve_slowly(problem, elements);
        ASSERT_EQ(solution.status, core::SolutionStatus::ok) << solution.message;
        for (std::size_t k = 1; k < solution.path.size(); ++k)
            EXPECT_LT(tests::relative_difference(solution.path[k].reaction,
                                                 elastic.points[std::min<std::size_t>(k, 4) - 1].reaction),
                      1e-7);
        EXPECT_LT(tests::relative_difference(solution.displacement, elastic.solution.displacement), 1e-7);
    }
}

/// All nodes are held in a large deformation, so that what is remembered fades as exp(-t / tau).
TEST(RelaxingHyperelasticity, FadesExponentiallyInAHeldShape) {
    auto problem = cube_held_stretched(0.0);
    const auto &mesh = problem.body->mesh;
    problem.load_case = tests::empty_load_case(mesh);
    for (const auto *side : {"x_min", "x_max", "y_min", "y_max", "z_min", "z_max"})
        tests::prescribe(problem.load_case, mesh, side, Vector3::Zero());
    Matrix3 gradient;
    gradient << 0.3, 0.2, 0.0, 0.0, -0.1, 0.1, 0.0, 0.0, 0.05;
    for (const auto &point : mesh.points)
        problem.load_case.node_shift.emplace_back(gradient * point);
    problem.load_case.regime = core::Regime::large;
    constexpr double tau = 3.0;
    problem.load_case.slow_history = {.relaxation = {.name = "one", .moduli = {0.7}, .times = {tau}},
                                      .times = {0.0, 0.5, 1.0, 3.0, 5.0, 7.0},
                                      .factors = {0.0, 0.5, 1.0, 1.0, 1.0, 1.0}};
    const auto solution = solve_slowly(problem, relaxing_elements[1]);
    ASSERT_EQ(solution.status, core::SolutionStatus::ok) << solution.message;
    const auto force = [&](std::size_t k) { return solution.path[k].reaction[1]; };
    for (std::size_t k = 2; k < 4; ++k) {
        const Vector3 first = force(k) - force(k + 1), next = force(k + 1) - force(k + 2);
        EXPECT_LT((next - std::exp(-2.0 / tau) * first).norm(), 1e-8 * first.norm());
        EXPECT_GT(first.norm(), 0.01 * force(k).norm());
    }
}

} // namespace livermark
