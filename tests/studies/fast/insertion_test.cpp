#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <random>

#include "core/support/input_error.hpp"
#include "core/tool/least_within_limits.hpp"
#include "core/tool/needle/needle.hpp"
#include "results/records/needle.hpp"
#include "studies/models/model_table.hpp"
#include "studies/models/pushed_model.hpp"
#include "studies/needle/needle_study.hpp"
#include "tests/samples/test_meshes.hpp"
#include "tests/studies/insertions.hpp"

namespace livermark::studies {
namespace {

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
double tip_compliance(double compliance) {
    return compliance + 1.0 / core::needle_stiffness;
}

double spring_of(double compliance, const core::Needle &needle, double depth) {
    return (depth - tip_compliance(compliance) * needle.tip_force()) / (1.0 + compliance * needle.friction);
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
    const auto needle = tests::needle_of_some_tissue();
    const auto line = core::needle_line(needle);
    EXPECT_LE(line.spacing, needle.spread / 3.0 + 1e-12);
    EXPECT_LT((line.places.at(line.target).middle - needle.target).norm(), 1e-12);
    EXPECT_LT((line.places.front().middle - needle.entry).norm(), 1e-12);
}

TEST(Insertion, OfABlockOnASpringHasItsClosedForm) {
    const auto soft = tests::needle_of_some_tissue();
    const auto line = core::needle_line(soft);
    const double compliance = 0.02;
    const auto found = insert(block_on_spring(soft, line, compliance), line, soft);
    ASSERT_NEAR(found.depth[found.at_plan], soft.depth(), 1e-12);
    for (int j = 1; j <= found.at_plan; ++j) {
        const double depth = found.depth[j];
        const bool is_whole = depth < tip_compliance(compliance) * soft.tip_force();
        const double tip = is_whole ? 0.0 : spring_of(compliance, soft, depth);
        const double force = is_whole ? depth / tip_compliance(compliance) : soft.tip_force() + soft.friction * tip;
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
    const auto soft = tests::needle_of_some_tissue();
    const auto line = core::needle_line(soft);
    const auto found = insert(block_on_spring(soft, line, 0.02), line, soft);
    const auto end = found.work.size() - 1;
    EXPECT_NEAR(found.work[end], found.friction[end] + found.tearing[end], 0.01 * found.work[end]);
    EXPECT_NEAR(found.stored[end], 0.0, 1e-9);
    EXPECT_NEAR(found.tearing[end], soft.tip_force() * found.tip[found.at_plan], 0.01 * found.tearing[end]);
    EXPECT_TRUE(std::isfinite(found.puncture_depth));
}

TEST(Insertion, JumpsWhereTheSurfaceGivesWay) {
    auto tough = tests::needle_of_some_tissue();
    tough.puncture_force = 0.8;
    const auto line = core::needle_line(tough);
    const double compliance = 0.02;
    const auto found = insert(block_on_spring(tough, line, compliance), line, tough);
    EXPECT_NEAR(found.puncture_depth, tip_compliance(compliance) * tough.puncture_force, tough.step);
    const auto at = std::ranges::find(found.depth, found.puncture_depth) - found.depth.begin();
    EXPECT_NEAR(found.force[at - 1], found.depth[at - 1] / tip_compliance(compliance), 1e-3);
    EXPECT_NEAR(found.tip[at], spring_of(compliance, tough, found.depth[at]), 1e-4 * tough.depth());
    EXPECT_LT(found.force[at], 0.6 * found.force[at - 1]);
    EXPECT_GT(found.puncture_loss, 0.0);
    EXPECT_LT(*std::ranges::max_element(found.force), tough.puncture_force) << "records are beside it";
    EXPECT_EQ((results::NeedleRun{.model = "block", .insertion = found}.largest_force(tough)), tough.puncture_force);
}

/// A rigid block that forces along the axis push aside as well, by d = 5 mm/N, and forces across it by e = 10 mm/N.
/// Each place that the tip has passed holds it back, with k, from where it was then. So with n places behind the tip it
/// goes aside by d dF / (1 + n e k) with the force F of tip and friction. A soft bed does not hold it, a stiff one
/// nearly.
TEST(Insertion, BesideABedOfSpringsHasItsClosedForm) {
    constexpr double along = 0.02, aside = 0.005, across = 0.01; // m/N
    auto needle = tests::needle_of_some_tissue();
    const auto line = core::needle_line(needle);
    const auto places = static_cast<Eigen::Index>(line.places.size());
    const core::Vector3 axis = needle.direction(), side = axis.unitOrthogonal();
    const Eigen::Matrix3d block = (along - across) * axis * axis.transpose() + across * Eigen::Matrix3d::Identity() +
                                  aside * (axis * side.transpose() + side * axis.transpose());
    Eigen::MatrixXd matrix = block.replicate(places, places);
    matrix.diagonal().array() += 1e-7 * along;
    for (const double side_stiffness : {1.0, 5e3, 1e5, std::numeric_limits<double>::infinity()}) {
        SCOPED_TRACE(side_stiffness);
        needle.side_stiffness = side_stiffness;
        results::NeedleRun run{.model = "block", .insertion = insert(matrix, line, needle)};
        const auto &found = run.insertion;
        const double held = across / (1.0 / core::needle_stiffness + needle.side_softness(line.spacing)); // e k
        for (int j = 1; j <= found.at_plan; ++j) {
            if (found.tip[j] <= 0.0)
                continue;
            double way = aside * needle.tip_force() / (1.0 + held);
            for (int n = 1; found.tip[j] > (n - 1) * line.spacing; ++n)
                way += aside * needle.friction * std::min(line.spacing, found.tip[j] - (n - 1) * line.spacing) /
                       (1.0 + n * held);
            EXPECT_NEAR(found.target[j].dot(side), way, 5e-6) << found.depth[j];
        }
        EXPECT_LT(run.energy_error(), 0.01);
        const double last = run.miss().dot(side), free = aside * run.force_at_plan();
        EXPECT_EQ(last > 0.99 * free, side_stiffness == 1.0);
        EXPECT_EQ(last < 0.01 * free, std::isinf(side_stiffness));
    }
}

TEST(Insertion, OfAForceTooSmallNeverPunctures) {
    auto tough = tests::needle_of_some_tissue();
    tough.puncture_force = 50.0;
    const auto line = core::needle_line(tough);
    const auto found = insert(block_on_spring(tough, line, 0.02), line, tough);
    EXPECT_TRUE(std::isnan(found.puncture_depth));
    EXPECT_EQ(*std::ranges::max_element(found.tip), 0.0);
    EXPECT_NEAR(found.force[found.at_plan], tough.depth() / tip_compliance(0.02), 1e-3);
    results::NeedleRun run{.model = "block", .insertion = found};
    run.note_limit(0.01); // the block goes with the tip
    EXPECT_NEAR(run.left_regime_at, 0.01 / 0.02 * tip_compliance(0.02), 1.01 * tough.step);
    EXPECT_NEAR(found.moved[found.at_plan], 0.02 * found.force[found.at_plan], 1e-6);
}

/// Sixty of them are in the full tests.
TEST(Insertion, OfSomeNeedlesStaysFiniteAndBalanced) {
    EXPECT_EQ(tests::drive_into_some_tissue(11, 4, 0.006), std::vector<std::string>{});
}

/// A rigid block on a spring along the axis whose force is k u (1 + (u / l)^2), and on a stiff linear one across it.
class BlockOnStiffeningSpring : public core::PushedBody {
  public:
    BlockOnStiffeningSpring(const core::Needle &needle, std::size_t num_places)
        : axis_(needle.direction()), places_(static_cast<Eigen::Index>(num_places)),
          compliance_(3 * places_, 3 * places_) {
        const Eigen::Matrix3d along = axis_ * axis_.transpose();
        for (Eigen::Index i = 0; i < places_; ++i)
            for (Eigen::Index j = 0; j < places_; ++j)
                compliance_.block<3, 3>(3 * i, 3 * j) =
                    (along + 0.1 * (Eigen::Matrix3d::Identity() - along)) / stiffness;
    }

    static double way_under(double force) {
        double way = force / stiffness;
        for (int step = 0; step < 50; ++step)
            way -= (stiffness * (way + std::pow(way, 3) / (length * length)) - force) /
                   (stiffness * (1.0 + 3.0 * std::pow(way / length, 2)));
        return way;
    }

    const Eigen::MatrixXd &compliance() const override { return compliance_; }
    std::optional<core::PushedPlaces> push(const Eigen::VectorXd &force) override {
        core::Vector3 sum = core::Vector3::Zero();
        for (Eigen::Index k = 0; k < places_; ++k)
            sum += force.segment<3>(3 * k);
        const double along = sum.dot(axis_);
        if (std::abs(along) > strongest)
            return std::nullopt;
        const double way = way_under(along);
        const core::Vector3 across = 0.1 / stiffness * (sum - along * axis_);
        const core::Vector3 moved = way * axis_ + across;
        const double stored =
            stiffness * (0.5 * way * way + 0.25 * std::pow(way, 4) / (length * length)) + 0.5 * sum.dot(across);
        return core::PushedPlaces{moved.replicate(places_, 1), stored};
    }

    static constexpr double stiffness = 30.0; ///< [N/m]
    static constexpr double length = 0.01;    ///< at which it is twice as stiff [m]
    double strongest = 1e9;                   ///< force that it bears [N]

  private:
    core::Vector3 axis_;
    Eigen::Index places_;
    Eigen::MatrixXd compliance_;
};

TEST(LargeInsertion, OfABlockOnAStiffeningSpringHasItsClosedForm) {
    auto needle = tests::needle_of_some_tissue();
    needle.puncture_force = 0.5;
    const auto line = core::needle_line(needle);
    BlockOnStiffeningSpring block(needle, line.places.size());
    results::NeedleRun run;
    run.insertion = insert(block, line, needle);
    const auto &found = run.insertion;
    ASSERT_TRUE(std::isnan(found.stopped_at));
    const double soft = 1.0 / core::needle_stiffness, enough = 1e-3 * line.spacing;
    const double gives_way = block.way_under(needle.puncture_force) + soft * needle.puncture_force;
    EXPECT_GT(block.way_under(needle.puncture_force), 0.7 * block.length) << "the spring stiffens";
    EXPECT_NEAR(found.puncture_depth, gives_way, needle.step + enough);
    for (int j = 1; j <= found.at_plan; ++j) {
        const double tip = found.tip[j], force = found.force[j];
        EXPECT_NEAR(found.depth[j], tip + block.way_under(force) + soft * (tip > 0.0 ? needle.tip_force() : force),
                    3.0 * enough);
        if (tip > 0.0) {
            EXPECT_NEAR(force, needle.tip_force() + needle.friction * tip, 1e-4) << found.depth[j];
        }
        EXPECT_NEAR(found.target[j].dot(needle.direction()), block.way_under(force), enough);
    }
    EXPECT_LT(run.energy_error(), 0.01);
    EXPECT_NEAR(found.force.back(), 0.0, 1e-6);
}

TEST(LargeInsertion, SaysWhereABodyComesToNoRest) {
    auto needle = tests::needle_of_some_tissue();
    needle.puncture_force = 0.5;
    const auto line = core::needle_line(needle);
    BlockOnStiffeningSpring block(needle, line.places.size());
    block.strongest = 0.3;
    results::NeedleRun run;
    run.insertion = insert(block, line, needle);
    const auto &found = run.insertion;
    EXPECT_NEAR(found.stopped_at, block.way_under(0.3) + 0.3 / core::needle_stiffness, 2.0 * needle.step);
    EXPECT_NEAR(found.depth[found.at_plan], needle.depth(), 1e-12);
    EXPECT_EQ(found.num_records(), found.at_plan + 1);
    EXPECT_TRUE(std::isnan(run.force_at_plan()));
    EXPECT_TRUE(std::isnan(run.largest_pull()));
    EXPECT_NEAR(run.largest_force(needle), 0.3, 0.03);
}

/// A box of 40 x 30 x 30 mm that is held below, with a needle that goes in from above, aslant.
struct PushedBlock {
    core::Problem problem = tests::box_held_below({0.04, 0.03, 0.03}, {4, 3, 3});
    core::Needle needle = tests::slanted_needle(0.5, 5e-4);

    results::NeedleRun in(const std::string &name) const {
        const auto line = core::needle_line(needle);
        const auto model = support::find_named(models::all_models(), name, "model");
        const auto pushed = models::pushed_model(model);
        results::NeedleRun run;
        run.model = name;
        run.insertion = pushed ? insert(*pushed->prepare(problem, line.places, 0, nullptr), line, needle)
                               : insert(model.compliance(problem, line.places).matrix, line, needle);
        return run;
    }
};

/// Distance of targets and forces of two, over those of the first.
double apart(const results::NeedleRun &run, const results::NeedleRun &other) {
    return std::max((run.miss() - other.miss()).norm() / run.miss().norm(),
                    results::force_error(other.insertion, run.insertion));
}

TEST(LargeInsertion, WithSmallForcesIsThatOfALinearBody) {
    PushedBlock block;
    for (double *const force : {&block.needle.toughness, &block.needle.friction, &block.needle.puncture_force})
        *force *= 0.01;
    EXPECT_LT(apart(block.in("fem_p1"), block.in("fem_p1_neo_hookean")), 0.01);
}

TEST(LargeInsertion, OfSpringsAndElementsBalancesItsWork) {
    const PushedBlock block;
    for (const auto *name : {"fem_p1_neo_hookean", "nodal_neo_hookean", "patch_nodal_volume"}) {
        const auto run = block.in(name);
        ASSERT_TRUE(std::isnan(run.insertion.stopped_at)) << name;
        EXPECT_GT(*std::ranges::max_element(run.insertion.entry), 2e-3) << name;
        EXPECT_LT(run.energy_error(), 0.02) << name;
        EXPECT_NEAR(run.insertion.force.back(), 0.0, 1e-5) << name;
    }
}

TEST(LargeInsertion, DiffersFromThatOfALinearBodyWhereTissueMovesFar) {
    const PushedBlock block;
    EXPECT_GT(apart(block.in("fem_p1"), block.in("fem_p1_neo_hookean")), 0.05);
}

} // namespace
} // namespace livermark::studies
