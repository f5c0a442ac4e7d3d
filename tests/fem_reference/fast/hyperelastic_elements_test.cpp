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
#include "tests/samples/even_foundation.hpp"
#include "tests/samples/ogden.hpp"

namespace livermark {

namespace {

using core::Vector3;
using fem_reference::Formulation;
using hyperelastic::Elements;
using hyperelastic::FollowerPressure;
using hyperelastic::State;
using hyperelastic::TetrahedronRule;

std::shared_ptr<const core::Body> small_body() {
    return tests::make_body(tests::shaken_box_mesh({0.1, 0.12, 0.09}, {2, 2, 2}), tests::soft_material);
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
        pressure = tests::soft_material.young_modulus * (0.3 * part(generator) - 0.2);
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
        constexpr double stiffness = 1e6;
        const auto foundation = tests::even_foundation({0, 1, 2, 7}, stiffness, normal_only);
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
            expected +=
                stiffness * (normal_only ? Vector3(area.normalized().dot(shift) * area) : Vector3(area.norm() * shift));
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
