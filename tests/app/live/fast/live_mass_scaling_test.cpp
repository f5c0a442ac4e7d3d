#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "app/live/parameters.hpp"
#include "app/live/scene.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/elastic_body.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark::live {
namespace {

using core::Vector3;

constexpr double hardness = 20.0;

/// A box of 60 x 30 x 30 mm that is constrained at x = 0, and whose middle is hard up to its surface.
struct BoxWithLump {
    core::Body body = *tests::make_body(tests::box_mesh({0.06, 0.03, 0.03}, {6, 3, 3}), {1060.0, 5e3, 0.45});
    std::vector<bool> is_constrained;
    int node = -1; ///< of the lump, in the middle of the top

    explicit BoxWithLump(double how_hard = hardness) {
        auto &mesh = body.mesh;
        mesh.region_names = {"soft", "hard"};
        for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
            double x = 0.0;
            for (const int i : mesh.tetrahedra[t])
                x += mesh.points[i].x() / 4.0;
            mesh.region[t] = x > 0.02 && x < 0.04 ? 1 : 0;
        }
        body.materials = {{1060.0, 5e3, 0.45}, {1060.0, how_hard * 5e3, 0.45}};
        for (const int patch : mesh.boundary_patch)
            is_constrained.push_back(mesh.patch_names[patch] == "x_min");
        for (int i = 0; i < mesh.num_nodes(); ++i)
            if ((mesh.points[i] - Vector3(0.03, 0.02, 0.03)).norm() < 1e-9)
                node = i;
    }

    /// Without friction, with which there are many equilibria.
    Tool poke(const Vector3 &place, double depth) const {
        return {.kind = ToolKind::probe,
                .target = place + Vector3(0.0, 0.0, 0.008 - depth),
                .radius = 0.008,
                .friction = 0.0};
    }
    Tool poke_at_lump(double depth) const { return poke(body.mesh.points[node], depth); }
    Tool pull_at_lump(const Vector3 &by) const {
        return {.kind = ToolKind::pull, .target = body.mesh.points[node] + by, .radius = 0.012, .node = node};
    }
};

Settings lump_settings(const std::string &springs, double mass_damping = 40.0) {
    return {.springs = springs, .young_modulus = 5e3, .poisson_ratio = 0.45, .damping = {mass_damping, 0.0}};
}

/// With a step so short that masses are as they are.
Settings unscaled(const std::string &springs, double time_step) {
    auto result = lump_settings(springs);
    result.time_step = time_step;
    return result;
}

Stepping lump_stepping(const BoxWithLump &box, const Settings &settings) {
    SpringsOfLaws kept;
    const auto body = with_material(box.body, settings.young_modulus, settings.poisson_ratio);
    return chosen_steps(body, mass_springs(body, settings, kept),
                        constrained_conditions(constrained_nodes(body.mesh, box.is_constrained)), settings);
}

const std::vector<std::string> some_springs{"patch", "lloyd", "nodal_springs", "nodal_neo_hookean"};

Frame frame_after(Scene &scene, const Tool &tool, double seconds, double time_step) {
    auto frame = scene.move(tool, 0);
    for (int left = static_cast<int>(seconds / time_step); left > 0; left -= 1000)
        frame = scene.move(tool, std::min(left, 1000));
    return frame;
}

double relative_distance(const std::vector<Vector3> &a, const std::vector<Vector3> &b) {
    double square = 0.0, size = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        square += (a[i] - b[i]).squaredNorm();
        size += b[i].squaredNorm();
    }
    return std::sqrt(square / size);
}

TEST(LiveMassScaling, MakesTheStepsOfAHardLumpNearlyThoseOfSoftTissue) {
    const BoxWithLump hard, soft(1.0);
    for (const auto &springs : some_springs) {
        const auto scaled = lump_stepping(hard, lump_settings(springs)),
                   plain = lump_stepping(soft, lump_settings(springs));
        EXPECT_EQ(scaled.scaling.parts.size(), 1U) << springs;
        EXPECT_TRUE(plain.scaling.parts.empty()) << springs;
        EXPECT_GT(scaled.chosen.time_step, 0.9 * plain.chosen.time_step) << springs;
        // As often as a second has steps: without a tool none is divided.
        Scene scene(hard.body, hard.is_constrained);
        scene.choose(lump_settings(springs));
        const int steps = static_cast<int>(std::ceil(1.0 / scaled.chosen.time_step));
        scene.move({}, steps);
        EXPECT_EQ(scene.num_evaluations(), steps) << springs;
    }
}

TEST(LiveMassScaling, LeavesMassesAsTheyAreWhereTheStepAsksForNothingElse) {
    const BoxWithLump box;
    for (const auto &springs : some_springs) {
        const auto scaled = lump_stepping(box, lump_settings(springs));
        EXPECT_TRUE(lump_stepping(box, unscaled(springs, 0.1 * scaled.chosen.time_step)).scaling.parts.empty())
            << springs;
        EXPECT_FALSE(lump_stepping(box, unscaled(springs, 0.99 * scaled.chosen.time_step)).scaling.parts.empty())
            << springs;
    }
}

/// Steps that a page names are those of the masses that move.
TEST(LiveMassScaling, NamesTheCriticalStepOfTheMassesThatMove) {
    const BoxWithLump box;
    for (const auto &springs : some_springs) {
        const auto scaled = lump_stepping(box, lump_settings(springs)).chosen,
                   short_steps = lump_stepping(box, unscaled(springs, 0.5 * scaled.unscaled_time_step)).chosen;
        EXPECT_LT(scaled.unscaled_time_step, 0.8 * scaled.longest_time_step) << springs;
        EXPECT_EQ(short_steps.unscaled_time_step, scaled.unscaled_time_step) << springs;
        EXPECT_EQ(short_steps.longest_time_step, scaled.longest_time_step) << springs;
        EXPECT_LT(short_steps.critical_time_step, 0.8 * scaled.critical_time_step) << springs;
        EXPECT_LT(short_steps.unscaled_time_step, short_steps.critical_time_step) << springs;
        const double decided = scaled.limit == StepLimit::rest      ? scaled.critical_time_step
                               : scaled.limit == StepLimit::pressed ? scaled.pressed_time_step
                                                                    : 0.004;
        const double factor = scaled.longest_time_step / decided;
        EXPECT_TRUE(std::abs(factor - 0.8) < 1e-12 || std::abs(factor - std::round(2.0 * factor) / 2.0) < 1e-12)
            << springs << ": " << factor;
    }
}

/// The force that a hand feels is that of how deep the tool is in the surface, and at rest no mass is in it.
TEST(LiveMassScaling, ComesToTheSameRestAndForceUnderATool) {
    const BoxWithLump box;
    for (const auto &springs : some_springs) {
        const double scaled_step = lump_stepping(box, lump_settings(springs)).chosen.time_step;
        for (const auto &tool : {box.poke_at_lump(0.003), box.pull_at_lump({0.0, 0.002, 0.003})}) {
            Scene scaled(box.body, box.is_constrained), plain(box.body, box.is_constrained);
            const double step = scaled.choose(lump_settings(springs)).time_step;
            const double short_step = plain.choose(unscaled(springs, 0.1 * scaled_step)).time_step;
            const auto found = frame_after(scaled, tool, 3.0, step),
                       expected = frame_after(plain, tool, 3.0, short_step);
            EXPECT_GT(expected.force.norm(), 1e-2);
            EXPECT_LT((found.force - expected.force).norm(), 1e-4 * expected.force.norm()) << springs;
            EXPECT_LT(relative_distance(found.displacement, expected.displacement), 1e-4) << springs;
        }
    }
}

/// A body that was bent by a tool at the lump swings freely when it lets go, without damping.
TEST(LiveMassScaling, GainsNoEnergyAfterARelease) {
    const BoxWithLump box;
    for (const auto &springs : some_springs) {
        SpringsOfLaws kept;
        const auto model = mass_springs(with_material(box.body, 5e3, 0.45), lump_settings(springs), kept).body;
        const auto energy = [&](const std::vector<Vector3> &displacement) {
            auto positions = box.body.mesh.points;
            for (std::size_t i = 0; i < positions.size(); ++i)
                positions[i] += displacement[i];
            return msm::elastic_energy(model, positions);
        };
        const double at_rest = energy(std::vector<Vector3>(box.body.mesh.points.size(), Vector3::Zero()));
        Scene scene(box.body, box.is_constrained);
        const double step = scene.choose(lump_settings(springs)).time_step;
        const auto bent = frame_after(scene, box.pull_at_lump({0.0, 0.004, 0.006}), 3.0, step);
        scene.choose(lump_settings(springs, 0.0));
        const double stored = energy(bent.displacement) - at_rest;
        double most = 0.0, last = 0.0;
        for (int i = 0; i < 2000; ++i) {
            const double now = energy(scene.move({}, 3).displacement) - at_rest;
            most = std::max(most, now);
            last = i >= 1500 ? std::max(last, now) : 0.0;
        }
        EXPECT_LT(most, 1.02 * stored) << springs;
        EXPECT_GT(last, 0.3 * stored) << springs << ": it swings still";
    }
}

/// A hand that tears and stamps at the lump as fast as it can.
TEST(LiveMassScaling, BearsRoughHandlingOfTheLump) {
    const BoxWithLump box;
    for (const auto &springs : some_springs) {
        Scene scene(box.body, box.is_constrained);
        const double step = scene.choose(lump_settings(springs, 5.0)).time_step;
        for (int i = 0; i < 20; ++i) {
            const double side = i % 4 ? 0.05 : -0.05;
            const auto tool = i % 2 ? box.poke_at_lump(0.03) : box.pull_at_lump({0.05, 0.0, side});
            frame_after(scene, tool, 0.1, step);
            frame_after(scene, {}, 0.05, step);
        }
        const auto frame = frame_after(scene, {}, 3.0, step);
        EXPECT_EQ(frame.restarts, 0) << springs;
        EXPECT_GT(frame.smallest_volume, 0.95) << springs;
    }
}

} // namespace
} // namespace livermark::live
