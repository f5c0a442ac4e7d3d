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

namespace {

using hyperelastic::Elements;
using hyperelastic::FollowerPressure;
using hyperelastic::State;
using hyperelastic::TetrahedronRule;

std::shared_ptr<const core::Body> small_body() {
    return tests::make_body(tests::shaken_box_mesh({0.1, 0.12, 0.09}, {2, 2, 2}), tissue);
}

/// Bent, stretched, and shaken a little; pressures as a compressed body has them.
State some_state(const Elements &elements) {
    auto state = elements.rest();
    std::mt19937 generator(7);
    std::uniform_real_distribution<double> part(-1.0, 1.0);
    for (int node = 0; node < elements.system().num_nodes(); ++node) {
        const Vector3 x = elements.system().points[node];
        const Vector3 u(0.2 * x.x() + 1.5 * x.z() * x.z(), -0.1 * x.y() + x.x() * x.z(), 2.0 * x.x() * x.x());
        for (int i = 0; i < 3; ++i)
            state.displacement[3 * node + i] = u[i] + 1e-3 * part(generator);
    }
    for (double &pressure : state.pressure)
        pressure = tissue.young_modulus * (0.3 * part(generator) - 0.2);
    return state;
}

State direction_of(const State &state) {
    State direction = state;
    std::mt19937 generator(11);
    std::uniform_real_distribution<double> part(-1.0, 1.0);
    for (double &u : direction.displacement)
        u = part(generator);
    for (double &p : direction.pressure)
        p = 1e5 * part(generator);
    return direction;
}

State moved(State state, const State &direction, double step) {
    for (std::size_t i = 0; i < state.displacement.size(); ++i)
        state.displacement[i] += step * direction.displacement[i];
    for (std::size_t k = 0; k < state.pressure.size(); ++k)
        state.pressure[k] += step * direction.pressure[k];
    return state;
}

/// Fourth order central difference of a vector.
template <class Function> std::vector<double> slope(const Function &function, double h) {
    const auto a = function(h), b = function(-h), c = function(2.0 * h), d = function(-2.0 * h);
    std::vector<double> result;
    for (std::size_t i = 0; i < a.size(); ++i)
        result.push_back((8.0 * (a[i] - b[i]) - (c[i] - d[i])) / (12.0 * h));
    return result;
}

double largest(const std::vector<double> &values) {
    double result = 0.0;
    for (const double value : values)
        result = std::max(result, std::abs(value));
    return result;
}

void expect_near(const std::vector<double> &found, const std::vector<double> &expected, double tolerance) {
    ASSERT_EQ(found.size(), expected.size());
    double difference = 0.0;
    for (std::size_t i = 0; i < found.size(); ++i)
        difference = std::max(difference, std::abs(found[i] - expected[i]));
    EXPECT_LT(difference, tolerance * largest(expected));
}

/// Laws of the library, and one whose volume measure is another.
std::vector<hyperelastic::MaterialLaw> some_laws() {
    const auto all = hyperelastic::all_materials();
    std::vector<hyperelastic::MaterialLaw> laws(all.begin(), all.end());
    laws.push_back(tests::calculix_neo_hooke());
    return laws;
}

struct Case {
    std::string name;
    int degree;
    Formulation formulation;
};

class HyperelasticElements : public testing::TestWithParam<Case> {
  protected:
    Elements elements(const hyperelastic::MaterialLaw &law) const {
        return Elements(small_body(), GetParam().degree, GetParam().formulation, law,
                        GetParam().degree == 1 ? TetrahedronRule::one_point : TetrahedronRule::fourteen_points);
    }
};

/// The step of the differences, in lengths of the direction: its displacements are up to a metre.
constexpr double step = 1e-6;

} // namespace

/// The mean of b_0^a b_1^b b_2^c b_3^d over a tetrahedron is 6 a! b! c! d! / (a + b + c + d + 3)!, with b the
/// barycentric coordinates.
TEST(HyperelasticElements, QuadratureRulesHaveTheirPointsAndDegrees) {
    struct Rule {
        TetrahedronRule rule;
        std::size_t num_points;
        int degree;
    };
    for (const auto &[rule, num_points, degree] : {Rule{TetrahedronRule::one_point, 1, 1},
                                                   {TetrahedronRule::four_points, 4, 2},
                                                   {TetrahedronRule::fourteen_points, 14, 5}}) {
        const auto reference = hyperelastic::reference_tetrahedron(1, rule);
        EXPECT_EQ(reference.weight.size(), num_points);
        for (int a = 0; a <= degree; ++a)
            for (int b = 0; a + b <= degree; ++b)
                for (int c = 0; a + b + c <= degree; ++c) {
                    const int d = degree - a - b - c;
                    double mean = 0.0;
                    for (std::size_t q = 0; q < reference.weight.size(); ++q) {
                        const auto &shape = reference.linear_shape[q];
                        mean += reference.weight[q] * std::pow(shape[0], a) * std::pow(shape[1], b) *
                                std::pow(shape[2], c) * std::pow(shape[3], d);
                    }
                    EXPECT_NEAR(mean,
                                6.0 * std::tgamma(a + 1) * std::tgamma(b + 1) * std::tgamma(c + 1) *
                                    std::tgamma(d + 1) / std::tgamma(degree + 4),
                                1e-14);
                }
    }
}

TEST_P(HyperelasticElements, ForcesAreDerivativesOfTheEnergy) {
    for (const auto &law : some_laws()) {
        const auto elements = this->elements(law);
        const auto state = some_state(elements);
        const auto direction = direction_of(state);
        const auto here = elements.internal_forces(state);
        ASSERT_GT(here.smallest_jacobian, 0.3);
        const auto energy = [&](double h) {
            return std::vector{elements.internal_forces(moved(state, direction, h)).energy};
        };
        double expected = 0.0;
        for (std::size_t i = 0; i < here.force.size(); ++i)
            expected += here.force[i] * direction.displacement[i];
        for (std::size_t k = 0; k < here.imbalance.size(); ++k)
            expected += here.imbalance[k] * direction.pressure[k];
        EXPECT_NEAR(slope(energy, 10.0 * step)[0], expected, 1e-6 * std::abs(expected));
    }
}

TEST_P(HyperelasticElements, TangentIsTheDerivativeOfTheForces) {
    for (const auto &law : some_laws()) {
        const auto elements = this->elements(law);
        const auto state = some_state(elements);
        const auto direction = direction_of(state);
        auto tangent = elements.zero_tangent();
        elements.assemble_tangent(state, tangent);

        std::vector<double> force(state.displacement.size()), imbalance(state.pressure.size());
        tangent.stiffness.multiply(std::span<const double>(direction.displacement), std::span<double>(force));
        if (!imbalance.empty()) {
            fem_reference::multiply(elements.compliance(), direction.pressure, imbalance);
            tangent.divergence.add_products(direction.displacement, direction.pressure, force, imbalance, 1);
        }
        const auto forces = [&](double h) { return elements.internal_forces(moved(state, direction, h)).force; };
        const auto imbalances = [&](double h) {
            return elements.internal_forces(moved(state, direction, h)).imbalance;
        };
        expect_near(force, slope(forces, step), 1e-7);
        if (!imbalance.empty())
            expect_near(imbalance, slope(imbalances, step), 1e-7);
    }
}

/// Beside the forces of the body there are those of the springs, in any direction or along the normal.
TEST_P(HyperelasticElements, StandOnSpringsWithTheTangentOfTheirForces) {
    for (const bool normal_only : {false, true}) {
        auto elements = this->elements(hyperelastic::material_law("neo_hookean"));
        const auto state = some_state(elements);
        const auto direction = direction_of(state);
        const auto alone = elements.internal_forces(state);
        const core::Foundation foundation{.facets = {0, 1, 2, 7}, .stiffness = 1e6, .normal_only = normal_only};
        elements.stand_on(foundation);
        const auto standing = elements.internal_forces(state);
        EXPECT_EQ(standing.energy, alone.energy);
        Vector3 sum = Vector3::Zero(), expected = Vector3::Zero();
        const Vector3 shift(1e-3, -2e-3, 3e-3);
        auto shifted = elements.rest();
        for (std::size_t i = 0; i < shifted.displacement.size(); ++i)
            shifted.displacement[i] = shift[static_cast<Eigen::Index>(i % 3)];
        const auto borne = elements.internal_forces(shifted).force;
        for (std::size_t i = 0; i < borne.size(); ++i)
            sum[static_cast<Eigen::Index>(i % 3)] += borne[i];
        for (const int f : foundation.facets) {
            const Vector3 area = core::area_vector(elements.body().mesh, f);
            expected += foundation.stiffness *
                        (normal_only ? Vector3(area.normalized().dot(shift) * area) : Vector3(area.norm() * shift));
        }
        EXPECT_LT((sum - expected).norm(), 1e-9 * expected.norm());
        auto tangent = elements.zero_tangent();
        elements.assemble_tangent(state, tangent);
        std::vector<double> found(state.displacement.size());
        tangent.stiffness.multiply(std::span<const double>(direction.displacement), std::span<double>(found));
        const State along{direction.displacement, std::vector<double>(state.pressure.size(), 0.0)};
        const auto forces = [&](double h) { return elements.internal_forces(moved(state, along, h)).force; };
        expect_near(found, slope(forces, step), 1e-7);
    }
}

/// Nothing that is turned inside out has an energy.
TEST_P(HyperelasticElements, SayWhereABodyIsInsideOut) {
    const auto elements = this->elements(hyperelastic::material_law("neo_hookean"));
    auto state = elements.rest();
    for (int node = 0; node < elements.system().num_nodes(); ++node)
        state.displacement[3 * node] = -1.5 * elements.system().points[node].x();
    EXPECT_LE(elements.internal_forces(state).smallest_jacobian, 0.0);
    EXPECT_EQ(elements.internal_forces(elements.rest()).smallest_jacobian, 1.0);
}

TEST_P(HyperelasticElements, FollowerPressureHasItsLoadStiffness) {
    const auto elements = this->elements(hyperelastic::material_law("neo_hookean"));
    const auto &mesh = elements.body().mesh;
    std::vector<double> pressure(mesh.boundary_triangles.size(), 0.0);
    for (std::size_t f = 0; f < pressure.size(); ++f)
        if (mesh.boundary_patch[f] == 1)
            pressure[f] = 300.0;
    const FollowerPressure follower(elements.system(), mesh, pressure);
    const auto state = some_state(elements);
    const auto direction = direction_of(state);
    const auto loads = follower.load_stiffness(0.7, state.displacement);
    auto tangent = elements.zero_tangent(); // of linear elasticity, to be emptied
    std::ranges::fill(tangent.stiffness.below, fem_reference::Block<double>{});
    std::ranges::fill(tangent.stiffness.diagonal, fem_reference::Block<double>{});
    loads.add_to(tangent.stiffness);
    std::vector<double> found(state.displacement.size());
    tangent.stiffness.multiply(std::span<const double>(direction.displacement), std::span<double>(found));
    loads.add_product(direction.displacement, found);
    const auto forces = [&](double h) {
        std::vector<double> force(state.displacement.size(), 0.0);
        follower.add_forces(-0.7, moved(state, direction, h).displacement, force);
        return force;
    };
    expect_near(found, slope(forces, step), 1e-8);
}

/// All around a body the same pressure has neither resultant nor moment, whatever its shape, and it has a potential:
/// pressure times volume. So the antisymmetric parts of neighbours cancel.
TEST_P(HyperelasticElements, FollowerPressureAllAroundHasAPotential) {
    const auto elements = this->elements(hyperelastic::material_law("neo_hookean"));
    const std::vector<double> pressure(elements.body().mesh.boundary_triangles.size(), 300.0);
    const FollowerPressure follower(elements.system(), elements.body().mesh, pressure);
    const auto state = some_state(elements);
    std::vector<double> force(state.displacement.size(), 0.0);
    follower.add_forces(1.0, state.displacement, force);
    Vector3 resultant = Vector3::Zero(), moment = Vector3::Zero();
    for (int node = 0; node < elements.system().num_nodes(); ++node) {
        const Vector3 x = elements.system().points[node] + Vector3::Map(&state.displacement[3 * node]);
        resultant += Vector3::Map(&force[3 * node]);
        moment += x.cross(Vector3::Map(&force[3 * node]));
    }
    EXPECT_LT(resultant.norm(), 1e-13 * 300.0);
    EXPECT_LT(moment.norm(), 1e-14 * 300.0);
    const auto loads = follower.load_stiffness(1.0, state.displacement);
    const auto direction = direction_of(state);
    std::vector<double> product(force.size(), 0.0);
    loads.add_product(direction.displacement, product);
    EXPECT_LT(largest(product), 1e-13 * 300.0);
}

INSTANTIATE_TEST_SUITE_P(Kinds, HyperelasticElements,
                         testing::Values(Case{"p1", 1, Formulation::displacement},
                                         Case{"p2", 2, Formulation::displacement}, Case{"p2p1", 2, Formulation::mixed}),
                         [](const auto &info) { return info.param.name; });

TEST(HyperelasticElements, AreRefusedWhereTheyDoNotExist) {
    const auto &law = hyperelastic::material_law("neo_hookean");
    EXPECT_THROW(Elements(small_body(), 1, Formulation::mixed, law, TetrahedronRule::one_point), std::invalid_argument);
    EXPECT_THROW(Elements(small_body(), 3, Formulation::displacement, law, TetrahedronRule::fourteen_points),
                 std::invalid_argument);
}

} // namespace livermark
