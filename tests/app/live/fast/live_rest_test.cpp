#include <gtest/gtest.h>

#include "app/live/parameters.hpp"
#include "app/live/scene.hpp"
#include "tests/app/live/rough_trial.hpp"

namespace livermark::live {
namespace {

using core::Vector3;

/// A bar of 63 nodes, so that none of the slices of its nodes is full.
struct OddBeam : TrialBody {
    OddBeam() : TrialBody(trial_body("small_beam")) {}
    int node = [this] {
        for (int i = 0; i < body.mesh.num_nodes(); ++i)
            if ((body.mesh.points[i] - Vector3(0.1, 0.02, 0.04)).norm() < 1e-9)
                return i;
        return -1;
    }();

    Scene scene(const Settings &settings) const {
        Scene made(body, is_constrained);
        made.choose(settings);
        return made;
    }
    Tool pull(const Vector3 &by) const {
        return {.kind = ToolKind::pull, .target = body.mesh.points[node] + by, .node = node};
    }
    Tool poke(double depth) const {
        return {.kind = ToolKind::probe, .target = body.mesh.points[node] + Vector3(0.0, 0.0, 0.012 - depth)};
    }
};

/// Expects that a scene at rest is, to the last bit, one in which nothing has been done but choosing.
void expect_fresh(Scene &scene, const OddBeam &beam, const Settings &settings) {
    auto fresh = beam.scene(settings);
    const int restarts = scene.move({}, 0).restarts;
    for (const auto &tool : {beam.poke(0.002), beam.pull({0.0, 0.004, 0.0}), Tool{}})
        for (int i = 0; i < 5; ++i) {
            const auto found = scene.move(tool, 20), expected = fresh.move(tool, 20);
            EXPECT_EQ(found.displacement, expected.displacement);
            EXPECT_EQ(found.force, expected.force);
            EXPECT_EQ(found.tool, expected.tool);
            EXPECT_EQ(found.indentation, expected.indentation);
            EXPECT_EQ(found.largest_speed, expected.largest_speed);
            EXPECT_EQ(found.smallest_volume, expected.smallest_volume);
            EXPECT_EQ(found.restarts, restarts);
            EXPECT_EQ(expected.restarts, 0);
        }
}

TEST(LiveRest, IsThatOfAFreshSceneAfterAnything) {
    const OddBeam beam;
    for (const auto &springs : spring_names()) {
        SCOPED_TRACE(springs);
        const Settings settings{.springs = springs, .young_modulus = 5e3, .poisson_ratio = 0.49};
        auto scene = beam.scene({.springs = springs, .young_modulus = 2e3, .poisson_ratio = 0.3});
        scene.move(beam.pull({0.0, 0.0, 300.0}), 300);
        scene.choose(settings);
        scene.move(beam.pull({0.0, 0.0, 0.004}), 100);
        scene.move(beam.poke(0.03), 100);
        scene.reset();
        expect_fresh(scene, beam, settings);
    }
}

/// Springs with lambda = mu under a smaller Poisson's ratio have a term that pulls volumes apart the more the larger
/// they are, and which tears the body when it is drawn far out.
TEST(LiveRest, IsThatOfAFreshSceneAfterAMotionWasLost) {
    const OddBeam beam;
    const Settings torn{.springs = "lloyd", .young_modulus = 5e3, .poisson_ratio = 0.0};
    auto scene = beam.scene(torn);
    int restarts = 0;
    for (int i = 0; i < 200 && restarts == 0; ++i)
        restarts = scene.move(beam.pull({0.3, 0.0, 0.0}), 50).restarts;
    ASSERT_EQ(restarts, 1) << "a motion was lost";
    expect_fresh(scene, beam, torn);
    scene.reset();
    expect_fresh(scene, beam, torn);
}

TEST(LiveRest, ALossForgetsNothingThatWasKept) {
    const OddBeam beam;
    auto scene = beam.scene({.springs = "lloyd", .young_modulus = 5e3, .poisson_ratio = 0.0});
    const auto kept = scene.move(beam.poke(0.002), 100);
    scene.keep();
    for (int i = 0; i < 200 && scene.move({}, 0).restarts == 0; ++i)
        scene.move(beam.pull({0.3, 0.0, 0.0}), 50);
    scene.restore();
    EXPECT_EQ(scene.move(beam.poke(0.002), 0).displacement, kept.displacement);
}

/// Three nodes are pulled by 300 m and then by 4 mm, while springs change.
TEST(LiveRest, NoMotionIsLostOfABeamThatIsTorn) {
    const OddBeam beam;
    auto scene = beam.scene({.young_modulus = 5e3});
    for (const auto &springs : spring_names()) {
        const Settings settings{.springs = springs, .young_modulus = 5e3, .poisson_ratio = 0.49};
        for (const double way : {300.0, 0.004})
            for (const auto &along : {Vector3(1.0, 0.0, 0.0), Vector3(0.0, 1.0, 0.0), Vector3(0.0, 0.0, 1.0)})
                EXPECT_EQ(scene.move(beam.pull(way * along), 400).restarts, 0) << springs;
        scene.choose(settings);
        EXPECT_EQ(scene.move(beam.poke(0.002), 100).restarts, 0) << springs;
    }
}

} // namespace
} // namespace livermark::live
