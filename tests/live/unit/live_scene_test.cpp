#include "live/scene.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <gtest/gtest.h>
#include <limits>
#include <string>

#include "live/messages.hpp"
#include "live/parameters.hpp"
#include "live/springs.hpp"
#include "msm/hyperelastic_springs.hpp"
#include "msm/nodal_springs.hpp"
#include "msm/spring_energy.hpp"
#include "msm/spring_law.hpp"
#include "msm/spring_network.hpp"
#include "msm/springs_with_volume.hpp"
#include "msm/statics/equilibrium.hpp"
#include "support/input_error.hpp"
#include "tests/test_meshes.hpp"

namespace livermark::live {
namespace {

using core::Vector3;

/// A box of 60 x 30 x 30 mm that is constrained at x = 0.
struct BoxScene {
    core::Body body = *tests::make_body(tests::box_mesh({0.06, 0.03, 0.03}, {6, 3, 3}), {1060.0, 5e3, 0.45});
    std::vector<bool> is_constrained = [this] {
        std::vector<bool> constrained;
        for (const int patch : body.mesh.boundary_patch)
            constrained.push_back(body.mesh.patch_names[patch] == "x_min");
        return constrained;
    }();
    /// In the middle of the top, 1 cm from the free end.
    int node = node_at({0.05, 0.02, 0.03});

    int node_at(const Vector3 &place) const {
        for (int i = 0; i < body.mesh.num_nodes(); ++i)
            if ((body.mesh.points[i] - place).norm() < 1e-9)
                return i;
        return -1;
    }
    /// Of no triangle that can be touched.
    int constrained_node() const { return node_at({0.0, 0.01, 0.01}); }

    Tool pull(const Vector3 &by) const {
        return {.kind = ToolKind::pull, .target = body.mesh.points[node] + by, .radius = 0.012, .node = node};
    }
    Tool poke(double depth) const {
        return {.kind = ToolKind::probe,
                .target = body.mesh.points[node] + Vector3(0.0, 0.0, 0.008 - depth),
                .radius = 0.008};
    }
};

Settings settings(const std::string &law = "patch") {
    return {.springs = law, .young_modulus = 5e3, .poisson_ratio = 0.45, .damping = {40.0, 0.0}};
}

Frame moved(Scene &scene, const Tool &tool, double seconds, double time_step) {
    auto frame = scene.move(tool, 0);
    for (int left = static_cast<int>(seconds / time_step); left > 0; left -= 1000)
        frame = scene.move(tool, std::min(left, 1000));
    return frame;
}

/// Where the model that the comparison knows by these names comes to rest under what the tool did.
std::vector<Vector3> rest_under(const Frame &frame, const BoxScene &box, const msm::ElasticBody &model) {
    auto conditions = constrained_conditions(constrained_nodes(box.body.mesh, box.is_constrained));
    for (const int node : frame.load.nodes)
        conditions.force[node] = frame.load.nodal[node];
    const auto rest = msm::find_equilibrium(model, box.body.mesh.points, conditions);
    EXPECT_EQ(rest.status, core::SolutionStatus::ok) << rest.message;
    return rest.displacement;
}

const msm::SpringLaw &law_named(std::string_view name) {
    const auto laws = msm::all_spring_laws();
    return *std::ranges::find(laws, name, &msm::SpringLaw::name);
}

double distance(const std::vector<Vector3> &a, const std::vector<Vector3> &b) {
    double square = 0.0, size = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        square += (a[i] - b[i]).squaredNorm();
        size += b[i].squaredNorm();
    }
    return std::sqrt(square / size);
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
    const auto energy = msm::all_spring_energies().front();
    const std::pair<std::string, msm::ElasticBody> models[] = {
        {"nodal_springs", msm::nodal_springs_with_volume(box.body)},
        {"nodal_" + energy.name, msm::hyperelastic_springs_with_volume(box.body, energy)}};
    for (const auto &[name, model] : models) {
        Scene scene(box.body, box.is_constrained);
        const auto chosen = scene.choose(settings(name));
        for (const auto &tool : {box.pull({0.0, 0.001, 0.002}), box.poke(0.003)}) {
            const auto frame = moved(scene, tool, 3.0, chosen.time_step);
            EXPECT_GT(frame.force.norm(), 1e-3);
            EXPECT_LT(distance(frame.displacement, rest_under(frame, box, model)), 1e-4) << name;
        }
    }
}

TEST(LiveScene, DividesStepsWhileSomethingIsPressed) {
    const BoxScene box;
    Scene scene(box.body, box.is_constrained);
    const auto chosen = scene.choose(settings());
    ASSERT_GT(chosen.time_step, 1.5 * chosen.pressed_time_step);
    scene.move({}, 10);
    EXPECT_EQ(scene.num_evaluations(), 10) << "at rest a step is one";
    // As far as a step is divided it is no longer than what the pressed body bears.
    const auto most = static_cast<long>(std::ceil(chosen.time_step / chosen.pressed_time_step));
    scene.move(box.poke(0.0), 100); // a probe that is put down below the surface would not find it
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
    Scene one(box.body, box.is_constrained), two(box.body, box.is_constrained, 2);
    for (auto *scene : {&one, &two})
        scene->choose(settings("nodal_neo_hookean"));
    EXPECT_EQ(one.move(box.poke(0.01), 200).displacement, two.move(box.poke(0.01), 200).displacement);
}

/// A tool that touches is not softer where steps are longer.
TEST(LiveScene, PressesAsFarWithLongStepsAsWithShortOnes) {
    const BoxScene box;
    const auto pressed = [&](double part) {
        Scene scene(box.body, box.is_constrained);
        auto chosen = scene.choose(settings());
        auto other = settings();
        other.time_step = part * chosen.longest_time_step;
        chosen = scene.choose(other);
        return moved(scene, box.poke(0.004), 3.0, chosen.time_step);
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

TEST(LiveScene, RefusesWhatItCannotDo) {
    const BoxScene box;
    Scene scene(box.body, box.is_constrained);
    EXPECT_THROW(scene.move({}, 1), support::InputError) << "nothing is chosen";
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    const auto refuses = [&](auto change) {
        auto changed = settings();
        change(changed);
        EXPECT_THROW(scene.choose(changed), support::InputError);
    };
    refuses([](Settings &s) { s.springs = "rubber"; });
    for (const double value : {nan, -1.0, 0.0, 1e12})
        refuses([&](Settings &s) { s.young_modulus = value; });
    for (const double value : {nan, -0.1, 0.5})
        refuses([&](Settings &s) { s.poisson_ratio = value; });
    for (const double value : {nan, -1.0, 1e9})
        refuses([&](Settings &s) { s.damping.alpha = value; });
    for (const double value : {nan, -1.0, 1.0})
        refuses([&](Settings &s) { s.damping.beta = value; });
    for (const double value : {nan, -1.0, 2.0})
        refuses([&](Settings &s) { s.time_step = value; });
    scene.choose(settings());
    auto tool = box.poke(0.001);
    EXPECT_THROW(scene.move(tool, -1), support::InputError);
    EXPECT_THROW(scene.move(tool, 10001), support::InputError);
    tool.radius = nan;
    EXPECT_THROW(scene.move(tool, 1), support::InputError);
    tool = box.poke(nan);
    EXPECT_THROW(scene.move(tool, 1), support::InputError);
    tool = box.pull(Vector3::Zero());
    for (const int node : {-1, box.constrained_node(), box.body.mesh.num_nodes(), 1 << 30}) {
        tool.node = node;
        EXPECT_THROW(scene.move(tool, 1), support::InputError) << node;
    }
    EXPECT_EQ(scene.move({}, 0).time, 0.0) << "what was refused did nothing";
}

TEST(LiveScene, RefusesBodiesThatCannotMove) {
    const BoxScene box;
    const std::size_t num_facets = box.is_constrained.size();
    EXPECT_THROW(Scene(box.body, std::vector<bool>(num_facets, false)), support::InputError);
    EXPECT_THROW(Scene(box.body, std::vector<bool>(num_facets, true)), support::InputError);
    EXPECT_THROW(Scene(box.body, std::vector<bool>(num_facets - 1, true)), support::InputError);
    const auto refuses = [&](auto damage) {
        auto body = box.body;
        damage(body);
        EXPECT_THROW(Scene(body, box.is_constrained), support::InputError);
    };
    refuses([](core::Body &b) { b.mesh.points[5].x() = std::numeric_limits<double>::infinity(); });
    refuses([](core::Body &b) { b.mesh.tetrahedra[5][2] = 1 << 20; });
    refuses([](core::Body &b) { b.mesh.boundary_triangles[5][2] = -1; });
    refuses([](core::Body &b) { std::swap(b.mesh.tetrahedra[5][0], b.mesh.tetrahedra[5][1]); });
    refuses([](core::Body &b) { b.mesh.region[5] = 1; });
    refuses([](core::Body &b) { b.mesh.points.emplace_back(0.0, 0.0, 0.0); });
    refuses([](core::Body &b) { b.materials.front().density = 0.0; });
    refuses([](core::Body &b) { b.materials.front().young_modulus = -1.0; });
}

std::vector<double> message_of(const BoxScene &box) {
    const auto &mesh = box.body.mesh;
    std::vector<double> message{static_cast<double>(mesh.num_nodes()), static_cast<double>(mesh.tetrahedra.size()), 1.0,
                                static_cast<double>(mesh.boundary_triangles.size())};
    for (const auto &x : mesh.points)
        message.insert(message.end(), x.begin(), x.end());
    for (const auto &t : mesh.tetrahedra)
        message.insert(message.end(), t.begin(), t.end());
    message.insert(message.end(), mesh.region.begin(), mesh.region.end());
    const auto &material = box.body.materials.front();
    message.insert(message.end(), {material.density, material.young_modulus, material.poisson_ratio});
    for (const auto &t : mesh.boundary_triangles)
        message.insert(message.end(), t.begin(), t.end());
    message.insert(message.end(), box.is_constrained.begin(), box.is_constrained.end());
    return message;
}

TEST(LiveMessages, SayWhatTheCallsSay) {
    const BoxScene box;
    const auto told = scene_of(message_of(box));
    Scene called(box.body, box.is_constrained);
    const auto laws = msm::all_spring_laws();
    const auto chosen = called.choose(settings(laws[0].name));
    const auto answer = reply(*told, std::vector<double>{1, 0, 1, 5e3, 0.45, 40.0, 0.0, 0.0});
    ASSERT_EQ(answer.size(), 4 * sizeof(double));
    double number = 0.0;
    std::memcpy(&number, answer.data(), sizeof number);
    EXPECT_EQ(number, chosen.time_step);

    const auto tool = box.poke(0.004);
    const auto frame = called.move(tool, 100);
    const auto bytes =
        reply(*told, std::vector<double>{2, 1, tool.target.x(), tool.target.y(), tool.target.z(), tool.radius, 0, 100});
    std::array<double, 15> head{};
    ASSERT_GT(bytes.size(), sizeof head);
    std::memcpy(head.data(), bytes.data(), sizeof head);
    EXPECT_EQ(head[0], frame.time);
    EXPECT_EQ(Vector3(head[4], head[5], head[6]), frame.force);
    EXPECT_EQ(head[7], frame.indentation);
    EXPECT_EQ(head[9], frame.largest_speed);
    EXPECT_GT(frame.largest_speed, 0.0);
    EXPECT_EQ(head[12], box.body.mesh.num_nodes());
    EXPECT_EQ(bytes.size(), sizeof head + sizeof(double) * 4 * (frame.load.nodes.size() + frame.load.triangles.size()) +
                                sizeof(float) * 3 * box.body.mesh.num_nodes());
    EXPECT_TRUE(reply(*told, std::vector<double>{3}).empty());
    for (const auto &name : spring_names())
        EXPECT_NE(joined_spring_names().find(name), std::string::npos);
}

TEST(LiveMessages, AreRefusedWhenTheyAreCutOffOrLongerOrOfAnotherKind) {
    const BoxScene box;
    const auto whole = message_of(box);
    for (std::size_t length = 0; length < whole.size(); length += 1 + length / 20)
        EXPECT_THROW(scene_of(std::span(whole).first(length)), support::InputError) << length;
    auto longer = whole;
    longer.push_back(0.0);
    EXPECT_THROW(scene_of(longer), support::InputError);
    const auto scene = scene_of(whole);
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    for (const std::vector<double> &message : {std::vector<double>{},
                                               {0},
                                               {4}, // nothing has been chosen
                                               {5},
                                               {6},
                                               {nan},
                                               {1.5},
                                               {1e300},
                                               {3, 0},
                                               {4, 0},
                                               {5, 0},
                                               {1, 0},
                                               {1, -1, 1, 5e3, 0.45, 10, 0, 0},
                                               {1, 99, 1, 5e3, 0.45, 10, 0, 0},
                                               {1, 0, 1, 5e3, 0.45, 10, 0, 0, 0},
                                               {2, 0, 0, 0, 0, 0, 0}})
        EXPECT_THROW(reply(*scene, message), support::InputError);
    for (const double count : {-1.0, 0.5, nan, 1e18}) {
        auto changed = whole;
        changed[1] = count;
        EXPECT_THROW(scene_of(changed), support::InputError) << count;
    }
}

} // namespace
} // namespace livermark::live
