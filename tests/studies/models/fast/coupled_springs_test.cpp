#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>

#include "fem_reference/hyperelastic/material_law.hpp"
#include "fem_reference/linear/linear_elasticity.hpp"
#include "msm/elastic_body.hpp"
#include "msm/springs/springs.hpp"
#include "msm/springs/tetrahedron.hpp"
#include "msm/statics/equilibrium.hpp"
#include "msm/statics/load_path.hpp"
#include "tests/fem_reference/fem_test_bodies.hpp"
#include "tests/oracles/linear_elements.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

using core::Vector3;
using Eigen::Matrix3d;
using Field = std::vector<Vector3>;

/// Far from rest: stretched, sheared and turned, with a volume of 0.85.
Matrix3d large_deformation() {
    Matrix3d stretch;
    stretch << 1.3, 0.2, -0.1, 0.2, 0.7, 0.15, -0.1, 0.15, 1.05;
    return Eigen::AngleAxisd(0.8, Vector3(1.0, -2.0, 0.5).normalized()) * stretch;
}

Field deformed(const core::Body &body, const Matrix3d &f) {
    auto points = body.mesh.points;
    for (auto &x : points)
        x = f * x + Vector3(0.1, 0.2, -0.3);
    return points;
}

Field shaken(const core::Body &body, double largest) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> offset(-largest, largest);
    auto points = body.mesh.points;
    for (auto &x : points)
        x += Vector3(offset(random), offset(random), offset(random));
    return points;
}

/// W and P of the material of finite elements.
double energy_of(const hyperelastic::MaterialLaw &law, const core::Material &material, const Matrix3d &f) {
    const double g = law.volume(f.determinant()).value;
    return law.energy(material, f) + 0.5 * law.volume_modulus(material) * g * g;
}

Matrix3d stress_of(const hyperelastic::MaterialLaw &law, const core::Material &material, const Matrix3d &f) {
    const auto volume = law.volume(f.determinant());
    return law.stress(material, f) +
           law.volume_modulus(material) * volume.value * volume.slope * f.determinant() * f.inverse().transpose();
}

std::shared_ptr<const core::Body> box_of(double poisson_ratio) {
    return tests::make_body(tests::shaken_box_mesh({0.1, 0.08, 0.06}, {5, 4, 3}), {1060.0, 5000.0, poisson_ratio});
}

struct HyperelasticSprings : testing::TestWithParam<std::string> {
    std::shared_ptr<const core::Body> two_materials(double poisson_ratio) const {
        return tests::shaken_rod(poisson_ratio, {5, 4, 3}).body;
    }

    const msm::CoupledSprings &springs = msm::find_coupled_springs(GetParam());
    const hyperelastic::MaterialLaw &law = hyperelastic::material_law(springs.energy.name);
};

TEST_P(HyperelasticSprings, HaveTheEnergyOfTheMaterialWhereTheDeformationIsTheSameEverywhere) {
    const auto f = large_deformation();
    for (const double nu : {0.1, 0.25, 0.45, 0.49}) {
        const auto body = two_materials(nu);
        double expected = 0.0;
        const auto volumes = core::tetrahedron_volumes(body->mesh);
        for (std::size_t t = 0; t < volumes.size(); ++t)
            expected += volumes[t] * energy_of(law, body->materials[body->mesh.region[t]], f);
        const auto model = msm::coupled_springs_with_volume(*body, springs);
        EXPECT_NEAR(msm::elastic_energy(model, deformed(*body, f)), expected, 1e-12 * expected) << nu;
    }
}

/// Inside nothing pulls, and each facet of the surface is held by P N of the material.
TEST_P(HyperelasticSprings, HaveTheStressOfTheMaterialWhereTheDeformationIsTheSameEverywhere) {
    const auto f = large_deformation();
    for (const double nu : {0.1, 0.25, 0.45, 0.49}) {
        const auto body = box_of(nu);
        const Matrix3d stress = stress_of(law, body->materials.front(), f);
        Field expected(body->mesh.points.size(), Vector3::Zero());
        double scale = 0.0;
        for (int facet = 0; facet < body->mesh.num_boundary_triangles(); ++facet)
            for (const int node : body->mesh.boundary_triangles[facet])
                expected[node] += stress * core::area_vector(body->mesh, facet) / 3.0;
        for (const auto &force : expected)
            scale = std::max(scale, force.norm());
        const auto found = msm::elastic_gradient(msm::coupled_springs_with_volume(*body, springs), deformed(*body, f));
        for (std::size_t i = 0; i < expected.size(); ++i)
            EXPECT_LT((found[i] - expected[i]).norm(), 1e-11 * scale) << nu << " " << i;
    }
}

/// Any energy and measure has the same second derivative at rest, that of linear elasticity.
TEST_P(HyperelasticSprings, AreSpringsOfHookesLawForSmallStrains) {
    const auto body = two_materials(0.25);
    const auto rest = msm::to_unknowns(body->mesh.points);
    auto hookes = msm::find_coupled_springs("nodal_springs");
    hookes.domains = springs.domains;
    for (const double part : {0.0, 0.3, 1.0}) {
        const Eigen::SparseMatrix<double> found =
            msm::coupled_springs(*body, msm::with_part_inside(springs, part))->hessian(rest, msm::Tangent::exact);
        const Eigen::SparseMatrix<double> expected =
            msm::coupled_springs(*body, msm::with_part_inside(hookes, part))->hessian(rest, msm::Tangent::exact);
        EXPECT_LT((found - expected).norm(), 1e-12 * expected.norm()) << part;
    }
}

TEST_P(HyperelasticSprings, HaveNoEnergyWhereATetrahedronIsInsideOut) {
    const auto body = box_of(0.45);
    const auto model = msm::coupled_springs_with_volume(*body, springs);
    auto points = body->mesh.points;
    const auto &corners = body->mesh.tetrahedra[body->mesh.tetrahedra.size() / 2];
    points[corners[0]] +=
        1.2 * ((points[corners[1]] + points[corners[2]] + points[corners[3]]) / 3.0 - points[corners[0]]);
    EXPECT_TRUE(std::isinf(msm::elastic_energy(model, points)));
}

/// A box held at one end and loaded at the other.
core::Problem loaded(const std::shared_ptr<const core::Body> &body, const Vector3 &traction) {
    auto load_case = tests::empty_load_case(body->mesh);
    tests::prescribe(load_case, body->mesh, "x_min", Vector3::Zero());
    tests::pull(load_case, body->mesh, "x_max", traction);
    return {body, load_case};
}

/// A factor of linear elements leads to the same place as one of the second derivative.
TEST_P(HyperelasticSprings, ComeToTheSameRestWithThePreconditionerAsWithout) {
    for (const double nu : {0.25, 0.45, 0.49}) {
        const auto body = two_materials(nu);
        const auto problem = loaded(body, {100.0, 150.0, -200.0});
        auto model = msm::coupled_springs_with_volume(*body, springs);
        const auto conditions = msm::nodal_conditions(problem, model.node_mass);
        ASSERT_TRUE(model.preconditioner);
        const auto found = msm::find_equilibrium(model, body->mesh.points, conditions);
        model.preconditioner = nullptr;
        const auto expected = msm::find_equilibrium(model, body->mesh.points, conditions);
        ASSERT_EQ(found.status, core::SolutionStatus::ok) << found.message;
        ASSERT_EQ(expected.status, core::SolutionStatus::ok) << expected.message;
        EXPECT_LT(tests::relative_difference(found.linear_displacement, expected.linear_displacement), 1e-8) << nu;
        EXPECT_LT(tests::relative_difference(found.displacement, expected.displacement), 1e-8) << nu;
        EXPECT_EQ(found.num_factors, 0);
        EXPECT_GT(tests::relative_difference(found.displacement, found.linear_displacement), 0.01) << "it is linear";
    }
}

TEST_P(HyperelasticSprings, FollowAPathWithPressureThatFollowsTheSurface) {
    const auto body = box_of(0.45);
    const auto model = msm::coupled_springs_with_volume(*body, springs);
    auto load_case = tests::empty_load_case(body->mesh);
    load_case.regime = core::Regime::large;
    load_case.path = {0.5, 1.0};
    tests::prescribe(load_case, body->mesh, "x_min", Vector3::Zero());
    load_case.conditions.push_back({"all around", core::ConditionKind::pressure});
    for (int f = 0; f < body->mesh.num_boundary_triangles(); ++f)
        if (load_case.is_free(f)) {
            load_case.condition_on[f] = 1;
            load_case.value[f] = -1600.0 * core::area_vector(body->mesh, f).normalized();
        }
    const core::Problem problem{body, load_case};
    const auto conditions = msm::nodal_conditions(problem, model.node_mass);
    const msm::RestStiffness rest(model, body->mesh.points, conditions.displacement);
    const auto path = msm::follow_path(model, problem, model.node_mass, rest);
    ASSERT_EQ(path.end.status, core::SolutionStatus::ok) << path.end.message;
    ASSERT_EQ(path.points.size(), 2U);
    const auto positions = msm::moved(body->mesh.points, path.end.displacement);
    const auto push = msm::SurfacePressure(problem).force(positions), elastic = msm::elastic_gradient(model, positions);
    double largest = 0.0;
    for (const auto &force : push)
        largest = std::max(largest, force.norm());
    for (std::size_t i = 0; i < positions.size(); ++i)
        if (body->mesh.points[i].x() > 1e-9) {
            EXPECT_LT((elastic[i] - push[i]).norm(), 1e-5 * largest) << i;
        }
}

INSTANTIATE_TEST_SUITE_P(Models, HyperelasticSprings, testing::ValuesIn([] {
                             std::vector<std::string> names;
                             for (const auto &springs : msm::all_coupled_springs())
                                 if (!springs.energy.is_finite)
                                     names.push_back(springs.name);
                             return names;
                         }()),
                         [](const auto &info) { return info.param; });

/// Springs of Hooke's law with another part inside tetrahedra.
std::shared_ptr<const msm::ElasticTerm> springs_of(const core::Body &body, double part) {
    return msm::coupled_springs(body, msm::with_part_inside(msm::find_coupled_springs("nodal_springs"), part));
}

constexpr double some = 0.2;

/// Nothing is left to the nodes, so for small strains they are linear elements.
TEST(NodalSprings, AreLinearElementsWhereAllStiffnessIsInsideTetrahedra) {
    const auto body = box_of(0.25);
    const auto rest = msm::to_unknowns(body->mesh.points);
    const Eigen::SparseMatrix<double> found = springs_of(*body, 1.0)->hessian(rest, msm::Tangent::exact);
    const Eigen::SparseMatrix<double> expected = tests::linear_elements(*body)->hessian(rest, msm::Tangent::exact);
    EXPECT_LT((found - expected).norm(), 1e-13 * expected.norm());
}

/// Means of a strain that is the same everywhere are that strain: V mu (1/2 (tr E)^2 + E : E), whatever the part
/// inside.
TEST(NodalSprings, HaveTheEnergyOfTheSolidWhereTheStrainIsTheSameEverywhere) {
    const auto body = box_of(0.25);
    Eigen::Matrix3d strain;
    strain << 2.0, 0.5, -1.0, 0.5, -1.0, 0.8, -1.0, 0.8, 1.5;
    strain *= 1e-6;
    auto moved = body->mesh.points;
    for (auto &x : moved)
        x += strain * x;
    double volume = 0.0;
    for (const double v : core::tetrahedron_volumes(body->mesh))
        volume += v;
    const double expected = volume * body->materials.front().shear_modulus() *
                            (0.5 * strain.trace() * strain.trace() + strain.squaredNorm());
    for (const double part : {0.0, some, 1.0})
        EXPECT_NEAR(springs_of(*body, part)->energy(msm::to_unknowns(moved)), expected, 1e-5 * expected);
}

/// A bar of one material that is pulled to twice its length takes twice the force of 1.5 times its length: elongations,
/// not their squares.
TEST(NodalSprings, PullInProportionToTheElongation) {
    const auto body = box_of(0.25);
    const auto force_at = [&](double elongation) {
        Eigen::VectorXd x = (1.0 + elongation) * msm::to_unknowns(body->mesh.points);
        Eigen::VectorXd force = Eigen::VectorXd::Zero(x.size());
        springs_of(*body, some)->add_force(x, x, 0.0, force);
        return force;
    };
    const auto half = force_at(0.5), whole = force_at(1.0);
    EXPECT_LT((whole - 2.0 * half).norm(), 1e-12 * whole.norm());
    EXPECT_GT(half.norm(), 0.0);
}

/// Strains that cancel around every node cost nothing but what they cost inside the tetrahedra; means around edges
/// leave nothing free by themselves.
TEST(CoupledSprings, LeaveNoMotionFree) {
    const auto body = tests::make_body(tests::shaken_box_mesh({0.1, 0.08, 0.06}, {3, 2, 2}), {1060.0, 5000.0, 0.25});
    const auto rest = msm::to_unknowns(body->mesh.points);
    const auto least = [&](const msm::CoupledSprings &springs) {
        const Eigen::MatrixXd stiffness = msm::coupled_springs(*body, springs)->hessian(rest, msm::Tangent::exact);
        const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(stiffness, Eigen::EigenvaluesOnly);
        const double largest = eigen.eigenvalues().maxCoeff();
        EXPECT_EQ((eigen.eigenvalues().array() < 1e-10 * largest).count(), 6) << springs.name;
        return eigen.eigenvalues()[6] / largest;
    };
    for (const auto &springs : msm::all_coupled_springs()) {
        EXPECT_GT(least(springs), 1e-3) << springs.name;
        if (springs.domains.edges > 0.0) {
            EXPECT_GT(least(msm::with_part_inside(springs, 0.0)), 1e-3) << springs.name;
        }
    }
}

/// A mean has a smaller square than what it is of, and around nodes it is one that leaves the sum alone.
TEST(MeansOfVolumes, CostNoMoreThanTheVolumesThemselves) {
    const auto body = box_of(0.45);
    const auto x = msm::to_unknowns(shaken(*body, 0.02));
    const auto parts = msm::nodal_parts(*body);
    const double mean = msm::volume_penalty(body->mesh, msm::mean_volumes_around_nodes(parts, {1e4}))->energy(x);
    const double own = msm::volume_penalty(body->mesh, msm::volumes_around_nodes(parts, {1e4}))->energy(x);
    EXPECT_LT(mean, 0.9 * own);
    EXPECT_GT(mean, 0.0);
}

/// Against quadratic finite elements on the same mesh, which at 0.49 lock a little themselves, linear ones lose at
/// least twice as much.
TEST(CoupledSprings, AreTwiceAsGoodAsLinearFiniteElementsUnderSmallLoads) {
    for (const double nu : {0.25, 0.45, 0.49}) {
        const auto body = box_of(nu);
        const auto problem = loaded(body, {3.0, 5.0, -2.0});
        const auto expected = fem_reference::StaticSolver(body, 2).solve(problem.load_case).displacement;
        const auto linear = fem_reference::StaticSolver(body, 1).solve(problem.load_case).displacement;
        for (const auto &springs : msm::all_coupled_springs()) {
            const auto model = msm::coupled_springs_with_volume(*body, springs);
            const auto found =
                msm::find_equilibrium(model, body->mesh.points, msm::nodal_conditions(problem, model.node_mass))
                    .linear_displacement;
            EXPECT_LT(tests::relative_difference(found, expected), 0.5 * tests::relative_difference(linear, expected))
                << springs.name << " " << nu;
        }
    }
}

class LinearElements : public testing::TestWithParam<double> {};

/// V (lambda / 2 (tr E)^2 + mu E : E) with E = (F^T F - I) / 2, at deformations as large as the elements.
TEST_P(LinearElements, HaveTheEnergyOfSaintVenantAndKirchhoff) {
    const auto body = box_of(GetParam());
    const auto &material = body->materials.front();
    const auto moved = shaken(*body, 0.02);
    const auto volumes = core::tetrahedron_volumes(body->mesh);
    double expected = 0.0;
    for (std::size_t t = 0; t < volumes.size(); ++t) {
        Matrix3d before, after; // edges
        const auto &nodes = body->mesh.tetrahedra[t];
        for (int a = 0; a < 3; ++a) {
            before.col(a) = body->mesh.points[nodes[a + 1]] - body->mesh.points[nodes[0]];
            after.col(a) = moved[nodes[a + 1]] - moved[nodes[0]];
        }
        const Matrix3d f = after * before.inverse();
        const Eigen::Matrix3d strain = 0.5 * (f.transpose() * f - Eigen::Matrix3d::Identity());
        expected += volumes[t] * (0.5 * material.lame_lambda() * strain.trace() * strain.trace() +
                                  material.shear_modulus() * strain.squaredNorm());
    }
    EXPECT_NEAR(tests::linear_elements(*body)->energy(msm::to_unknowns(moved)), expected, 1e-12 * expected);
}

/// Linearised, they are linear finite elements, which were put together by another library from other formulas.
TEST_P(LinearElements, AreLinearFiniteElementsUnderSmallLoads) {
    auto problem = loaded(box_of(GetParam()), {10.0, 20.0, -5.0});
    problem.load_case.acceleration = {0.1, 0.0, -0.3};
    const msm::ElasticBody springs(msm::lumped_masses(*problem.body), {tests::linear_elements(*problem.body)});
    const auto found =
        msm::find_equilibrium(springs, problem.body->mesh.points, msm::nodal_conditions(problem, springs.node_mass));
    fem_reference::StaticSolver fem(problem.body, 1);
    const auto expected = fem.solve(problem.load_case).displacement;
    EXPECT_LT(tests::relative_difference(found.linear_displacement, expected), 1e-12);
    EXPECT_GT(tests::relative_difference(found.displacement, expected), 1e-4); // they are not linear
}

/// With lambda / mu of 2.5, or of 12 where lambda is above 10 mu.
TEST_P(LinearElements, OfSofterVolumeAreTheStiffnessThatPreconditions) {
    const auto body = box_of(GetParam());
    const auto &material = body->materials.front();
    const double mu = material.shear_modulus();
    const double lambda = std::min(material.lame_lambda(), (material.lame_lambda() > 10.0 * mu ? 12.0 : 2.5) * mu);
    const double nu = 0.5 * lambda / (lambda + mu);
    const core::Body softer{body->name, body->mesh, {{material.density, 2.0 * mu * (1.0 + nu), nu}}};
    const auto expected =
        tests::linear_elements(softer)->hessian(msm::to_unknowns(body->mesh.points), msm::Tangent::material);
    EXPECT_LT((msm::stiffness_of_softer_volume(*body, 1.0) - expected).norm(), 1e-13 * expected.norm());
}

INSTANTIATE_TEST_SUITE_P(PoissonRatio, LinearElements, testing::Values(0.0, 0.25, 0.45, 0.49),
                         [](const auto &info) { return "nu_" + std::to_string(std::lround(100.0 * info.param)); });

} // namespace
} // namespace livermark
