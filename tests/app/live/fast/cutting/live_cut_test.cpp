#include <algorithm>
#include <cmath>
#include <cstring>
#include <gtest/gtest.h>
#include <map>
#include <set>

#include "app/live/messages.hpp"
#include "app/live/parameters.hpp"
#include "app/live/scene.hpp"
#include "core/support/input_error.hpp"
#include "meshes/cutting/cut.hpp"
#include "tests/app/live/sick_box.hpp"

namespace livermark::live {
namespace {

TEST(LiveCut, TakesARegionWithAMarginAndLeavesAClosedSurface) {
    const SickBox box;
    Scene scene(box.body, box.is_constrained);
    scene.choose(settings());
    const auto reading = scene.cut(around_lesion(0.004));
    const auto &left = scene.remains();
    EXPECT_NEAR(reading.volume + volume_of_body(left.mesh), volume_of_body(box.body.mesh), 1e-15);
    EXPECT_EQ(scene.gone().size() + left.tetrahedron.size(), box.body.mesh.tetrahedra.size());
    for (const int region : left.mesh.region)
        EXPECT_EQ(region, 0);
    EXPECT_GE(reading.margin, 0.0);
    EXPECT_LT(reading.margin, 0.008);
    EXPECT_EQ(reading.num_pieces, 1);
    EXPECT_EQ(reading.num_loose, 0);
    EXPECT_GT(reading.wound_area, 6e-4);
    std::map<std::pair<int, int>, int> balance;
    for (const auto &triangle : left.mesh.boundary_triangles)
        for (std::size_t k = 0; k < 3; ++k) {
            const auto [low, high] = std::minmax(triangle[k], triangle[(k + 1) % 3]);
            balance[{low, high}] += triangle[k] < triangle[(k + 1) % 3] ? 1 : -1;
        }
    for (const auto &[edge, count] : balance)
        EXPECT_EQ(count, 0) << edge.first << ' ' << edge.second;
    std::set<std::array<int, 3>> boundary, outer;
    for (auto triangle : left.mesh.boundary_triangles)
        boundary.insert((std::ranges::sort(triangle), triangle));
    for (auto triangle : core::outer_faces(left.mesh.tetrahedra))
        outer.insert((std::ranges::sort(triangle), triangle));
    EXPECT_EQ(boundary, outer);
}

TEST(LiveCut, KeepsTheMarginWhereItIsAskedTo) {
    const SickBox box;
    Scene scene(box.body, box.is_constrained);
    scene.choose(settings());
    for (const double margin : {0.001, 0.004, 0.006}) {
        scene.reset();
        auto request = around_lesion(margin);
        const double about = scene.cut(request).volume;
        scene.reset();
        request.keeps_margin = true;
        const auto reading = scene.cut(request);
        EXPECT_GE(reading.margin, margin);
        EXPECT_LT(reading.margin, margin + 0.005) << "no more than an edge";
        EXPECT_GE(reading.volume, about);
    }
}

class LiveCutOfSprings : public testing::TestWithParam<const char *> {
  protected:
    SickBox box;
};

TEST_P(LiveCutOfSprings, KeepsTheMotionOfWhatIsLeft) {
    Scene scene(box.body, box.is_constrained);
    scene.choose(short_steps(GetParam()));
    scene.move(box.poke(0.004), 200);
    scene.move({}, 20);
    scene.keep(); // as a cut does: a state has fewer digits then
    const auto before = scene.move({}, 0);
    scene.cut(around_lesion(0.002));
    const auto after = scene.move({}, 0);
    std::set<int> left;
    for (const auto &tetrahedron : scene.remains().mesh.tetrahedra)
        left.insert(tetrahedron.begin(), tetrahedron.end());
    EXPECT_LT(left.size(), box.body.mesh.points.size());
    for (int node = 0; node < box.body.mesh.num_nodes(); ++node)
        EXPECT_EQ(after.displacement[node], left.contains(node) ? before.displacement[node] : Vector3::Zero()) << node;
    EXPECT_GT(after.largest_speed, 0.3 * before.largest_speed);
    EXPECT_GT(scene.move({}, 10).largest_speed, 0.1 * before.largest_speed);
}

/// Springs that are found around the cut alone, and those that a choice sets up from nothing.
TEST_P(LiveCutOfSprings, MoveToTheBitAsThoseThatAreSetUpAnew) {
    Scene scene(box.body, box.is_constrained), anew(box.body, box.is_constrained);
    for (auto *each : {&scene, &anew}) {
        each->choose(short_steps(GetParam()));
        each->move(box.poke(0.003), 100);
        each->cut(around_lesion(0.001));
        each->cut(beyond(0.055));
        each->keep();
    }
    anew.choose(short_steps(GetParam()));
    anew.restore();
    expect_same(scene.move(box.pull({0.0, 0.0, 0.01}), 100), anew.move(box.pull({0.0, 0.0, 0.01}), 100));
}

/// Other nodes and other slices, so only nearly: single precision.
TEST_P(LiveCutOfSprings, MoveAsTheCutBodyAlone) {
    Scene scene(box.body, box.is_constrained);
    scene.choose(short_steps(GetParam()));
    scene.cut(beyond(0.053));
    const auto &left = scene.remains();
    auto part = box.body;
    std::vector<int> number(part.mesh.points.size(), -1);
    part.mesh.points.clear();
    for (const auto &tetrahedron : left.mesh.tetrahedra)
        for (const int node : tetrahedron)
            number[node] = 0;
    for (std::size_t node = 0; node < number.size(); ++node)
        if (number[node] == 0) {
            number[node] = part.mesh.num_nodes();
            part.mesh.points.push_back(left.mesh.points[node]);
        }
    const auto renumbered = [&](auto nodes) {
        for (int &node : nodes)
            node = number[node];
        return nodes;
    };
    part.mesh.region = left.mesh.region;
    part.mesh.tetrahedra.clear();
    for (const auto &tetrahedron : left.mesh.tetrahedra)
        part.mesh.tetrahedra.push_back(renumbered(tetrahedron));
    part.mesh.boundary_triangles.clear();
    for (const auto &triangle : left.mesh.boundary_triangles)
        part.mesh.boundary_triangles.push_back(renumbered(triangle));
    part.mesh.boundary_patch = left.mesh.boundary_patch;
    part.mesh.patch_names = left.mesh.patch_names;
    Scene alone(part, scene.constrained_remains());
    alone.choose(short_steps(GetParam()));
    const auto is = scene.move(box.poke(0.003), 300);
    const auto should = alone.move(box.poke(0.003), 300);
    EXPECT_GT(should.force.norm(), 0.015);
    EXPECT_NEAR(is.force.norm(), should.force.norm(), 1e-3 * should.force.norm());
    for (std::size_t node = 0; node < number.size(); ++node)
        if (number[node] >= 0) {
            EXPECT_LT((is.displacement[node] - should.displacement[number[node]]).norm(), 3e-6) << node;
        }
}

TEST_P(LiveCutOfSprings, AreBackToTheBitWhenACutIsUndone) {
    Scene scene(box.body, box.is_constrained), uncut(box.body, box.is_constrained);
    for (auto *each : {&scene, &uncut}) {
        each->choose(settings(GetParam()));
        each->cut(blade(0.05, 0.012));
        each->move(box.poke(0.004), 50);
        each->keep();
    }
    scene.cut(around_lesion(0.003));
    scene.move(box.poke(0.008), 50);
    scene.restore();
    EXPECT_EQ(scene.gone(), uncut.gone());
    expect_same(scene.move(box.poke(0.004), 0), uncut.move(box.poke(0.004), 0));
    expect_same(scene.move(box.poke(0.006), 60), uncut.move(box.poke(0.006), 60));
}

TEST_P(LiveCutOfSprings, AreWholeAgainAfterAReset) {
    Scene scene(box.body, box.is_constrained), uncut(box.body, box.is_constrained);
    for (auto *each : {&scene, &uncut})
        each->choose(settings(GetParam()));
    scene.cut(around_lesion(0.003));
    scene.choose(settings(GetParam()));
    scene.move(box.poke(0.004), 30);
    scene.reset();
    EXPECT_TRUE(scene.gone().empty());
    expect_same(scene.move(box.poke(0.004), 50), uncut.move(box.poke(0.004), 50));
}

INSTANTIATE_TEST_SUITE_P(Springs, LiveCutOfSprings,
                         testing::Values("lloyd", "patch", "nodal_neo_hookean", "edge_neo_hookean_f"));

TEST(LiveCut, IsFeltByAProbeInTheWound) {
    const SickBox box;
    Scene scene(box.body, box.is_constrained);
    scene.choose(settings());
    scene.cut(beyond(0.046));
    const Tool probe{.kind = ToolKind::probe, .target = {0.051, 0.015, 0.015}, .radius = 0.008};
    Frame frame;
    for (int i = 0; i < 20; ++i)
        frame = scene.move(probe, 50);
    EXPECT_GT(frame.force.x(), 0.02);
    ASSERT_FALSE(frame.load.triangles.empty());
    for (const int triangle : frame.load.triangles)
        EXPECT_LT(scene.remains().facet[frame.surface->facet[triangle]], 0) << "it is of the wound";
    EXPECT_LT(frame.smallest_volume, 1.0);
}

/// A blade meets the body where it is, not where it was at rest.
TEST(LiveCut, IsWhereTheBodyHasMovedTo) {
    const SickBox box;
    Scene scene(box.body, box.is_constrained);
    scene.choose(settings());
    const auto num_taken = [&](double pulled) {
        scene.reset();
        for (int i = 0; i < 30; ++i)
            scene.move(box.pull({pulled, 0.0, 0.0}), 50);
        scene.cut(beyond(0.056));
        return scene.gone().size();
    };
    const auto at_rest = num_taken(0.0), pulled = num_taken(0.02);
    EXPECT_GT(pulled, at_rest);
}

TEST(LiveCut, IsRefusedInASentenceAndHarmsNothing) {
    const SickBox box;
    Scene scene(box.body, box.is_constrained), quiet(box.body, box.is_constrained);
    EXPECT_THROW(scene.cut(around_lesion(0.002)), support::InputError) << "nothing is chosen";
    for (auto *each : {&scene, &quiet}) {
        each->choose(settings("lloyd"));
        each->cut(blade(0.02, 0.008));
        each->move(box.poke(0.004), 40);
    }
    const auto sentence = [&](const CutRequest &request) -> std::string {
        try {
            scene.cut(request);
        } catch (const support::InputError &error) {
            return error.what();
        }
        return "it was cut";
    };
    const auto expect = [&](const CutRequest &request, const std::string &words) {
        EXPECT_NE(sentence(request).find(words), std::string::npos) << sentence(request);
    };
    expect(beyond(0.2), "touches nothing");
    expect({.tool = HalfSpaceCut{{-0.1, 0.0, 0.0}, {1.0, 0.0, 0.0}}}, "takes all of the body");
    expect({.tool = HalfSpaceCut{{0.0049, 0.0, 0.0}, {-1.0, 0.0, 0.0}}}, "all that is constrained");
    expect({.tool = HalfSpaceCut{{0.0, 0.0, 0.02}, {0.0, 0.0, 1.0}}}, "through what is constrained");
    expect(blade(0.03, 0.05), "that nothing holds");
    expect(blade(0.02, 0.008), "made already");
    expect({.tool = RegionCut{"lesion", -1.0}}, "margin is -1");
    expect({.tool = RegionCut{"lesion", std::nan("")}}, "margin");
    expect({.tool = RegionCut{"lesion", 0.5}}, "margin of 0.5 m");
    expect({.tool = RegionCut{"liver", 0.001}}, "no region 'liver'");
    expect({.tool = HalfSpaceCut{{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}}}, "normal");
    expect({.tool = HalfSpaceCut{{std::nan(""), 0.0, 0.0}, {0.0, 0.0, 1.0}}}, "not finite");
    expect({.tool = BladeCut{{Vector3(0.0, 0.0, 0.0), Vector3(1.0, 0.0, 0.0), Vector3(1.0, 0.0, 0.0),
                              Vector3(0.0, 0.0, 0.0)},
                             0.001}},
           "do not form a quadrilateral");
    expect(parting(0.2, 0.01), "parts nothing");
    expect(parting(0.03, 0.05), "that nothing holds");
    expect_same(scene.move(box.poke(0.004), 40), quiet.move(box.poke(0.004), 40));
    scene.cut(around_lesion(0.001));
    expect(around_lesion(0.002), "nothing is left of this region");
}

TEST(LiveCut, TakesALoosePieceAwayIfItIsAskedTo) {
    const SickBox box;
    Scene scene(box.body, box.is_constrained);
    scene.choose(settings());
    auto request = blade(0.03, 0.05);
    request.takes_loose = true;
    const auto reading = scene.cut(request);
    EXPECT_EQ(reading.num_loose, 1);
    EXPECT_EQ(reading.num_pieces, 1);
    for (const auto &tetrahedron : scene.remains().mesh.tetrahedra)
        for (const int node : tetrahedron)
            EXPECT_LT(box.body.mesh.points[node].x(), 0.031);
    EXPECT_EQ(reading.margin > 0.005, true) << "the lesion went with it";
}

TEST(LiveCut, IsUndoneWithOtherSpringsToTheBit) {
    const SickBox box;
    Scene scene(box.body, box.is_constrained), uncut(box.body, box.is_constrained);
    for (auto *each : {&scene, &uncut}) {
        each->choose(settings("lloyd"));
        each->move(box.poke(0.004), 30);
        each->keep();
        if (each == &scene)
            each->cut(around_lesion(0.002));
        each->choose(short_steps("van_gelder"));
        each->restore();
    }
    EXPECT_TRUE(scene.gone().empty());
    expect_same(scene.move(box.poke(0.005), 60), uncut.move(box.poke(0.005), 60));
}

TEST(LiveCut, EndsNeitherNeedleNorSteps) {
    const SickBox box;
    Scene scene(box.body, box.is_constrained);
    const auto chosen = scene.choose(settings("nodal_neo_hookean"));
    const Tool needle{.kind = ToolKind::needle,
                      .needle = {.name = {},
                                 .entry = {0.021, 0.013, 0.03},
                                 .target = {0.025, 0.016, 0.01},
                                 .diameter = 1e-3,
                                 .spread = 6e-3,
                                 .toughness = 30.0,
                                 .friction = 3.0,
                                 .puncture_force = 0.05},
                      .depth = 0.005};
    scene.move(needle, 200);
    scene.cut(beyond(0.05));
    const auto frame = scene.move(needle, static_cast<int>(0.3 / chosen.time_step));
    ASSERT_TRUE(frame.needle.has_value());
    EXPECT_GT(frame.needle->force, 0.0);
    EXPECT_EQ(frame.restarts, 0);
}

TEST(LiveCut, RepliesWithTheNewBoundary) {
    const SickBox box;
    Scene scene(box.body, box.is_constrained);
    scene.choose(settings());
    const auto bytes = reply(scene, std::vector<double>{7.0, 0.0, 0.0, 1.0, 0.002, 1.0, 0.0});
    std::vector<double> numbers(bytes.size() / sizeof(double));
    std::memcpy(numbers.data(), bytes.data(), bytes.size());
    constexpr std::size_t num_readings = 20;
    ASSERT_GT(numbers.size(), num_readings);
    const auto num_gone = static_cast<std::size_t>(numbers[16]), num_triangles = static_cast<std::size_t>(numbers[17]);
    ASSERT_EQ(numbers.size(), num_readings + num_gone + 4 * num_triangles);
    EXPECT_EQ(num_gone, scene.gone().size());
    EXPECT_EQ(num_triangles, scene.remains().mesh.boundary_triangles.size());
    std::array<int, 3> kinds{};
    for (std::size_t f = 0; f < num_triangles; ++f)
        ++kinds[static_cast<std::size_t>(numbers[num_readings + num_gone + 3 * num_triangles + f])];
    EXPECT_EQ(kinds[1], 2 * 6 * 6);
    EXPECT_LE(kinds[0], static_cast<int>(box.body.mesh.boundary_triangles.size()) - 72);
    EXPECT_GT(kinds[0], 500);
    EXPECT_GT(kinds[2], 20);
    for (const auto &bad :
         {std::vector<double>{7.0}, {7.0, 0.0, 3.0}, {7.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0}, {7.0, 0.0, 1.0, 0.0}})
        EXPECT_THROW(reply(scene, bad), support::InputError);
}

} // namespace
} // namespace livermark::live
