// Bodies with a capsule, vessels as lines, a map of stiffness or a foundation.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "app/live/messages.hpp"
#include "app/live/parameters.hpp"
#include "app/live/scene.hpp"
#include "core/support/input_error.hpp"
#include "meshes/cutting/cut.hpp"
#include "msm/spring_law.hpp"
#include "msm/springs/springs.hpp"
#include "msm/statics/equilibrium.hpp"
#include "tests/app/live/body_message.hpp"
#include "tests/app/live/box_scene.hpp"

namespace livermark::live {
namespace {

/// Springs at the top of a box, which cuts go through, some of them along the normal alone.
core::Foundation springs_at_top(const core::TetraMesh &mesh, double stiffness) {
    core::Foundation foundation;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (mesh.patch_names[static_cast<std::size_t>(mesh.boundary_patch[f])] == "z_max") {
            double x = 0.0;
            for (const int node : mesh.boundary_triangles[f])
                x += mesh.points[static_cast<std::size_t>(node)].x() / 3.0;
            foundation.facets.push_back(f);
            foundation.stiffness.push_back(stiffness * (1.0 + x / 0.06));
            foundation.normal_only.push_back(x < 0.025 ? 1 : 0);
        }
    return foundation;
}
constexpr double soft_ligament = 1e5; // [N/m^3]

/// The box with a capsule, a vessel along it, and tissue that is stiffer to one side, on a foundation.
struct PartedBox : BoxScene {
    PartedBox() {
        body.capsule = core::Capsule{.thickness = 1e-4, .young_modulus = 1e6};
        body.vessels = core::VesselTree{.points = {{-0.01, 0.014, 0.012}, {0.03, 0.016, 0.017}, {0.055, 0.02, 0.02}},
                                        .radius = {2e-3, 2e-3, 1e-3},
                                        .segments = {{0, 1}, {1, 2}},
                                        .wall_ratio = 0.2,
                                        .wall_modulus = 1e6};
        for (const auto &nodes : body.mesh.tetrahedra)
            body.modulus_factor.push_back(0.8 + body.mesh.points[nodes[0]].y() / 0.075);
        foundation = springs_at_top(body.mesh, soft_ligament);
    }
};

/// Bodies with one of these parts each, and with all.
std::vector<BoxScene> boxes_with_parts() {
    const PartedBox all;
    std::vector<BoxScene> boxes(5);
    boxes[0].body.capsule = all.body.capsule;
    boxes[1].body.vessels = all.body.vessels;
    boxes[2].body.modulus_factor = all.body.modulus_factor;
    boxes[3].foundation = all.foundation;
    boxes[4] = all;
    return boxes;
}

/// @param foundation  of the body, or nothing
msm::ElasticBody compared_model(const core::Body &body, const std::string &springs,
                                const std::optional<core::Foundation> &foundation) {
    auto model = [&] {
        const auto laws = msm::all_spring_laws();
        const auto law = std::ranges::find(laws, springs, &msm::SpringLaw::name);
        if (law == laws.end())
            return msm::coupled_springs_with_volume(body, msm::find_coupled_springs(springs));
        return msm::springs_with_volume(body, msm::springs_beside_volume(body, *law),
                                        msm::find_volume_term("nodal_volume"))
            .body;
    }();
    if (foundation)
        model.add(msm::foundation_springs(body.mesh, *foundation));
    return msm::with_vessel_lines(std::move(model), body);
}

CutRequest half() {
    return {.tool = meshes::HalfSpaceCut{{0.04, 0.0, 0.0}, {1.0, 0.0, 0.0}}};
}

/// In the upper side, across the vessel.
CutRequest notch() {
    return {
        .tool = meshes::BladeCut{
            {Vector3(0.024, -0.01, 0.04), {0.024, 0.04, 0.04}, {0.026, 0.04, 0.014}, {0.026, -0.01, 0.014}}, 0.001}};
}

TEST(LiveParts, ComeToRestWhereTheComparedModelDoes) {
    for (const auto &box : boxes_with_parts())
        for (const std::string springs : {"patch", "nodal_neo_hookean"}) {
            // Another Young's modulus than the body's own: capsule and vessels keep theirs.
            auto wanted = settings(springs);
            wanted.young_modulus = 8e3;
            Scene scene(box.body, box.is_constrained, box.foundation);
            const auto chosen = scene.choose(wanted);
            const auto model = compared_model(with_material(box.body, 8e3, 0.45), springs, box.foundation);
            for (const auto &tool : {box.pull({0.0, 0.001, 0.002}), box.poke(0.003)}) {
                const auto frame = moved(scene, tool, 3.0, chosen.time_step);
                EXPECT_EQ(frame.restarts, 0);
                auto conditions = constrained_conditions(constrained_nodes(box.body.mesh, box.is_constrained));
                for (std::size_t k = 0; k < frame.load.nodes.size(); ++k)
                    conditions.force[frame.load.nodes[k]] = frame.load.nodal[k];
                const auto rest = msm::find_equilibrium(model, box.body.mesh.points, conditions);
                ASSERT_EQ(rest.status, core::SolutionStatus::ok) << rest.message;
                EXPECT_LT(distance(frame.displacement, rest.displacement), 1e-4) << springs;
            }
        }
}

TEST(LiveParts, StiffenTheBody) {
    const auto boxes = boxes_with_parts();
    for (const auto &springs : spring_names()) {
        const auto force = [&](const BoxScene &box) {
            Scene scene(box.body, box.is_constrained, box.foundation);
            const auto chosen = scene.choose(settings(springs));
            const auto frame = moved(scene, box.pull({0.0, 0.0, 0.002}), 2.0, chosen.time_step);
            return frame.force.norm() / frame.displacement[box.node].norm();
        };
        const double plain = force({});
        EXPECT_GT(force(boxes[0]), 1.1 * plain) << springs << " with a capsule";
        EXPECT_GT(force(boxes[1]), 1.01 * plain) << springs << " with vessels";
        EXPECT_GT(force(boxes[3]), 1.1 * plain) << springs << " on a foundation";
    }
}

TEST(LiveParts, AMapOfOnesIsNone) {
    const BoxScene box;
    auto body = box.body;
    body.modulus_factor.assign(body.mesh.tetrahedra.size(), 1.0);
    Scene even(box.body, box.is_constrained), mapped(body, box.is_constrained);
    for (auto *scene : {&even, &mapped}) {
        scene->choose(settings("nodal_neo_hookean"));
        scene->move(box.poke(0.004), 300);
    }
    EXPECT_EQ(even.move(box.poke(0.006), 100).displacement, mapped.move(box.poke(0.006), 100).displacement);
    EXPECT_EQ(even.cut(half()).volume, mapped.cut(half()).volume);
}

/// Also with springs that are chosen after the cut; and whole again it moves as before.
TEST(LiveParts, ComeToRestAfterACutWhereTheComparedModelOfTheCutBodyDoes) {
    const PartedBox box;
    const auto &body = box.body;
    const auto cut = meshes::cut(body, {.tool = notch().tool});
    std::set<int> left; // nodes
    for (const int t : cut.parents.front())
        left.insert(body.mesh.tetrahedra[t].begin(), body.mesh.tetrahedra[t].end());
    const auto tool = box.pull({0.0, 0.001, 0.002});
    for (const std::string springs : {"patch", "nodal_neo_hookean"}) {
        SCOPED_TRACE(springs);
        auto wanted = settings(springs);
        wanted.damping.alpha = 10.0; // with more a body that is as soft as this one creeps back to rest
        Scene scene(body, box.is_constrained, box.foundation), fresh(body, box.is_constrained, box.foundation);
        auto chosen = scene.choose(wanted);
        scene.cut(notch());
        ASSERT_EQ(scene.gone().size() + cut.parents.front().size(), body.mesh.tetrahedra.size());
        const auto expect_the_rest = [&] {
            const auto frame = moved(scene, tool, 4.0, chosen.time_step);
            EXPECT_EQ(frame.restarts, 0);
            auto conditions = constrained_conditions(constrained_nodes(body.mesh, box.is_constrained));
            for (std::size_t k = 0; k < frame.load.nodes.size(); ++k)
                conditions.force[frame.load.nodes[k]] = frame.load.nodal[k];
            msm::NodalConditions rest_conditions;
            std::vector<Vector3> found;
            for (const int node : left) {
                rest_conditions.displacement.push_back(conditions.displacement[node]);
                rest_conditions.constraint.push_back(conditions.constraint[node]);
                rest_conditions.force.push_back(conditions.force[node]);
                found.push_back(frame.displacement[node]);
            }
            const auto rest =
                msm::find_equilibrium(compared_model(cut.body, springs, springs_at_top(cut.body.mesh, soft_ligament)),
                                      cut.body.mesh.points, rest_conditions);
            ASSERT_EQ(rest.status, core::SolutionStatus::ok) << rest.message;
            EXPECT_LT(distance(found, rest.displacement), 1e-4);
        };
        expect_the_rest();
        chosen = scene.choose(wanted);
        expect_the_rest();
        scene.reset();
        EXPECT_TRUE(scene.gone().empty());
        fresh.choose(wanted);
        EXPECT_EQ(scene.move(tool, 50).displacement, fresh.move(tool, 50).displacement);
    }
}

/// Loads of the parts are those of where the body is, and of nothing before.
TEST(LiveParts, MoveAfterAResetAsAtFirst) {
    const PartedBox box;
    for (const std::string springs : {"patch", "nodal_neo_hookean"}) {
        Scene used(box.body, box.is_constrained, box.foundation), fresh(box.body, box.is_constrained, box.foundation);
        used.choose(settings(springs));
        fresh.choose(settings(springs));
        used.move(box.pull({0.0, 0.002, 0.004}), 500);
        used.reset();
        const auto tool = box.poke(0.004);
        EXPECT_EQ(used.move(tool, 100).displacement, fresh.move(tool, 100).displacement) << springs;
        used.keep();
        const auto first = used.move(tool, 200).displacement;
        used.move(box.pull({0.0, 0.002, 0.004}), 100);
        used.restore();
        EXPECT_EQ(used.move(tool, 200).displacement, first) << springs;
    }
}

TEST(LiveParts, AreInTheMessageThatOpensAScene) {
    PartedBox box;
    auto &mesh = box.body.mesh; // of which one side has been cut open
    const auto open = std::ranges::find(mesh.patch_names, "x_max") - mesh.patch_names.begin();
    ASSERT_LT(open, static_cast<std::ptrdiff_t>(mesh.patch_names.size()));
    mesh.patch_names[static_cast<std::size_t>(open)] = core::wound_patch;
    const auto message = body_message(box.body, box.is_constrained, box.foundation);
    const auto told = scene_of(message);
    EXPECT_EQ(told->body().capsule, box.body.capsule);
    EXPECT_EQ(told->body().vessels, box.body.vessels);
    EXPECT_EQ(told->body().modulus_factor, box.body.modulus_factor);
    Scene called(box.body, box.is_constrained, box.foundation);
    for (auto *scene : {told.get(), &called})
        scene->choose(settings("nodal_neo_hookean"));
    EXPECT_EQ(told->move(box.poke(0.004), 200).displacement, called.move(box.poke(0.004), 200).displacement);
    for (std::size_t length = message.size() - 1; length + 40 > message.size(); --length)
        EXPECT_THROW(scene_of(std::span(message).first(length)), support::InputError) << length;
}

TEST(LiveParts, AreRefusedWhereTheyAreNone) {
    const auto refuses = [](auto damage) {
        PartedBox box;
        damage(box.body);
        EXPECT_THROW(Scene(box.body, box.is_constrained, box.foundation), support::InputError);
    };
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    for (const double value : {nan, 0.0, -1.0, std::numeric_limits<double>::infinity()}) {
        refuses([&](core::Body &b) { b.modulus_factor[3] = value; });
        refuses([&](core::Body &b) { b.capsule->thickness = value; });
        refuses([&](core::Body &b) { b.capsule->young_modulus = value; });
        refuses([&](core::Body &b) { b.vessels->radius[1] = value; });
        refuses([&](core::Body &b) { b.vessels->wall_ratio = value; });
        refuses([&](core::Body &b) { b.vessels->wall_modulus = value; });
    }
    refuses([](core::Body &b) { b.modulus_factor.pop_back(); });
    refuses([](core::Body &b) { b.vessels->wall_ratio = 1.5; });
    refuses([](core::Body &b) { b.vessels->points[1].x() = nan; });
    refuses([](core::Body &b) { b.vessels->segments[0] = {1, 1}; });
    refuses([](core::Body &b) { b.vessels->segments[0] = {1, 3}; });
}

TEST(LiveFoundation, IsRefusedWhereItIsNone) {
    const auto refuses = [](auto damage) {
        PartedBox box;
        damage(*box.foundation);
        EXPECT_THROW(Scene(box.body, box.is_constrained, box.foundation), support::InputError);
    };
    using core::Foundation;
    for (const double value :
         {std::numeric_limits<double>::quiet_NaN(), 0.0, -1.0, std::numeric_limits<double>::infinity()})
        refuses([&](Foundation &f) { f.stiffness[2] = value; });
    refuses([](Foundation &f) { f.stiffness.pop_back(); });
    refuses([](Foundation &f) { f.normal_only.pop_back(); });
    refuses([](Foundation &f) { f.facets.front() = -1; });
    refuses([](Foundation &f) { f.facets.back() = 1'000'000; });
    refuses([](Foundation &f) { std::swap(f.facets[0], f.facets[1]); });
    refuses([](Foundation &f) { f.facets[1] = f.facets[0]; });
    const BoxScene box;
    const auto held = std::ranges::find(box.is_constrained, true) - box.is_constrained.begin();
    EXPECT_THROW(Scene(box.body, box.is_constrained, core::Foundation{{static_cast<int>(held)}, {1e5}, {0}}),
                 support::InputError);
}

/// The free end beyond a cut through the middle: what is on springs in all directions stays, and what is only on such
/// along the normal is loose.
TEST(LiveFoundation, HoldsWhatACutWouldLoosen) {
    const BoxScene box;
    const CutRequest slice{
        .tool = meshes::BladeCut{
            {Vector3(0.034, -0.01, 0.04), {0.034, 0.04, 0.04}, {0.034, 0.04, -0.01}, {0.034, -0.01, -0.01}}, 0.001}};
    const auto standing = springs_at_top(box.body.mesh, soft_ligament);
    auto sliding = standing;
    std::ranges::fill(sliding.normal_only, 1);
    for (const auto &foundation : {std::optional(sliding), std::optional<core::Foundation>()}) {
        Scene loose(box.body, box.is_constrained, foundation);
        loose.choose(settings());
        EXPECT_THROW(loose.cut(slice), support::InputError);
    }
    Scene scene(box.body, box.is_constrained, standing);
    const auto chosen = scene.choose(settings());
    const auto reading = scene.cut(slice);
    EXPECT_EQ(reading.num_pieces, 2);
    EXPECT_EQ(reading.num_loose, 0);
    // A poke moves the end, and the end alone, and when the finger goes the end comes back.
    const auto poked = moved(scene, box.poke(0.003), 2.0, chosen.time_step);
    EXPECT_EQ(poked.restarts, 0);
    EXPECT_GT(poked.displacement[box.node].norm(), 0.001);
    EXPECT_LT(poked.displacement[box.node_at({0.02, 0.02, 0.03})].norm(), 1e-6);
    EXPECT_LT(moved(scene, {}, 3.0, chosen.time_step).displacement[box.node].norm(), 1e-5);
}

/// Springs so stiff that the steps of the body are too long on them: steps are shorter, whole and cut, and whether they
/// are chosen before or after the cut.
TEST(LiveFoundation, IsBorneByTheSteps) {
    const BoxScene box;
    for (const std::string springs : {"patch", "nodal_neo_hookean"}) {
        SCOPED_TRACE(springs);
        Scene plain(box.body, box.is_constrained);
        Scene scene(box.body, box.is_constrained, springs_at_top(box.body.mesh, 1e9));
        const auto wanted = settings(springs);
        const double critical = plain.choose(wanted).critical_time_step;
        EXPECT_LT(scene.choose(wanted).critical_time_step, 0.3 * critical);
        const auto expect_bearable = [&] {
            for (const auto &tool : {box.pull({0.0, 0.001, 0.002}), box.poke(0.003), Tool{}}) {
                const auto frame = scene.move(tool, 2000);
                EXPECT_EQ(frame.restarts, 0);
                EXPECT_LT(frame.largest_speed, 0.5);
            }
        };
        expect_bearable();
        scene.cut(notch());
        expect_bearable();
        EXPECT_LT(scene.choose(wanted).critical_time_step, 0.3 * critical);
        expect_bearable();
    }
}

} // namespace
} // namespace livermark::live
