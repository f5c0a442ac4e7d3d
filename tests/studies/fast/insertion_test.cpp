#include "studies/needle/insertion.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>

#include "core/tool/least_within_limits.hpp"
#include "results/records/needle.hpp"
#include "tests/studies/some_tissue.hpp"

namespace livermark::studies {
namespace {

using tests::needle_of_some_tissue;

core::Needle needle() {
    return needle_of_some_tissue();
}

/// A rigid block on a spring along the axis that gives way by so much [m/N], and on stiffer ones across it.
Eigen::MatrixXd block_on_spring(const core::Needle &needle, const core::NeedleLine &line, double compliance) {
    const auto places = static_cast<Eigen::Index>(line.places.size());
    const core::Vector3 axis = needle.direction();
    const Eigen::Matrix3d along = axis * axis.transpose();
    const Eigen::Matrix3d block = compliance * (along + 0.1 * (Eigen::Matrix3d::Identity() - along));
    Eigen::MatrixXd matrix(3 * places, 3 * places);
    for (Eigen::Index i = 0; i < places; ++i)
        for (Eigen::Index j = 0; j < places; ++j)
            matrix.block<3, 3>(3 * i, 3 * j) = block;
    matrix.diagonal().array() += 1e-7 * compliance; // as a block it would let forces within it be anything
    return matrix;
}

/// By which the tissue gives way under the tip, and the needle there.
double of_tip(double compliance) {
    return compliance + 1.0 / core::needle_stiffness;
}

double spring_of(double compliance, const core::Needle &needle, double depth) {
    return (depth - of_tip(compliance) * needle.tip_force()) / (1.0 + compliance * needle.friction);
}

TEST(LeastWithinLimits, MeetsTheConditionsOfTheLeast) {
    std::mt19937 random(7);
    std::normal_distribution<double> normal;
    for (int n = 1; n <= 30; ++n) {
        const Eigen::MatrixXd root = Eigen::MatrixXd::NullaryExpr(n, n, [&] { return normal(random); });
        const Eigen::MatrixXd matrix = root * root.transpose() + 1e-3 * Eigen::MatrixXd::Identity(n, n);
        const Eigen::VectorXd b = Eigen::VectorXd::NullaryExpr(n, [&] { return 5.0 * normal(random); });
        const Eigen::VectorXd high = Eigen::VectorXd::NullaryExpr(n, [&] { return std::abs(normal(random)); });
        const auto x = core::least_within_limits(matrix, b, -high, high);
        const Eigen::VectorXd gradient = matrix * x - b;
        for (int i = 0; i < n; ++i) {
            EXPECT_LE(std::abs(x[i]), high[i] * (1.0 + 1e-12));
            if (std::abs(x[i]) < high[i])
                EXPECT_NEAR(gradient[i], 0.0, 1e-8 * b.norm()) << n;
            else
                EXPECT_LE(gradient[i] * x[i], 1e-9 * b.norm()) << n;
        }
    }
}

TEST(NeedleLine, HasTheTargetAmongItsPlaces) {
    const auto line = core::needle_line(needle());
    EXPECT_LE(line.spacing, needle().spread / 3.0 + 1e-12);
    EXPECT_LT((line.places.at(line.target).middle - needle().target).norm(), 1e-12);
    EXPECT_LT((line.places.front().middle - needle().entry).norm(), 1e-12);
}

TEST(Insertion, OfABlockOnASpringHasItsClosedForm) {
    const auto soft = needle();
    const auto line = core::needle_line(soft);
    const double compliance = 0.02;
    const auto found = insert(block_on_spring(soft, line, compliance), line, soft);
    ASSERT_NEAR(found.depth[found.at_plan], soft.depth(), 1e-12);
    for (int j = 1; j <= found.at_plan; ++j) {
        const double depth = found.depth[j];
        const bool is_whole = depth < of_tip(compliance) * soft.tip_force();
        const double tip = is_whole ? 0.0 : spring_of(compliance, soft, depth);
        const double force = is_whole ? depth / of_tip(compliance) : soft.tip_force() + soft.friction * tip;
        EXPECT_NEAR(found.tip[j], tip, 1e-5 * soft.depth()) << depth;
        EXPECT_NEAR(found.force[j], force, 1e-4) << depth;
        EXPECT_NEAR(found.target[j].dot(soft.direction()), compliance * force, 1e-5 * soft.depth());
    }
    // Drawn back, the shaft sticks at first: only the spring moves.
    const int turn = found.at_plan;
    EXPECT_NEAR(found.force[turn + 1] - found.force[turn], (found.depth[turn + 1] - found.depth[turn]) / compliance,
                1e-3 * (found.depth[turn] - found.depth[turn + 1]) / compliance);
    EXPECT_NEAR(*std::min_element(found.force.begin(), found.force.end()), -soft.friction * found.tip[turn],
                0.02 * soft.friction * found.tip[turn]);
    EXPECT_NEAR(found.force.back(), 0.0, 1e-9);
    EXPECT_EQ(found.tip.back(), 0.0);
}

TEST(Insertion, BalancesItsEnergies) {
    const auto soft = needle();
    const auto line = core::needle_line(soft);
    const auto found = insert(block_on_spring(soft, line, 0.02), line, soft);
    const auto end = found.work.size() - 1;
    EXPECT_NEAR(found.work[end], found.friction[end] + found.tearing[end], 0.01 * found.work[end]);
    EXPECT_NEAR(found.stored[end], 0.0, 1e-9);
    EXPECT_NEAR(found.tearing[end], soft.tip_force() * found.tip[found.at_plan], 0.01 * found.tearing[end]);
    EXPECT_TRUE(std::isfinite(found.puncture_depth));
}

TEST(Insertion, JumpsWhereTheSurfaceGivesWay) {
    auto tough = needle();
    tough.puncture_force = 0.8;
    const auto line = core::needle_line(tough);
    const double compliance = 0.02;
    const auto found = insert(block_on_spring(tough, line, compliance), line, tough);
    EXPECT_NEAR(found.puncture_depth, of_tip(compliance) * tough.puncture_force, tough.step);
    const auto at = std::ranges::find(found.depth, found.puncture_depth) - found.depth.begin();
    EXPECT_NEAR(found.force[at - 1], found.depth[at - 1] / of_tip(compliance), 1e-3);
    EXPECT_NEAR(found.tip[at], spring_of(compliance, tough, found.depth[at]), 1e-4 * tough.depth());
    EXPECT_LT(found.force[at], 0.6 * found.force[at - 1]);
    EXPECT_GT(found.puncture_loss, 0.0);
    EXPECT_LT(*std::ranges::max_element(found.force), tough.puncture_force) << "records are beside it";
    EXPECT_EQ((results::NeedleRun{.model = "block", .insertion = found}.largest_force(tough)), tough.puncture_force);
}

TEST(Insertion, OfAForceTooSmallNeverPunctures) {
    auto tough = needle();
    tough.puncture_force = 50.0;
    const auto line = core::needle_line(tough);
    const auto found = insert(block_on_spring(tough, line, 0.02), line, tough);
    EXPECT_TRUE(std::isnan(found.puncture_depth));
    EXPECT_EQ(*std::ranges::max_element(found.tip), 0.0);
    EXPECT_NEAR(found.force[found.at_plan], tough.depth() / of_tip(0.02), 1e-3);
    results::NeedleRun run{.model = "block", .insertion = found};
    run.note_limit(0.01); // the block goes with the tip
    EXPECT_NEAR(run.left_regime_at, 0.01 / 0.02 * of_tip(0.02), 1.01 * tough.step);
    EXPECT_NEAR(found.moved[found.at_plan], 0.02 * found.force[found.at_plan], 1e-6);
}

/// Sixty of them are in the full tests.
TEST(Insertion, OfSomeNeedlesStaysFiniteAndBalanced) {
    EXPECT_EQ(tests::drive_into_some_tissue(11, 4, 0.006), std::vector<std::string>{});
}

} // namespace
} // namespace livermark::studies
