#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <gtest/gtest.h>
#include <limits>
#include <string>
#include <vector>

#include "app/live/messages.hpp"
#include "app/live/parameters.hpp"
#include "core/support/input_error.hpp"
#include "msm/elastic_body.hpp"
#include "msm/springs/springs.hpp"
#include "msm/statics/load_path.hpp"
#include "tests/app/live/body_message.hpp"
#include "tests/app/live/box_scene.hpp"
#include "tests/samples/touch/jaws.hpp"

namespace livermark::live {
namespace {

/// A bar of 60 x 30 x 24 mm that is its own mirror image in z = 0, held at x = 0; jaws come from above and below.
struct Bar : BoxScene {
    static constexpr double top = 0.012; // [m]
    Vector3 place;                       ///< that is grasped [m]

    Bar() {
        body = *tests::make_body(tests::with_mirror_image(tests::box_mesh({0.06, 0.03, top}, {6, 3, 2})),
                                 {1060, 5e3, 0.45});
        is_constrained.clear();
        for (const int patch : body.mesh.boundary_patch)
            is_constrained.push_back(body.mesh.patch_names[patch] == "x_min");
        node = node_at({0.04, 0.02, top});
        place = body.mesh.points[node];
    }
    Tool grasp(double depth, const Vector3 &led = Vector3::Zero()) const {
        return {.kind = ToolKind::grasp,
                .target = place + led,
                .radius = 0.008,
                .depth = depth,
                .place = place,
                .inwards = -Vector3::UnitZ()};
    }
};

/// The answer of a load case whose jaws close from where they just touch to where those of the page have come to rest.
msm::FollowedPath grasped_by_load_case(const Bar &bar, const Tool &tool, const Frame &frame,
                                       const msm::ElasticBody &model) {
    const Vector3 start = bar.place + tool.radius * Vector3::UnitZ();
    auto problem = touched_by_ball(bar.body, bar.is_constrained, tool, start, frame.tool - start);
    problem.load_case.touching->between = 0.5 * (frame.tool + frame.grasp->other);
    problem.load_case.conditions.push_back({"other jaw", core::ConditionKind::touch});
    problem.load_case.foundation = bar.foundation;
    const auto conditions = constrained_conditions(constrained_nodes(bar.body.mesh, bar.is_constrained));
    const msm::RestStiffness rest(model, bar.body.mesh.points, conditions.displacement);
    const auto path = msm::follow_path(model, problem, model.node_mass, rest);
    EXPECT_EQ(path.end.status, core::SolutionStatus::ok) << path.end.message;
    return path;
}

struct Apart {
    double force = 0.0, displacement = 0.0; ///< over those of the load case
};

Apart compared(const Bar &bar, const Tool &tool, const Frame &frame, const msm::ElasticBody &model) {
    const auto expected = grasped_by_load_case(bar, tool, frame, model);
    const auto &reaction = expected.points.back().reaction;
    const Vector3 other = frame.grasp->other_force, first = frame.force - other;
    return {((first + reaction[1]).norm() + (other + reaction[2]).norm()) / (first.norm() + other.norm()),
            distance(frame.displacement, expected.end.displacement)};
}

TEST(LiveGrasp, PressesAsTheJawsOfALoadCaseDo) {
    const Bar bar;
    auto tool = bar.grasp(0.004);
    tool.friction = 0.0;
    for (const std::string name : {"nodal_springs", "nodal_neo_hookean"}) {
        const auto model = msm::coupled_springs_with_volume(bar.body, msm::find_coupled_springs(name));
        Scene scene(bar.body, bar.is_constrained);
        const auto chosen = scene.choose(settings(name));
        const auto frame = moved(scene, tool, 3.0, chosen.time_step);
        ASSERT_TRUE(frame.grasp);
        EXPECT_NEAR(frame.grasp->depth, 0.004, 1e-12);
        const auto apart = compared(bar, tool, frame, model);
        RecordProperty(name + "_force", std::to_string(apart.force));
        RecordProperty(name + "_displacement", std::to_string(apart.displacement));
        EXPECT_LT(apart.force, 1e-3) << name;
        EXPECT_LT(apart.displacement, 1e-3) << name;
    }
}

/// As of a ball alone, where friction leaves a body depends on its way there. A bar that is held at both ends draws the
/// hand nowhere, so that jaws close straight as those of a load case do.
TEST(LiveGrasp, AHandThatClosesSlowlyMeetsTheFrictionOfALoadCase) {
    Bar bar;
    for (std::size_t f = 0; f < bar.is_constrained.size(); ++f)
        if (bar.body.mesh.patch_names[bar.body.mesh.boundary_patch[f]] == "x_max")
            bar.is_constrained[f] = true;
    bar.place = {0.03, 0.015, Bar::top};
    const std::string name = "nodal_neo_hookean";
    const auto model = msm::coupled_springs_with_volume(bar.body, msm::find_coupled_springs(name));
    Scene scene(bar.body, bar.is_constrained);
    const auto chosen = scene.choose(settings(name));
    ASSERT_GT(bar.grasp(0.0).friction, 0.0);
    constexpr int num_parts = 200;
    for (int part = 1; part < num_parts; ++part)
        moved(scene, bar.grasp(0.004 * part / num_parts), 0.02, chosen.time_step);
    const auto frame = moved(scene, bar.grasp(0.004), 3.0, chosen.time_step);
    const auto apart = compared(bar, bar.grasp(0.004), frame, model);
    RecordProperty("force", std::to_string(apart.force));
    RecordProperty("displacement", std::to_string(apart.displacement));
    EXPECT_LT((0.5 * (frame.tool + frame.grasp->other) - Vector3(0.03, 0.015, 0.0)).norm(), 5e-5) << "the hand";
    EXPECT_LT(apart.force, 0.02);
    EXPECT_LT(apart.displacement, 0.02);
}

/// A bar that is bent to the other side, so that what looked up at rest looks down where it is grasped: each jaw
/// touches the side that it was put on and no other, also when the bar turns back between them.
TEST(LiveGrasp, EachJawTouchesItsOwnSideOfALobeThatIsBentOver) {
    Bar bar;
    bar.body = *tests::make_body(tests::with_mirror_image(tests::box_mesh({0.12, 0.03, 0.006}, {12, 3, 1})),
                                 {1060, 5e3, 0.45});
    bar.is_constrained.clear();
    for (const int patch : bar.body.mesh.boundary_patch)
        bar.is_constrained.push_back(bar.body.mesh.patch_names[patch] == "x_min");
    const auto &mesh = bar.body.mesh;
    const int node = bar.node_at({0.11, 0.01, 0.006});
    Scene scene(bar.body, bar.is_constrained);
    const auto chosen = scene.choose(settings("nodal_neo_hookean"));
    Tool pull{.kind = ToolKind::pull, .target = {0.02, 0.01, 0.07}, .radius = 0.008, .node = node};
    const auto bent = moved(scene, pull, 2.0, chosen.time_step);
    const auto now = [&](const Frame &frame, int i) { return Vector3(mesh.points[i] + frame.displacement[i]); };
    const auto normal = [&](const Frame &frame, int f) {
        const auto &[a, b, c] = mesh.boundary_triangles[f];
        return Vector3((now(frame, b) - now(frame, a)).cross(now(frame, c) - now(frame, a)).normalized());
    };
    // The facet that has turned furthest, in the middle of a side.
    int most = -1;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f) {
        const auto &nodes = mesh.boundary_triangles[f];
        const bool is_inner = std::ranges::all_of(nodes, [&](int i) {
            return mesh.points[i].z() == 0.006 && mesh.points[i].y() > 0.009 && mesh.points[i].y() < 0.021;
        });
        if (is_inner && (most < 0 || normal(bent, f).z() < normal(bent, most).z()))
            most = f;
    }
    EXPECT_LT(normal(bent, most).z(), -0.3) << "it is not bent over";
    Vector3 place = Vector3::Zero();
    for (const int i : mesh.boundary_triangles[most])
        place += now(bent, i) / 3.0;
    const Tool tool{.kind = ToolKind::grasp,
                    .target = place,
                    .radius = 0.005,
                    .depth = 0.002,
                    .place = place,
                    .inwards = -normal(bent, most)};
    bool have_touched = false;
    for (int picture = 0; picture < 150; ++picture) {
        const auto frame = scene.move(tool, 20);
        ASSERT_EQ(frame.restarts, 0);
        std::array<Vector3, 2> on_side{Vector3::Zero(), Vector3::Zero()}; // which looked up at rest, and the others
        for (std::size_t l = 0; l < frame.load.triangles.size(); ++l) {
            const int f = frame.surface->facet[frame.load.triangles[l]];
            const auto &force = frame.load.facet[l];
            on_side[core::area_vector(mesh, f).z() > 1e-9 ? 0 : 1] += force;
            EXPECT_LT(force.dot(normal(frame, f)), 1e-3 * force.norm()) << "a jaw draws";
        }
        const Vector3 other = frame.grasp->other_force, first = frame.force - other;
        EXPECT_LT((on_side[0] + first).norm() + (on_side[1] + other).norm(), 1e-9);
        have_touched = have_touched || (first.norm() > 0.01 && other.norm() > 0.01);
    }
    EXPECT_TRUE(have_touched);
}

/// The springs below a facet bear what a jaw presses there.
TEST(LiveGrasp, PressesOnAFoundationAsTheJawsOfALoadCaseDo) {
    Bar bar;
    bar.foundation = core::Foundation{};
    for (int f = 0; f < bar.body.mesh.num_boundary_triangles(); ++f)
        if (bar.body.mesh.patch_names[bar.body.mesh.boundary_patch[f]] == "z_min") {
            bar.foundation->facets.push_back(f);
            bar.foundation->stiffness.push_back(2e4);
            bar.foundation->normal_only.push_back(0);
        }
    auto tool = bar.grasp(0.004);
    tool.friction = 0.0;
    Scene scene(bar.body, bar.is_constrained, bar.foundation);
    const auto chosen = scene.choose(settings("nodal_neo_hookean"));
    const auto frame = moved(scene, tool, 3.0, chosen.time_step);
    const auto model = msm::coupled_springs_with_volume(bar.body, msm::find_coupled_springs("nodal_neo_hookean"));
    const auto apart = compared(bar, tool, frame, model);
    EXPECT_LT(apart.force, 1e-3);
    EXPECT_LT(apart.displacement, 1e-3);
}

/// Each jaw mirrors the other one, and the readings add up.
TEST(LiveGrasp, JawsPressWithEqualForcesOnABodyThatIsItsOwnMirrorImage) {
    const Bar bar;
    Scene scene(bar.body, bar.is_constrained);
    const auto chosen = scene.choose(settings("nodal_neo_hookean"));
    const auto frame = moved(scene, bar.grasp(0.003), 3.0, chosen.time_step);
    ASSERT_TRUE(frame.grasp);
    const Vector3 other = frame.grasp->other_force, first = frame.force - other;
    EXPECT_GT(first.z(), 0.01) << "the body pushes the upper jaw up";
    EXPECT_LT((tests::JawsAndHalf::mirrored(first) - other).norm(), 1e-3 * first.norm());
    EXPECT_LT(std::abs(frame.force.z()), 1e-3 * first.norm());
    EXPECT_NEAR(frame.grasp->closing, first.z(), 1e-3 * first.norm());
    EXPECT_NEAR(frame.tool.z(), Bar::top + 0.008 - 0.003, 1e-4);
    EXPECT_NEAR(frame.grasp->other.z(), -frame.tool.z(), 1e-4);
    EXPECT_NEAR(frame.load.pressed, first.norm() + other.norm(), 1e-12);
    EXPECT_GT(frame.indentation, 0.001);
    EXPECT_LT(frame.indentation, 0.003);
    Vector3 on_nodes = Vector3::Zero(), on_triangles = Vector3::Zero();
    for (const auto &force : frame.load.nodal)
        on_nodes += force;
    for (const auto &force : frame.load.facet)
        on_triangles += force;
    EXPECT_LT((on_nodes + frame.force).norm() + (on_triangles + frame.force).norm(), 1e-9 * first.norm());
}

/// Displacement to the side of the node that is grasped, and of the hand, when jaws have been led there [m].
std::array<double, 2> led_aside(double friction) {
    const Bar bar;
    Scene scene(bar.body, bar.is_constrained);
    const auto chosen = scene.choose(settings("nodal_neo_hookean"));
    auto tool = bar.grasp(0.004);
    tool.friction = friction;
    moved(scene, tool, 0.5, chosen.time_step);
    constexpr int num_parts = 50;
    Frame frame;
    for (int part = 1; part <= num_parts; ++part) {
        tool.target = tool.place + 0.006 * part / num_parts * Vector3::UnitY();
        frame = moved(scene, tool, 0.02, chosen.time_step);
    }
    frame = moved(scene, tool, 1.0, chosen.time_step);
    EXPECT_EQ(frame.restarts, 0);
    return {frame.displacement[bar.node].y(), frame.tool.y() - tool.place.y()};
}

TEST(LiveGrasp, DrawsWhatItHoldsAlongByFriction) {
    const auto [held, hand] = led_aside(0.8);
    EXPECT_GT(held, 0.7 * hand);
    EXPECT_GT(hand, 0.002);
    const auto [slipped, further] = led_aside(0.0);
    EXPECT_LT(slipped, 0.5 * held);
    EXPECT_GT(further, hand) << "nothing holds the hand back";
}

/// @return the sentence with which a tool is refused, or none
std::string refusal(Scene &scene, const Tool &tool) {
    try {
        scene.move(tool, 1);
    } catch (const support::InputError &error) {
        return error.what();
    }
    return {};
}

TEST(LiveGrasp, IsRefusedWhereJawsDoNotGo) {
    const Bar bar;
    Scene scene(bar.body, bar.is_constrained);
    scene.choose(settings());
    const auto before = scene.move(bar.poke(0.002), 50);
    const auto says = [&](const Tool &tool, const std::string &words) {
        const auto sentence = refusal(scene, tool);
        EXPECT_NE(sentence.find(words), std::string::npos) << sentence;
    };
    auto tool = bar.grasp(0.002);
    tool.place += Vector3(0.0, 0.0, 0.02);
    says(tool, "beside the body");
    tool = bar.grasp(0.002);
    tool.inwards = Vector3::Zero();
    says(tool, "no direction");
    tool = bar.grasp(0.002);
    tool.depth = std::numeric_limits<double>::quiet_NaN();
    says(tool, "depth");
    // With what it had before it goes on.
    EXPECT_EQ(scene.move(bar.poke(0.002), 0).displacement, before.displacement);
    EXPECT_TRUE(refusal(scene, bar.grasp(0.002)).empty());

    const auto says_of_length = [&](double length, const std::string &words) {
        const BoxScene box{
            .body = *tests::make_body(tests::box_mesh({length, 0.03, 0.03}, {6, 3, 3}), {1060.0, 5e3, 0.45})};
        Scene box_scene(box.body, box.is_constrained);
        box_scene.choose(settings());
        tool = bar.grasp(0.002);
        tool.place = {length, 0.015, 0.015};
        tool.inwards = -Vector3::UnitX();
        const auto sentence = refusal(box_scene, tool);
        EXPECT_NE(sentence.find(words), std::string::npos) << sentence;
    };
    says_of_length(0.05, "constrained");
    says_of_length(0.12, "120 mm thick there, and jaws open to 60 mm; take an edge");
}

/// Jaws close no further than what is between them bears, however deep they are asked to.
TEST(LiveGrasp, LeavesRoomBetweenItsJaws) {
    const Bar bar;
    Scene scene(bar.body, bar.is_constrained);
    const auto chosen = scene.choose(settings("nodal_neo_hookean"));
    const auto frame = moved(scene, bar.grasp(0.05), 1.0, chosen.time_step);
    EXPECT_GT(frame.grasp->depth, 0.004);
    EXPECT_LE(frame.grasp->depth, 0.75 * Bar::top + 1e-12);
    EXPECT_LT(frame.grasp->closing, 2.0 * strongest_coupling);
    EXPECT_EQ(frame.restarts, 0);
    const auto open = moved(scene, bar.grasp(-0.01), 1.0, chosen.time_step);
    EXPECT_EQ(open.force.norm(), 0.0);
    EXPECT_EQ(open.grasp->closing, 0.0);
}

/// The state that was kept is there again to the last bit, also after the material or a cut has changed in between.
TEST(LiveGrasp, GoesOnFromWhatWasKept) {
    const Bar bar;
    Scene scene(bar.body, bar.is_constrained), other(bar.body, bar.is_constrained);
    for (auto *one : {&scene, &other})
        one->choose(settings("nodal_neo_hookean"));
    const auto tool = bar.grasp(0.003);
    for (auto *one : {&scene, &other}) {
        one->move(tool, 300);
        one->keep();
    }
    scene.move(bar.grasp(0.001, {0.0, 0.004, 0.0}), 100);
    scene.move(bar.poke(0.003), 100);
    scene.restore();
    EXPECT_EQ(scene.move(tool, 200).displacement, other.move(tool, 200).displacement);
    scene.move(tool, 100);
    other.move(tool, 100);
    scene.cut({.tool = meshes::HalfSpaceCut{{0.05, 0.0, 0.0}, {1.0, 0.0, 0.0}}, .takes_loose = true});
    const auto cut = scene.move(tool, 200);
    EXPECT_GT(cut.grasp->closing, 0.0) << "what is left can be grasped";
    scene.restore();
    other.keep();
    EXPECT_EQ(scene.move(tool, 200).displacement, other.move(tool, 200).displacement);
    scene.reset();
    EXPECT_FALSE(scene.move({}, 10).grasp);
}

TEST(LiveGrasp, MessagesSayWhatTheCallsSay) {
    const Bar bar;
    const auto told = scene_of(body_message(bar.body, bar.is_constrained));
    Scene called(bar.body, bar.is_constrained);
    const auto &names = spring_names();
    const auto law = std::ranges::find(names, "nodal_neo_hookean") - names.begin();
    called.choose(settings("nodal_neo_hookean"));
    reply(*told, std::vector<double>{1, static_cast<double>(law), 1, 5e3, 0.45, 40.0, 0.0, 0.0});
    const auto tool = bar.grasp(0.003, {0.0, 0.001, 0.0});
    const auto frame = called.move(tool, 300);
    std::vector<double> message{8};
    for (const auto &vector : {tool.place, tool.inwards, tool.target})
        message.insert(message.end(), vector.begin(), vector.end());
    message.insert(message.end(), {tool.radius, tool.depth, 300});
    for (std::size_t length = 1; length < message.size(); ++length)
        EXPECT_THROW(reply(*told, std::span(message).first(length)), support::InputError) << length;
    auto wrong = message;
    wrong.push_back(0.0);
    EXPECT_THROW(reply(*told, wrong), support::InputError);
    for (const std::size_t number : {1U, 4U, 7U, 10U, 11U, 12U}) {
        wrong = message;
        wrong[number] = std::numeric_limits<double>::quiet_NaN();
        EXPECT_THROW(reply(*told, wrong), support::InputError) << number;
    }
    EXPECT_THROW(reply(*told, std::vector<double>{2, 4, 0, 0, 0, 0.01, 0, 1}), support::InputError);
    const auto bytes = reply(*told, message);
    std::array<double, 15> head{};
    ASSERT_GT(bytes.size(), sizeof head);
    std::memcpy(head.data(), bytes.data(), sizeof head);
    EXPECT_EQ(head[0], frame.grasp->depth);
    EXPECT_EQ(head[1], frame.grasp->closing);
    EXPECT_EQ(Vector3(head[2], head[3], head[4]), frame.grasp->other);
    EXPECT_EQ(Vector3(head[5], head[6], head[7]), frame.grasp->other_force);
    EXPECT_EQ(head[8], frame.time);
    EXPECT_EQ(Vector3(head[9], head[10], head[11]), frame.tool);
    EXPECT_EQ(Vector3(head[12], head[13], head[14]), frame.force);
}

} // namespace
} // namespace livermark::live
