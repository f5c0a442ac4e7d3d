#include <algorithm>
#include <gtest/gtest.h>
#include <numeric>
#include <vector>

#include "interactive/elements/quadratic_tetrahedra.hpp"
#include "tests/interactive/moving_scene.hpp"

namespace livermark {
namespace {

using core::Vector3;
using interactive::Field;
using interactive::Matrix3;
using tests::bar_scene;
using tests::noise;

/// Positions that are a polynomial of second degree of those at rest, and its gradient.
Vector3 bent(const Vector3 &p) {
    return {p.x() + 2.0 * p.x() * p.y() - p.z() * p.z(), p.y() + 3.0 * p.z() * p.x() + p.y() * p.y(),
            p.z() - p.x() * p.x() + p.y() * p.z()};
}

Matrix3 gradient_of_bent(const Vector3 &p) {
    Matrix3 f;
    f << 1.0 + 2.0 * p.y(), 2.0 * p.x(), -2.0 * p.z(), 3.0 * p.z(), 1.0 + 2.0 * p.y(), 3.0 * p.x(), -2.0 * p.x(), p.z(),
        1.0 + p.y();
    return f;
}

TEST(QuadraticTetrahedra, HaveTheGradientsOfPolynomialsOfSecondDegree) {
    const auto scene = interactive::quadratic_scene(bar_scene(false));
    const interactive::QuadraticEnergy energy(scene);
    const Field rest = interactive::rest_positions(scene);
    Field x = rest;
    for (Eigen::Index i = 0; i < x.cols(); ++i)
        x.col(i) = bent(rest.col(i));
    constexpr double root_of_five = 2.2360679774997897, near = (5.0 + 3.0 * root_of_five) / 20.0;
    ASSERT_EQ(energy.tetrahedra().size(), scene.body->mesh.tetrahedra.size());
    for (const auto &t : energy.tetrahedra()) {
        const auto f = t.gradients(x);
        for (int q = 0; q < 4; ++q) {
            Vector3 point = near * rest.col(t.nodes[q]);
            for (int k = 0; k < 4; ++k)
                if (k != q)
                    point += (1.0 - near) / 3.0 * rest.col(t.nodes[k]);
            EXPECT_LT((f[q] - gradient_of_bent(point)).norm(), 1e-12);
            // The same by shape functions.
            Matrix3 sum = Matrix3::Zero();
            const auto slopes = t.shape_gradients(q);
            for (int a = 0; a < 10; ++a)
                sum += x.col(t.nodes[a]) * slopes.row(a);
            EXPECT_LT((f[q] - sum).norm(), 1e-12);
        }
    }
}

TEST(QuadraticScene, KeepsTheMassAndGivesEachNodeSomeOfIt) {
    const auto given = bar_scene(true);
    const auto scene = interactive::quadratic_scene(given);
    EXPECT_GT(std::ranges::min(scene.node_mass), 0.0);
    const auto sum = [](const std::vector<double> &mass) { return std::accumulate(mass.begin(), mass.end(), 0.0); };
    EXPECT_NEAR(sum(scene.node_mass), sum(given.node_mass), 1e-12 * sum(given.node_mass));
}

/// All nodes at x = 0, corners or middles, and no other.
TEST(QuadraticScene, ConstrainsTheMiddlesOfConstrainedFacets) {
    const auto scene = interactive::quadratic_scene(bar_scene(true));
    const Field rest = interactive::rest_positions(scene);
    const auto is_free = interactive::free_nodes(scene);
    ASSERT_GT(rest.cols(), bar_scene(true).body->mesh.num_nodes());
    for (Eigen::Index i = 0; i < rest.cols(); ++i)
        EXPECT_EQ(is_free[i], rest(0, i) > 0.0);
}

TEST(QuadraticScene, LeavesTheMiddleFreeWhereNoFacetIsConstrained) {
    auto given = bar_scene(false);
    const auto &corners = given.body->mesh.boundary_triangles.front();
    given.constrained_nodes = {corners[0], corners[1]};
    EXPECT_TRUE(interactive::quadratic_scene(given).followers.empty());
    given.constrained_nodes.push_back(corners[2]);
    EXPECT_EQ(interactive::quadratic_scene(given).followers.size(), 3U);
}

TEST(QuadraticScene, CarriesTheForcesOfMiddlesAtTheirEnds) {
    const auto scene = interactive::quadratic_scene(bar_scene(true));
    const Field forces = noise(interactive::num_nodes(scene), 1.0, 5);
    const Field pushed = interactive::reactions_to(scene, forces);
    // The work of both along a motion of the constrained nodes is the same.
    const Field targets = noise(static_cast<Eigen::Index>(scene.constrained_nodes.size()), 1.0, 6);
    Field moved = Field::Zero(3, forces.cols());
    interactive::put_constrained(scene, targets, moved);
    EXPECT_NEAR(pushed.cwiseProduct(targets).sum(), -forces.cwiseProduct(moved).sum(), 1e-12);
    EXPECT_GT(scene.followers.size(), 0U);
}

} // namespace
} // namespace livermark
