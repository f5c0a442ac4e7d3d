#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <gtest/gtest.h>
#include <limits>
#include <map>
#include <numbers>
#include <ostream>
#include <random>
#include <set>
#include <stdexcept>

#include "msm/spring_law.hpp"
#include "msm/statics/equilibrium.hpp"
#include "tests/samples/moving_samples.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {

namespace msm {
void PrintTo(const SpringLaw &law, std::ostream *out) {
    *out << law.name;
}
} // namespace msm

namespace {

class EverySpringLaw : public testing::TestWithParam<msm::SpringLaw> {};

TEST_P(EverySpringLaw, StatesWhatItIsAndWhereItComesFrom) {
    EXPECT_FALSE(GetParam().summary.empty());
    EXPECT_FALSE(GetParam().source.empty());
}

TEST_P(EverySpringLaw, GivesEveryEdgeAPositiveStiffness) {
    const auto body = tests::make_body(tests::box_mesh({0.1, 0.12, 0.08}, {3, 4, 2}), {1060.0, 5e3, 0.25});
    const auto table = core::edge_table(body->mesh.tetrahedra);
    const auto stiffness = GetParam().stiffness(*body, table);
    ASSERT_EQ(stiffness.size(), table.edges.size());
    EXPECT_GT(std::ranges::min(stiffness), 0.0);
}

TEST_P(EverySpringLaw, IsProportionalToYoungsModulus) {
    const auto mesh = tests::box_mesh({0.1, 0.12, 0.08}, {2, 2, 2});
    const auto table = core::edge_table(mesh.tetrahedra);
    const auto soft = GetParam().stiffness(*tests::make_body(mesh, {1060.0, 1.0, 0.25}), table);
    const auto hard = GetParam().stiffness(*tests::make_body(mesh, {1060.0, 10.0, 0.25}), table);
    ASSERT_EQ(soft.size(), table.edges.size());
    for (std::size_t s = 0; s < soft.size(); ++s)
        EXPECT_NEAR(hard[s], 10.0 * soft[s], 1e-12 * hard[s]);
}

INSTANTIATE_TEST_SUITE_P(SpringLaws, EverySpringLaw,
                         testing::ValuesIn(msm::all_spring_laws().begin(), msm::all_spring_laws().end()),
                         [](const auto &info) { return info.param.name; });

std::vector<double> stiffness(const std::string &law, const core::Body &body, const core::EdgeTable &table) {
    for (const auto &known : msm::all_spring_laws())
        if (known.name == law)
            return known.stiffness(body, table);
    throw std::invalid_argument("no spring law " + law);
}

double trace(const std::vector<double> &stiffness, const core::TetraMesh &mesh, const core::EdgeTable &table) {
    double sum = 0.0;
    for (std::size_t s = 0; s < stiffness.size(); ++s) {
        const auto [i, j] = table.edges[s];
        sum += stiffness[s] * (mesh.points[j] - mesh.points[i]).squaredNorm();
    }
    return sum;
}

/// The projection of isotropic elasticity on the six springs of a regular tetrahedron is k = (2 sqrt 2 / 25) l E (Lloyd
/// et al. 2007), whatever length an irregular mesh puts in. The six equal springs of trace 15 mu V = 6 E V have k = E V
/// / l^2 = (sqrt 2 / 12) l E, 4 % above: they match the mean stiffness in all directions instead of the nearest tensor.
TEST(SpringLaws, HaveTheirFactorsOnARegularTetrahedron) {
    const double edge = 0.013, young_modulus = 4200.0, root = std::numbers::sqrt2;
    const auto body = tests::make_body(tests::regular_tetrahedron(edge), {1060.0, young_modulus, 0.25});
    const auto table = core::edge_table(body->mesh.tetrahedra);
    for (const auto &[law, factor] : std::vector<std::pair<std::string, double>>{{"lloyd", 2.0 * root / 25.0},
                                                                                 {"lloyd_edge", 2.0 * root / 25.0},
                                                                                 {"lloyd_mean_edge", 2.0 * root / 25.0},
                                                                                 {"patch", root / 12.0},
                                                                                 {"uniform", root / 12.0},
                                                                                 {"van_gelder", root / 12.0}}) {
        const auto found = stiffness(law, *body, table);
        ASSERT_EQ(found.size(), 6U);
        const double expected = factor * edge * young_modulus;
        for (const double k : found)
            EXPECT_NEAR(k, expected, (law.starts_with("lloyd") ? 1e-13 : 1e-12) * expected) << law;
    }
}

using Tensor = Eigen::Matrix<double, 6, 6>; // of order 4, in Mandel's notation, which keeps the Frobenius norm

/// n n of a direction.
Eigen::Vector<double, 6> dyad(const core::Vector3 &n) {
    const double root = std::numbers::sqrt2;
    return {n.x() * n.x(),        n.y() * n.y(),        n.z() * n.z(),
            root * n.y() * n.z(), root * n.z() * n.x(), root * n.x() * n.y()};
}

/// On a regular tetrahedron the springs are the projection of isotropic elasticity at Poisson's ratio 1/4 on cubic
/// elasticity of six equal springs: what is left is orthogonal to them, and a fifth of the whole. So the two families
/// of shear have 3/5 and 6/5 of the energy, and dilatation 24/25.
TEST(SpringLawsOfLloyd, AreAProjectionThatLeavesAFifthOfIsotropicElasticity) {
    const double young_modulus = 4200.0;
    const double mu = young_modulus / 2.5, lambda = mu;
    const auto body = tests::make_body(tests::regular_tetrahedron(1.0), {1060.0, young_modulus, 0.25});
    const auto &points = body->mesh.points;
    const auto table = core::edge_table(body->mesh.tetrahedra);
    const auto k = stiffness("lloyd", *body, table);
    Tensor springs = Tensor::Zero();
    for (std::size_t s = 0; s < table.edges.size(); ++s) {
        const core::Vector3 edge = points[table.edges[s][1]] - points[table.edges[s][0]];
        const auto direction = dyad(edge.normalized());
        springs += k[s] * edge.squaredNorm() * direction * direction.transpose();
    }
    springs /= core::tetrahedron_volumes(body->mesh).front();
    Tensor isotropic = 2.0 * mu * Tensor::Identity();
    isotropic.topLeftCorner<3, 3>().array() += lambda;
    EXPECT_NEAR((springs - isotropic).cwiseProduct(springs).sum(), 0.0, 1e-12 * isotropic.squaredNorm());
    EXPECT_NEAR((springs - isotropic).norm(), 0.2 * isotropic.norm(), 1e-12 * isotropic.norm());

    // Two shears, three shears and the dilatation, in rising order.
    const Eigen::SelfAdjointEigenSolver<Tensor> modes(springs);
    const double isotropic_modes[] = {2.0 * mu, 2.0 * mu, 2.0 * mu, 2.0 * mu, 2.0 * mu, 2.0 * mu + 3.0 * lambda};
    const double expected[] = {0.6, 0.6, 1.2, 1.2, 1.2, 0.96};
    for (int mode = 0; mode < 6; ++mode)
        EXPECT_NEAR(modes.eigenvalues()[mode] / isotropic_modes[mode], expected[mode], 1e-12) << mode;
}

/// A box whose upper half, in x, is ten times as stiff as the rest.
std::shared_ptr<const core::Body> box_of_two_materials() {
    core::Body body;
    body.name = "two_materials";
    body.mesh = tests::box_mesh({0.1, 0.12, 0.08}, {4, 3, 2});
    body.mesh.region_names = {"soft", "hard"};
    body.materials = {{1060.0, 5e3, 0.25}, {1060.0, 5e4, 0.25}};
    for (int t = 0; t < body.mesh.num_tetrahedra(); ++t) {
        double x = 0.0;
        for (const int node : body.mesh.tetrahedra[t])
            x += 0.25 * body.mesh.points[node].x();
        body.mesh.region[t] = x < 0.05 ? 0 : 1;
    }
    return std::make_shared<const core::Body>(std::move(body));
}

/// sum of k l^2 = 15 sum of mu V, mu = E / 2.5: the trace C_aabb V of the solid with lambda = mu.
TEST(SpringLawsOfGivenTrace, HaveThatOfTheSolidWithTumoursToo) {
    const auto body = box_of_two_materials();
    const auto table = core::edge_table(body->mesh.tetrahedra);
    const double expected = 0.5 * 0.1 * 0.12 * 0.08 * 15.0 * (5e3 + 5e4) / 2.5;
    for (const auto *law : {"patch", "uniform", "van_gelder"})
        EXPECT_NEAR(trace(stiffness(law, *body, table), body->mesh, table), expected, 1e-12 * expected) << law;
}

/// Turned about an axis of no symmetry.
TEST(PatchSpringLaw, DoesNotDependOnTheOrientationOfTheBody) {
    auto mesh = tests::box_mesh({0.1, 0.12, 0.08}, {3, 2, 2});
    const auto table = core::edge_table(mesh.tetrahedra);
    const auto before = stiffness("patch", *tests::make_body(mesh, {1060.0, 5e3, 0.25}), table);
    const Eigen::AngleAxisd turn(0.7, core::Vector3(1.0, 2.0, 3.0).normalized());
    for (auto &point : mesh.points)
        point = turn * point;
    const auto after = stiffness("patch", *tests::make_body(mesh, {1060.0, 5e3, 0.25}), table);
    ASSERT_EQ(before.size(), table.edges.size());
    for (std::size_t s = 0; s < before.size(); ++s)
        EXPECT_NEAR(after[s], before[s], 1e-9 * before[s]);
}

TEST(UniformSpringLaw, GivesOneMaterialOneStiffnessAwayFromInterfaces) {
    const auto single = tests::make_body(tests::box_mesh({0.1, 0.12, 0.08}, {3, 4, 2}), {1060.0, 5e3, 0.25});
    const auto equal = stiffness("uniform", *single, core::edge_table(single->mesh.tetrahedra));
    EXPECT_NEAR(std::ranges::min(equal), std::ranges::max(equal), 1e-12 * equal.front());
    const auto body = box_of_two_materials();
    const auto table = core::edge_table(body->mesh.tetrahedra);
    const auto k = stiffness("uniform", *body, table);
    EXPECT_NEAR(std::ranges::max(k), 10.0 * std::ranges::min(k), 1e-12 * std::ranges::max(k));
    for (std::size_t s = 0; s < k.size(); ++s) {
        const auto [i, j] = table.edges[s];
        if (body->mesh.points[i].x() < 0.04 && body->mesh.points[j].x() < 0.06) {
            EXPECT_NEAR(k[s], std::ranges::min(k), 1e-12 * k[s]);
        }
    }
}

TEST(SpringLawTable, HasEveryFileOfItsFolderUnderItsName) {
    std::set<std::string> files;
    for (const auto &file : std::filesystem::directory_iterator(LIVERMARK_SOURCE_DIR "/msm/spring_laws"))
        files.insert(file.path().stem().string());
    std::set<std::string> names;
    for (const auto &law : msm::all_spring_laws())
        names.insert(law.name);
    EXPECT_EQ(names, files);
}

class EverySpringCurve : public testing::TestWithParam<msm::SpringCurve> {
  protected:
    msm::ForceCurve curve = GetParam().curve;
};

TEST_P(EverySpringCurve, IsHookesNearRestAndPullsWhereItIsLong) {
    EXPECT_LT(curve.force(0.9), 0.0);
    EXPECT_GT(curve.force(1.1), 0.0);
    EXPECT_NEAR(curve.energy(1.0), 0.0, 1e-16);
    EXPECT_NEAR(curve.force(1.0), 0.0, 1e-16);
    EXPECT_NEAR(curve.slope(1.0), 1.0, 1e-15);
}

TEST_P(EverySpringCurve, HasForcesThatAreTheDerivativeOfItsEnergyAndSlopesOfItsForces) {
    const double step = 1e-5;
    for (const double stretch : {0.4, 0.8, 1.0, 1.3, 2.0}) {
        const auto slope_of = [&](double (*function)(double)) {
            return (function(stretch + step) - function(stretch - step)) / (2.0 * step);
        };
        const double scale = 1.0 + std::abs(curve.slope(stretch));
        EXPECT_NEAR(slope_of(curve.energy), curve.force(stretch), 1e-8 * scale) << stretch;
        EXPECT_NEAR(slope_of(curve.force), curve.slope(stretch), 1e-7 * scale) << stretch;
    }
}

INSTANTIATE_TEST_SUITE_P(Curves, EverySpringCurve, testing::ValuesIn(msm::all_spring_curves()),
                         [](const auto &info) { return info.param.name; });

/// The mean over all directions of the energy of springs with sum k l0^2 = 15 mu V, over mu V.
double energy_in_all_directions(const msm::ForceCurve &curve, const Eigen::Matrix3d &deformation) {
    constexpr int num_heights = 400, num_angles = 400; // the midpoint rule is exact enough for smooth functions
    double sum = 0.0;
    for (int i = 0; i < num_heights; ++i)
        for (int j = 0; j < num_angles; ++j) {
            const double z = -1.0 + (2.0 * i + 1.0) / num_heights;
            const double angle = 2.0 * std::numbers::pi * (j + 0.5) / num_angles;
            const double radius = std::sqrt(1.0 - z * z);
            sum += curve.energy(
                (deformation * Eigen::Vector3d(radius * std::cos(angle), radius * std::sin(angle), z)).norm());
        }
    return 15.0 * sum / (num_heights * num_angles);
}

/// A material out of central springs, at any deformation.
TEST(SpringCurveNeoHookean, IsANeoHookeanMaterialInAllDirectionsTogether) {
    Eigen::Matrix3d sheared, pressed, pulled;
    sheared << 1.0, 0.6, 0.0, 0.0, 1.0, 0.1, 0.0, 0.0, 1.0;
    pressed << 0.6, 0.0, 0.1, 0.0, 1.2, 0.0, 0.2, 0.0, 1.1;
    pulled << 1.7, 0.2, 0.0, 0.0, 0.9, 0.0, 0.0, 0.3, 1.3;
    const auto curves = msm::all_spring_curves();
    const auto curve = std::ranges::find(curves, "neo_hookean", &msm::SpringCurve::name);
    ASSERT_NE(curve, curves.end());
    for (const auto &deformation : {sheared, pressed, pulled}) {
        const double volume = deformation.determinant();
        const double expected = 0.5 * (deformation.squaredNorm() - 3.0) + 1.0 / volume - 1.0;
        EXPECT_NEAR(energy_in_all_directions(curve->curve, deformation), expected, 1e-5 * expected);
        EXPECT_GT(std::abs(energy_in_all_directions(msm::hooke, deformation) - expected), 1e-2 * expected);
    }
}

using core::Vector3;

/// A block of cubic cells with springs to the 18 nearest neighbours, k = 0.4 E a. Each cell gives a quarter of a spring
/// to each of its edges and half a spring to each diagonal of its faces, so that a cell alone already has the
/// elasticity of the continuum: E_eff = E and Poisson's ratio 1/4 exactly, boundary cells included.
struct Lattice {
    std::vector<Vector3> points;
    core::SpringNetwork springs;
};

constexpr int cells = 4;
constexpr double spacing = 0.01;
constexpr double lattice_modulus = 5000.0;

int node_at(int i, int j, int k) {
    return i + (cells + 1) * (j + (cells + 1) * k);
}

Lattice make_lattice() {
    Lattice lattice;
    for (int k = 0; k <= cells; ++k)
        for (int j = 0; j <= cells; ++j)
            for (int i = 0; i <= cells; ++i)
                lattice.points.emplace_back(spacing * i, spacing * j, spacing * k);
    const double k18 = 0.4 * lattice_modulus * spacing;
    std::map<std::array<int, 2>, double> stiffness;
    for (int cell = 0; cell < cells * cells * cells; ++cell) {
        const std::array origin{cell % cells, cell / cells % cells, cell / (cells * cells)};
        for (int a = 0; a < 8; ++a)
            for (int b = a + 1; b < 8; ++b) {
                const int differ = __builtin_popcount(static_cast<unsigned>(a ^ b));
                if (differ == 3)
                    continue; // the space diagonals are not among the 18
                const auto corner = [&](int c) {
                    return node_at(origin[0] + (c & 1), origin[1] + (c >> 1 & 1), origin[2] + (c >> 2 & 1));
                };
                stiffness[{corner(a), corner(b)}] += (differ == 1 ? 0.25 : 0.5) * k18;
            }
    }
    for (const auto &[edge, k] : stiffness) {
        lattice.springs.edges.push_back(edge);
        lattice.springs.stiffness.push_back(k);
        lattice.springs.rest_length.push_back((lattice.points[edge[1]] - lattice.points[edge[0]]).norm());
    }
    lattice.springs.node_mass.assign(lattice.points.size(), 1.0);
    return lattice;
}

/// Uniaxial traction along x on rollers: the linearised solution is the affine field of the continuum.
TEST(SpringLattice, With18NeighboursIsIsotropicElasticityWithPoissonOneQuarter) {
    const auto lattice = make_lattice();
    const double stress = 3.0;
    auto conditions = tests::free_conditions(lattice.points.size());
    for (std::size_t n = 0; n < lattice.points.size(); ++n)
        for (int c = 0; c < 3; ++c)
            if (lattice.points[n][c] == 0.0) {
                conditions.displacement[n][c] = 0.0;
                conditions.constraint[n][static_cast<std::size_t>(c)] = 0;
            }
    for (int j = 0; j < cells; ++j)
        for (int k = 0; k < cells; ++k)
            for (const auto &[dj, dk] : {std::array{0, 0}, {1, 0}, {0, 1}, {1, 1}})
                conditions.force[node_at(cells, j + dj, k + dk)].x() += stress * spacing * spacing / 4.0;

    const auto result = msm::find_equilibrium(lattice.springs, lattice.points, conditions);
    ASSERT_EQ(result.status, core::SolutionStatus::ok) << result.message;
    const double strain = stress / lattice_modulus;
    const double scale = strain * spacing * cells;
    for (std::size_t n = 0; n < lattice.points.size(); ++n) {
        const auto &x = lattice.points[n];
        const Vector3 exact(strain * x.x(), -0.25 * strain * x.y(), -0.25 * strain * x.z());
        EXPECT_LT((result.linear_displacement[n] - exact).norm(), 1e-12 * scale);
    }

    // The springs themselves are geometrically non-linear: the difference is of the order of the strain.
    const double tip = result.displacement[node_at(cells, cells, cells)].x();
    EXPECT_NEAR(tip, scale, 2.0 * strain * scale);
    EXPECT_GT(std::abs(tip - scale), 0.01 * strain * scale);
}

using Eigen::MatrixXd;
using Eigen::VectorXd;

msm::BoundedLeastSquares solve(const MatrixXd &matrix, const VectorXd &target, const VectorXd &lower) {
    return msm::solve_bounded_least_squares(matrix.sparseView(), target, lower);
}

/// The best of all 2^n choices of unknowns at their bound that keeps the others above theirs.
VectorXd brute_force(const MatrixXd &matrix, const VectorXd &target, const VectorXd &lower) {
    const auto n = static_cast<int>(matrix.cols());
    VectorXd best;
    double least = std::numeric_limits<double>::infinity();
    for (unsigned choice = 0; choice < (1U << n); ++choice) {
        std::vector<int> free;
        for (int i = 0; i < n; ++i)
            if ((choice >> i & 1U) != 0)
                free.push_back(i);
        VectorXd x = lower;
        if (!free.empty()) {
            const MatrixXd part = matrix(Eigen::all, free);
            x(free) += (part.transpose() * part).ldlt().solve(part.transpose() * (target - matrix * lower));
        }
        const double size = (matrix * x - target).squaredNorm();
        if ((x - lower).minCoeff() >= 0.0 && size < least) {
            least = size;
            best = x;
        }
    }
    return best;
}

struct RandomProblem {
    MatrixXd matrix;
    VectorXd target;
    VectorXd lower;
};

/// @param likeness  of the columns to each other, 0 ... 1; the more alike, the more unknowns end at their bound
RandomProblem random_problem(std::mt19937 &random, int rows, int columns, double likeness) {
    std::normal_distribution<double> normal;
    const auto draw = [&] { return normal(random); };
    const VectorXd common = VectorXd::NullaryExpr(rows, draw);
    RandomProblem problem{MatrixXd::NullaryExpr(rows, columns, draw), VectorXd::NullaryExpr(rows, draw),
                          VectorXd::NullaryExpr(columns, draw)};
    problem.matrix = (1.0 - likeness) * problem.matrix + likeness * common.rowwise().replicate(columns);
    return problem;
}

TEST(BoundedLeastSquares, TakesTheBestOfAllChoicesOfBounds) {
    std::mt19937 random(7);
    for (int repeat = 0; repeat < 200; ++repeat) {
        const auto [matrix, target, lower] = random_problem(random, 10, 7, 0.1 * (repeat % 10));
        const VectorXd expected = brute_force(matrix, target, lower);
        const auto result = solve(matrix, target, lower);
        EXPECT_LT((result.x - expected).norm(), 1e-8 * (1.0 + expected.norm())) << "problem " << repeat;
    }
}

/// Feasible, no gradient towards the inside at a bound, none at all where free.
TEST(BoundedLeastSquares, MeetsTheConditionsOfKarushKuhnAndTucker) {
    std::mt19937 random(11);
    for (const double likeness : {0.0, 0.1, 0.2}) {
        const auto [matrix, target, lower] = random_problem(random, 400, 300, likeness);
        const auto result = solve(matrix, target, lower);
        const VectorXd lengths = matrix.colwise().norm();
        const VectorXd gradient = (matrix.transpose() * (matrix * result.x - target)).cwiseQuotient(lengths);
        const double tolerance = 1e-10 * (target - matrix * lower).norm();
        int at_bound = 0;
        for (Eigen::Index i = 0; i < lower.size(); ++i) {
            EXPECT_GE(result.x[i], lower[i]);
            EXPECT_GE(gradient[i], -tolerance);
            if (result.x[i] > lower[i])
                EXPECT_LE(gradient[i], tolerance);
            else
                ++at_bound;
        }
        EXPECT_GT(at_bound, 30);
        EXPECT_LT(at_bound, 270);
    }
}

TEST(BoundedLeastSquares, GivesOneOfTheMinimisersWhereColumnsDependOnEachOther) {
    const MatrixXd matrix{{1.0, 1.0, 0.0}, {0.0, 0.0, 1.0}};
    const VectorXd target{{3.0, -1.0}};
    const VectorXd x = solve(matrix, target, VectorXd::Zero(3)).x;
    EXPECT_NEAR((matrix * x - target).norm(), 1.0, 1e-12);
    EXPECT_GE(x.minCoeff(), 0.0);
}

TEST(BoundedLeastSquares, RefusesColumnsOfZerosAndShapesThatDiffer) {
    const VectorXd two = VectorXd::Ones(2);
    EXPECT_THROW(solve(MatrixXd{{1.0, 0.0}, {1.0, 0.0}}, two, two), std::invalid_argument);
    EXPECT_THROW(solve(MatrixXd::Identity(2, 2), VectorXd::Ones(3), two), std::invalid_argument);
    EXPECT_THROW(solve(MatrixXd::Identity(2, 2), two, VectorXd::Ones(3)), std::invalid_argument);
}

} // namespace
} // namespace livermark
