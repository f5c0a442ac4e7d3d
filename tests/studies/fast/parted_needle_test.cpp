// Needles in bodies with a capsule, vessels as lines or a map of stiffness.
#include <Eigen/LU>
#include <cmath>
#include <gtest/gtest.h>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/support/input_error.hpp"
#include "core/tool/needle/needle.hpp"
#include "results/records/needle.hpp"
#include "studies/models/model_table.hpp"
#include "studies/models/motion/moving_method.hpp"
#include "studies/models/pushed_model.hpp"
#include "studies/needle/needle_study.hpp"
#include "tests/samples/bodies_with_vessels.hpp"
#include "tests/samples/covered_bodies.hpp"
#include "tests/samples/test_meshes.hpp"
#include "tests/studies/insertions.hpp"

namespace livermark::studies {
namespace {

using core::Vector3;
namespace covered = tests::covered;

using SharedBody = std::shared_ptr<const core::Body>;

/// A tube across the way of the needle, half as deep as that goes.
SharedBody with_vessel_across(const SharedBody &body) {
    return tests::vessels::with_vessels(body,
                                        tests::vessels::rod({0.0, 0.015, 0.021}, {0.04, 0.015, 0.021}, 2e-3, 1e6));
}

SharedBody with_map(const SharedBody &body) {
    auto mapped = *body;
    for (const auto &nodes : mapped.mesh.tetrahedra)
        mapped.modulus_factor.push_back(0.8 + 20.0 * mapped.mesh.points[nodes[0]].x());
    return std::make_shared<const core::Body>(std::move(mapped));
}

/// A box of 40 x 30 x 30 mm that is held below, with a needle that goes in from above, aslant.
struct PartedBlock {
    core::Problem problem = tests::box_held_below({0.04, 0.03, 0.03}, {4, 3, 3});
    core::Needle needle = tests::slanted_needle(0.2, 1e-3);

    core::Problem of(const SharedBody &body) const { return {body, problem.load_case}; }
    std::vector<SharedBody> parted() const {
        const auto &plain = problem.body;
        return {covered::with_capsule(plain), with_vessel_across(plain), with_map(plain),
                with_map(with_vessel_across(covered::with_capsule(plain)))};
    }
    Eigen::MatrixXd compliance(const SharedBody &body, const std::string &model) const {
        return support::find_named(models::all_models(), model, "model")
            .compliance(of(body), core::needle_line(needle).places)
            .matrix;
    }
};

/// Sliding tissue exerts what tears it and what rubs, whatever bears it: a membrane and the wall of a vessel on the way
/// change how far it goes along, and no force but by that.
void expect_force_of_tearing_and_rubbing(const core::Insertion &insertion, const core::Needle &needle) {
    const auto at_plan = static_cast<std::size_t>(insertion.at_plan);
    EXPECT_GT(insertion.tip[at_plan], 0.5 * needle.depth());
    EXPECT_NEAR(insertion.force[at_plan], needle.tip_force() + needle.friction * insertion.tip[at_plan], 1e-4);
}

/// Before the puncture the tip is borne by the body with its membrane: along the axis by what its place gives way by,
/// while that is held across it.
TEST(NeedleInAPartedBody, GivesWayWhereTheBodyBearsThePunctureAndSlidesAsWithoutParts) {
    const PartedBlock block;
    const auto &needle = block.needle;
    const auto line = core::needle_line(needle);
    const Vector3 axis = needle.direction();
    const auto bodies = block.parted();
    for (const std::string name : {"fem_p1", "nodal_neo_hookean"}) {
        SCOPED_TRACE(name);
        const auto depth_of = [&](const SharedBody &body) {
            const auto compliance = block.compliance(body, name);
            const auto found = insert(compliance, line, needle);
            const Eigen::Matrix3d at_entry =
                compliance.topLeftCorner<3, 3>() + Eigen::Matrix3d::Identity() / core::needle_stiffness;
            const double expected = needle.puncture_force / axis.dot(at_entry.inverse() * axis);
            EXPECT_NEAR(found.puncture_depth, expected + 0.5 * needle.step, 0.501 * needle.step);
            expect_force_of_tearing_and_rubbing(found, needle);
            return expected;
        };
        const double plain = depth_of(block.problem.body);
        EXPECT_LT(depth_of(bodies[0]), 0.9 * plain) << "the membrane bears";
        EXPECT_LT(depth_of(bodies[1]), 0.98 * plain) << "the vessel bears";
    }
}

TEST(NeedleInAPartedBody, ThatMovesFarSlidesAsWithoutParts) {
    PartedBlock block;
    block.needle.step = 5e-4;
    const auto line = core::needle_line(block.needle);
    const auto body = block.parted().back();
    for (const std::string name : {"fem_p1_neo_hookean", "nodal_neo_hookean"}) {
        SCOPED_TRACE(name);
        const auto pushed = models::pushed_model(support::find_named(models::all_models(), name, "model"));
        results::NeedleRun run{
            .model = name,
            .insertion = insert(*pushed->prepare(block.of(body), line.places, 0, nullptr), line, block.needle)};
        ASSERT_TRUE(std::isnan(run.insertion.stopped_at));
        expect_force_of_tearing_and_rubbing(run.insertion, block.needle);
        EXPECT_LT(run.energy_error(), 0.02);
    }
}

/// In small steps springs of the arena meet the needle of their own compliance.
TEST(NeedleInAPartedBody, OfSpringsThatMoveMeetsTheirStaticNeedle) {
    PartedBlock block;
    auto &needle = block.needle;
    needle.toughness = 8.0;
    needle.friction = 1.0;
    needle.puncture_force = 8e-3;
    const models::NeedlePlan plan{.speed = 0.02, .rest = 0.1, .mass_damping = 30.0};
    const auto line = core::needle_line(needle);
    const auto body = block.parted().back();
    for (const std::string name : {"nodal_neo_hookean", "lloyd"}) {
        SCOPED_TRACE(name);
        const auto expected = insert(block.compliance(body, name), line, needle);
        const auto plain = insert(block.compliance(block.problem.body, name), line, needle);
        const auto at_plan = static_cast<std::size_t>(expected.at_plan);
        const double farthest = expected.target[at_plan].norm();
        EXPECT_GT((plain.target[at_plan] - expected.target[at_plan]).norm(), 0.1 * farthest) << "the parts matter";
        const auto moving =
            support::find_named(models::all_moving_methods(), name, "method").with_needle(block.of(body), needle, plan);
        const auto effort = moving->least_effort().value();
        moving->prepare_for(effort);
        for (int frame = 1; frame <= plan.at_plan(needle); ++frame)
            moving->advance({.depth = plan.depth_after(needle, frame)}, effort);
        const auto reading = moving->reading();
        EXPECT_LT((reading.places[static_cast<std::size_t>(line.target)] - expected.target[at_plan]).norm(),
                  0.05 * farthest);
        EXPECT_NEAR(reading.force, expected.force[at_plan], 0.05 * expected.force[at_plan]);
    }
}

} // namespace
} // namespace livermark::studies
