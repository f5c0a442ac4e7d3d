#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <random>
#include <string>

#include "msm/elastic_body.hpp"
#include "msm/spring_law.hpp"
#include "msm/springs/coupled_springs.hpp"
#include "msm/springs/spring_network.hpp"
#include "msm/springs/tetrahedron.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

using core::Vector3;
using msm::Tangent;
using Term = std::shared_ptr<const msm::RelaxingTerm>;
using Unknowns = Eigen::VectorXd;

struct NamedRelaxingTerm {
    std::string name;
    std::function<std::shared_ptr<const msm::ElasticTerm>(const core::Body &)> make;
    bool is_central = false; ///< whether all of each stress relaxes
};

/// Every term of which stresses relax.
std::vector<NamedRelaxingTerm> all_relaxing_terms() {
    std::vector<NamedRelaxingTerm> terms{
        {"springs",
         [](const core::Body &body) {
             return msm::spring_term(msm::spring_network(body, msm::all_spring_laws().front()));
         },
         true},
    };
    for (const auto &curve : msm::all_spring_curves())
        terms.push_back({"springs_with_the_curve_" + curve.name,
                         [curve](const core::Body &body) {
                             return msm::spring_term(msm::spring_network(body, msm::all_spring_laws().front()),
                                                     curve.curve);
                         },
                         true});
    for (const auto &springs : msm::all_coupled_springs())
        terms.push_back(
            {springs.name, [springs](const core::Body &body) { return msm::coupled_springs(body, springs); }});
    return terms;
}

Unknowns random_part(Eigen::Index size, double largest, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> value(-largest, largest);
    Unknowns vector(size);
    for (double &entry : vector)
        entry = value(random);
    return vector;
}

class EveryRelaxingTerm : public testing::TestWithParam<NamedRelaxingTerm> {
  protected:
    std::shared_ptr<const core::Body> body =
        tests::make_body(tests::box_mesh({0.1, 0.1, 0.1}, {2, 2, 2}), {1060.0, 5e3, 0.4});
    Term term = std::dynamic_pointer_cast<const msm::RelaxingTerm>(GetParam().make(*body));
    Unknowns rest = msm::to_unknowns(body->mesh.points);
    Unknowns shaken = rest + random_part(rest.size(), 0.006, 7);
    Unknowns added = random_part(term->relaxing_compliance().size(), 0.3 * term->relaxing_stress(shaken).norm(), 8) /
                     std::sqrt(static_cast<double>(term->relaxing_compliance().size()));
    Term faded = term->relaxed(0.4, added);

    static Unknowns force(const msm::ElasticTerm &of, const Unknowns &x) {
        Unknowns force = Unknowns::Zero(x.size());
        of.add_force(x, x, 0.0, force);
        return force;
    }
    Unknowns force_of(const Unknowns &x, const Unknowns &stress) const {
        Unknowns force = Unknowns::Zero(x.size());
        term->add_force_of(x, stress, force);
        return force;
    }
};

TEST_P(EveryRelaxingTerm, IsTheElasticOneWhereNothingHasFaded) {
    const auto same = term->relaxed(1.0, {});
    EXPECT_DOUBLE_EQ(same->energy(shaken), term->energy(shaken));
    EXPECT_LT((force(*same, shaken) - force(*term, shaken)).norm(), 1e-14 * force(*term, shaken).norm());
}

TEST_P(EveryRelaxingTerm, HasForcesThatAreTheDerivativeOfItsEnergyWhereItHasFaded) {
    const double step = 1e-6;
    const auto direction = random_part(rest.size(), 1.0, 11);
    const double slope =
        (faded->energy(shaken + step * direction) - faded->energy(shaken - step * direction)) / (2.0 * step);
    const auto at_rest = force(*faded, rest);
    EXPECT_GT(at_rest.norm(), 0.0);
    EXPECT_NEAR(slope, -force(*faded, shaken).dot(direction), 1e-6 * force(*faded, shaken).norm() * direction.norm());
}

TEST_P(EveryRelaxingTerm, HasAHessianThatIsTheDerivativeOfItsForcesWhereItHasFaded) {
    const double step = 1e-7;
    const auto direction = random_part(rest.size(), 1.0, 12);
    const Unknowns found = faded->hessian(shaken, Tangent::exact) * direction;
    const Unknowns expected =
        (force(*faded, shaken - step * direction) - force(*faded, shaken + step * direction)) / (2.0 * step);
    EXPECT_LT((found - expected).norm(), 1e-5 * found.norm());
    Unknowns product = Unknowns::Zero(rest.size());
    faded->add_hessian_product(shaken, direction, product);
    EXPECT_LT((product - found).norm(), 1e-12 * found.norm());
}

TEST_P(EveryRelaxingTerm, HasTangentsThatAreNowhereNegativeWhereItHasFaded) {
    for (const auto tangent : {Tangent::semi_definite, Tangent::material}) {
        const Eigen::MatrixXd matrix = faded->hessian(shaken, tangent);
        const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(matrix, Eigen::EigenvaluesOnly);
        EXPECT_GT(eigen.eigenvalues().minCoeff(), -1e-12 * eigen.eigenvalues().maxCoeff());
    }
}

TEST_P(EveryRelaxingTerm, HasDashpotsOfWhatIsLeft) {
    const auto velocity = random_part(rest.size(), 0.5, 13);
    Unknowns more = -force(*faded, shaken);
    faded->add_force(shaken, velocity, 0.003, more);
    const Unknowns expected = -0.003 * (faded->hessian(shaken, Tangent::material) * velocity);
    EXPECT_LT((more - expected).norm(), 1e-11 * (expected.norm() + force(*faded, shaken).norm()));
}

TEST_P(EveryRelaxingTerm, IsTheSumOfWhatStaysAndWhatRelaxes) {
    const auto whole = force(*term, shaken);
    const Unknowns sum = force(*term->relaxed(0.0, {}), shaken) + force_of(shaken, term->relaxing_stress(shaken));
    EXPECT_LT((sum - whole).norm(), 1e-12 * whole.norm());
    const Unknowns of_added = force(*faded, shaken) - force(*term->relaxed(0.4, {}), shaken);
    EXPECT_GT(of_added.norm(), 0.01 * whole.norm());
    EXPECT_LT((of_added - force_of(shaken, added)).norm(), 1e-11 * whole.norm());
}

TEST_P(EveryRelaxingTerm, RelaxesFurtherFromWhereItHasRelaxedTo) {
    const auto half = term->relaxed(0.5, {}), quarter = half->relaxed(0.5, {});
    EXPECT_LT((force(*quarter, shaken) - force(*term->relaxed(0.25, {}), shaken)).norm(),
              1e-13 * force(*term, shaken).norm());
    const auto stress = term->relaxing_stress(shaken);
    EXPECT_LT((half->relaxing_stress(shaken) - 0.5 * stress).norm(), 1e-13 * stress.norm());
    EXPECT_LT((half->relaxing_compliance() - 2.0 * term->relaxing_compliance()).norm(),
              1e-13 * term->relaxing_compliance().norm());
}

TEST_P(EveryRelaxingTerm, RelaxesWithoutAPressureUnlessItsSpringsKnowNothingOfEachOther) {
    const auto all = term->relaxing_stress(1.05 * rest).norm();
    if (GetParam().is_central)
        EXPECT_GT(all, 0.01 * term->relaxing_stress(shaken).norm());
    else
        EXPECT_LT(all, 1e-11 * term->relaxing_stress(shaken).norm());
}

TEST_P(EveryRelaxingTerm, TurnsWithTheBody) {
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(1.1, Vector3(1.0, 2.0, -0.5).normalized()).toRotationMatrix();
    const auto turned = [&turn](const Unknowns &field) {
        auto result = msm::to_field(field);
        for (auto &node : result)
            node = turn * node;
        return msm::to_unknowns(result);
    };
    const auto stress = term->relaxing_stress(shaken);
    EXPECT_LT((term->relaxing_stress(turned(shaken)) - stress).norm(), 1e-11 * stress.norm());
    EXPECT_LT((force_of(turned(shaken), added) - turned(force_of(shaken, added))).norm(),
              1e-11 * force_of(shaken, added).norm());
}

TEST_P(EveryRelaxingTerm, HasACompliancesEnergyAtSmallStrains) {
    const Unknowns small = rest + 1e-5 * (shaken - rest);
    const auto stress = term->relaxing_stress(small);
    const double expected = 0.5 * term->relaxing_compliance().cwiseProduct(stress).dot(stress);
    EXPECT_NEAR(term->energy(small) - term->relaxed(0.0, {})->energy(small), expected, 1e-5 * expected);
}

TEST_P(EveryRelaxingTerm, HasFastKernelsForTheElasticOneAlone) {
    EXPECT_FALSE(msm::step_parts(msm::ElasticBody(std::vector<double>(body->mesh.points.size(), 1.0), {faded})));
}

INSTANTIATE_TEST_SUITE_P(RelaxingTerms, EveryRelaxingTerm, testing::ValuesIn(all_relaxing_terms()),
                         [](const auto &info) { return info.param.name; });

TEST(RelaxingTerms, DoNotIncludeVolumesAndGuards) {
    const auto body = tests::make_body(tests::box_mesh({0.1, 0.1, 0.1}, {1, 1, 1}), {1060.0, 5e3, 0.4});
    EXPECT_EQ(dynamic_cast<const msm::RelaxingTerm *>(msm::inversion_guard(*body).get()), nullptr);
    for (const auto &volume : msm::all_volume_terms())
        EXPECT_EQ(dynamic_cast<const msm::RelaxingTerm *>(volume.make(*body, {7e3}).get()), nullptr);
}

} // namespace
} // namespace livermark
