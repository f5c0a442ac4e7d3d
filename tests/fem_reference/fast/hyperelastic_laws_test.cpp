#include <gtest/gtest.h>

#include <cmath>
#include <fmt/format.h>
#include <string>
#include <vector>

#include "core/error_norms.hpp"
#include "fem_reference/hyperelastic/hyperelasticity.hpp"
#include "fem_reference/linear/linear_elasticity.hpp"
#include "tests/fem_reference/hyperelastic_bodies.hpp"

namespace livermark {

namespace {

using core::Vector3;
using fem_reference::Formulation;
using tests::free_component;

/// A law of the library that is one term of Ogden's with an exponent a; that of the neo-Hookean law is 2.
struct OgdenOnPath {
    std::string name;
    double exponent;

    const hyperelastic::MaterialLaw &law() const { return hyperelastic::material_law(name); }

    /// The first Piola-Kirchhoff stress along a principal axis,
    ///     P = 2 mu / a (l^(a - 1) - 1 / l) + lambda ln J / l [Pa].
    double principal_stress(double stretch, double jacobian) const {
        return 2.0 * tests::soft_material.shear_modulus() / exponent *
                   (std::pow(stretch, exponent - 1.0) - 1.0 / stretch) +
               tests::soft_material.lame_lambda() * std::log(jacobian) / stretch;
    }
};

class HyperelasticPathOfOgden : public testing::TestWithParam<OgdenOnPath> {};

/// Parameter: every law of the library.
class HyperelasticPathOfLaw : public testing::TestWithParam<hyperelastic::MaterialLaw> {};

/// The zero of a function that grows, by bisection to the last bit.
template <class Function> double zero_of(const Function &function, double low, double high) {
    for (int i = 0; i < 200; ++i) {
        const double middle = 0.5 * (low + high);
        (function(middle) < 0.0 ? low : high) = middle;
    }
    return low;
}

} // namespace

/// Stretched along one axis, with sides that are free: their stretch is the one without stress across.
TEST_P(HyperelasticPathOfOgden, UniaxialStretchIsExact) {
    const auto body = tests::soft_block();
    const auto &size = tests::block_size;
    for (const double stretch : {0.6, 1.5}) {
        const double side =
            zero_of([&](double t) { return GetParam().principal_stress(t, stretch * t * t); }, 0.3, 3.0);
        const double stress = GetParam().principal_stress(stretch, stretch * side * side);
        auto load_case = tests::on_rollers(body->mesh);
        tests::prescribe(load_case, body->mesh, "x_max", {(stretch - 1.0) * size.x(), free_component, free_component});
        for (const auto &kind : tests::hyperelastic_kinds) {
            const auto found = hyperelastic::solve({body, load_case}, GetParam().law(), kind, {.tolerance = 1e-12});
            ASSERT_EQ(found.solution.status, core::SolutionStatus::ok) << found.solution.message;
            ASSERT_EQ(found.points.size(), 5U);
            std::vector<Vector3> expected;
            for (const auto &x : body->mesh.points)
                expected.emplace_back((stretch - 1.0) * x.x(), (side - 1.0) * x.y(), (side - 1.0) * x.z());
            EXPECT_LT(tests::relative_difference(found.solution.displacement, expected), 1e-12);
            EXPECT_NEAR(found.solution.reaction[3].x(), stress * size.y() * size.z(),
                        1e-12 * std::abs(stress) * size.y() * size.z());
            EXPECT_NEAR(found.points.back().smallest_jacobian, stretch * side * side, 1e-12);
        }
    }
}

/// Under the same pressure p from all sides a body shrinks by s in each direction, with P(s) = -p s^2; a dead pressure
/// is per area at rest and has no s^2.
TEST_P(HyperelasticPathOfOgden, FollowerPressureActsOnTheDeformedArea) {
    const auto body = tests::soft_block();
    const double p = 4000.0;
    const double side =
        zero_of([&](double s) { return GetParam().principal_stress(s, s * s * s) + p * s * s; }, 0.3, 3.0);
    ASSERT_LT(side, 0.95);
    std::vector<double> pressure;
    for (const int patch : body->mesh.boundary_patch)
        pressure.push_back(body->mesh.patch_names[patch].ends_with("max") ? p : 0.0);
    std::vector<Vector3> expected;
    for (const auto &x : body->mesh.points)
        expected.emplace_back((side - 1.0) * x);
    for (const auto &kind : tests::hyperelastic_kinds) {
        const auto found = hyperelastic::solve({body, tests::on_rollers(body->mesh)}, GetParam().law(), kind,
                                               {.tolerance = 1e-13}, pressure);
        ASSERT_EQ(found.solution.status, core::SolutionStatus::ok) << found.solution.message;
        EXPECT_LT(tests::relative_difference(found.solution.displacement, expected), 1e-12);
    }
}

/// As the load goes to zero, so does the difference from linear elements of the same kind, over the solution in
/// proportion to the load.
TEST_P(HyperelasticPathOfLaw, IsLinearElasticityUnderSmallLoads) {
    const tests::Bar bar;
    for (const auto &kind : tests::hyperelastic_kinds) {
        fem_reference::StaticSolver linear(bar.body, kind.degree, fem_reference::SolverChoice::automatic,
                                           kind.formulation);
        const auto difference = [&](double traction) {
            const auto load_case = bar.pulled({0.0, 0.5 * traction, traction});
            const auto large = hyperelastic::solve({bar.body, load_case}, GetParam(), kind);
            const auto small = linear.solve(load_case);
            EXPECT_EQ(large.solution.status, core::SolutionStatus::ok) << large.solution.message;
            const auto comparison = core::compare(bar.body->mesh, load_case, small, large.solution, "hyperelastic");
            EXPECT_NEAR(large.solution.nonlinearity, comparison.relative_l2, 1e-6 + 1e-3 * comparison.relative_l2);
            return comparison.relative_l2;
        };
        const double at_one = difference(1.0), at_tenth = difference(0.1);
        RecordProperty(fmt::format("differences_of_degree_{}_{}", kind.degree, kind.formulation == Formulation::mixed),
                       fmt::format("{:.3e} {:.3e}", at_one, at_tenth));
        EXPECT_LT(at_tenth, 3e-3);
        EXPECT_NEAR(at_one / at_tenth, 10.0, 1.0);
    }
}

/// The mark of a consistent tangent: what is out of balance is squared by each iteration, until rounding. A block is
/// pulled and sheared by a third, under a dead load, and pressed under a pressure that follows its side, whose load
/// stiffness is not symmetric.
TEST_P(HyperelasticPathOfLaw, NewtonConvergesQuadratically) {
    const auto body = tests::soft_block();
    const auto &mesh = body->mesh;
    auto clamped = tests::empty_load_case(mesh);
    tests::prescribe(clamped, mesh, "x_min", Vector3::Zero());
    auto pulled = clamped;
    tests::pull(pulled, mesh, "x_max", {1500.0, 500.0, 0.0});
    const auto none = std::vector<double>{};
    const auto pressed = tests::pressure_on(mesh, "x_max", 1000.0);
    for (const auto *const pressure : {&none, &pressed})
        for (const auto &kind : tests::hyperelastic_kinds) {
            const auto found = hyperelastic::solve({body, pressure->empty() ? pulled : clamped}, GetParam(), kind,
                                                   {.fractions = {0.5, 1.0}, .tolerance = 1e-12}, *pressure);
            ASSERT_EQ(found.solution.status, core::SolutionStatus::ok) << found.solution.message;
            EXPECT_GT(tests::largest(found.solution.displacement), 0.015);
            for (const auto &step : found.steps) {
                ASSERT_TRUE(step.converged);
                const auto &r = step.residuals;
                const auto residuals = fmt::format("{:.1e}", fmt::join(r, " "));
                const auto name =
                    fmt::format("residuals_{}_{}_{}_{}", pressure->empty() ? "dead" : "follower", kind.degree,
                                kind.formulation == Formulation::mixed ? "mixed" : "", step.fraction);
                RecordProperty(name, residuals);
                fmt::print("{} {}: {}\n", GetParam().name, name, residuals);
                EXPECT_LE(r.size(), 7U);
                for (std::size_t k = 0; k + 1 < r.size(); ++k)
                    if (r[k] < 1e-2) {
                        EXPECT_LT(r[k + 1], std::max(10.0 * r[k] * r[k], 1e-12)) << residuals;
                    }
            }
        }
}

INSTANTIATE_TEST_SUITE_P(Laws, HyperelasticPathOfOgden,
                         testing::Values(OgdenOnPath{"neo_hookean", 2.0}, OgdenOnPath{"ogden", 5.4067}),
                         [](const auto &info) { return info.param.name; });

INSTANTIATE_TEST_SUITE_P(Laws, HyperelasticPathOfLaw, testing::ValuesIn(hyperelastic::all_materials()),
                         [](const auto &info) { return info.param.name; });

} // namespace livermark
