#include <Eigen/Eigenvalues>
#include <algorithm>
#include <filesystem>
#include <gtest/gtest.h>
#include <numbers>
#include <ostream>
#include <set>
#include <stdexcept>

#include "msm/spring_law.hpp"
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
/// et al. 2007), whatever length an irregular mesh puts in.
TEST(SpringLawsOfLloyd, HaveHisFactorOnARegularTetrahedron) {
    const double edge = 0.013;
    const double young_modulus = 4200.0;
    const auto body = tests::make_body(tests::regular_tetrahedron(edge), {1060.0, young_modulus, 0.25});
    const auto table = core::edge_table(body->mesh.tetrahedra);
    const double expected = 2.0 * std::numbers::sqrt2 / 25.0 * edge * young_modulus;
    for (const auto *law : {"lloyd", "lloyd_edge", "lloyd_mean_edge"}) {
        const auto found = stiffness(law, *body, table);
        ASSERT_EQ(found.size(), 6U);
        for (const double k : found)
            EXPECT_NEAR(k, expected, 1e-13 * expected) << law;
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

/// The six equal springs of trace 15 mu V = 6 E V on a regular tetrahedron have k = E V / l^2 = (sqrt 2 / 12) l E, 4 %
/// above Lloyd's: they match the mean stiffness in all directions instead of the nearest tensor.
TEST(SpringLawsOfGivenTrace, HaveVanGeldersFactorOnARegularTetrahedron) {
    const double edge = 0.013;
    const double young_modulus = 4200.0;
    const auto body = tests::make_body(tests::regular_tetrahedron(edge), {1060.0, young_modulus, 0.25});
    const auto table = core::edge_table(body->mesh.tetrahedra);
    const double expected = std::numbers::sqrt2 / 12.0 * edge * young_modulus;
    for (const auto *law : {"patch", "uniform", "van_gelder"}) {
        const auto found = stiffness(law, *body, table);
        ASSERT_EQ(found.size(), 6U);
        for (const double k : found)
            EXPECT_NEAR(k, expected, 1e-12 * expected) << law;
    }
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

TEST(UniformSpringLaw, GivesOneMaterialOneStiffness) {
    const auto body = tests::make_body(tests::box_mesh({0.1, 0.12, 0.08}, {3, 4, 2}), {1060.0, 5e3, 0.25});
    const auto k = stiffness("uniform", *body, core::edge_table(body->mesh.tetrahedra));
    EXPECT_NEAR(std::ranges::min(k), std::ranges::max(k), 1e-12 * k.front());
}

TEST(UniformSpringLaw, KeepsTheRatioOfTheMaterialsAwayFromTheirInterface) {
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

} // namespace
} // namespace livermark
