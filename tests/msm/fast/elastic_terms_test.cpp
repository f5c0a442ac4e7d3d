#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <random>
#include <string>
#include <vector>

#include "msm/dynamics/stepper.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/elastic_body.hpp"
#include "msm/integrator.hpp"
#include "msm/kernels/vector_springs.hpp"
#include "msm/spring_law.hpp"
#include "msm/springs/springs.hpp"
#include "msm/springs/tetrahedron.hpp"
#include "tests/fem_reference/fem_test_bodies.hpp"
#include "tests/oracles/linear_elements.hpp"
#include "tests/same_bits.hpp"
#include "tests/samples/bodies_with_vessels.hpp"
#include "tests/samples/covered_bodies.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

using core::Vector3;
using msm::Tangent;
using Term = std::shared_ptr<const msm::ElasticTerm>;

/// So far from rest that some tetrahedra are inverted.
constexpr double inverting = 0.02;

struct NamedTerm {
    std::string name;
    std::function<Term(const core::Body &)> make;
    double shake = inverting; ///< motion of nodes [m]
    bool has_faded = false;   ///< part of its stresses, and others are added
};

/// Every term that a model can be made of.
std::vector<NamedTerm> all_terms() {
    std::vector<NamedTerm> terms{
        {"springs",
         [](const core::Body &body) {
             return msm::spring_term(msm::spring_network(body, msm::all_spring_laws().front()));
         }},
        {"linear_elements", tests::linear_elements},
        {"inversion_guard", msm::inversion_guard},
        {"coupled_capsule",
         [](const core::Body &body) {
             return msm::coupled_capsule(*tests::covered::with_capsule(std::make_shared<const core::Body>(body)));
         },
         0.006},
        {"vessel_lines",
         [](const core::Body &body) {
             return msm::vessel_lines(*tests::vessels::with_vessels(std::make_shared<const core::Body>(body)));
         },
         0.006},
    };
    for (const auto &volume : msm::all_volume_terms())
        terms.push_back({volume.name, [volume](const core::Body &body) { return volume.make(body, {7e3, 2e4}); }});
    for (const auto &curve : msm::all_spring_curves())
        terms.push_back({"springs_with_the_curve_" + curve.name,
                         [curve](const core::Body &body) {
                             return msm::spring_term(msm::spring_network(body, msm::all_spring_laws().front()),
                                                     curve.curve);
                         },
                         0.006});
    // Most energies are infinite where a tetrahedron is inside out.
    for (const auto &springs : msm::all_coupled_springs())
        terms.push_back({springs.name,
                         [springs](const core::Body &body) { return msm::coupled_springs(body, springs); },
                         springs.energy.is_finite ? inverting : 0.006});
    for (const auto &springs : msm::all_coupled_springs())
        if (springs.domains.nodes > 0.0)
            terms.push_back({springs.name + "_in_vectors",
                             [springs](const core::Body &body) {
                                 const auto model = msm::coupled_springs_with_volume(body, springs);
                                 return msm::in_vectors(model, body.mesh.points).terms.front();
                             },
                             springs.energy.is_finite ? inverting : 0.006});
    for (const auto *const kind : {"nodal", "mean_nodal"})
        terms.push_back({std::string(kind) + "_logarithmic_volume",
                         [kind](const core::Body &body) {
                             const auto parts = msm::nodal_parts(body);
                             auto volumes = kind == std::string("nodal")
                                                ? msm::volumes_around_nodes(parts, {7e3, 2e4})
                                                : msm::mean_volumes_around_nodes(parts, {7e3, 2e4});
                             volumes.measure = msm::logarithm_of_volume;
                             return msm::volume_penalty(body.mesh, volumes);
                         },
                         0.006});
    return terms;
}

/// Two materials side by side, on an irregular mesh.
std::shared_ptr<const core::Body> two_materials() {
    auto mesh = tests::box_mesh({0.1, 0.1, 0.1}, {2, 3, 2});
    mesh.region_names = {"soft", "hard"};
    for (int t = 0; t < mesh.num_tetrahedra(); ++t)
        mesh.region[t] = mesh.points[mesh.tetrahedra[t][0]].x() < 0.04 ? 0 : 1;
    core::Body body{.name = "two", .mesh = std::move(mesh), .materials = {{1060.0, 5e3, 0.4}, {1060.0, 2e4, 0.45}}};
    return std::make_shared<const core::Body>(std::move(body));
}

Eigen::VectorXd random_vector(Eigen::Index size, double largest, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> value(-largest, largest);
    Eigen::VectorXd vector(size);
    for (double &entry : vector)
        entry = value(random);
    return vector;
}

/// Terms of which stresses relax.
std::vector<NamedTerm> relaxing_terms() {
    auto terms = all_terms();
    std::erase_if(terms, [body = two_materials()](const NamedTerm &term) {
        return !std::dynamic_pointer_cast<const msm::RelaxingTerm>(term.make(*body));
    });
    return terms;
}

/// All terms, and those that relax after a part of their stresses has faded.
std::vector<NamedTerm> all_and_faded_terms() {
    auto terms = all_terms();
    for (const auto &relaxing : relaxing_terms())
        terms.push_back({relaxing.name + "_that_has_faded",
                         [make = relaxing.make](const core::Body &body) {
                             const auto whole = std::dynamic_pointer_cast<const msm::RelaxingTerm>(make(body));
                             const auto rest = msm::to_unknowns(body.mesh.points);
                             const auto stress = whole->relaxing_stress(rest + random_vector(rest.size(), 0.006, 7));
                             const auto root = std::sqrt(static_cast<double>(stress.size()));
                             return whole->relaxed(0.4, random_vector(stress.size(), 0.3 * stress.norm() / root, 8));
                         },
                         0.006, true});
    return terms;
}

class EveryElasticTerm : public testing::TestWithParam<NamedTerm> {
  protected:
    std::shared_ptr<const core::Body> body = two_materials();
    Term term = GetParam().make(*body);
    Eigen::VectorXd rest = msm::to_unknowns(body->mesh.points);
    Eigen::VectorXd shaken = rest + random_vector(rest.size(), GetParam().shake, 7);

    Eigen::VectorXd gradient(const Eigen::VectorXd &x) const {
        Eigen::VectorXd force = Eigen::VectorXd::Zero(x.size());
        term->add_force(x, x, 0.0, force);
        return -force;
    }
};

class EveryTermAtRest : public EveryElasticTerm {};

TEST(FixableTerm, GivesTheSameBitsWhereTheBodyStays) {
    const auto body = two_materials();
    const auto rest = msm::to_unknowns(body->mesh.points);
    for (const auto &springs : msm::all_coupled_springs())
        for (const double shake : {0.0, 0.006}) {
            SCOPED_TRACE(springs.name);
            const auto term = msm::coupled_springs(*body, springs);
            const auto *fixable = dynamic_cast<const msm::FixableTerm *>(term.get());
            ASSERT_TRUE(fixable);
            const Eigen::VectorXd x = rest + random_vector(rest.size(), shake, 7);
            const auto v = random_vector(rest.size(), 1.0, 8);
            const auto force = [&](const msm::ElasticTerm &of, double beta) {
                Eigen::VectorXd sum = Eigen::VectorXd::Zero(x.size());
                of.add_force(x, v, beta, sum);
                return std::vector<double>(sum.begin(), sum.end());
            };
            const auto fixed = fixable->fixed_at(x);
            for (const double beta : {0.0, 1.0, 0.3})
                EXPECT_TRUE(tests::same_bits(force(*fixed, beta), force(*term, beta))) << beta;
        }
}

TEST_P(EveryTermAtRest, IsAtRestInTheMesh) {
    EXPECT_LT(term->energy(rest), 1e-24 * (1.0 + term->energy(shaken)));
    EXPECT_LT(gradient(rest).norm(), 1e-12 * gradient(shaken).norm());
}

TEST_P(EveryTermAtRest, CostsNothingInRigidMotion) {
    const Eigen::AngleAxisd turn(1.1, Vector3(1.0, 2.0, -0.5).normalized());
    auto moved = body->mesh.points;
    for (auto &x : moved)
        x = turn * x + Vector3(0.3, -0.2, 0.7);
    EXPECT_LT(term->energy(msm::to_unknowns(moved)), 1e-24 * (1.0 + term->energy(shaken)));
    EXPECT_LT(gradient(msm::to_unknowns(moved)).norm(), 1e-11 * gradient(shaken).norm());
}

TEST_P(EveryElasticTerm, FindsTheSameBitsOfForceAndEnergyAtOnce) {
    const Eigen::VectorXd before = random_vector(rest.size(), 1.0, 15);
    Eigen::VectorXd expected = before, found = before;
    term->add_force(shaken, shaken, 0.0, expected);
    const std::vector energies{term->add_force_and_energy(shaken, found), term->energy(shaken)};
    EXPECT_NE(energies.front(), 0.0);
    EXPECT_EQ(energies.front(), energies.back());
    EXPECT_TRUE(tests::same_bits(std::vector<double>(found.begin(), found.end()),
                                 std::vector<double>(expected.begin(), expected.end())));
}

TEST_P(EveryElasticTerm, LeavesTheForceAloneWhereItHasNoEnergy) {
    const Eigen::VectorXd inverted = rest + random_vector(rest.size(), 2.0 * inverting, 7);
    const Eigen::VectorXd before = random_vector(rest.size(), 1.0, 15);
    Eigen::VectorXd found = before;
    EXPECT_EQ(term->add_force_and_energy(inverted, found), term->energy(inverted));
    EXPECT_EQ(found == before, !std::isfinite(term->energy(inverted)));
}

TEST_P(EveryElasticTerm, HasForcesThatAreTheDerivativeOfItsEnergy) {
    const double step = 1e-6;
    const auto direction = random_vector(rest.size(), 1.0, 11);
    const double slope =
        (term->energy(shaken + step * direction) - term->energy(shaken - step * direction)) / (2.0 * step);
    const double expected = gradient(shaken).dot(direction);
    EXPECT_GT(std::abs(expected), 0.0);
    EXPECT_NEAR(slope, expected, 1e-6 * gradient(shaken).norm() * direction.norm());
}

TEST_P(EveryElasticTerm, HasAHessianThatIsTheDerivativeOfItsForces) {
    const double step = 1e-7;
    const auto direction = random_vector(rest.size(), 1.0, 12);
    const Eigen::VectorXd found = term->hessian(shaken, Tangent::exact) * direction;
    const Eigen::VectorXd expected =
        (gradient(shaken + step * direction) - gradient(shaken - step * direction)) / (2.0 * step);
    EXPECT_GT(found.norm(), 0.0);
    EXPECT_LT((found - expected).norm(), 1e-5 * found.norm());
}

TEST_P(EveryElasticTerm, HasProductsOfItsHessianWithoutTheMatrix) {
    const auto direction = random_vector(rest.size(), 1.0, 14);
    const Eigen::VectorXd expected = term->hessian(shaken, Tangent::exact) * direction;
    Eigen::VectorXd found = Eigen::VectorXd::Ones(rest.size());
    term->add_hessian_product(shaken, direction, found);
    EXPECT_LT((found - Eigen::VectorXd::Ones(rest.size()) - expected).norm(), 1e-12 * expected.norm());
}

TEST_P(EveryTermAtRest, HasTheMaterialTangentAtRest) {
    const Eigen::MatrixXd exact = term->hessian(rest, Tangent::exact);
    EXPECT_LT((exact - Eigen::MatrixXd(term->hessian(rest, Tangent::material))).norm(), 1e-11 * exact.norm() + 1e-30);
}

/// Tangents for a step where the exact one is not positive semi-definite, and for dashpots, which must not drive.
TEST_P(EveryElasticTerm, HasTangentsThatAreNowhereNegative) {
    for (const auto tangent : {Tangent::semi_definite, Tangent::material}) {
        const Eigen::MatrixXd matrix = term->hessian(shaken, tangent);
        EXPECT_LT((matrix - matrix.transpose()).norm(), 1e-13 * matrix.norm() + 1e-30);
        const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(matrix, Eigen::EigenvaluesOnly);
        EXPECT_GT(eigen.eigenvalues().minCoeff(), -1e-12 * eigen.eigenvalues().maxCoeff() - 1e-30);
    }
}

TEST_P(EveryElasticTerm, KeepsItsEntriesInTheirPlaces) {
    const auto places = [](const Eigen::SparseMatrix<double> &matrix) {
        std::vector<std::pair<Eigen::Index, Eigen::Index>> places;
        for (Eigen::Index column = 0; column < matrix.outerSize(); ++column)
            for (Eigen::SparseMatrix<double>::InnerIterator entry(matrix, column); entry; ++entry)
                places.emplace_back(entry.row(), entry.col());
        return places;
    };
    const auto expected = places(term->hessian(rest, Tangent::exact));
    for (const auto tangent : {Tangent::exact, Tangent::semi_definite, Tangent::material})
        EXPECT_EQ(places(term->hessian(shaken, tangent)), expected);
}

TEST_P(EveryElasticTerm, HasDashpotsOfItsMaterialTangent) {
    const double beta = 0.003;
    const auto velocity = random_vector(rest.size(), 0.5, 13);
    Eigen::VectorXd force = gradient(shaken);
    term->add_force(shaken, velocity, beta, force);
    const Eigen::VectorXd expected = -beta * (term->hessian(shaken, Tangent::material) * velocity);
    const double tolerance = GetParam().has_faded ? 1e-11 : 1e-12;
    EXPECT_LT((force - expected).norm(), tolerance * (expected.norm() + gradient(shaken).norm()));
}

TEST_P(EveryElasticTerm, HasForcesWithoutResultantAndMoment) {
    const auto forces = msm::to_field(gradient(shaken));
    Vector3 resultant = Vector3::Zero(), moment = Vector3::Zero();
    double scale = 0.0;
    for (std::size_t i = 0; i < forces.size(); ++i) {
        resultant += forces[i];
        moment += Vector3(msm::node_part(shaken, static_cast<int>(i))).cross(forces[i]);
        scale += forces[i].norm();
    }
    EXPECT_LT(resultant.norm(), 1e-13 * scale);
    EXPECT_LT(moment.norm(), 1e-13 * scale);
}

TEST_P(EveryElasticTerm, IsBoundedByItsBlocks) {
    std::vector<Eigen::Matrix3d> blocks(body->mesh.points.size(), Eigen::Matrix3d::Zero());
    term->add_block_bound(rest, blocks);
    Eigen::MatrixXd bound = -Eigen::MatrixXd(term->hessian(rest, Tangent::material));
    for (std::size_t i = 0; i < blocks.size(); ++i)
        bound.block<3, 3>(static_cast<Eigen::Index>(3 * i), static_cast<Eigen::Index>(3 * i)) += blocks[i];
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(bound, Eigen::EigenvaluesOnly);
    EXPECT_GT(eigen.eigenvalues().minCoeff(), -1e-12 * bound.norm() - 1e-30);
}

INSTANTIATE_TEST_SUITE_P(ElasticTerms, EveryElasticTerm, testing::ValuesIn(all_and_faded_terms()),
                         [](const auto &info) { return info.param.name; });
INSTANTIATE_TEST_SUITE_P(ElasticTerms, EveryTermAtRest, testing::ValuesIn(all_terms()),
                         [](const auto &info) { return info.param.name; });

/// A volume term alone leaves most motions free; springs leave rigid ones only, and so does the sum.
TEST(VolumeTerms, LeaveNoMotionFreeBesideSprings) {
    const auto body = two_materials();
    const auto rest = msm::to_unknowns(body->mesh.points);
    const auto springs = msm::spring_term(msm::spring_network(*body, msm::all_spring_laws().front()));
    for (const auto &volume : msm::all_volume_terms()) {
        const auto term = volume.make(*body, {7e3, 2e4});
        const auto num_free = [](const Eigen::MatrixXd &stiffness) {
            const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(stiffness, Eigen::EigenvaluesOnly);
            return (eigen.eigenvalues().array() < 1e-10 * eigen.eigenvalues().maxCoeff()).count();
        };
        const Eigen::MatrixXd alone = term->hessian(rest, Tangent::exact);
        EXPECT_GT(num_free(alone), 6) << volume.name;
        EXPECT_EQ(num_free(alone + Eigen::MatrixXd(springs->hessian(rest, Tangent::exact))), 6) << volume.name;
    }
}

/// A volume that grows by a known factor everywhere costs kappa / 2 (J - 1)^2 for each unit of volume.
TEST(VolumeTerms, CostWhatTheirModulusSaysWhereTheVolumeGrowsEverywhere) {
    const auto body = two_materials();
    double expected = 0.0;
    const auto volumes = core::tetrahedron_volumes(body->mesh);
    for (std::size_t t = 0; t < volumes.size(); ++t)
        expected += 0.5 * (body->mesh.region[t] == 0 ? 7e3 : 2e4) * std::pow(1.1 * 1.2 * 0.9 - 1.0, 2) * volumes[t];
    auto stretched = body->mesh.points;
    for (auto &x : stretched)
        x = x.cwiseProduct(Vector3(1.1, 1.2, 0.9));
    for (const auto &volume : msm::all_volume_terms())
        EXPECT_NEAR(volume.make(*body, {7e3, 2e4})->energy(msm::to_unknowns(stretched)), expected, 1e-12 * expected)
            << volume.name;
}

class EveryRelaxingTerm : public testing::TestWithParam<NamedTerm> {
  protected:
    std::shared_ptr<const core::Body> body =
        tests::make_body(tests::box_mesh({0.1, 0.1, 0.1}, {2, 2, 2}), {1060.0, 5e3, 0.4});
    std::shared_ptr<const msm::RelaxingTerm> term =
        std::dynamic_pointer_cast<const msm::RelaxingTerm>(GetParam().make(*body));
    Eigen::VectorXd rest = msm::to_unknowns(body->mesh.points);
    Eigen::VectorXd shaken = rest + random_vector(rest.size(), 0.006, 7);
    Eigen::VectorXd added =
        random_vector(term->relaxing_compliance().size(), 0.3 * term->relaxing_stress(shaken).norm(), 8) /
        std::sqrt(static_cast<double>(term->relaxing_compliance().size()));
    std::shared_ptr<const msm::RelaxingTerm> faded = term->relaxed(0.4, added);

    static Eigen::VectorXd force(const msm::ElasticTerm &of, const Eigen::VectorXd &x) {
        Eigen::VectorXd force = Eigen::VectorXd::Zero(x.size());
        of.add_force(x, x, 0.0, force);
        return force;
    }
    Eigen::VectorXd force_of(const Eigen::VectorXd &x, const Eigen::VectorXd &stress) const {
        Eigen::VectorXd force = Eigen::VectorXd::Zero(x.size());
        term->add_force_of(x, stress, force);
        return force;
    }
};

TEST_P(EveryRelaxingTerm, IsTheElasticOneWhereNothingHasFaded) {
    const auto same = term->relaxed(1.0, {});
    EXPECT_DOUBLE_EQ(same->energy(shaken), term->energy(shaken));
    EXPECT_LT((force(*same, shaken) - force(*term, shaken)).norm(), 1e-14 * force(*term, shaken).norm());
}

TEST_P(EveryRelaxingTerm, IsTheSumOfWhatStaysAndWhatRelaxes) {
    const auto whole = force(*term, shaken);
    const Eigen::VectorXd sum =
        force(*term->relaxed(0.0, {}), shaken) + force_of(shaken, term->relaxing_stress(shaken));
    EXPECT_LT((sum - whole).norm(), 1e-12 * whole.norm());
    const Eigen::VectorXd more = force(*faded, shaken) - force(*term->relaxed(0.4, {}), shaken);
    EXPECT_GT(more.norm(), 0.01 * whole.norm());
    EXPECT_LT((more - force_of(shaken, added)).norm(), 1e-11 * whole.norm());
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
    if (GetParam().name.starts_with("springs"))
        EXPECT_GT(all, 0.01 * term->relaxing_stress(shaken).norm());
    else
        EXPECT_LT(all, 1e-11 * term->relaxing_stress(shaken).norm());
}

TEST_P(EveryRelaxingTerm, TurnsWithTheBody) {
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(1.1, Vector3(1.0, 2.0, -0.5).normalized()).toRotationMatrix();
    const auto turned = [&turn](const Eigen::VectorXd &field) {
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
    const Eigen::VectorXd small = rest + 1e-5 * (shaken - rest);
    const auto stress = term->relaxing_stress(small);
    const double expected = 0.5 * term->relaxing_compliance().cwiseProduct(stress).dot(stress);
    EXPECT_NEAR(term->energy(small) - term->relaxed(0.0, {})->energy(small), expected, 1e-5 * expected);
}

TEST_P(EveryRelaxingTerm, HasFastKernelsForTheElasticOneAlone) {
    EXPECT_FALSE(msm::step_parts(msm::ElasticBody(std::vector<double>(body->mesh.points.size(), 1.0), {faded})));
}

INSTANTIATE_TEST_SUITE_P(RelaxingTerms, EveryRelaxingTerm, testing::ValuesIn(relaxing_terms()),
                         [](const auto &info) { return info.param.name; });

TEST(RelaxingTerms, DoNotIncludeVolumesAndGuards) {
    const auto body = tests::make_body(tests::box_mesh({0.1, 0.1, 0.1}, {1, 1, 1}), {1060.0, 5e3, 0.4});
    EXPECT_EQ(dynamic_cast<const msm::RelaxingTerm *>(msm::inversion_guard(*body).get()), nullptr);
    for (const auto &volume : msm::all_volume_terms())
        EXPECT_EQ(dynamic_cast<const msm::RelaxingTerm *>(volume.make(*body, {7e3}).get()), nullptr);
}

/// A box constrained at one side, and pressed on the other by a fourth of its Young's modulus.
struct PressedBox {
    std::shared_ptr<const core::Body> body =
        tests::make_body(tests::shaken_box_mesh({0.1, 0.1, 0.1}, {3, 3, 3}), {1060.0, 5e3, 0.45});
    core::SpringNetwork springs = msm::spring_network(*body, msm::all_spring_laws().front());
    msm::NodalConditions conditions = [this] {
        auto load_case = tests::empty_load_case(body->mesh);
        tests::prescribe(load_case, body->mesh, "x_min", Vector3::Zero());
        tests::pull(load_case, body->mesh, "x_max", {-1250.0, 0.0, 0.0});
        return msm::nodal_conditions({body, load_case}, springs.node_mass);
    }();

    /// Volume of the smallest tetrahedron after the load has long been on, with much damping [m^3].
    double smallest_volume_at_rest(const msm::ElasticBody &elastic) const {
        const double highest = msm::largest_angular_frequency(elastic, body->mesh.points, conditions);
        const auto equation = msm::elastic_motion(elastic, body->mesh.points, conditions, {0.2 * highest, 0.0});
        const auto step = msm::find_integrator("symplectic_euler").prepare(equation, 0.3 / highest);
        const Eigen::VectorXd zero = Eigen::VectorXd::Zero(3 * body->mesh.num_nodes());
        msm::State state{zero, zero};
        for (int s = 0; s < 20000; ++s)
            step(state);
        EXPECT_LT(msm::kinetic_energy(equation, state), 1e-12);
        auto moved = body->mesh;
        for (int i = 0; i < moved.num_nodes(); ++i)
            moved.points[i] += msm::node_part(state.displacement, i);
        return std::ranges::min(core::tetrahedron_volumes(moved));
    }
};

/// Pressed together by a fifth or more, springs give way through their own mirror image, and the volume around a node
/// may stay what it was with a tetrahedron there inside out. The guard holds up to twice that load.
TEST(InversionGuard, HoldsTetrahedraThatSpringsLetTurnInsideOut) {
    const PressedBox box;
    const auto springs = msm::spring_term(box.springs);
    const auto resists = msm::all_volume_terms().front().make(*box.body, {8e3});
    const msm::ElasticBody unguarded(box.springs.node_mass, {springs, resists});
    const msm::ElasticBody guarded(box.springs.node_mass, {springs, resists, msm::inversion_guard(*box.body)});
    EXPECT_LT(box.smallest_volume_at_rest(unguarded), 0.0);
    EXPECT_GT(box.smallest_volume_at_rest(guarded), 0.0);
}

TEST(InversionGuard, IsNotFeltAsLongAsTetrahedraKeepHalfTheirVolume) {
    const PressedBox box;
    const auto guard = msm::inversion_guard(*box.body);
    auto squeezed = box.body->mesh.points;
    for (auto &x : squeezed)
        x.z() *= 0.51;
    EXPECT_EQ(guard->energy(msm::to_unknowns(squeezed)), 0.0);
    for (auto &x : squeezed)
        x.z() *= 0.9;
    EXPECT_GT(guard->energy(msm::to_unknowns(squeezed)), 0.0);
}

} // namespace
} // namespace livermark
