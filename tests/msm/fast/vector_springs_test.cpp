#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <string>

#include "msm/elastic_body.hpp"
#include "msm/kernels/vector_springs.hpp"
#include "msm/springs/springs.hpp"
#include "msm/statics/equilibrium.hpp"
#include "tests/fem_reference/fem_test_bodies.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

using core::Vector3;

/// Tolerance of energies, forces and products: rounding differs.
constexpr double rounding = 1e-12;

/// Two materials side by side, of a number of tetrahedra that fills its slices or does not.
core::Body two_blocks(const std::array<int, 3> &bricks, double poisson_ratio) {
    auto mesh = tests::box_mesh({0.1, 0.05, 0.07}, bricks);
    mesh.region_names = {"soft", "hard"};
    for (int t = 0; t < mesh.num_tetrahedra(); ++t)
        mesh.region[t] = mesh.points[mesh.tetrahedra[t][0]].x() < 0.04 ? 0 : 1;
    return {.name = "two",
            .mesh = std::move(mesh),
            .materials = {{1060.0, 5e3, poisson_ratio}, {1060.0, 2e4, poisson_ratio}}};
}

Eigen::VectorXd random_field(Eigen::Index size, double largest, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> value(-largest, largest);
    Eigen::VectorXd field(size);
    for (double &entry : field)
        entry = value(random);
    return field;
}

double sum_of_energies(const msm::ElasticBody &body, const Eigen::VectorXd &x) {
    double energy = 0.0;
    for (const auto &term : body.terms)
        energy += term->energy(x);
    return energy;
}

Eigen::VectorXd sum_of_products(const msm::ElasticBody &body, const Eigen::VectorXd &x, const Eigen::VectorXd &u) {
    Eigen::VectorXd product = Eigen::VectorXd::Zero(x.size());
    for (const auto &term : body.terms)
        term->add_hessian_product(x, u, product);
    return product;
}

std::vector<std::string> springs_around_nodes() {
    std::vector<std::string> names;
    for (const auto &springs : msm::all_coupled_springs())
        if (springs.domains.nodes > 0.0)
            names.push_back(springs.name);
    return names;
}

/// @param energies, forces  their tolerances
void expect_the_same(const msm::ElasticBody &scalar, const msm::ElasticBody &vectors, const Eigen::VectorXd &x,
                     const Eigen::VectorXd &u, double energies, double forces) {
    const double expected = sum_of_energies(scalar, x);
    EXPECT_NEAR(sum_of_energies(vectors, x), expected, energies * expected);
    for (const double size : {1.0, 2.0}) { // the second product at a place keeps what the first one found
        const auto product = sum_of_products(scalar, x, size * u);
        EXPECT_LT((sum_of_products(vectors, x, size * u) - product).norm(), rounding * product.norm());
    }
    const auto force = msm::to_unknowns(msm::elastic_gradient(scalar, msm::to_field(x)));
    EXPECT_LT((msm::to_unknowns(msm::elastic_gradient(vectors, msm::to_field(x))) - force).norm(),
              forces * force.norm());
}

class VectorSprings : public testing::TestWithParam<std::string> {};

/// The terms themselves are the oracle.
TEST_P(VectorSprings, HaveTheEnergiesForcesAndProductsOfTheTerms) {
    const auto &springs = msm::find_coupled_springs(GetParam());
    for (const std::array<int, 3> &bricks : {std::array{1, 1, 1}, std::array{2, 1, 1}, std::array{3, 2, 3}})
        for (const double poisson_ratio : {0.25, 0.45})
            for (const double shake : {1e-6, 1e-3, 0.004}) {
                const auto body = two_blocks(bricks, poisson_ratio);
                SCOPED_TRACE(testing::Message() << body.mesh.num_tetrahedra() << " tetrahedra, shaken by " << shake);
                const auto scalar = msm::coupled_springs_with_volume(body, springs);
                const auto vectors = msm::in_vectors(scalar, body.mesh.points);
                ASSERT_EQ(vectors.terms.size(), 1U);
                ASSERT_NE(vectors.terms.front(), scalar.terms.front());
                EXPECT_EQ(bool(vectors.preconditioner), bool(scalar.preconditioner));
                const auto rest = msm::to_unknowns(body.mesh.points);
                const auto u = random_field(rest.size(), 1.0, 4);
                // Energies are of differences of strains.
                expect_the_same(scalar, vectors, rest + random_field(rest.size(), shake, 3), u, 1e-9,
                                rounding * std::max(1.0, 1e-3 / shake));
                const auto at_rest = msm::StiffnessProduct(scalar, body.mesh.points).times(u);
                EXPECT_LT((msm::StiffnessProduct(vectors, body.mesh.points).times(u) - at_rest).norm(),
                          rounding * at_rest.norm());
            }
}

/// The guard of elongations pushes a tetrahedron with less than half its volume; other energies are infinite where
/// one is inside out.
TEST_P(VectorSprings, KnowTheGuardAndWhereThereIsNoEnergy) {
    const auto body = two_blocks({3, 2, 3}, 0.45);
    const auto scalar = msm::coupled_springs_with_volume(body, msm::find_coupled_springs(GetParam()));
    const auto vectors = msm::in_vectors(scalar, body.mesh.points);
    const auto rest = msm::to_unknowns(body.mesh.points);
    const Eigen::VectorXd x = rest + random_field(rest.size(), 0.025, 5);
    const double expected = sum_of_energies(scalar, x), found = sum_of_energies(vectors, x);
    ASSERT_EQ(std::isfinite(found), std::isfinite(expected));
    EXPECT_EQ(std::isfinite(found), msm::find_coupled_springs(GetParam()).energy.is_finite);
    if (!std::isfinite(expected))
        return;
    expect_the_same(scalar, vectors, x, random_field(rest.size(), 1.0, 6), rounding, rounding);
}

TEST_P(VectorSprings, ComeToRestWhereTheTermsDo) {
    const auto body = std::make_shared<const core::Body>(two_blocks({5, 2, 3}, 0.45));
    auto load_case = tests::empty_load_case(body->mesh);
    tests::prescribe(load_case, body->mesh, "x_min", Vector3::Zero());
    tests::pull(load_case, body->mesh, "x_max", {200.0, 100.0, -300.0});
    const auto scalar = msm::coupled_springs_with_volume(*body, msm::find_coupled_springs(GetParam()));
    const auto vectors = msm::in_vectors(scalar, body->mesh.points);
    const auto conditions = msm::nodal_conditions({body, load_case}, scalar.node_mass);
    const auto expected = msm::find_equilibrium(scalar, body->mesh.points, conditions);
    const auto found = msm::find_equilibrium(vectors, body->mesh.points, conditions);
    ASSERT_EQ(expected.status, core::SolutionStatus::ok) << expected.message;
    ASSERT_EQ(found.status, core::SolutionStatus::ok) << found.message;
    const auto displacement = msm::to_unknowns(expected.displacement);
    EXPECT_LT((msm::to_unknowns(found.displacement) - displacement).norm(), 1e-9 * displacement.norm());
    EXPECT_GT((displacement - msm::to_unknowns(expected.linear_displacement)).norm(), 0.01 * displacement.norm());
}

TEST_P(VectorSprings, FindTheSameBitsEveryTime) {
    const auto body = two_blocks({3, 2, 3}, 0.45);
    const auto scalar = msm::coupled_springs_with_volume(body, msm::find_coupled_springs(GetParam()));
    const auto rest = msm::to_unknowns(body.mesh.points);
    const Eigen::VectorXd x = rest + random_field(rest.size(), 0.004, 3), u = random_field(rest.size(), 1.0, 4);
    const auto first = msm::in_vectors(scalar, body.mesh.points), second = msm::in_vectors(scalar, body.mesh.points);
    sum_of_products(second, rest, u); // what was asked before makes no difference
    EXPECT_EQ(sum_of_energies(first, x), sum_of_energies(second, x));
    EXPECT_TRUE(sum_of_products(first, x, u) == sum_of_products(second, x, u));
}

INSTANTIATE_TEST_SUITE_P(AroundNodes, VectorSprings, testing::ValuesIn(springs_around_nodes()),
                         [](const auto &info) { return info.param; });

TEST(VectorSpringsOfOthers, AreTheTermsThemselves) {
    const auto body = two_blocks({2, 1, 1}, 0.45);
    const auto edges = msm::coupled_springs_with_volume(body, msm::find_coupled_springs("edge_neo_hookean"));
    const auto single = msm::ElasticBody(msm::spring_network(body, msm::all_spring_laws().front()));
    for (const auto &other : {edges, single})
        EXPECT_EQ(msm::in_vectors(other, body.mesh.points).terms, other.terms);
}

} // namespace
} // namespace livermark
