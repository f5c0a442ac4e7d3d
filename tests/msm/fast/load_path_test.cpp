#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <numeric>
#include <vector>

#include "core/part_springs.hpp"
#include "msm/elastic_body.hpp"
#include "msm/springs/springs.hpp"
#include "msm/statics/load_path.hpp"
#include "msm/statics/rest_stiffness.hpp"
#include "tests/samples/standing_block.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

using core::Vector3;
using Field = std::vector<Vector3>;

/// A block of springs constrained at x_min.
struct ConstrainedBlock {
    ConstrainedBlock() {
        body = tests::make_body(tests::box_mesh({0.1, 0.04, 0.05}, {6, 3, 3}), {1060.0, 5e3, 0.25});
        springs = msm::spring_network(*body, msm::all_spring_laws().front());
        load_case = tests::empty_load_case(body->mesh);
        load_case.regime = core::Regime::large;
        load_case.path = {0.3, 0.6, 1.0};
        tests::prescribe(load_case, body->mesh, "x_min", Vector3::Zero());
    }

    msm::FollowedPath follow() const {
        const core::Problem problem{body, load_case};
        const auto conditions = msm::nodal_conditions(problem, springs.node_mass);
        const msm::RestStiffness rest(springs, body->mesh.points, conditions.displacement);
        return msm::follow_path(springs, problem, springs.node_mass, rest);
    }

    /// Pressure that follows the surface.
    void blow(const std::string &patch, double pressure) {
        const auto &mesh = body->mesh;
        load_case.conditions.push_back({patch, core::ConditionKind::pressure});
        for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
            if (mesh.patch_names[mesh.boundary_patch[f]] == patch) {
                load_case.condition_on[f] = static_cast<int>(load_case.conditions.size()) - 1;
                load_case.value[f] = -pressure * core::area_vector(mesh, f).normalized();
            }
    }

    Field moved(const Field &displacement) const { return msm::moved(body->mesh.points, displacement); }

    std::shared_ptr<const core::Body> body;
    core::SpringNetwork springs;
    core::LoadCase load_case;
};

/// Equilibria under the loads of each point alone, where the path comes to, too.
std::vector<msm::Equilibrium> expect_equilibria(const ConstrainedBlock &block, const msm::FollowedPath &path) {
    EXPECT_EQ(path.end.status, core::SolutionStatus::ok) << path.end.message;
    EXPECT_EQ(path.points.size(), 3U);
    std::vector<msm::Equilibrium> equilibria;
    for (std::size_t k = 0; k < path.points.size(); ++k) {
        const core::Problem problem{block.body, core::scaled(block.load_case, block.load_case.path[k])};
        const auto conditions = msm::nodal_conditions(problem, block.springs.node_mass);
        const auto &alone =
            equilibria.emplace_back(msm::find_equilibrium(block.springs, block.body->mesh.points, conditions));
        const auto reaction = msm::constraint_forces(problem, conditions, alone.constraint_force, alone.press);
        EXPECT_LT((path.points[k].reaction[0] - reaction[0]).norm(), 1e-7 * reaction[0].norm());
        for (std::size_t i = 0; i < alone.displacement.size(); ++i)
            EXPECT_LT((path.points[k].displacement[i].cast<double>() - alone.displacement[i]).norm(), 2e-8);
    }
    return equilibria;
}

TEST(LoadPath, ComesToTheSameEquilibriaAsTheLoadsAlone) {
    ConstrainedBlock block;
    tests::pull(block.load_case, block.body->mesh, "x_max", {150.0, 60.0, -90.0});
    block.load_case.acceleration = {0.0, 1.0, 0.0};
    for (const auto &alone : expect_equilibria(block, block.follow())) {
        const auto largest = std::ranges::max(alone.displacement, {}, [](const auto &u) { return u.norm(); });
        EXPECT_GT(largest.norm(), 0.002); // far from small
    }
}

TEST(LoadPath, PressesAsDeepAsTheWholeAtEachPartOfIt) {
    ConstrainedBlock block;
    const Vector3 direction = Vector3(1.0, 0.5, -2.0).normalized();
    tests::press(block.load_case, block.body->mesh, "x_max", direction, 0.03);
    const auto path = block.follow();
    const auto equilibria = expect_equilibria(block, path);
    double last = 0.0;
    for (std::size_t k = 0; k < equilibria.size(); ++k) {
        const double press = equilibria[k].press;
        EXPECT_NEAR(path.points[k].reaction[1].dot(direction), press, 1e-7 * press);
        EXPECT_GT(press, last);
        last = press;
    }
}

TEST(LoadPath, FollowerPressureBalancesTheSpringsWhereTheyAreAlsoAtItsRim) {
    ConstrainedBlock block;
    block.blow("y_max", 60.0);
    const auto path = block.follow();
    ASSERT_EQ(path.end.status, core::SolutionStatus::ok) << path.end.message;
    const auto x = block.moved(path.end.displacement);
    const msm::SurfacePressure pressure({block.body, block.load_case});
    const auto loads = pressure.force(x);
    const auto elastic = msm::elastic_gradient(block.springs, x);
    double turned = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i) {
        if (block.body->mesh.points[i].x() > 1e-9) {
            EXPECT_LT((elastic[i] - loads[i]).norm(), 1e-6 * 60.0 * 0.1 * 0.05) << i;
        }
        turned = std::max(turned, std::abs(loads[i].x()));
    }
    EXPECT_GT(turned, 1e-4); // at rest the load has no component along the block
    Vector3 total = Vector3::Zero();
    for (const auto &load : loads)
        total += load;
    EXPECT_LT((path.points.back().reaction[0] + total).norm(), 1e-6 * total.norm());
}

TEST(LoadPath, EndsWhereThereIsNoEquilibriumAndKeepsThePointsBefore) {
    ConstrainedBlock block;
    for (const auto *const patch : {"y_min", "y_max", "z_min", "z_max", "x_max"})
        block.blow(patch, -2e4); // blown up without bound: springs soften as they turn
    block.load_case.path = {0.001, 1.0};
    const auto path = block.follow();
    EXPECT_EQ(path.end.status, core::SolutionStatus::not_converged);
    EXPECT_FALSE(path.end.message.empty());
    EXPECT_EQ(path.points.size(), 1U);
}

namespace standing = tests::standing;

/// Displacement upwards of the bottom of coupled springs on a foundation [m]; all of it moves by that.
double moved_up(double top, double traction) {
    const auto problem = standing::block(top, traction);
    const auto &mesh = problem.body->mesh;
    const auto body = msm::coupled_springs_with_volume(*problem.body, msm::find_coupled_springs("nodal_neo_hookean"));
    const auto conditions = msm::nodal_conditions(problem, body.node_mass);
    const msm::RestStiffness rest(body, mesh.points, conditions.displacement);
    const auto path = msm::follow_path(body, problem, body.node_mass, rest);
    EXPECT_EQ(path.end.status, core::SolutionStatus::ok) << path.end.message;
    EXPECT_EQ(path.points.size(), 2U);
    const auto &end = path.points.back();
    EXPECT_LT(standing::out_of_balance(problem, path.end.displacement, end.reaction), 1e-7);
    const double moved = standing::moved_up(mesh, path.end.displacement);
    for (const int f : standing::bottom(mesh))
        for (const int node : mesh.boundary_triangles[f])
            EXPECT_NEAR(path.end.displacement[node].z(), moved, 1e-6 * std::abs(moved));
    // Half of force times change of length: the energy of the tissue alone.
    const double area = standing::size.x() * standing::size.y();
    const double expected = 0.5 * (standing::stiffness * moved - traction) * area * (top - moved);
    EXPECT_NEAR(end.strain_energy, expected, 0.02 * expected);
    return moved;
}

/// The mean of a pressed and a pulled block: their strains make errors in opposite directions.
TEST(Foundation, BearsCoupledSpringsAsFarAsTheClosedForm) {
    for (const auto &[top, traction] : standing::drives) {
        const double expected = standing::expected(top, traction);
        EXPECT_NEAR(0.5 * (moved_up(top, traction) - moved_up(-top, -traction)), expected, 2e-3 * expected);
    }
}

/// At loads so small that springs are linear.
TEST(Foundation, BearsCoupledSpringsUnderSmallLoadsAsFarAsTheClosedForm) {
    for (const auto &[top, traction] : {standing::Drive{1e-6, 0.0}, standing::Drive{0.0, 0.1}}) {
        const auto problem = standing::block(top, traction);
        const auto &mesh = problem.body->mesh;
        const auto body =
            msm::coupled_springs_with_volume(*problem.body, msm::find_coupled_springs("nodal_neo_hookean"));
        const auto conditions = msm::nodal_conditions(problem, body.node_mass);
        const msm::RestStiffness rest(body, mesh.points, conditions.displacement);
        const auto found = msm::find_equilibrium(body, problem, body.node_mass, rest, {.bears_rounding = true});
        ASSERT_EQ(found.status, core::SolutionStatus::ok) << found.message;
        const double expected = standing::expected(top, traction);
        EXPECT_NEAR(standing::moved_up(mesh, found.displacement), expected, 1e-4 * std::abs(expected));
        EXPECT_NEAR(standing::moved_up(mesh, found.linear_displacement), expected, 1e-6 * std::abs(expected));
        const auto reaction =
            msm::constraint_forces(problem, conditions, found.constraint_force, found.press, found.touch);
        EXPECT_LT(standing::out_of_balance(problem, found.displacement, reaction), 1e-7);
    }
}

TEST(Foundation, HasAnEnergyWhoseDerivativesAreItsForcesAndItsHessian) {
    auto problem = standing::block(0.0, 0.0);
    const auto &points = problem.body->mesh.points;
    const Eigen::VectorXd rest = msm::to_unknowns(points);
    const auto wave = [&](double phase) {
        return Eigen::VectorXd(1e-3 * (Eigen::VectorXd::LinSpaced(rest.size(), phase, 40.0).array().sin()));
    };
    const Eigen::VectorXd x = rest + wave(0.0), direction = wave(3.0);
    for (const bool normal_only : {false, true}) {
        auto &foundation = problem.load_case.foundation.value();
        std::ranges::fill(foundation.normal_only, normal_only ? 1 : 0);
        const auto body = msm::on_foundation(msm::ElasticBody(std::vector<double>(points.size(), 1.0), {}), problem);
        ASSERT_EQ(body.terms.size(), 1U);
        const auto &term = *body.terms.front();
        const auto force = [&](const Eigen::VectorXd &at) {
            Eigen::VectorXd result = Eigen::VectorXd::Zero(rest.size());
            term.add_force(at, at, 0.0, result);
            return result;
        };
        const double slope = 0.5 * (term.energy(x + direction) - term.energy(x - direction));
        EXPECT_GT(std::abs(slope), 0.0);
        EXPECT_NEAR(slope, -force(x).dot(direction), 1e-10 * force(x).norm() * direction.norm());
        const Eigen::VectorXd product = term.hessian(x, msm::Tangent::exact) * direction;
        const Eigen::VectorXd column = 0.5 * (force(x - direction) - force(x + direction));
        EXPECT_LT((column - product).norm(), 1e-10 * product.norm());
        const Eigen::SparseMatrix<double> expected = core::foundation_stiffness(problem.body->mesh, foundation);
        EXPECT_LT((term.hessian({}, msm::Tangent::material) - expected).norm(), 1e-14 * expected.norm());
        Eigen::VectorXd found = Eigen::VectorXd::Zero(rest.size());
        term.add_hessian_product(x, direction, found);
        EXPECT_LT((found - product).norm(), 1e-12 * product.norm());
        std::vector<Eigen::Matrix3d> bound(points.size(), Eigen::Matrix3d::Zero());
        term.add_block_bound(x, bound);
        double most = 0.0;
        for (std::size_t i = 0; i < bound.size(); ++i) {
            const Vector3 u = msm::node_part(direction, static_cast<int>(i));
            most += u.dot(bound[i] * u);
        }
        EXPECT_LE(direction.dot(product), most);
        // A body that is moved by one vector is borne by what the area of the springs says.
        Vector3 sum = Vector3::Zero();
        const Vector3 shift(1e-3, -2e-3, 3e-3);
        for (const auto &on_node :
             msm::to_field(force(msm::to_unknowns(msm::moved(points, Field(points.size(), shift))))))
            sum += on_node;
        const Vector3 borne = normal_only ? Vector3(0.0, 0.0, shift.z()) : shift;
        const double whole = standing::stiffness * standing::size.x() * standing::size.y();
        EXPECT_LT((sum + whole * borne).norm(), 1e-12 * sum.norm());
    }
}

TEST(SurfacePressure, IsTheDerivativeOfItsEnergyButForTheRim) {
    ConstrainedBlock block;
    block.blow("y_max", 100.0);
    const msm::SurfacePressure open({block.body, block.load_case});
    for (const auto *const patch : {"x_min", "x_max", "y_min", "z_min", "z_max"})
        block.blow(patch, 100.0);
    const msm::SurfacePressure closed({block.body, block.load_case});
    Field displacement;
    for (const auto &point : block.body->mesh.points)
        displacement.push_back(0.2 * Vector3(point.y() - point.z(), std::sin(20.0 * point.x()) * 0.05, point.x()));
    const auto x = block.moved(displacement);
    for (const auto &push : closed.rim_force(x)) // a closed surface has no rim
        EXPECT_LT(push.norm(), 1e-14);
    Field gradient(x.size(), Vector3::Zero());
    open.add_gradient(x, gradient);
    constexpr double step = 1e-6;
    for (std::size_t i = 0; i < x.size(); i += 7)
        for (int c = 0; c < 3; ++c) {
            auto ahead = x, behind = x;
            ahead[i][c] += step, behind[i][c] -= step;
            EXPECT_NEAR((open.energy(ahead) - open.energy(behind)) / (2.0 * step), gradient[i][c], 1e-9);
        }
}

TEST(NodalConditions, HaveFactorsAndShiftsOfNodesInWhatIsPrescribed) {
    constexpr double free = std::numeric_limits<double>::quiet_NaN();
    const auto body = tests::make_body(tests::box_mesh({0.1, 0.1, 0.1}, {2, 2, 2}), {1060.0, 5000.0, 0.45});
    auto load_case = tests::empty_load_case(body->mesh);
    tests::prescribe(load_case, body->mesh, "z_max", {free, 0.0, -0.01});
    tests::pull(load_case, body->mesh, "x_max", {1.0, 0.0, 0.0});
    auto multiplied = load_case, shifted = load_case;
    for (const auto &point : body->mesh.points) {
        multiplied.node_factor.push_back(0.5 + point.x());
        shifted.node_shift.emplace_back(0.1 * point);
    }
    const std::vector<double> masses(body->mesh.points.size());
    const auto with_factor = msm::nodal_conditions({body, multiplied}, masses),
               with_shift = msm::nodal_conditions({body, shifted}, masses);
    Vector3 pulled = Vector3::Zero();
    for (int node = 0; node < body->mesh.num_nodes(); ++node) {
        pulled += with_factor.force[node];
        const auto &point = body->mesh.points[node];
        const Vector3 &factor = with_factor.displacement[node], &shift = with_shift.displacement[node];
        EXPECT_TRUE(std::isnan(factor.x()) && std::isnan(shift.x()));
        if (point.z() < 0.1 - 1e-9) {
            EXPECT_TRUE(factor.array().isNaN().all() && shift.array().isNaN().all());
            continue;
        }
        EXPECT_EQ(factor.y(), 0.0);
        EXPECT_EQ(factor.z(), multiplied.node_factor[node] * -0.01);
        EXPECT_EQ(shift.y(), 0.1 * point.y());
        EXPECT_EQ(shift.z(), -0.01 + 0.1 * point.z());
    }
    EXPECT_LT((pulled - Vector3(0.01, 0.0, 0.0)).norm(), 1e-15); // loads have no factor
    const auto half = core::scaled(shifted, 0.5);
    EXPECT_TRUE(half.prescribed_at(body->mesh.num_boundary_triangles() - 1, 0).array().isNaN().any());
    EXPECT_EQ(half.node_shift.back(), Vector3(0.05 * body->mesh.points.back()));
    EXPECT_FALSE(core::are_statically_equal(shifted, half));
    auto still = tests::empty_load_case(body->mesh);
    tests::prescribe(still, body->mesh, "z_max", Vector3::Zero());
    EXPECT_FALSE(core::is_driven(still));
    still.node_shift = shifted.node_shift;
    EXPECT_TRUE(core::is_driven(still));
}

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int size = 12;

MatrixXd positive_definite() {
    MatrixXd matrix = MatrixXd::Identity(size, size);
    for (int i = 0; i < size; ++i)
        for (int j = 0; j < size; ++j)
            matrix(i, j) += std::cos(i + 1.0) * std::cos(j + 1.0) + (i == j ? i : 0.1);
    return matrix;
}

VectorXd identity(const VectorXd &b) {
    return b;
}

TEST(ConjugateGradients, NeedAStepForEachUnknownAndOneWithTheInverse) {
    const MatrixXd matrix = positive_definite();
    const Eigen::LLT<MatrixXd> factor(matrix);
    const VectorXd b = VectorXd::LinSpaced(size, -1.0, 2.0);
    int num_products = 0;
    const auto times = [&](const VectorXd &v) -> VectorXd {
        ++num_products;
        return matrix * v;
    };
    const VectorXd at_last = msm::conjugate_gradients(times, identity, b, 1e-12, size);
    EXPECT_LT((matrix * at_last - b).norm(), 1e-10 * b.norm());
    num_products = 0;
    const VectorXd at_once = msm::conjugate_gradients(
        times, [&](const VectorXd &v) -> VectorXd { return factor.solve(v); }, b, 1e-12, size);
    EXPECT_EQ(num_products, 1);
    EXPECT_LT((matrix * at_once - b).norm(), 1e-12 * b.norm());
}

TEST(ConjugateGradients, GoDownhillWhereTheMatrixIsIndefinite) {
    MatrixXd matrix = positive_definite();
    const VectorXd b = VectorXd::LinSpaced(size, -1.0, 2.0);
    for (const double shift : {2.0, 5.0, 100.0}) {
        const MatrixXd indefinite = matrix - shift * MatrixXd::Identity(size, size);
        ASSERT_EQ(Eigen::LLT<MatrixXd>(indefinite).info(), Eigen::NumericalIssue);
        const VectorXd x = msm::conjugate_gradients([&](const VectorXd &v) -> VectorXd { return indefinite * v; },
                                                    identity, b, 1e-12, size);
        EXPECT_GT(b.dot(x), 0.0) << shift;
        EXPECT_TRUE(x.allFinite());
    }
}

TEST(MassLumping, ConservesTotalMassOfSeveralRegions) {
    auto mesh = tests::box_mesh({0.1, 0.2, 0.3}, {3, 2, 4});
    mesh.region_names = {"light", "heavy"};
    for (std::size_t t = 0; t < mesh.region.size(); t += 3)
        mesh.region[t] = 1;
    core::Body body{"box", mesh, {{1000.0, 5e3, 0.25}, {3000.0, 5e3, 0.25}}};

    double expected = 0.0;
    const auto volumes = core::tetrahedron_volumes(mesh);
    for (std::size_t t = 0; t < volumes.size(); ++t)
        expected += volumes[t] * body.materials[mesh.region[t]].density;
    const auto masses = msm::lumped_masses(body);
    EXPECT_NEAR(std::accumulate(masses.begin(), masses.end(), 0.0), expected, 1e-14 * expected);
}

TEST(MassLumping, GivesAQuarterOfATetrahedronToEachCorner) {
    const auto body = tests::make_body(tests::regular_tetrahedron(0.01), {1060.0, 5e3, 0.25});
    const double volume = core::tetrahedron_volumes(body->mesh).front();
    const auto masses = msm::lumped_masses(*body);
    ASSERT_EQ(masses.size(), 4U);
    for (const double mass : masses)
        EXPECT_DOUBLE_EQ(mass, 1060.0 * volume / 4.0);
}

} // namespace
} // namespace livermark
