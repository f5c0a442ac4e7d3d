#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

#include "core/support/input_error.hpp"
#include "core/tool/needle/pushed_body.hpp"
#include "results/records/needle.hpp"
#include "studies/models/model_table.hpp"
#include "studies/models/pushed_model.hpp"
#include "studies/needle/insertion.hpp"
#include "tests/samples/test_meshes.hpp"
#include "tests/studies/some_tissue.hpp"

namespace livermark::studies {
namespace {

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
    core::Problem problem = [] {
        core::Problem held{tests::make_body(tests::box_mesh({0.04, 0.03, 0.03}, {4, 3, 3}), {1060.0, 5e3, 0.45}), {}};
        held.load_case = tests::empty_load_case(held.body->mesh);
        tests::prescribe(held.load_case, held.body->mesh, "z_min", core::Vector3::Zero());
        return held;
    }();
    core::Needle needle{.name = "needle",
                        .entry = {0.016, 0.013, 0.03},
                        .target = {0.024, 0.017, 0.012},
                        .diameter = 1e-3,
                        .spread = 8e-3,
                        .toughness = 60.0,
                        .friction = 6.0,
                        .puncture_force = 0.5,
                        .step = 5e-4};

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

/// How far targets and forces of two are apart, over those of the first.
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
