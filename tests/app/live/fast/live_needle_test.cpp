#include <algorithm>
#include <cmath>
#include <cstring>
#include <gtest/gtest.h>
#include <random>

#include "app/live/messages.hpp"
#include "app/live/parameters.hpp"
#include "app/live/scene.hpp"
#include "core/support/input_error.hpp"
#include "core/tool/needle/needle.hpp"
#include "tests/app/live/box_scene.hpp"

namespace livermark::live {
namespace {

Tool prick(double depth) {
    return {.kind = ToolKind::needle,
            .needle = {.name = {},
                       .entry = {0.031, 0.013, 0.03},
                       .target = {0.035, 0.016, 0.01},
                       .diameter = 1e-3,
                       .spread = 6e-3,
                       .toughness = 30.0,
                       .friction = 3.0,
                       .puncture_force = 0.05},
            .depth = depth};
}

/// Leads it there at a speed, a frame of the screen at a time.
Frame led(Scene &scene, double from, double to, double time_step, double speed = 0.02) {
    const double frame = 1.0 / 60.0;
    const int count = std::max(1, static_cast<int>(std::ceil(std::abs(to - from) / (speed * frame))));
    Frame last;
    for (int i = 1; i <= count; ++i)
        last = scene.move(prick(from + (to - from) * i / count), static_cast<int>(std::ceil(frame / time_step)));
    return last;
}

/// A body with a hard part, whose masses are not scaled while a needle is in: digits of forces keep it trembling.
BoxScene with_hard_part() {
    BoxScene box;
    auto &mesh = box.body.mesh;
    mesh.region_names = {"soft", "hard"};
    for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
        double x = 0.0;
        for (const int i : mesh.tetrahedra[t])
            x += mesh.points[i].x() / 4.0;
        mesh.region[t] = x > 0.02 && x < 0.04 ? 1 : 0;
    }
    box.body.materials = {{1060.0, 5e3, 0.45}, {1060.0, 20.0 * 5e3, 0.45}};
    return box;
}

TEST(LiveNeedle, GoesInTakesTheTargetAlongAndComesOut) {
    const BoxScene box;
    for (const std::string springs : {"patch", "nodal_neo_hookean"}) {
        Scene scene(box.body, box.is_constrained);
        const double step = scene.choose(settings(springs)).time_step;
        const auto before = led(scene, 0.0, 0.0002, step);
        ASSERT_TRUE(before.needle.has_value());
        EXPECT_GT(before.needle->force, 0.0);
        EXPECT_LT(before.needle->force, prick(0.0).needle.puncture_force);
        EXPECT_EQ(before.needle->tip, 0.0) << "the surface is whole";
        const double depth = prick(0.0).needle.depth();
        const auto in = led(scene, 0.0002, depth, step);
        EXPECT_TRUE(in.needle->is_punctured);
        EXPECT_GT(in.needle->tip, 0.5 * depth);
        EXPECT_LT(in.needle->tip, depth) << "the tissue has gone along";
        EXPECT_GT(in.needle->target.dot(prick(0.0).needle.direction()), 1e-5);
        EXPECT_NEAR(in.needle->force, prick(0.0).needle.tip_force() + prick(0.0).needle.friction * in.needle->tip,
                    0.01);
        EXPECT_LT((in.tool - prick(0.0).needle.target).norm(), 1e-3) << "it is led as fast as it was asked for";
        EXPECT_LT((in.force + in.needle->force * prick(0.0).needle.direction()).norm(), 0.02);
        core::Vector3 sum = core::Vector3::Zero();
        for (const auto &force : in.needle->forces)
            sum += force;
        EXPECT_NEAR(sum.dot(prick(0.0).needle.direction()), in.needle->force, 1e-9) << "of all places";
        const auto out = led(scene, depth, -0.005, step);
        EXPECT_LT(led(scene, -0.005, -0.005, step).needle->force, 1e-9);
        EXPECT_EQ(out.needle->tip, 0.0);
        EXPECT_EQ(out.restarts, 0);
        scene.move({}, static_cast<int>(1.0 / step));
        EXPECT_LT(scene.move({}, 0).displacement[box.node].norm(), 1e-5);
    }
}

/// A membrane and the wall of a vessel on the way bear the tissue, and exert nothing on the needle by themselves.
TEST(LiveNeedle, GoesThroughACapsuleAndAVesselWithTheForceOfTheTissue) {
    const BoxScene plain;
    BoxScene parted;
    parted.body.capsule = core::Capsule{.thickness = 1e-4, .young_modulus = 1e6};
    parted.body.vessels = core::VesselTree{.points = {{0.033, 0.002, 0.02}, {0.033, 0.028, 0.02}},
                                           .radius = {2e-3, 2e-3},
                                           .segments = {{0, 1}},
                                           .wall_ratio = 0.2,
                                           .wall_modulus = 1e6};
    const auto needle = prick(0.0).needle;
    const auto moved = [&](const BoxScene &box) {
        Scene scene(box.body, box.is_constrained);
        const auto frame = led(scene, 0.0, needle.depth(), scene.choose(settings("nodal_neo_hookean")).time_step);
        EXPECT_EQ(frame.restarts, 0);
        EXPECT_TRUE(frame.needle->is_punctured);
        EXPECT_NEAR(frame.needle->force, needle.tip_force() + needle.friction * frame.needle->tip, 0.01);
        return frame.needle->target.norm();
    };
    EXPECT_LT(moved(parted), 0.9 * moved(plain));
}

TEST(LiveNeedle, LetGoLeavesTheBodyAsItWas) {
    const BoxScene box;
    Scene scene(box.body, box.is_constrained), untouched(box.body, box.is_constrained);
    const double step = scene.choose(settings()).time_step;
    untouched.choose(settings());
    led(scene, 0.0, 0.015, step);
    scene.reset();
    EXPECT_EQ(scene.move(box.poke(0.004), 50).displacement, untouched.move(box.poke(0.004), 50).displacement);
}

TEST(LiveNeedle, GoesOnFromWhatWasKept) {
    const BoxScene box;
    Scene scene(box.body, box.is_constrained), untouched(box.body, box.is_constrained);
    double step = 0.0;
    for (auto *each : {&scene, &untouched}) {
        step = each->choose(settings()).time_step;
        led(*each, 0.0, 0.012, step);
        each->keep();
    }
    scene.move(box.poke(0.004), 100);
    scene.restore();
    const auto restored = led(scene, 0.012, 0.016, step), expected = led(untouched, 0.012, 0.016, step);
    EXPECT_EQ(restored.displacement, expected.displacement);
    EXPECT_EQ(restored.needle->force, expected.needle->force);
    EXPECT_EQ(restored.needle->tip, expected.needle->tip);
}

/// Steps with scaled masses are too long without, so they are divided while the needle is in.
TEST(LiveNeedle, GoesThroughAStiffLumpWhoseMassesAreScaled) {
    const auto box = with_hard_part();
    Scene scene(box.body, box.is_constrained);
    const double step = scene.choose(settings()).time_step;
    scene.move({}, 10);
    const long alone = scene.num_evaluations();
    scene.move(prick(0.0), 40);
    EXPECT_GE(scene.num_evaluations() - alone, 80);
    const auto in = led(scene, 0.0, 0.018, step);
    EXPECT_GT(in.needle->tip, 0.01);
    EXPECT_EQ(in.restarts, 0);
    for (int i = 0; i < 100; ++i)
        scene.move({}, 10);
    const long before = scene.num_evaluations();
    scene.move({}, 10);
    EXPECT_EQ(scene.num_evaluations() - before, 10) << "masses are scaled again";
}

/// Led in, drawn back and led on, it keeps still within two seconds as app/viewer/src/live/rest.ts asks: in frames over
/// a quarter of a second the body gets nowhere.
TEST(LiveNeedle, ComesToRestWhereItStays) {
    const double size = 0.06, frame = 1.0 / 60.0;
    for (const auto &box : {BoxScene(), with_hard_part()})
        for (const std::string springs : {"nodal_neo_hookean", "edge_neo_hookean", "patch"})
            for (const double poisson_ratio : {0.45, 0.49}) {
                Scene scene(box.body, box.is_constrained);
                const double step = scene
                                        .choose({.springs = springs,
                                                 .young_modulus = 5e3,
                                                 .poisson_ratio = poisson_ratio,
                                                 .damping = {10.0, 0.0}})
                                        .time_step;
                const int steps = static_cast<int>(std::ceil(frame / step));
                double depth = 0.0;
                for (const double next : {0.015, 0.008, 0.018}) {
                    led(scene, depth, next, step);
                    depth = next;
                    scene.move(prick(depth), static_cast<int>(1.75 / step));
                    const auto first = scene.move(prick(depth), 1);
                    double furthest = 0.0, fastest = 0.0;
                    for (double time = 0.0; time < 0.25; time += steps * step) {
                        const auto now = scene.move(prick(depth), steps);
                        fastest = std::max(fastest, now.largest_speed);
                        for (std::size_t i = 0; i < now.displacement.size(); ++i)
                            furthest = std::max(
                                furthest, (now.displacement[i] - first.displacement[i]).lpNorm<Eigen::Infinity>());
                    }
                    EXPECT_LT(furthest, 0.25 * 1e-5 * size) << springs << ", " << poisson_ratio << ", " << depth;
                    EXPECT_LT(fastest, 5e-3 * size) << springs << ", " << poisson_ratio << ", " << depth;
                    EXPECT_GT(first.needle->tip, 0.004) << "it is in";
                }
            }
}

TEST(LiveNeedle, StaysFiniteHoweverItIsLed) {
    const BoxScene box;
    std::mt19937 random(3);
    std::uniform_real_distribution<double> part;
    for (int n = 0; n < 12; ++n) {
        Scene scene(box.body, box.is_constrained);
        const double step = scene.choose(settings(n % 2 == 0 ? "patch" : "nodal_neo_hookean")).time_step;
        auto tool = prick(0.0);
        tool.needle.entry = {0.015 + 0.03 * part(random), 0.008 + 0.014 * part(random), 0.03};
        tool.needle.target = {0.015 + 0.03 * part(random), 0.008 + 0.014 * part(random), 0.008 + 0.01 * part(random)};
        tool.needle.spread = 0.004 + 0.006 * part(random);
        tool.needle.toughness = 5.0 + 100.0 * part(random);
        tool.needle.friction = n % 4 == 0 ? 0.0 : 30.0 * part(random);
        tool.needle.puncture_force = tool.needle.tip_force() * (1.0 + part(random));
        for (int i = 0; i < 25; ++i) {
            tool.depth = tool.needle.depth() * (1.4 * part(random) - 0.3);
            const auto frame = scene.move(tool, static_cast<int>(0.04 / step));
            ASSERT_EQ(frame.restarts, 0) << n;
            ASSERT_TRUE(std::isfinite(frame.needle->force)) << n;
            ASSERT_LT(std::abs(frame.needle->force), 20.0) << n;
            ASSERT_GE(frame.needle->work.tearing, -1e-9) << n;
        }
    }
}

TEST(LiveNeedle, RefusesWaysThatLeaveTheBody) {
    const BoxScene box;
    Scene scene(box.body, box.is_constrained);
    scene.choose(settings());
    const auto refused = [&](auto change) {
        auto tool = prick(0.001);
        change(tool.needle);
        EXPECT_THROW(scene.move(tool, 1), support::InputError);
    };
    refused([](core::Needle &n) { n.target.z() = -0.01; });
    refused([](core::Needle &n) { n.entry.z() = 0.05; });
    refused([](core::Needle &n) { n.entry = Vector3(0.0, 0.015, 0.015); });
    refused([](core::Needle &n) { n.target = n.entry; });
    refused([](core::Needle &n) { n.target.x() = std::nan(""); });
    refused([](core::Needle &n) { n.diameter = 0.0; });
    refused([](core::Needle &n) { n.puncture_force = 0.0; });
    refused([](core::Needle &n) { n.friction = -1.0; });
    EXPECT_THROW(scene.move(prick(std::nan("")), 1), support::InputError);
    EXPECT_EQ(scene.move(prick(0.001), 20).restarts, 0) << "another needle goes";
    EXPECT_THROW(scene.move(prick(std::nan("")), 1), support::InputError);
}

TEST(LiveNeedle, IsSaidInMessages) {
    const BoxScene box;
    Scene told(box.body, box.is_constrained), called(box.body, box.is_constrained);
    for (auto *scene : {&told, &called})
        scene->choose(settings());
    const auto tool = prick(0.004);
    const auto &n = tool.needle;
    const auto frame = called.move(tool, 200);
    const auto bytes = reply(told, std::vector<double>{6, n.entry.x(), n.entry.y(), n.entry.z(), n.target.x(),
                                                       n.target.y(), n.target.z(), n.diameter, n.spread, n.toughness,
                                                       n.friction, n.puncture_force, tool.depth, 200});
    const auto &forces = frame.needle->forces;
    ASSERT_EQ(forces.size(), core::needle_line(n).places.size());
    const std::size_t behind = 12 + 3 * forces.size();
    std::vector<double> head(behind + 7);
    ASSERT_GT(bytes.size(), head.size() * sizeof(double));
    std::memcpy(head.data(), bytes.data(), head.size() * sizeof(double));
    EXPECT_EQ(head[0], frame.needle->depth);
    EXPECT_EQ(head[1], frame.needle->tip);
    EXPECT_EQ(head[2], frame.needle->force);
    EXPECT_EQ(head[3], frame.needle->tip_force);
    EXPECT_EQ(head[4], frame.needle->is_punctured ? 1.0 : 0.0);
    EXPECT_EQ(Vector3(head[5], head[6], head[7]), frame.needle->target);
    EXPECT_EQ(head[8], frame.needle->work.hand);
    EXPECT_EQ(head[11], static_cast<double>(forces.size()));
    EXPECT_EQ(Vector3::Map(&head[12]), forces.front());
    EXPECT_EQ(Vector3::Map(&head[behind - 3]), forces.back());
    EXPECT_EQ(head[behind], frame.time);
    EXPECT_EQ(Vector3::Map(&head[behind + 1]), frame.tool);
    EXPECT_EQ(Vector3::Map(&head[behind + 4]), frame.force);
}

} // namespace
} // namespace livermark::live
