#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <map>
#include <vector>

#include "fem_reference/hyperelastic/material_law.hpp"
#include "tests/samples/calculix_neo_hooke.hpp"
#include "tests/samples/ogden.hpp"

namespace livermark {

namespace {

using hyperelastic::MaterialLaw;
using hyperelastic::Matrix3;
using hyperelastic::Tangent;

const core::Material tissue{1000.0, 5000.0, 0.45};

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

} // namespace livermark
