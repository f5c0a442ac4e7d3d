#include "app/live/scene.hpp"

#include <gtest/gtest.h>
#include <limits>
#include <utility>
#include <vector>

#include "core/support/input_error.hpp"
#include "tests/app/live/box_scene.hpp"

namespace livermark::live {
namespace {

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

} // namespace
} // namespace livermark::live
