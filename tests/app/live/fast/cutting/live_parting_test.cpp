#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <map>

#include "app/live/scene.hpp"
#include "core/support/input_error.hpp"
#include "tests/app/live/sick_box.hpp"

namespace livermark::live {
namespace {

/// The box with a lesion that is a cube of 1 cm, 1 cm from both sides and from the far end 1.5 cm.
SickBox box_with_cube(double height) {
    SickBox box;
    auto &mesh = box.body.mesh;
    for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
        Vector3 middle = Vector3::Zero();
        for (const int node : mesh.tetrahedra[t])
            middle += 0.25 * mesh.points[node];
        mesh.region[t] = (middle - Vector3(0.04, 0.015, height)).lpNorm<Eigen::Infinity>() < 0.005 ? 1 : 0;
    }
    return box;
}

TEST(LiveWayOut, OpensFromTheCapsuleByTheShortestWayOrSaysThatTheCavityIsClosed) {
    const auto box = box_with_cube(0.02);
    Scene scene(box.body, box.is_constrained);
    scene.choose(settings());
    const auto closed = scene.cut(around_lesion(0.0));
    EXPECT_NEAR(closed.closed_volume, closed.volume, 1e-15);
    EXPECT_NEAR(closed.volume, 1e-6, 1e-12);
    EXPECT_NEAR(closed.closed_depth, 0.005, 1e-9);
    EXPECT_EQ(closed.way_volume, 0.0);
    scene.reset();
    auto request = around_lesion(0.0);
    request.opens = true;
    const auto opened = scene.cut(request);
    EXPECT_EQ(opened.closed_volume, 0.0);
    EXPECT_EQ(opened.closed_depth, 0.0);
    EXPECT_GT(opened.way_volume, 0.4e-6);
    EXPECT_LT(opened.way_volume, 1.7e-6);
    EXPECT_GE(opened.volume, closed.volume + opened.way_volume - 1e-15);
    EXPECT_LT(opened.volume, closed.volume + opened.way_volume + 0.1e-6) << "what does not hold together";
    // Straight up, as wide as the cube from corner to corner.
    for (const int t : scene.gone())
        for (const int node : box.body.mesh.tetrahedra[t])
            EXPECT_GT(box.body.mesh.points[node].z(), 0.0149);
    // A wound that is open already needs no channel.
    scene.reset();
    request.tool = RegionCut{"lesion", 0.008};
    EXPECT_EQ(scene.cut(request).way_volume, 0.0);
    EXPECT_EQ(scene.cut(blade(0.055, 0.01)).closed_volume, 0.0);
}

/// A body of which all but the far end of the surface is constrained has one way, and none as wide if that is too
/// narrow.
TEST(LiveWayOut, OpensPastWhatIsConstrainedOrIsRefused) {
    auto box = box_with_cube(0.015);
    const auto constrain = [&](double free_from) {
        for (int f = 0; f < box.body.mesh.num_boundary_triangles(); ++f) {
            bool is_free = true;
            for (const int node : box.body.mesh.boundary_triangles[f])
                is_free = is_free && box.body.mesh.points[node].x() > free_from - 1e-9;
            box.is_constrained[static_cast<std::size_t>(f)] = !is_free;
        }
    };
    auto request = around_lesion(0.0);
    request.opens = true;
    constrain(0.06);
    Scene scene(box.body, box.is_constrained);
    scene.choose(settings());
    const auto reading = scene.cut(request);
    EXPECT_EQ(reading.closed_volume, 0.0);
    for (const int t : scene.gone())
        for (const int node : box.body.mesh.tetrahedra[t])
            EXPECT_GT(box.body.mesh.points[node].x(), 0.03);
    box.is_constrained.assign(box.is_constrained.size(), true);
    box.is_constrained[0] = false;
    Scene shut(box.body, box.is_constrained);
    shut.choose(settings());
    try {
        shut.cut(request);
        ADD_FAILURE() << "it was cut";
    } catch (const support::InputError &error) {
        EXPECT_NE(std::string(error.what()).find("no channel as wide"), std::string::npos) << error.what();
    }
    request.opens = false;
    EXPECT_GT(shut.cut(request).closed_volume, 0.0);
}

class LivePartingOfSprings : public testing::TestWithParam<const char *> {
  protected:
    SickBox box;
};

TEST_P(LivePartingOfSprings, GoOnPartedAndAreBackToTheBitWhenThatIsUndone) {
    Scene scene(box.body, box.is_constrained), uncut(box.body, box.is_constrained);
    for (auto *each : {&scene, &uncut}) {
        each->choose(short_steps(GetParam()));
        each->cut(blade(0.055, 0.008));
        each->move(box.poke(0.004), 50);
        each->keep();
    }
    scene.cut(parting(0.0217, 0.02));
    const auto before = uncut.move({}, 0), after = scene.move({}, 0);
    const auto num_nodes = box.body.mesh.points.size();
    ASSERT_GT(after.displacement.size(), num_nodes + 10);
    for (std::size_t node = 0; node < num_nodes; ++node) // some have gone along with the field
        EXPECT_LT((after.displacement[node] - before.displacement[node]).norm(), 1e-4) << node;
    EXPECT_NEAR(after.largest_speed, before.largest_speed, 0.1 * before.largest_speed);
    EXPECT_EQ(scene.move(box.poke(0.006), 60).restarts, 0);
    for (auto *each : {&scene, &uncut})
        each->restore();
    expect_same(scene.move(box.poke(0.006), 60), uncut.move(box.poke(0.006), 60));
}

/// The parted and snapped body as a file would have it.
TEST_P(LivePartingOfSprings, MoveAsThePartedBodyAlone) {
    Scene scene(box.body, box.is_constrained);
    scene.choose(short_steps(GetParam()));
    scene.cut(parting(0.0317, 0.018));
    const auto &parted = scene.body();
    auto is_constrained = box.is_constrained;
    is_constrained.resize(parted.mesh.boundary_triangles.size(), false);
    Scene alone(parted, is_constrained);
    alone.choose(short_steps(GetParam()));
    EXPECT_TRUE(scene.gone().empty());
    const auto is = scene.move(box.poke(0.003), 300), should = alone.move(box.poke(0.003), 300);
    EXPECT_GT(should.force.norm(), 0.005);
    expect_same(is, should);
}

INSTANTIATE_TEST_SUITE_P(Springs, LivePartingOfSprings,
                         testing::Values("lloyd", "patch", "nodal_neo_hookean", "edge_neo_hookean_f"));

double gap_between_sides(const Scene &scene, const Frame &frame) {
    double gap = 0.0;
    const auto &original = scene.original_node();
    for (std::size_t node = 0; node < original.size(); ++node)
        gap = std::max(gap, (frame.displacement[node] - frame.displacement[original[node]]).norm());
    return gap;
}

TEST(LiveParting, PartsTheBodyCleanlyAlongABladeWithoutThickness) {
    const SickBox box;
    Scene scene(box.body, box.is_constrained);
    const auto chosen = scene.choose(settings("nodal_neo_hookean"));
    const auto reading = scene.cut(parting(0.0214, 0.02));
    EXPECT_EQ(reading.volume, 0.0);
    EXPECT_TRUE(scene.gone().empty());
    EXPECT_EQ(reading.num_pieces, 1);
    EXPECT_NEAR(reading.wound_area, 2.0 * 0.03 * 0.02, 0.2e-3) << "both sides";
    // The faces have nodes on both sides of the blade in a mesh of 5 mm, and are on it afterwards.
    EXPECT_NEAR(reading.jagged.worst, 0.0036, 1e-9);
    EXPECT_LT(reading.snapped.worst, 1e-9);
    EXPECT_NEAR(volume_of_body(scene.body().mesh), volume_of_body(box.body.mesh), 1e-12) << "the box stays one";
    for (const double volume : core::tetrahedron_volumes(scene.body().mesh))
        EXPECT_GT(volume, 0.0);
    // It is closed, and the wound is the patch that is no capsule.
    std::map<std::pair<int, int>, int> balance;
    int num_wound = 0;
    double farthest = 0.0;
    const auto &left = scene.remains();
    for (std::size_t f = 0; f < left.facet.size(); ++f) {
        const auto &triangle = left.mesh.boundary_triangles[f];
        for (std::size_t k = 0; k < 3; ++k) {
            const auto [low, high] = std::minmax(triangle[k], triangle[(k + 1) % 3]);
            balance[{low, high}] += triangle[k] < triangle[(k + 1) % 3] ? 1 : -1;
        }
        if (left.facet[f] >= 0)
            continue;
        ++num_wound;
        EXPECT_EQ(left.mesh.patch_names[left.mesh.boundary_patch[f]], core::wound_patch);
        for (const int node : triangle)
            farthest = std::max(farthest, std::abs(left.mesh.points[node].x() - 0.0214));
    }
    EXPECT_GE(num_wound, 2 * 2 * 6 * 3);
    EXPECT_LT(farthest, 1e-9);
    for (const auto &[edge, count] : balance)
        EXPECT_EQ(count, 0) << edge.first << ' ' << edge.second;
    // It opens under a pull.
    Frame frame;
    for (int i = 0; i < 20; ++i)
        frame = scene.move(box.pull({0.0, 0.0, -0.02}), static_cast<int>(0.02 / chosen.time_step));
    EXPECT_GT(gap_between_sides(scene, frame), 0.002);
    EXPECT_EQ(frame.restarts, 0);
    EXPECT_GT(frame.smallest_volume, 0.1);
}

TEST(LiveParting, PartsInTwoOfWhichTheLoosePieceGoes) {
    const SickBox box;
    Scene scene(box.body, box.is_constrained);
    scene.choose(settings());
    auto request = parting(0.0317, 0.05);
    request.takes_loose = true;
    const auto reading = scene.cut(request);
    EXPECT_EQ(reading.num_loose, 1);
    EXPECT_NEAR(reading.volume, 0.0283 * 9e-4, 0.3e-6);
    EXPECT_EQ(scene.move(box.poke(0.003), 0).displacement.size(), scene.body().mesh.points.size());
    // Further cuts go through what is parted.
    EXPECT_GT(scene.cut(parting(0.0133, 0.01)).wound_area, reading.wound_area);
    EXPECT_GT(scene.cut(beyond(0.025)).volume, 0.0);
}

/// Other springs in between, fitted to the parted body, and scaled masses that end.
TEST(LiveParting, PartsTwiceAndIsWholeAgainAfterAReset) {
    SickBox box;
    box.body.materials[1].young_modulus = 2e5;
    Scene scene(box.body, box.is_constrained), uncut(box.body, box.is_constrained);
    for (auto *each : {&scene, &uncut})
        each->choose(settings("lloyd"));
    scene.cut(parting(0.0217, 0.02));
    scene.choose(settings("lloyd"));
    const auto num_nodes = scene.body().mesh.points.size();
    scene.cut(parting(0.0383, 0.012)); // through the lesion
    EXPECT_GT(scene.body().mesh.points.size(), num_nodes);
    EXPECT_EQ(scene.move(box.poke(0.004), 60).restarts, 0);
    scene.restore();
    EXPECT_EQ(scene.body().mesh.points.size(), num_nodes);
    EXPECT_EQ(scene.original_mesh().points, box.body.mesh.points);
    scene.reset();
    EXPECT_EQ(scene.body().mesh.points, box.body.mesh.points);
    EXPECT_EQ(scene.body().mesh.boundary_triangles, box.body.mesh.boundary_triangles);
    expect_same(scene.move(box.poke(0.004), 50), uncut.move(box.poke(0.004), 50));
}

} // namespace
} // namespace livermark::live
