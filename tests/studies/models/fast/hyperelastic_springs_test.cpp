#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <gtest/gtest.h>
#include <random>

#include "fem_reference/hyperelastic/material_law.hpp"
#include "fem_reference/linear/linear_elasticity.hpp"
#include "msm/springs/coupled_springs.hpp"
#include "msm/statics/equilibrium.hpp"
#include "msm/statics/load_path.hpp"
#include "tests/fem_reference/fem_test_bodies.hpp"
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

struct HyperelasticSprings : testing::TestWithParam<std::string> {
    std::shared_ptr<const core::Body> box(double poisson_ratio) const {
        return tests::make_body(tests::shaken_box_mesh(tests::rod_size, {5, 4, 3}), {1060.0, 5000.0, poisson_ratio});
    }
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
        const auto body = box(nu);
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

TEST_P(HyperelasticSprings, TurnTheirForcesWithTheBody) {
    const auto body = two_materials(0.45);
    const auto model = msm::coupled_springs_with_volume(*body, springs);
    const Eigen::AngleAxisd turn(2.0, Vector3(0.3, 1.0, -0.7).normalized());
    const auto points = shaken(*body, 0.002);
    auto turned = points;
    for (auto &x : turned)
        x = turn * x;
    const double expected = msm::elastic_energy(model, points);
    EXPECT_GT(expected, 0.0);
    EXPECT_NEAR(msm::elastic_energy(model, turned), expected, 1e-12 * expected);
    const auto forces = msm::elastic_gradient(model, points), found = msm::elastic_gradient(model, turned);
    for (std::size_t i = 0; i < forces.size(); ++i)
        EXPECT_LT((found[i] - turn * forces[i]).norm(), 1e-11 * (1.0 + forces[i].norm())) << i;
}

/// Any energy and measure has the same second derivative at rest, that of linear elasticity.
TEST_P(HyperelasticSprings, AreSpringsOfHookesLawForSmallStrains) {
    const auto body = two_materials(0.25);
    const auto rest = msm::to_unknowns(body->mesh.points);
    auto of_hooke = msm::find_coupled_springs("nodal_springs");
    of_hooke.domains = springs.domains;
    for (const double part : {0.0, 0.3, 1.0}) {
        const Eigen::SparseMatrix<double> found =
            msm::coupled_springs(*body, msm::with_part_inside(springs, part))->hessian(rest, msm::Tangent::exact);
        const Eigen::SparseMatrix<double> expected =
            msm::coupled_springs(*body, msm::with_part_inside(of_hooke, part))->hessian(rest, msm::Tangent::exact);
        EXPECT_LT((found - expected).norm(), 1e-12 * expected.norm()) << part;
    }
}

TEST_P(HyperelasticSprings, HaveNoEnergyWhereATetrahedronIsInsideOut) {
    const auto body = box(0.45);
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

TEST_P(HyperelasticSprings, ApproachLinearElasticityInProportionToTheLoad) {
    const auto body = two_materials(0.45);
    const auto model = msm::coupled_springs_with_volume(*body, springs);
    const auto nonlinearity = [&](double load) {
        const auto problem = loaded(body, {load, 2.0 * load, -load});
        const auto found =
            msm::find_equilibrium(model, body->mesh.points, msm::nodal_conditions(problem, model.node_mass));
        EXPECT_EQ(found.status, core::SolutionStatus::ok) << found.message;
        return tests::relative_difference(found.displacement, found.linear_displacement);
    };
    EXPECT_NEAR(nonlinearity(2.0) / nonlinearity(1.0), 2.0, 0.1);
}

/// Against quadratic finite elements, which at 0.49 lock a little themselves, linear ones lose at least twice as much.
TEST_P(HyperelasticSprings, AreTwiceAsGoodAsLinearFiniteElementsUnderSmallLoads) {
    for (const double nu : {0.25, 0.45, 0.49}) {
        const auto body = box(nu);
        const auto problem = loaded(body, {3.0, 5.0, -2.0});
        const auto model = msm::coupled_springs_with_volume(*body, springs);
        const auto found =
            msm::find_equilibrium(model, body->mesh.points, msm::nodal_conditions(problem, model.node_mass))
                .linear_displacement;
        const auto expected = fem_reference::StaticSolver(body, 2).solve(problem.load_case).displacement;
        const auto linear = fem_reference::StaticSolver(body, 1).solve(problem.load_case).displacement;
        EXPECT_LT(tests::relative_difference(found, expected), 0.5 * tests::relative_difference(linear, expected))
            << nu;
    }
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
    const auto body = box(0.45);
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
    auto positions = body->mesh.points;
    for (std::size_t i = 0; i < positions.size(); ++i)
        positions[i] += path.end.displacement[i];
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

} // namespace
} // namespace livermark
