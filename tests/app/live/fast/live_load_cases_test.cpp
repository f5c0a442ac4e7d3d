#include <array>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "app/live/scene.hpp"
#include "core/support/toml_input.hpp"
#include "core/tool/needle/needle.hpp"
#include "load_cases/readers/load_case_reader.hpp"
#include "meshes/cutting/cut.hpp"
#include "meshes/cutting/cut_reader.hpp"
#include "msm/statics/load_path.hpp"
#include "tests/app/live/box_scene.hpp"
#include "tests/samples/touch/jaws.hpp"

/// Each tool of the page, written as the load case that docs/explanation/live_page.md has for it:
/// read by the reader of load cases and solved by the model that `livermark run` has, it has the force and the
/// displacements of the page.
namespace livermark::live {
namespace {

/// A bar of 60 x 30 x 24 mm that is held at both ends, so that friction draws a hand nowhere; jaws have room around it.
struct HeldBar : BoxScene {
    static constexpr double top = 0.012; // [m]
    Vector3 place{0.03, 0.015, top};     ///< in the middle of the upper side [m]

    HeldBar() {
        body = *tests::make_body(tests::with_mirror_image(tests::box_mesh({0.06, 0.03, top}, {6, 3, 2})),
                                 {1060.0, 5e3, 0.45});
        is_constrained.clear();
        for (const int patch : body.mesh.boundary_patch) {
            const auto &name = body.mesh.patch_names[patch];
            is_constrained.push_back(name == "x_min" || name == "x_max");
        }
        node = node_at({0.03, 0.02, top});
    }
};

std::string written(const Vector3 &vector) {
    return fmt::format("[{:.17g}, {:.17g}, {:.17g}]", vector.x(), vector.y(), vector.z());
}

const std::string springs = "nodal_neo_hookean", held = R"(
title = "What the live page did"
target_peak_displacement = 0.01
[[condition]]
patch = "x_min"
displacement = [0.0, 0.0, 0.0]
[[condition]]
patch = "x_max"
displacement = [0.0, 0.0, 0.0]
)",
                  large = "regime = \"large\"\npath = [0.25, 0.5, 0.75, 1.0]\n";

/// The table of a ball or plate that begins on a place, as deep as the page has it.
std::string touch(const HeldBar &bar, const std::string &shape, double depth) {
    return fmt::format("[touch]\ndisc = {{ point = {}, radius = 0.012 }}\n{}\ndepth = {:.17g}\nfriction = 0.3\n",
                       written(bar.place), shape, depth);
}

msm::ElasticBody compared(const core::Body &body) {
    return msm::coupled_springs_with_volume(body, msm::find_coupled_springs(springs));
}

/// Answer of `livermark run` to the load case.
/// @param body  without what a [[cut]] takes
msm::FollowedPath run(const core::Body &body, const std::string &load_case) {
    const core::Problem problem{std::make_shared<core::Body>(body),
                                load_cases::parse_load_case(large + held + load_case, "live.toml", body.mesh)};
    const auto model = compared(body);
    const auto conditions = msm::nodal_conditions(problem, model.node_mass);
    const msm::RestStiffness rest(model, body.mesh.points, conditions.displacement);
    const auto path = msm::follow_path(model, problem, model.node_mass, rest);
    EXPECT_EQ(path.end.status, core::SolutionStatus::ok) << path.end.message;
    return path;
}

/// A scene whose tool is led slowly to where it stays: with friction a body comes to rest where its way has left it.
struct Hand {
    const HeldBar &bar;
    Scene scene{bar.body, bar.is_constrained};
    double time_step = scene.choose(settings(springs)).time_step;

    explicit Hand(const HeldBar &of) : bar(of) {}
    /// @param tool_at  the tool at a depth [m]
    template <class ToolAt> Frame lead(const ToolAt &tool_at, double depth) {
        constexpr int num_parts = 100;
        for (int part = 1; part < num_parts; ++part)
            moved(scene, tool_at(depth * part / num_parts), 0.02, time_step);
        const auto frame = moved(scene, tool_at(depth), 2.0, time_step);
        EXPECT_EQ(frame.restarts, 0);
        return frame;
    }
};

Tool ball_at(const HeldBar &bar, double depth) {
    return {.kind = ToolKind::probe, .target = bar.place + (0.012 - depth) * Vector3::UnitZ(), .radius = 0.012};
}

void expect_same(double force, double expected_force, double displacement_apart, double margin) {
    testing::Test::RecordProperty("force", std::to_string(force / expected_force - 1.0));
    testing::Test::RecordProperty("displacement", std::to_string(displacement_apart));
    EXPECT_GT(expected_force, 0.05);
    EXPECT_NEAR(force / expected_force, 1.0, margin);
    EXPECT_LT(displacement_apart, margin);
}

/// Margin of a ball and of jaws, whose friction goes another way through the first moments.
constexpr double margin_of_friction = 0.02;

TEST(LiveLoadCases, RepeatAPoke) {
    const HeldBar bar;
    Hand hand(bar);
    const auto frame = hand.lead([&](double depth) { return ball_at(bar, depth); }, 0.004);
    const double depth = bar.place.z() + 0.012 - frame.tool.z();
    const auto path = run(bar.body, touch(bar, "radius = 0.012", depth));
    expect_same(frame.force.norm(), path.points.back().reaction.back().norm(),
                distance(frame.displacement, path.end.displacement), margin_of_friction);
}

TEST(LiveLoadCases, RepeatAPlate) {
    const HeldBar bar;
    Hand hand(bar);
    const double size = 0.007, edge = edge_of_plate * size;
    const auto frame = hand.lead(
        [&](double depth) {
            return Tool{.kind = ToolKind::probe,
                        .target = bar.place + (edge - depth) * Vector3::UnitZ(),
                        .radius = size,
                        .inwards = -Vector3::UnitZ(),
                        .face = core::ToolFace::square};
        },
        0.003);
    const double depth = bar.place.z() + edge - frame.tool.z();
    const auto path = run(bar.body, touch(bar, fmt::format("plate = \"square\"\nsize = {}", size), depth));
    expect_same(frame.force.norm(), path.points.back().reaction.back().norm(),
                distance(frame.displacement, path.end.displacement), margin_of_friction);
}

TEST(LiveLoadCases, RepeatAGrasp) {
    const HeldBar bar;
    Hand hand(bar);
    const auto frame = hand.lead(
        [&](double depth) {
            return Tool{.kind = ToolKind::grasp,
                        .target = bar.place,
                        .radius = 0.008,
                        .depth = depth,
                        .place = bar.place,
                        .inwards = -Vector3::UnitZ()};
        },
        0.004);
    const auto path = run(bar.body, touch(bar, "radius = 0.008\njaws = true", frame.grasp->depth));
    const auto &reaction = path.points.back().reaction;
    expect_same((frame.force - frame.grasp->other_force).norm(), reaction[reaction.size() - 2].norm(),
                distance(frame.displacement, path.end.displacement), margin_of_friction);
    EXPECT_NEAR(frame.grasp->other_force.norm() / reaction.back().norm(), 1.0, margin_of_friction);
}

/// The page says the force and its disc; what the disc moves by is the answer.
TEST(LiveLoadCases, RepeatAPull) {
    const HeldBar bar;
    Hand hand(bar);
    const Vector3 way = Vector3(0.0, 0.3, 1.0).normalized();
    const auto frame = hand.lead(
        [&](double depth) {
            return Tool{.kind = ToolKind::pull,
                        .target = bar.body.mesh.points[bar.node] + depth * way,
                        .radius = 0.012,
                        .node = bar.node};
        },
        0.004);
    const auto path =
        run(bar.body,
            fmt::format("[[condition]]\ndisc = {{ point = {}, radius = 0.012, profile = \"round\" }}\nforce = {}\n",
                        written(frame.load.shape.middle), written(-frame.force)));
    const auto &displacement = path.end.displacement;
    EXPECT_NEAR(indentation(frame.load, displacement) / frame.indentation, 1.0, 0.01);
    EXPECT_LT(distance(frame.displacement, displacement), 0.01);
    EXPECT_GT(frame.force.norm(), 0.05);
}

/// A ball beside a notch that a blade has left, at rest again.
TEST(LiveLoadCases, RepeatABallOnWhatABladeHasLeft) {
    const HeldBar bar;
    Hand hand(bar);
    const meshes::BladeCut blade{
        {Vector3(0.044, -0.01, 0.02), {0.044, 0.04, 0.02}, {0.046, 0.04, 0.002}, {0.046, -0.01, 0.002}}, 0.001};
    const auto reading = hand.scene.cut({.tool = blade});
    EXPECT_GT(reading.volume, 0.0);
    const auto frame = hand.lead([&](double depth) { return ball_at(bar, depth); }, 0.004);
    const double depth = bar.place.z() + 0.012 - frame.tool.z();
    const auto cut_lines =
        fmt::format("[[cut]]\nblade = {{ corners = [{}, {}, {}, {}], thickness = 0.001 }}\n", written(blade.corners[0]),
                    written(blade.corners[1]), written(blade.corners[2]), written(blade.corners[3]));
    const auto cuts = meshes::read_cuts(support::parse_toml(cut_lines, "live.toml"));
    ASSERT_EQ(cuts.size(), 1U);
    const auto rest = meshes::cut(bar.body, cuts.front());
    EXPECT_NEAR(rest.removed_volume, reading.volume, 1e-12 * reading.volume);
    const auto path = run(rest.body, cut_lines + touch(bar, "radius = 0.012", depth));
    std::set<int> left; // nodes, whose numbers are those of the rest in their order
    for (const int t : rest.parents.front())
        left.insert(bar.body.mesh.tetrahedra[t].begin(), bar.body.mesh.tetrahedra[t].end());
    std::vector<Vector3> found;
    for (const int node : left)
        found.push_back(frame.displacement[node]);
    expect_same(frame.force.norm(), path.points.back().reaction.back().norm(), distance(found, path.end.displacement),
                margin_of_friction);
}

/// `livermark needle` brings the same springs to rest under forces at the places of the needle, and its hand takes the
/// same force of the tip and of friction.
TEST(LiveLoadCases, RepeatANeedle) {
    const HeldBar bar;
    Hand hand(bar);
    const core::Needle needle{.name = "needle",
                              .entry = {0.031, 0.013, HeldBar::top},
                              .target = {0.035, 0.016, -0.006},
                              .diameter = 1e-3,
                              .spread = 6e-3,
                              .toughness = 30.0,
                              .friction = 3.0,
                              .puncture_force = 0.05};
    hand.lead([&](double depth) { return Tool{.kind = ToolKind::needle, .needle = needle, .depth = depth}; },
              needle.depth());
    const auto frame = hand.scene.move({.kind = ToolKind::needle, .needle = needle, .depth = needle.depth()}, 1);
    ASSERT_TRUE(frame.needle);
    const auto file = std::filesystem::path(testing::TempDir()) / "livermark_live_needle.toml";
    std::ofstream(file) << held + fmt::format(R"([[needle]]
name = "needle"
entry = {}
target = {}
diameter = 0.001
spread = 0.006
toughness = 30.0
friction = 3.0
puncture_force = 0.05
)",
                                              written(needle.entry), written(needle.target));
    const auto load_case = load_cases::read_load_case(file, bar.body.mesh);
    const auto read = load_cases::read_needles(file, bar.body, load_case);
    std::filesystem::remove(file);
    ASSERT_EQ(read.size(), 1U);
    const auto line = core::needle_line(read.front());
    ASSERT_EQ(line.places.size(), frame.needle->forces.size());
    Eigen::VectorXd force(3 * std::ssize(line.places));
    for (std::size_t k = 0; k < line.places.size(); ++k)
        force.segment<3>(3 * static_cast<Eigen::Index>(k)) = frame.needle->forces[k];
    const auto pushed =
        msm::pushed_springs(compared(bar.body), {std::make_shared<core::Body>(bar.body), load_case}, line.places);
    const auto rest = pushed->push(force);
    ASSERT_TRUE(rest);
    const Vector3 target = rest->displacement.segment<3>(3 * line.target);
    EXPECT_GT(target.norm(), 1e-4);
    EXPECT_LT((target - frame.needle->target).norm(), 0.02 * target.norm());
    EXPECT_NEAR(frame.needle->force, read.front().tip_force() + read.front().friction * frame.needle->tip,
                0.02 * frame.needle->force);
}

} // namespace
} // namespace livermark::live
