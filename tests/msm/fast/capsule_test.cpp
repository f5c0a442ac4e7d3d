#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "msm/springs/springs.hpp"
#include "msm/statics/equilibrium.hpp"
#include "tests/fem_reference/fem_test_bodies.hpp"
#include "tests/samples/covered_bodies.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

namespace covered = tests::covered;

const core::Material soft{1060.0, 5000.0, 0.45};

/// Mean growth of a ball under a traction, over that of the closed form.
double growth_of_ball(const msm::ElasticBody &body, const core::Problem &problem, double pressure) {
    const auto found = msm::find_equilibrium(body, problem.body->mesh.points,
                                             msm::nodal_conditions(problem, body.node_mass), {.bears_rounding = true});
    EXPECT_EQ(found.status, core::SolutionStatus::ok) << found.message;
    return covered::growth(problem.body->mesh, found.displacement).mean / covered::small_growth(0.03, soft, pressure);
}

} // namespace

/// On regular triangles the springs are a plane stress with E t and Poisson's ratio 1/3: three eighths of E t in shear.
TEST(CapsuleSprings, AreAPlaneStressOnRegularTriangles) {
    const auto body = covered::with_capsule(tests::make_body(tests::regular_tetrahedron(0.01), soft));
    const auto edges = core::edge_table(body->mesh.tetrahedra);
    const auto stiffness = core::capsule_springs(*body, edges);
    const auto strain = covered::some_strain();
    double energy = 0.0, expected = 0.0;
    for (std::size_t e = 0; e < edges.edges.size(); ++e) {
        const auto &[a, b] = edges.edges[e];
        const core::Vector3 span = body->mesh.points[b] - body->mesh.points[a];
        const double longer = span.dot(strain * span) / span.norm();
        energy += 0.5 * stiffness[e] * longer * longer;
    }
    const double shear = 3.0 / 8.0 * covered::capsule.stiffness();
    for (int f = 0; f < body->mesh.num_boundary_triangles(); ++f) {
        const core::Vector3 normal = core::area_vector(body->mesh, f);
        const auto here = covered::in_plane(strain, normal);
        expected += normal.norm() * shear * (here.squaredNorm() + 0.5 * here.trace() * here.trace());
    }
    EXPECT_NEAR(energy, expected, 1e-12 * expected);
}

TEST(CapsuleSprings, AreNotWhereACutHasOpenedTheBody) {
    auto mesh = tests::box_mesh({0.1, 0.1, 0.1}, {2, 2, 2});
    for (auto &name : mesh.patch_names)
        name = std::string(core::wound_patch) + core::patch_joint + name;
    const auto body = covered::with_capsule(tests::make_body(mesh, soft));
    for (const double stiffness : core::capsule_springs(*body, core::edge_table(mesh.tetrahedra)))
        EXPECT_EQ(stiffness, 0.0);
    EXPECT_EQ(msm::coupled_capsule(*body)->energy(1.1 * msm::to_unknowns(mesh.points)), 0.0);
}

/// Energy of the closed form on any triangles, where all strains are the same.
TEST(CoupledCapsule, StoresTheEnergyOfAnEvenStrain) {
    const auto body =
        covered::with_capsule(tests::make_body(tests::shaken_box_mesh({0.1, 0.08, 0.06}, {3, 2, 2}), soft));
    const Eigen::Matrix3d f = Eigen::Matrix3d::Identity() + covered::some_strain();
    auto moved = body->mesh.points;
    for (auto &point : moved)
        point = f * point;
    const double expected = covered::capsule_energy(*body, f);
    EXPECT_NEAR(msm::coupled_capsule(*body)->energy(msm::to_unknowns(moved)), expected, 1e-11 * expected);
    EXPECT_EQ(msm::coupled_capsule(*tests::make_body(body->mesh, soft)), nullptr);
}

/// Springs hold a ball together under a traction along its normals as the closed form says. Those that are not coupled
/// have another Poisson's ratio than the capsule, and hold it less.
TEST(CoupledCapsule, HoldsABallTogether) {
    constexpr double radius = 0.03, pressure = 0.5;
    const auto problem = covered::blown_up_ball(radius, 6, soft, pressure, core::ConditionKind::traction);
    const auto &springs = msm::find_coupled_springs("nodal_neo_hookean");
    EXPECT_NEAR(growth_of_ball(msm::coupled_springs_with_volume(*problem.body, springs), problem, pressure), 1.0, 0.03);
    const core::Problem bare{covered::with_capsule(problem.body, std::nullopt), problem.load_case};
    EXPECT_GT(growth_of_ball(msm::coupled_springs_with_volume(*bare.body, springs), bare, pressure), 1.1);
    const auto beside =
        msm::springs_with_volume(*problem.body, msm::springs_beside_volume(*problem.body, msm::patch_with(1.0)),
                                 msm::find_volume_term("nodal_volume"));
    const double uncoupled = growth_of_ball(beside.body, problem, pressure);
    EXPECT_GT(uncoupled, 1.0);
    EXPECT_LT(uncoupled, 1.12) << "25 % softer where it grows in both directions, beside the body";
}

} // namespace livermark
