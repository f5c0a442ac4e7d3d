#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "core/error_norms.hpp"
#include "fem_reference/hyperelastic/elements.hpp"
#include "fem_reference/hyperelastic/hyperelasticity.hpp"
#include "fem_reference/hyperelastic/material_law.hpp"
#include "fem_reference/hyperelastic/surface.hpp"
#include "fem_reference/linear/linear_elasticity.hpp"
#include "fem_reference/solvers/matrices.hpp"
#include "tests/fem_reference/fem_test_bodies.hpp"
#include "tests/fem_reference/hyperelastic_bodies.hpp"
#include "tests/samples/calculix_neo_hooke.hpp"
#include "tests/samples/ogden.hpp"

namespace livermark {

namespace {

using hyperelastic::MaterialLaw;
using hyperelastic::Matrix3;
using hyperelastic::Tangent;

const core::Material &tissue = tests::soft_material;

/// Stretched, sheared and turned, with strains of up to 40 %; the second has two principal stretches in common, which
/// laws in principal stretches have to bear, the third three, and in the last, two that differ in the eighth digit.
std::vector<Matrix3> deformations() {
    const Matrix3 turn = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1.0, 2.0, 3.0).normalized()).toRotationMatrix();
    Matrix3 general;
    general << 1.3, 0.2, -0.1, 0.05, 0.8, 0.3, -0.2, 0.1, 1.1;
    return {turn * general,      turn * Eigen::Vector3d(1.3, 0.9, 0.9).asDiagonal() * turn.transpose(),
            Matrix3(1.1 * turn), Matrix3::Identity(),
            general.inverse(),   turn * Eigen::Vector3d(1.2, 1.2 + 1e-8, 0.9).asDiagonal() * turn.transpose()};
}

/// Fourth order central difference along an entry of F.
template <class Function> auto slope(const Function &function, const Matrix3 &f, int i, int j) {
    constexpr double h = 1e-3;
    const auto at = [&](double step) {
        Matrix3 moved = f;
        moved(i, j) += step;
        return function(moved);
    };
    return ((8.0 * (at(h) - at(-h)) - (at(2.0 * h) - at(-2.0 * h))) / (12.0 * h));
}

class HyperelasticMaterial : public testing::TestWithParam<MaterialLaw> {};

std::vector<MaterialLaw> laws() {
    const auto all = hyperelastic::all_materials();
    std::vector<MaterialLaw> result(all.begin(), all.end());
    result.push_back(tests::calculix_neo_hooke());
    for (const auto &ogden : tests::ogden_laws())
        result.push_back(ogden.law);
    return result;
}

/// P = dW / dF with the volume term.
Matrix3 whole_stress(const MaterialLaw &law, const Matrix3 &f) {
    const auto volume = law.volume(f.determinant());
    return law.stress(tissue, f) +
           law.volume_modulus(tissue) * volume.value * volume.slope * f.determinant() * f.inverse().transpose();
}

} // namespace

TEST_P(HyperelasticMaterial, StressIsTheDerivativeOfTheEnergy) {
    const auto &law = GetParam();
    for (const auto &f : deformations()) {
        Matrix3 expected;
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                expected(i, j) = slope([&](const Matrix3 &g) { return law.energy(tissue, g); }, f, i, j);
        EXPECT_LT((law.stress(tissue, f) - expected).norm(), 1e-7 * tissue.young_modulus);
    }
}

TEST_P(HyperelasticMaterial, TangentIsTheDerivativeOfTheStress) {
    const auto &law = GetParam();
    for (const auto &f : deformations()) {
        const auto tangent = law.tangent(tissue, f);
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) {
                const Matrix3 expected =
                    slope([&](const Matrix3 &g) -> Matrix3 { return law.stress(tissue, g); }, f, i, j);
                for (int k = 0; k < 3; ++k)
                    for (int l = 0; l < 3; ++l)
                        EXPECT_NEAR(tangent(3 * k + l, 3 * i + j), expected(k, l), 1e-7 * tissue.young_modulus);
            }
        EXPECT_LT((tangent - tangent.transpose()).norm(), 1e-13 * tangent.norm());
    }
}

TEST_P(HyperelasticMaterial, VolumeMeasureHasItsDerivatives) {
    const auto &law = GetParam();
    EXPECT_EQ(law.volume(1.0).value, 0.0);
    EXPECT_EQ(law.volume(1.0).slope, 1.0);
    for (const double jacobian : {0.5, 0.9, 1.4}) {
        constexpr double h = 1e-4;
        const auto low = law.volume(jacobian - h), high = law.volume(jacobian + h), here = law.volume(jacobian);
        EXPECT_NEAR((high.value - low.value) / (2.0 * h), here.slope, 1e-6);
        EXPECT_NEAR((high.slope - low.slope) / (2.0 * h), here.curvature, 1e-6);
    }
}

TEST_P(HyperelasticMaterial, DoesNotSeeRotations) {
    const auto &law = GetParam();
    const Matrix3 turn = Eigen::AngleAxisd(1.9, Eigen::Vector3d(3.0, -1.0, 2.0).normalized()).toRotationMatrix();
    for (const auto &f : deformations()) {
        EXPECT_NEAR(law.energy(tissue, turn * f), law.energy(tissue, f), 1e-12 * tissue.young_modulus);
        EXPECT_LT((law.stress(tissue, turn * f) - turn * law.stress(tissue, f)).norm(), 1e-12 * tissue.young_modulus);
        EXPECT_NEAR(law.energy(tissue, f * turn), law.energy(tissue, f), 1e-12 * tissue.young_modulus);
    }
}

/// At rest there is no stress, and small strains have that of Hooke's law, whose Lame parameters are the tissue's.
TEST_P(HyperelasticMaterial, IsLinearElasticityForSmallStrains) {
    const auto &law = GetParam();
    const Matrix3 rest = Matrix3::Identity();
    EXPECT_LT(law.stress(tissue, rest).norm(), 1e-12 * tissue.young_modulus);
    EXPECT_NEAR(law.energy(tissue, rest), 0.0, 1e-12 * tissue.young_modulus);
    auto tangent = law.tangent(tissue, rest);
    hyperelastic::add_volume_tangent(0.0, law.volume_modulus(tissue), 1.0, rest, tangent);
    const double lambda = tissue.lame_lambda(), mu = tissue.shear_modulus();
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            for (int k = 0; k < 3; ++k)
                for (int l = 0; l < 3; ++l) {
                    const double hooke = (i == j && k == l ? lambda : 0.0) + (i == k && j == l ? mu : 0.0) +
                                         (i == l && j == k ? mu : 0.0);
                    EXPECT_NEAR(tangent(3 * i + j, 3 * k + l), hooke, 1e-11 * lambda);
                }
}

/// Under tension and pressure along one axis the stress along it is, with the sides free,
///     P = 2 mu / a (s^(a - 1) - 1 / s) + lambda ln(s t^2) / s,   2 mu / a (t^a - 1) + lambda ln(s t^2) = 0,
/// and so P s = 2 mu / a (s^a - t^a). The second equation gives s by t.
TEST(HyperelasticMaterials, OgdenUniaxialStressIsThatOfTheClosedForm) {
    const double mu = tissue.shear_modulus(), lambda = tissue.lame_lambda();
    auto laws = tests::ogden_laws();
    laws.push_back({5.4067, hyperelastic::material_law("ogden")});
    for (const auto &[a, law] : laws)
        for (const double t : {0.85, 1.15}) {
            const double s = std::exp(-2.0 * mu / (a * lambda) * (std::pow(t, a) - 1.0)) / (t * t);
            const Matrix3 f = Eigen::Vector3d(s, t, t).asDiagonal();
            Matrix3 expected = Matrix3::Zero();
            expected(0, 0) = 2.0 * mu / a * (std::pow(s, a) - std::pow(t, a)) / s;
            EXPECT_LT((whole_stress(law, f) - expected).norm(), 1e-13 * tissue.young_modulus) << law.name;
        }
}

/// Uniaxial stress of an incompressible body, P = 2 (l - l^-2) (dW/dI1 + dW/dI2 / l), of the papers that the laws are
/// from.
TEST(HyperelasticMaterials, LawsWithConstantsHaveTheUniaxialStressOfTheirPapers) {
    const double mu = tissue.shear_modulus();
    for (const double l : {0.6, 0.9, 1.3}) {
        const double across = 1.0 / std::sqrt(l), x = l * l + 2.0 / l - 3.0;
        const Matrix3 f = Eigen::Vector3d(l, across, across).asDiagonal();
        const auto along = [&](const char *law) {
            const auto stress = hyperelastic::material_law(law).stress(tissue, f);
            return stress(0, 0) - across / l * stress(1, 1); // less the pressure that leaves the side free
        };
        const double yeoh = 0.5 * mu * (1.0 + 2.0 * 0.05 * x + 3.0 * 0.02 * x * x);
        EXPECT_NEAR(along("yeoh"), 2.0 * (l - 1.0 / (l * l)) * yeoh, 1e-12 * mu);
        const double mooney = 0.5 * mu * (0.9 + 0.1 / l);
        EXPECT_NEAR(along("mooney_rivlin"), 2.0 * (l - 1.0 / (l * l)) * mooney, 1e-12 * mu);
    }
}

TEST(HyperelasticMaterials, NeedTheirConstants) {
    const core::Material plain{1000.0, 5000.0, 0.45};
    for (const auto &law : hyperelastic::all_materials()) {
        EXPECT_TRUE(hyperelastic::has_constants(law, tissue)) << law.name;
        EXPECT_EQ(hyperelastic::has_constants(law, plain), law.num_constants == 0) << law.name;
    }
}

/// Two exponents have a form without principal stretches: 2, the neo-Hookean law, and -2 with tr C^-1, whose stress is
/// mu (F^-T - F^-T F^-1 F^-T).
TEST(HyperelasticMaterials, OgdenLawsHaveTheirSpecialCases) {
    const auto &neo_hookean = hyperelastic::material_law("neo_hookean");
    const double mu = tissue.shear_modulus();
    std::map<int, std::size_t> num_compared; // of each exponent
    for (const auto &[exponent, law] : tests::ogden_laws())
        for (const auto &f : deformations()) {
            const Matrix3 g = f.inverse();
            ++num_compared[static_cast<int>(exponent)];
            if (exponent == 2) {
                EXPECT_NEAR(law.energy(tissue, f), neo_hookean.energy(tissue, f), 1e-13 * mu);
                EXPECT_LT((law.stress(tissue, f) - neo_hookean.stress(tissue, f)).norm(), 1e-13 * mu);
                EXPECT_LT((law.tangent(tissue, f) - neo_hookean.tangent(tissue, f)).norm(), 1e-13 * mu);
            } else if (exponent == -2) {
                EXPECT_NEAR(law.energy(tissue, f), 0.5 * mu * (g.squaredNorm() - 3.0 + 2.0 * std::log(f.determinant())),
                            1e-13 * mu);
                EXPECT_LT((law.stress(tissue, f) - mu * (g.transpose() - g.transpose() * g * g.transpose())).norm(),
                          1e-13 * mu);
            }
        }
    EXPECT_EQ(num_compared[2], deformations().size());
    EXPECT_EQ(num_compared[-2], deformations().size());
    EXPECT_GT(deformations().size(), 2U);
}

INSTANTIATE_TEST_SUITE_P(Laws, HyperelasticMaterial, testing::ValuesIn(laws()),
                         [](const auto &info) { return info.param.name; });

TEST(HyperelasticMaterials, AreFoundByName) {
    EXPECT_EQ(hyperelastic::material_law("neo_hookean").name, "neo_hookean");
    EXPECT_THROW(hyperelastic::material_law("jelly"), std::invalid_argument);
}

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
        return 2.0 * tissue.shear_modulus() / exponent * (std::pow(stretch, exponent - 1.0) - 1.0 / stretch) +
               tissue.lame_lambda() * std::log(jacobian) / stretch;
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
    auto clamped = tests::held(mesh);
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
