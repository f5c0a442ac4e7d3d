#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "fem_reference/hyperelastic/hyperelasticity.hpp"
#include "fem_reference/linear/linear_elasticity.hpp"
#include "tests/fem_reference/hyperelastic_bodies.hpp"
#include "tests/samples/bodies_with_vessels.hpp"
#include "tests/samples/covered_bodies.hpp"

namespace livermark {
namespace {

using core::Vector3;
using fem_reference::Formulation;
using fem_reference::SolverChoice;
namespace covered = tests::covered;

core::Solution linear(const core::Problem &problem, const hyperelastic::Discretisation &kind) {
    return fem_reference::solve_static(problem, kind.degree, SolverChoice::automatic, kind.formulation);
}

hyperelastic::PathSolution hyperelastic_solution(const core::Problem &problem, const hyperelastic::Discretisation &kind,
                                                 const std::vector<double> &pressure = {}) {
    return hyperelastic::solve(problem, hyperelastic::material_law("neo_hookean"), kind, {.fractions = {0.5, 1.0}},
                               pressure);
}

} // namespace

/// The patch test: on every kind of elements a strain that is the same everywhere stores what the closed form says.
TEST(Capsule, StoresTheEnergyOfAnEvenStrain) {
    const auto bare = tests::soft_block();
    const auto body = covered::with_capsule(bare);
    const Eigen::Matrix3d f = Eigen::Matrix3d::Identity() + covered::some_strain();
    for (const auto &kind : tests::hyperelastic_kinds) {
        const double small = linear(covered::deformed(body, f), kind).strain_energy -
                             linear(covered::deformed(bare, f), kind).strain_energy;
        const double expected = covered::small_capsule_energy(*body, covered::some_strain());
        EXPECT_NEAR(small, expected, 1e-9 * expected) << kind.degree;
        const double large = hyperelastic_solution(covered::deformed(body, f), kind).solution.strain_energy -
                             hyperelastic_solution(covered::deformed(bare, f), kind).solution.strain_energy;
        const double large_energy = covered::capsule_energy(*body, f);
        EXPECT_NEAR(large, large_energy, 1e-9 * large_energy) << kind.degree;
    }
}

/// Forces and stiffness of elements with a capsule and vessels are derivatives of their energy.
TEST(Capsule, HasTheDerivativesOfItsEnergyAsVesselsHave) {
    const auto body = covered::with_capsule(tests::vessels::with_vessels(tests::soft_block()));
    for (const auto &kind : tests::hyperelastic_kinds) {
        const auto elements = tests::neo_hookean_elements(body, kind.degree);
        auto state = elements.rest();
        std::vector<double> direction(state.displacement.size());
        for (std::size_t i = 0; i < direction.size(); ++i) {
            state.displacement[i] = 1e-3 * std::sin(1.7 * static_cast<double>(i));
            direction[i] = std::cos(2.3 * static_cast<double>(i));
        }
        const auto moved = [&](double step) {
            auto there = state;
            for (std::size_t i = 0; i < direction.size(); ++i)
                there.displacement[i] += step * direction[i];
            return elements.internal_forces(there);
        };
        constexpr double step = 1e-6;
        const auto ahead = moved(step), behind = moved(-step), here = moved(0.0);
        double work = 0.0, size = 0.0;
        for (std::size_t i = 0; i < direction.size(); ++i) {
            work += here.force[i] * direction[i];
            size += here.force[i] * here.force[i];
        }
        EXPECT_NEAR((ahead.energy - behind.energy) / (2.0 * step), work, 1e-6 * std::sqrt(size));
        auto tangent = elements.zero_tangent();
        elements.assemble_tangent(state, tangent);
        std::vector<double> product(direction.size());
        tangent.stiffness.multiply(direction, product);
        double difference = 0.0, whole = 0.0;
        for (std::size_t i = 0; i < direction.size(); ++i) {
            const double expected = (ahead.force[i] - behind.force[i]) / (2.0 * step);
            difference += (product[i] - expected) * (product[i] - expected);
            whole += expected * expected;
        }
        EXPECT_LT(std::sqrt(difference), 1e-6 * std::sqrt(whole)) << kind.degree;
    }
}

/// A ball with a capsule under a traction along its normals grows evenly, by the closed form: the error of its facets
/// goes with the square of their size.
TEST(Capsule, HoldsABallTogether) {
    constexpr double radius = 0.03, pressure = 100.0;
    const double expected = covered::small_growth(radius, tests::soft_material, pressure);
    const double bare =
        pressure / (3.0 * (tests::soft_material.lame_lambda() + 2.0 / 3.0 * tests::soft_material.shear_modulus()));
    EXPECT_LT(expected, 0.9 * bare);
    for (const auto &kind : tests::hyperelastic_kinds) {
        const auto grown = [&](int bricks) {
            const auto problem =
                covered::blown_up_ball(radius, bricks, tests::soft_material, pressure, core::ConditionKind::traction);
            return covered::growth(problem.body->mesh, linear(problem, kind).displacement);
        };
        const auto coarse = grown(3), fine = grown(6);
        EXPECT_NEAR(fine.mean, expected, 0.025 * expected) << kind.degree;
        EXPECT_LT(std::abs(fine.mean - expected), 0.5 * std::abs(coarse.mean - expected)) << kind.degree;
        EXPECT_LT(fine.spread, 0.02 * expected) << kind.degree;
    }
}

/// The same by a tenth of its radius, with a pressure that follows the surface: with F = g I the Cauchy stress inside
/// is P / g^2 by the law, and the capsule, whose thickness goes with g^-2, has the tension E t / 3 (1 - g^-6) in a
/// sphere of radius g R.
TEST(Capsule, HoldsABallTogetherAtLargeStrains) {
    constexpr double radius = 0.03, stretch = 1.1;
    const auto &law = hyperelastic::material_law("neo_hookean");
    const hyperelastic::Matrix3 f = stretch * hyperelastic::Matrix3::Identity();
    const auto volume = law.volume(f.determinant());
    const double first_piola = law.stress(tests::soft_material, f)(0, 0) + law.volume_modulus(tests::soft_material) *
                                                                               volume.value * volume.slope *
                                                                               f.determinant() / stretch;
    const double pressure = first_piola / (stretch * stretch) + 2.0 / (stretch * radius) *
                                                                    covered::capsule.stiffness() / 3.0 *
                                                                    (1.0 - std::pow(stretch, -6.0));
    auto problem = covered::blown_up_ball(radius, 6, tests::soft_material, pressure, core::ConditionKind::pressure);
    const auto outside = [&] {
        std::vector<double> on(problem.body->mesh.boundary_triangles.size(), 0.0);
        for (int facet = 0; facet < problem.body->mesh.num_boundary_triangles(); ++facet)
            if (problem.load_case.is_loaded(facet))
                on[facet] = core::follower_pressure(problem.load_case, problem.body->mesh, facet);
        return on;
    }();
    problem.load_case = core::without_follower_pressures(problem.load_case);
    const auto found = hyperelastic_solution(problem, {.degree = 2}, outside);
    ASSERT_EQ(found.solution.status, core::SolutionStatus::ok) << found.solution.message;
    const auto grown = covered::growth(problem.body->mesh, found.solution.displacement);
    EXPECT_NEAR(grown.mean, stretch - 1.0, 0.015 * (stretch - 1.0));
}

/// A capsule on a half-space under shear tractions t sin(k x): of plane strains, a half-space resists displacements
/// U sin(k x) along its surface with mu k / (1 - nu) U, and the capsule with (4/3) E t k^2 U, because it cannot grow
/// across. What is pulled along does not move the other way, so both simply add.
TEST(Capsule, IsALayerOnAHalfSpace) {
    constexpr double length = 0.04, traction = 10.0; // half a wave
    const double wave_number = std::numbers::pi / length;
    for (const double young_modulus : {1e3, 4e3}) {
        auto bare = tests::make_body(tests::box_mesh({length, 0.0025, 2.0 * length}, {16, 1, 24}),
                                     {1000.0, young_modulus, 0.4});
        auto mesh = bare->mesh;
        for (auto &name : mesh.patch_names)
            if (name != "z_max")
                name = std::string(core::wound_patch) + core::patch_joint + name;
        const auto body = covered::with_capsule(tests::make_body(mesh, bare->materials.front()));
        auto load_case = tests::empty_load_case(mesh);
        const auto name = [](const char *side) { return std::string(core::wound_patch) + core::patch_joint + side; };
        constexpr double free = tests::free_component;
        for (const auto *const side : {"x_min", "x_max"})
            tests::prescribe(load_case, mesh, name(side), {0.0, free, free});
        for (const auto *const side : {"y_min", "y_max"})
            tests::prescribe(load_case, mesh, name(side), {free, 0.0, free});
        tests::prescribe(load_case, mesh, name("z_min"), Vector3::Zero());
        tests::pull(load_case, mesh, "z_max", {traction, 0.0, 0.0});
        for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
            if (load_case.is_loaded(f)) {
                double middle = 0.0;
                for (const int node : mesh.boundary_triangles[f])
                    middle += mesh.points[node].x() / 3.0;
                load_case.value[f].x() = traction * std::sin(wave_number * middle);
            }
        const auto solution = fem_reference::solve_static({body, load_case}, 2);
        double moved = 0.0;
        for (std::size_t i = 0; i < mesh.points.size(); ++i)
            if (mesh.points[i].z() > 2.0 * length - 1e-9)
                moved = std::max(moved, solution.displacement[i].x());
        const auto &material = body->materials.front();
        const double solid = material.shear_modulus() * wave_number / (1.0 - material.poisson_ratio),
                     layer = 4.0 / 3.0 * covered::capsule.stiffness() * wave_number * wave_number;
        const double expected = traction / (solid + layer);
        EXPECT_NEAR(moved, expected, 0.01 * expected) << young_modulus;
        EXPECT_LT(moved, 0.7 * traction / solid) << "the capsule matters";
    }
}

} // namespace livermark
