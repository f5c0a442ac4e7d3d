#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "fem_reference/linear/elastic_system.hpp"
#include "fem_reference/linear/linear_elasticity.hpp"
#include "fem_reference/solvers/constrained_solver.hpp"
#include "tests/fem_reference/fem_test_bodies.hpp"
#include "tests/not_a_number.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {

namespace {

using core::Vector3;
using tests::nan;
const core::Material patch_material{1060.0, 5000.0, 0.45};
const Vector3 patch_size(0.1, 0.08, 0.06);

/// Parameter: degree of the elements.
class FemPatch : public testing::TestWithParam<int> {};

std::vector<Vector3> affine_field(const std::vector<Vector3> &points, const Eigen::Matrix3d &gradient,
                                  const Vector3 &shift) {
    std::vector<Vector3> field;
    for (const auto &point : points)
        field.push_back(gradient * point + shift);
    return field;
}

std::vector<double> flat(const std::vector<Vector3> &field) {
    std::vector<double> values;
    for (const auto &vector : field)
        values.insert(values.end(), {vector.x(), vector.y(), vector.z()});
    return values;
}

} // namespace

TEST_P(FemPatch, AffineBoundaryDisplacementGivesTheAffineField) {
    const auto body = tests::make_body(tests::shaken_box_mesh(patch_size, {4, 3, 3}), patch_material);
    const auto system = fem_reference::assemble(*body, GetParam());
    Eigen::Matrix3d gradient;
    gradient << 0.01, -0.02, 0.005, 0.03, -0.01, 0.02, -0.015, 0.007, 0.02;
    const auto exact = affine_field(system.points, gradient, {0.001, -0.002, 0.003});
    std::vector<double> prescribed(3 * exact.size(), nan);
    for (const int node : system.facet_nodes)
        for (int i = 0; i < 3; ++i)
            prescribed[3 * node + i] = exact[node][i];
    ASSERT_GT(std::ranges::count_if(prescribed, [](double value) { return std::isnan(value); }), 0);

    fem_reference::ConstrainedSolver solver(compressed_rows(system.stiffness));
    const auto found = solver.solve(prescribed, std::vector<double>(prescribed.size(), 0.0));
    ASSERT_TRUE(found.unique);
    std::vector<Vector3> displacement;
    for (std::size_t node = 0; node < exact.size(); ++node)
        displacement.push_back(Vector3::Map(&found.displacement[3 * node]));
    EXPECT_LT(tests::relative_difference(displacement, exact), 1e-10);

    // W = V (lambda/2 tr(eps)^2 + mu eps : eps)
    const Eigen::Matrix3d strain = 0.5 * (gradient + gradient.transpose());
    const double energy = patch_size.prod() * (0.5 * patch_material.lame_lambda() * strain.trace() * strain.trace() +
                                               patch_material.shear_modulus() * strain.squaredNorm());
    EXPECT_NEAR(found.energy, energy, 1e-10 * energy);
}

TEST_P(FemPatch, UniaxialTractionGivesYoungModulusAndPoissonRatio) {
    const auto body = tests::make_body(tests::shaken_box_mesh(patch_size, {4, 3, 3}), patch_material);
    const auto &mesh = body->mesh;
    auto load_case = tests::empty_load_case(mesh);
    tests::prescribe(load_case, mesh, "x_min", {0.0, nan, nan});
    tests::prescribe(load_case, mesh, "y_min", {nan, 0.0, nan});
    tests::prescribe(load_case, mesh, "z_min", {nan, nan, 0.0});
    const double traction = 50.0;
    tests::pull(load_case, mesh, "x_max", {traction, 0.0, 0.0});
    const auto solution = fem_reference::solve_static({body, load_case}, GetParam());
    ASSERT_EQ(solution.status, core::SolutionStatus::ok) << solution.message;

    const double strain = traction / patch_material.young_modulus;
    const Eigen::Matrix3d gradient =
        Vector3(strain, -patch_material.poisson_ratio * strain, -patch_material.poisson_ratio * strain).asDiagonal();
    EXPECT_LT(tests::relative_difference(solution.displacement, affine_field(mesh.points, gradient, Vector3::Zero())),
              1e-10);
    const double area = patch_size.y() * patch_size.z();
    EXPECT_LT(tests::relative_difference(solution.reaction,
                                         {Vector3(-traction * area, 0.0, 0.0), Vector3::Zero(), Vector3::Zero()}),
              1e-9);
    const double energy = 0.5 * traction * strain * patch_size.prod();
    EXPECT_NEAR(solution.strain_energy, energy, 1e-10 * energy);
}

TEST_P(FemPatch, SimpleShearFromFacetsThatMoveAndFacetsThatPull) {
    const auto body = tests::make_body(tests::shaken_box_mesh(patch_size, {4, 3, 3}), patch_material);
    const auto &mesh = body->mesh;
    const double shear = 0.02;
    auto load_case = tests::empty_load_case(mesh);
    tests::prescribe(load_case, mesh, "z_min", Vector3::Zero());
    tests::prescribe(load_case, mesh, "z_max", {shear * patch_size.z(), 0.0, 0.0});
    const double stress = patch_material.shear_modulus() * shear;
    tests::pull(load_case, mesh, "x_min", {0.0, 0.0, -stress});
    tests::pull(load_case, mesh, "x_max", {0.0, 0.0, stress});
    const auto solution = fem_reference::solve_static({body, load_case}, GetParam());
    ASSERT_EQ(solution.status, core::SolutionStatus::ok) << solution.message;
    Eigen::Matrix3d gradient = Eigen::Matrix3d::Zero();
    gradient(0, 2) = shear;
    EXPECT_LT(tests::relative_difference(solution.displacement, affine_field(mesh.points, gradient, Vector3::Zero())),
              1e-10);
}

TEST_P(FemPatch, RigidMotionsCostNoEnergyAndNoForce) {
    const auto body = tests::make_body(tests::shaken_box_mesh(patch_size, {4, 3, 3}), patch_material);
    const auto system = fem_reference::assemble(*body, GetParam());
    fem_reference::ConstrainedSolver solver(compressed_rows(system.stiffness));
    const auto forces_of = [&](const Eigen::Matrix3d &gradient) {
        const auto motion = flat(affine_field(system.points, gradient, {0.01, -0.02, 0.03}));
        return solver.solve(motion, std::vector<double>(motion.size(), 0.0));
    };
    Eigen::Matrix3d spin;
    spin << 0.0, -0.3, 0.2, 0.3, 0.0, -0.1, -0.2, 0.1, 0.0;
    const auto rigid = forces_of(spin);
    const auto strained = forces_of(spin.cwiseAbs()); // same size, but no rotation
    const auto largest = [](const std::vector<double> &values) {
        return std::abs(*std::ranges::max_element(values, {}, [](double value) { return std::abs(value); }));
    };
    EXPECT_LT(std::abs(rigid.energy), 1e-12 * strained.energy);
    EXPECT_LT(largest(rigid.residual), 1e-12 * largest(strained.residual));
}

TEST_P(FemPatch, SeriesBarOfTwoMaterials) {
    auto mesh = tests::box_mesh(patch_size, {4, 2, 2});
    mesh.region_names = {"near", "far"};
    for (int t = 0; t < mesh.num_tetrahedra(); ++t) {
        double x = 0.0;
        for (const int node : mesh.tetrahedra[t])
            x += mesh.points[node].x() / 4.0;
        mesh.region[t] = x < patch_size.x() / 2.0 ? 0 : 1;
    }
    auto body = std::make_shared<core::Body>();
    body->name = "bar";
    body->mesh = mesh;
    body->materials = {{1060.0, 5000.0, 0.0}, {1060.0, 50000.0, 0.0}};
    auto load_case = tests::empty_load_case(mesh);
    tests::prescribe(load_case, mesh, "x_min", Vector3::Zero());
    tests::prescribe(load_case, mesh, "x_max", {0.001, 0.0, 0.0});
    const auto solution = fem_reference::solve_static({body, load_case}, GetParam());
    ASSERT_EQ(solution.status, core::SolutionStatus::ok) << solution.message;

    // The same stress in both halves: u_end = stress (L / 2) (1 / E_near + 1 / E_far)
    const double half = patch_size.x() / 2.0;
    const double stress = 0.001 / (half / 5000.0 + half / 50000.0);
    std::vector<Vector3> exact;
    for (const auto &point : mesh.points)
        exact.emplace_back(stress * (std::min(point.x(), half) / 5000.0 + std::max(point.x() - half, 0.0) / 50000.0),
                           0.0, 0.0);
    EXPECT_LT(tests::relative_difference(solution.displacement, exact), 1e-10);
    const Vector3 force(stress * patch_size.y() * patch_size.z(), 0.0, 0.0);
    EXPECT_LT(tests::relative_difference(solution.reaction, {-force, force}), 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Degree, FemPatch, testing::Values(1, 2));

} // namespace livermark

namespace livermark::fem_reference {
namespace {

constexpr int no_factor = 0;

/// A box that is constrained at one end, and pulled at the other.
struct Pulled {
    explicit Pulled(double poisson_ratio) {
        body = tests::make_body(tests::box_mesh({0.09, 0.03, 0.03}, {9, 3, 3}), {1000.0, 5000.0, poisson_ratio});
        constrained = tests::empty_load_case(body->mesh);
        tests::prescribe(constrained, body->mesh, "x_min", core::Vector3::Zero());
    }
    core::LoadCase load(const core::Vector3 &traction) const {
        auto load_case = constrained;
        tests::pull(load_case, body->mesh, "x_max", traction);
        return load_case;
    }
    std::shared_ptr<const core::Body> body;
    core::LoadCase constrained;
};

double relative_error(const std::vector<core::Vector3> &found, const std::vector<core::Vector3> &expected) {
    double off = 0.0, size = 0.0;
    for (std::size_t i = 0; i < expected.size(); ++i) {
        off = std::max(off, (found.at(i) - expected[i]).norm());
        size = std::max(size, expected[i].norm());
    }
    return off / size;
}

TEST(RepeatedLoads, AgreeWithTheStaticSolverWithAndWithoutAFactor) {
    for (const double poisson_ratio : {0.3, 0.45, 0.49}) {
        const Pulled pulled(poisson_ratio);
        StaticSolver expected(pulled.body, 2);
        std::vector<std::string> told;
        const auto tell = [&](const std::string &sentence) { told.push_back(sentence); };
        RepeatedLoads factor(*pulled.body, pulled.constrained, tell);
        RepeatedLoads levels(*pulled.body, pulled.constrained, tell, no_factor);
        EXPECT_EQ(told.size(), 4U);
        std::vector<double> last_of_factor, last_of_levels;
        for (const core::Vector3 &traction : {core::Vector3(100.0, 0.0, 0.0), {0.0, 50.0, -20.0}}) {
            const auto load_case = pulled.load(traction);
            const auto solution = expected.solve(load_case);
            const auto exact = factor.solve(load_case, last_of_factor);
            EXPECT_TRUE(exact.has_converged);
            EXPECT_LT(relative_error(exact.displacement, solution.displacement), 1e-9);
            EXPECT_NEAR(exact.work, 2.0 * solution.strain_energy, 1e-9 * exact.work);
            const auto near = levels.solve(load_case, last_of_levels);
            EXPECT_TRUE(near.has_converged);
            EXPECT_GT(near.iterations, 1);
            EXPECT_LT(relative_error(near.displacement, solution.displacement), 1e-4) << poisson_ratio;
            EXPECT_NEAR(near.work, exact.work, 1e-4 * exact.work);
        }
    }
}

/// StaticSolver finds what a newton on each place does at all of them.
TEST(RepeatedLoads, MoveUnderForcesOnPlacesInside) {
    const Pulled pulled(0.45);
    const core::Vector3 middle(0.045, 0.015, 0.015);
    RepeatedLoads::InnerForces inner{{{middle, 0.008}, {middle + core::Vector3(0.004, 0.0, 0.0), 0.008}},
                                     {{3.0, -1.0, 2.0}, {0.0, 4.0, 1.0}}};
    StaticSolver solver(pulled.body, 2);
    const auto compliance = solver.compliance(pulled.constrained, inner.places);
    const Eigen::VectorXd force = Eigen::Map<const Eigen::VectorXd>(inner.forces.front().data(), 6);
    for (const int largest : {no_factor, RepeatedLoads::largest_factor}) {
        RepeatedLoads loads(
            *pulled.body, pulled.constrained, [](const std::string &) {}, largest);
        std::vector<double> last;
        const auto found = loads.solve(pulled.constrained, last, inner);
        ASSERT_TRUE(found.has_converged);
        EXPECT_NEAR(found.work, force.dot(compliance.matrix * force), 1e-4 * found.work);
    }
    inner.places.front().middle.x() += 100.0;
    RepeatedLoads loads(*pulled.body, pulled.constrained, [](const std::string &) {});
    std::vector<double> last;
    EXPECT_THROW(loads.solve(pulled.constrained, last, inner), std::invalid_argument);
}

TEST(RepeatedLoads, NeedFewerIterationsNearTheLastSolution) {
    const Pulled pulled(0.45);
    RepeatedLoads levels(
        *pulled.body, pulled.constrained, [](const std::string &) {}, no_factor);
    std::vector<double> last;
    const auto first = levels.solve(pulled.load({0.0, 50.0, 0.0}), last);
    const auto same = levels.solve(pulled.load({0.0, 50.0, 0.0}), last);
    EXPECT_LE(same.iterations, 1);
    EXPECT_LT(relative_error(same.displacement, first.displacement), 1e-5);
    const auto near = levels.solve(pulled.load({0.0, 50.5, 0.0}), last);
    EXPECT_GT(near.iterations, 0);
    EXPECT_LT(near.iterations, first.iterations);
}

TEST(RepeatedLoads, ClearTheLastSolutionWhenNothingPulls) {
    const Pulled pulled(0.45);
    for (const int largest : {no_factor, RepeatedLoads::largest_factor}) {
        RepeatedLoads loads(
            *pulled.body, pulled.constrained, [](const std::string &) {}, largest);
        std::vector<double> last;
        loads.solve(pulled.load({0.0, 50.0, 0.0}), last);
        const auto displacement = loads.solve(pulled.constrained, last).displacement;
        ASSERT_EQ(displacement.size(), pulled.body->mesh.points.size());
        for (const auto &u : displacement)
            EXPECT_EQ(u.norm(), 0.0);
    }
}

TEST(RepeatedLoads, SayWhenNothingHoldsTheBody) {
    const Pulled pulled(0.45);
    const auto free = tests::empty_load_case(pulled.body->mesh);
    for (const int largest : {no_factor, RepeatedLoads::largest_factor}) {
        RepeatedLoads loads(
            *pulled.body, free, [](const std::string &) {}, largest);
        std::vector<double> last;
        const auto solution = loads.solve(free, last);
        EXPECT_FALSE(solution.is_unique);
        EXPECT_FALSE(solution.has_converged);
        EXPECT_TRUE(last.empty());
    }
}

} // namespace
} // namespace livermark::fem_reference
