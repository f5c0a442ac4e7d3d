#include "app/live/scene.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <string>

#include "app/live/parameters.hpp"
#include "core/support/input_error.hpp"
#include "msm/elastic_body.hpp"
#include "msm/spring_energy.hpp"
#include "msm/spring_law.hpp"
#include "msm/springs/springs.hpp"
#include "msm/statics/equilibrium.hpp"
#include "msm/statics/load_path.hpp"
#include "tests/app/live/box_scene.hpp"

namespace livermark::live {
namespace {

/// Displacement in which the model of these names in the comparison comes to rest under what the tool did.
std::vector<Vector3> rest_under(const Frame &frame, const BoxScene &box, const msm::ElasticBody &model) {
    auto conditions = constrained_conditions(constrained_nodes(box.body.mesh, box.is_constrained));
    for (std::size_t k = 0; k < frame.load.nodes.size(); ++k)
        conditions.force[frame.load.nodes[k]] = frame.load.nodal[k];
    const auto rest = msm::find_equilibrium(model, box.body.mesh.points, conditions);
    EXPECT_EQ(rest.status, core::SolutionStatus::ok) << rest.message;
    return rest.displacement;
}

const msm::SpringLaw &law_named(std::string_view name) {
    const auto laws = msm::all_spring_laws();
    return *std::ranges::find(laws, name, &msm::SpringLaw::name);
}

TEST(LiveScene, ComesToRestWhereTheComparedModelDoes) {
    const BoxScene box;
    for (const std::string law : {"patch", "lloyd", "van_gelder"}) {
        Scene scene(box.body, box.is_constrained);
        const auto chosen = scene.choose(settings(law));
        const auto model = msm::springs_with_volume(box.body, msm::springs_beside_volume(box.body, law_named(law)),
                                                    msm::find_volume_term("nodal_volume"));
        for (const auto &tool : {box.pull({0.0, 0.001, 0.002}), box.poke(0.003)}) {
            const auto frame = moved(scene, tool, 3.0, chosen.time_step);
            EXPECT_GT(frame.force.norm(), 1e-3);
            EXPECT_GT(frame.indentation, 1e-4);
            EXPECT_LT(distance(frame.displacement, rest_under(frame, box, model.body)), 1e-4) << law;
        }
    }
}

TEST(LiveScene, ComesToRestWhereTheComparedSpringsAroundNodesDo) {
    const BoxScene box;
    for (const auto &springs : msm::all_coupled_springs()) {
        if (!msm::are_in_kernels(springs))
            continue;
        const auto &name = springs.name;
        const auto model = msm::coupled_springs_with_volume(box.body, springs);
        Scene scene(box.body, box.is_constrained);
        const auto chosen = scene.choose(settings(name));
        for (const auto &tool : {box.pull({0.0, 0.001, 0.002}), box.poke(0.003)}) {
            const auto frame = moved(scene, tool, 3.0, chosen.time_step);
            EXPECT_GT(frame.force.norm(), 1e-3);
            EXPECT_LT(distance(frame.displacement, rest_under(frame, box, model)), 1e-4) << name;
        }
    }
}

/// Answer of the comparison to a ball that goes straight to where the one of the page has come to rest.
msm::FollowedPath pressed_by_ball(const BoxScene &box, const Tool &tool, const Frame &frame,
                                  const msm::ElasticBody &model) {
    const Vector3 start = box.body.mesh.points[box.node] + shape_of(tool).radius * Vector3::UnitZ();
    const auto problem = touched_by_ball(box.body, box.is_constrained, tool, start, frame.tool - start);
    const auto conditions = constrained_conditions(constrained_nodes(box.body.mesh, box.is_constrained));
    const msm::RestStiffness rest(model, box.body.mesh.points, conditions.displacement);
    const auto path = msm::follow_path(model, problem, model.node_mass, rest);
    EXPECT_EQ(path.end.status, core::SolutionStatus::ok) << path.end.message;
    return path;
}

/// The law of contact is that of load cases. With friction there are many equilibria, see below.
TEST(LiveScene, PressesAsTheBallOfALoadCaseDoes) {
    const BoxScene box;
    auto tool = box.poke(0.004);
    tool.friction = 0.0;
    for (const std::string name : {"nodal_springs", "nodal_neo_hookean"}) {
        const auto model = msm::coupled_springs_with_volume(box.body, msm::find_coupled_springs(name));
        Scene scene(box.body, box.is_constrained);
        const auto chosen = scene.choose(settings(name));
        const auto frame = moved(scene, tool, 3.0, chosen.time_step);
        const auto expected = pressed_by_ball(box, tool, frame, model);
        EXPECT_LT((frame.force + expected.points.back().reaction[1]).norm(), 1e-3 * frame.force.norm()) << name;
        EXPECT_LT(distance(frame.displacement, expected.end.displacement), 1e-3) << name;
        Vector3 on_nodes = Vector3::Zero(), on_triangles = Vector3::Zero();
        for (const auto &force : frame.load.nodal)
            on_nodes += force;
        for (const auto &force : frame.load.facet)
            on_triangles += force;
        EXPECT_LT((on_nodes + frame.force).norm() + (on_triangles + frame.force).norm(), 1e-9 * frame.force.norm());
    }
}

/// A square plate in the middle of the top.
Tool plate(const BoxScene &box, double depth) {
    const double size = 0.008;
    return {.kind = ToolKind::probe,
            .target = box.body.mesh.points[box.node] + (edge_of_plate * size - depth) * Vector3::UnitZ(),
            .radius = size,
            .friction = 0.0,
            .inwards = -Vector3::UnitZ(),
            .face = core::ToolFace::square};
}

TEST(LiveScene, PressesAsThePlateOfALoadCaseDoes) {
    const BoxScene box;
    const auto tool = plate(box, 0.003);
    for (const std::string name : {"nodal_springs", "nodal_neo_hookean"}) {
        const auto model = msm::coupled_springs_with_volume(box.body, msm::find_coupled_springs(name));
        Scene scene(box.body, box.is_constrained);
        const auto chosen = scene.choose(settings(name));
        const auto frame = moved(scene, tool, 3.0, chosen.time_step);
        const auto expected = pressed_by_ball(box, tool, frame, model);
        RecordProperty(name, std::to_string((frame.force + expected.points.back().reaction[1]).norm()));
        EXPECT_GT(frame.force.norm(), 0.02);
        EXPECT_LT((frame.force + expected.points.back().reaction[1]).norm(), 1e-3 * frame.force.norm()) << name;
        EXPECT_LT(distance(frame.displacement, expected.end.displacement), 1e-3) << name;
        EXPECT_EQ(moved(scene, plate(box, -0.01), 0.5, chosen.time_step).force.norm(), 0.0);
    }
}

/// Put down in the body it begins where it just touches, and goes on from what was kept to the last bit, also after
/// what it touches was of another material.
TEST(LiveScene, APlateBeginsOutsideAndGoesOnFromWhatWasKept) {
    const BoxScene box;
    Scene scene(box.body, box.is_constrained), other(box.body, box.is_constrained);
    for (auto *one : {&scene, &other})
        one->choose(settings("nodal_neo_hookean"));
    const auto tool = plate(box, 0.003);
    const auto first = scene.move(tool, 0);
    EXPECT_NEAR(first.tool.z(), 0.03 + edge_of_plate * tool.radius, 1e-7);
    EXPECT_EQ(first.force.norm(), 0.0);
    scene.move(tool, 300);
    other.move(tool, 300);
    for (auto *one : {&scene, &other})
        one->keep();
    auto turned = tool;
    turned.inwards = {0.1, 0.0, -1.0};
    EXPECT_EQ(scene.move(turned, 0).force.norm(), 0.0) << "it is another plate";
    scene.move(box.poke(0.003), 50);
    scene.restore();
    EXPECT_EQ(scene.move(tool, 200).displacement, other.move(tool, 200).displacement);
    scene.choose(settings("nodal_springs"));
    EXPECT_GT(scene.move(tool, 300).force.norm(), 0.01);
}

/// A part of the body that stands behind its face would be pushed by its back.
TEST(LiveScene, RefusesAPlateWhereTheBodyIsInItsWay) {
    const BoxScene box;
    Scene scene(box.body, box.is_constrained);
    scene.choose(settings());
    auto tool = plate(box, 0.0);
    tool.target = {0.06, 0.015, 0.005};
    tool.inwards = -Vector3::UnitX();
    EXPECT_EQ(scene.move(tool, 1).restarts, 0);
    scene.move({}, 0);
    tool.target = {0.03, 0.015, 0.005};
    const auto before = scene.move(box.poke(0.002), 50);
    EXPECT_THROW(scene.move(tool, 1), support::InputError);
    tool.inwards = Vector3::Zero();
    EXPECT_THROW(scene.move(tool, 1), support::InputError);
    EXPECT_EQ(scene.move(box.poke(0.002), 0).displacement, before.displacement);
}

/// With friction the body comes to rest where its way there has left it: a hand that goes down in 4 s ends where the
/// ball of a load case does. One that jumps makes the body swing and stick elsewhere.
TEST(LiveScene, AHandThatGoesSlowlyMeetsTheFrictionOfALoadCase) {
    const BoxScene box;
    const std::string name = "nodal_neo_hookean";
    const auto model = msm::coupled_springs_with_volume(box.body, msm::find_coupled_springs(name));
    Scene scene(box.body, box.is_constrained);
    const auto chosen = scene.choose(settings(name));
    ASSERT_GT(box.poke(0.0).friction, 0.0);
    constexpr int num_parts = 200;
    for (int part = 1; part < num_parts; ++part)
        moved(scene, box.poke(0.004 * part / num_parts), 0.02, chosen.time_step);
    const auto frame = moved(scene, box.poke(0.004), 3.0, chosen.time_step);
    const auto expected = pressed_by_ball(box, box.poke(0.004), frame, model);
    EXPECT_LT((frame.force + expected.points.back().reaction[1]).norm(), 0.02 * frame.force.norm());
    EXPECT_LT(distance(frame.displacement, expected.end.displacement), 0.01);
    const Vector3 normal = Vector3::UnitZ();
    EXPECT_GT((frame.force - frame.force.dot(normal) * normal).norm(), 0.2 * frame.force.norm()) << "friction acts";
}

/// Once the hand has come to where it was to go, it and friction only take energy from a body without damping.
TEST(LiveScene, ABodyWithoutDampingGainsNoEnergyOfABallThatIsHeldInIt) {
    const BoxScene box;
    for (const std::string name : {"patch", "nodal_neo_hookean"}) {
        SpringsOfLaws kept;
        const auto model = mass_springs(box.body, settings(name), kept).body;
        const auto energy = [&](const std::vector<Vector3> &displacement) {
            auto positions = box.body.mesh.points;
            for (std::size_t i = 0; i < positions.size(); ++i)
                positions[i] += displacement[i];
            return msm::elastic_energy(model, positions);
        };
        const double none = energy(std::vector<Vector3>(box.body.mesh.points.size(), Vector3::Zero()));
        auto undamped = settings(name);
        undamped.damping = {0.0, 0.0};
        Scene scene(box.body, box.is_constrained);
        scene.choose(undamped);
        double first = 0.0, later = 0.0; // highest of seconds
        for (int i = 0; i < 1500; ++i) {
            const double now = energy(scene.move(box.poke(0.004), 3).displacement) - none;
            (i < 500 ? first : later) = std::max(i < 500 ? first : later, now);
        }
        EXPECT_GT(later, 0.0) << name;
        EXPECT_LT(later, 1.02 * first) << name;
    }
}

TEST(LiveScene, DividesStepsWhileSomethingIsPressed) {
    BoxScene box;
    Scene scene(box.body, box.is_constrained);
    const auto chosen = scene.choose(settings());
    ASSERT_GT(chosen.time_step, 1.5 * chosen.pressed_time_step);
    scene.move({}, 10);
    EXPECT_EQ(scene.num_evaluations(), 10) << "at rest a step is one";
    // As far as a step is divided it is no longer than what the pressed body bears.
    const auto most = static_cast<long>(std::ceil(chosen.time_step / chosen.pressed_time_step));
    box.node = box.node_at({0.01, 0.02, 0.03}); // beside what is held, so that it is pressed and does not bend away
    scene.move(box.poke(0.0), 100);
    const long before = scene.num_evaluations();
    double smallest = 1.0;
    for (int i = 0; i < 200; ++i)
        smallest = std::min(smallest, scene.move(box.poke(0.02), 1).smallest_volume);
    EXPECT_LT(smallest, 0.7);
    EXPECT_GT(scene.num_evaluations() - before, 220);
    EXPECT_LE(scene.num_evaluations() - before, 200 * most);
    for (int i = 0; i < 5; ++i)
        scene.move({}, 1000);
    const long at_rest = scene.num_evaluations();
    scene.move({}, 10);
    EXPECT_EQ(scene.num_evaluations() - at_rest, 10);
}

TEST(LiveScene, FeelsTheForceThatItShows) {
    const BoxScene box;
    Scene felt(box.body, box.is_constrained), shown(box.body, box.is_constrained);
    for (auto *scene : {&felt, &shown})
        scene->choose(settings("nodal_neo_hookean"));
    for (const double depth : {0.002, 0.004, 0.006})
        EXPECT_EQ(felt.feel(box.poke(depth), 30), shown.move(box.poke(depth), 30).force);
    EXPECT_EQ(felt.move(box.poke(0.006), 0).displacement, shown.move(box.poke(0.006), 0).displacement);
}

TEST(LiveScene, GivesTheSameBitsOnSeveralThreads) {
    const BoxScene box;
    Scene one(box.body, box.is_constrained), two(box.body, box.is_constrained, {}, 2);
    for (auto *scene : {&one, &two})
        scene->choose(settings("nodal_neo_hookean"));
    EXPECT_EQ(one.move(box.poke(0.01), 200).displacement, two.move(box.poke(0.01), 200).displacement);
}

/// A tool that touches is not softer where steps are longer.
TEST(LiveScene, PressesAsFarWithLongStepsAsWithShortOnes) {
    const BoxScene box;
    auto tool = box.poke(0.004);
    tool.friction = 0.0; // with friction there are many equilibria
    const auto pressed = [&](double part) {
        Scene scene(box.body, box.is_constrained);
        auto chosen = scene.choose(settings());
        auto other = settings();
        other.time_step = part * chosen.longest_time_step;
        chosen = scene.choose(other);
        return moved(scene, tool, 3.0, chosen.time_step);
    };
    const auto longest = pressed(1.0), shorter = pressed(0.1);
    EXPECT_NEAR(longest.force.norm(), shorter.force.norm(), 1e-3 * shorter.force.norm());
    EXPECT_LT(distance(longest.displacement, shorter.displacement), 1e-3);
}

TEST(LiveScene, SpringsAloneHaveYoungsModulusAndNoOtherPoissonsRatio) {
    const BoxScene box;
    auto alone = settings("lloyd");
    alone.keeps_volume = false;
    alone.young_modulus = 7e3;
    Scene scene(box.body, box.is_constrained);
    const auto chosen = scene.choose(alone);
    const auto frame = moved(scene, box.pull({0.0, 0.0, 0.002}), 3.0, chosen.time_step);
    auto body = box.body;
    body.materials.front().young_modulus = 7e3;
    const auto springs = msm::spring_network(body, law_named("lloyd"));
    EXPECT_LT(distance(frame.displacement, rest_under(frame, box, springs)), 1e-4);
}

TEST(LiveScene, TheTargetOfAPullIsWhereItsNodeGoesAsFarAsTheHandCan) {
    const BoxScene box;
    Scene scene(box.body, box.is_constrained);
    const auto chosen = scene.choose(settings());
    const auto frame = moved(scene, box.pull({0.0, 0.0, 0.003}), 2.0, chosen.time_step);
    // The coupling gives way by the force, and the node is a little further out than the mean of what is constrained.
    EXPECT_NEAR(frame.displacement[box.node].z(), 0.003 + frame.force.z() / 400.0, 5e-4);
    EXPECT_LT(frame.force.z(), 0.0) << "the body draws back";
}

TEST(LiveScene, TheSameCallsGiveTheSameBits) {
    const BoxScene box;
    const auto last_frame = [&] {
        Scene scene(box.body, box.is_constrained);
        scene.choose(settings());
        scene.move(box.poke(0.02), 200);
        auto softer = settings("van_gelder");
        softer.young_modulus = 3e3;
        scene.choose(softer);
        return scene.move(box.pull({0.01, 0.0, 0.01}), 200);
    };
    const auto first = last_frame(), second = last_frame();
    EXPECT_EQ(first.force, second.force);
    EXPECT_EQ(first.displacement, second.displacement);
}

TEST(LiveScene, GoesOnFromWhereItIsWithOtherParameters) {
    const BoxScene box;
    Scene scene(box.body, box.is_constrained);
    scene.choose(settings());
    const auto before = scene.move(box.poke(0.005), 300);
    auto other = settings("lloyd");
    other.poisson_ratio = 0.3;
    other.keeps_volume = false;
    scene.choose(other);
    const auto after = scene.move(box.poke(0.005), 0);
    EXPECT_EQ(before.displacement, after.displacement);
    EXPECT_EQ(before.time, after.time);
}

TEST(LiveScene, ComesBackWhenItIsLetGoAndAtOnceWhenItIsReset) {
    const BoxScene box;
    Scene scene(box.body, box.is_constrained);
    const auto chosen = scene.choose(settings());
    const auto touched = moved(scene, box.poke(0.006), 0.5, chosen.time_step);
    const auto left = moved(scene, {}, 2.0, chosen.time_step);
    EXPECT_TRUE(left.force.isZero(0.0));
    EXPECT_EQ(left.indentation, 0.0);
    EXPECT_LT(left.displacement[box.node].norm(), 1e-4 * touched.displacement[box.node].norm());
    moved(scene, box.poke(0.006), 0.5, chosen.time_step);
    scene.reset();
    const auto reset = scene.move({}, 0);
    for (const auto &u : reset.displacement)
        EXPECT_TRUE(u.isZero(0.0));
    EXPECT_EQ(reset.smallest_volume, 1.0);
}

TEST(LiveScene, GoesOnFromWhatWasKeptAsIfNothingHadBeenDoneSince) {
    const BoxScene box;
    Scene scene(box.body, box.is_constrained), untouched(box.body, box.is_constrained);
    for (auto *each : {&scene, &untouched}) {
        each->choose(settings());
        each->move(box.poke(0.004), 150);
        each->keep();
    }
    scene.move(box.pull({0.01, 0.0, 0.01}), 200);
    scene.restore();
    // As far as the poke goes, and into another tool.
    for (const auto &tool : {box.poke(0.004), box.poke(0.006), Tool{}}) {
        const auto restored = scene.move(tool, 60), expected = untouched.move(tool, 60);
        EXPECT_EQ(restored.displacement, expected.displacement);
        EXPECT_EQ(restored.force, expected.force);
        EXPECT_EQ(restored.indentation, expected.indentation);
        EXPECT_GT(restored.time, expected.time) << "time goes on";
    }
}

TEST(LiveScene, KeepsNothingThatCouldBeRestoredUntilItIsAsked) {
    const BoxScene box;
    Scene scene(box.body, box.is_constrained);
    EXPECT_THROW(scene.keep(), support::InputError);
    scene.choose(settings());
    EXPECT_THROW(scene.restore(), support::InputError);
    scene.keep();
    scene.reset();
    EXPECT_THROW(scene.restore(), support::InputError);
}

TEST(LiveScene, TellsItsLargestSpeedWhichIsNothingAtRest) {
    const BoxScene box;
    Scene scene(box.body, box.is_constrained);
    const auto chosen = scene.choose(settings());
    EXPECT_EQ(scene.move({}, 0).largest_speed, 0.0);
    EXPECT_GT(scene.move(box.pull({0.0, 0.0, 0.003}), 50).largest_speed, 1e-3);
    const auto before = moved(scene, {}, 1.0, chosen.time_step);
    const auto after = scene.move({}, 1);
    double way = 0.0;
    for (std::size_t i = 0; i < after.displacement.size(); ++i)
        way = std::max(way, (after.displacement[i] - before.displacement[i]).norm());
    EXPECT_NEAR(after.largest_speed * chosen.time_step, way, 1e-12 + 1e-6 * way);
    EXPECT_LT(moved(scene, {}, 3.0, chosen.time_step).largest_speed, 1e-4);
}

/// A hand that tears and stamps as fast as it can.
TEST(LiveScene, BearsRoughHandlingAtTheLongestStep) {
    const BoxScene box;
    for (const bool keeps_volume : {true, false}) {
        Scene scene(box.body, box.is_constrained);
        auto rough = settings();
        rough.keeps_volume = keeps_volume;
        rough.damping.alpha = 5.0;
        const auto chosen = scene.choose(rough);
        for (int i = 0; i < 20; ++i) {
            moved(scene, i % 2 ? box.poke(0.03) : box.pull({0.05, 0.0, i % 4 ? 0.05 : -0.05}), 0.1, chosen.time_step);
            moved(scene, {}, 0.05, chosen.time_step);
        }
        const auto frame = moved(scene, {}, 3.0, chosen.time_step);
        EXPECT_EQ(frame.restarts, 0);
        EXPECT_GT(frame.smallest_volume, 0.95);
    }
}

TEST(LiveScene, OffersNoLongerStepThanIsSafe) {
    const BoxScene box;
    Scene scene(box.body, box.is_constrained);
    const auto longest = scene.choose(settings());
    EXPECT_EQ(longest.time_step, longest.longest_time_step);
    EXPECT_LT(longest.longest_time_step, longest.critical_time_step);
    auto shorter = settings();
    shorter.time_step = 0.3 * longest.longest_time_step;
    EXPECT_EQ(scene.choose(shorter).time_step, shorter.time_step);
    auto longer = settings();
    longer.time_step = 1.01 * longest.longest_time_step;
    EXPECT_THROW(scene.choose(longer), support::InputError);
}

} // namespace
} // namespace livermark::live
