#include "msm/kernels/layout/sliced_body.hpp"

#include <gtest/gtest.h>
#include <map>
#include <set>

#include "core/mesh/tetra_mesh.hpp"
#include "msm/springs/coupled_springs.hpp"
#include "tests/samples/moving_samples.hpp"

namespace livermark {
namespace {

/// A body of two materials, its springs around edges and their stars.
struct StarsOfBody {
    core::Body body = tests::two_materials(108, 0.25, 0.45);
    msm::StepParts parts =
        msm::step_parts(msm::coupled_springs_with_volume(body, msm::find_coupled_springs("edge_neo_hookean"))).value();
    std::vector<msm::Star> stars = msm::stars_around_edges(parts);
};

/// Six times the volume between the axis and both nodes.
double volume_between(const StarsOfBody &of, const msm::Star &star, int from, int to) {
    const auto &x = of.body.mesh.points;
    return 6.0 * core::signed_volume(x[star.axis[0]], x[star.axis[1]], x[from], x[to]);
}

TEST(Stars, HaveEveryTetrahedronAroundEachOfItsEdgesOnce) {
    const StarsOfBody of;
    std::multiset<int> tetrahedra;
    for (const auto &star : of.stars)
        for (const auto &corner : star.rim)
            if (corner.tetrahedron >= 0)
                tetrahedra.insert(corner.tetrahedron);
    EXPECT_EQ(tetrahedra.size(), 6U * of.body.mesh.tetrahedra.size());
    for (int t = 0; t < of.body.mesh.num_tetrahedra(); ++t)
        EXPECT_EQ(tetrahedra.count(t), 6U) << t;
}

TEST(Stars, GoAroundTheirAxisAsTetrahedraDo) {
    const StarsOfBody of;
    const auto volumes = core::tetrahedron_volumes(of.body.mesh);
    ASSERT_FALSE(of.stars.empty());
    for (const auto &star : of.stars)
        for (std::size_t k = 0; k < star.rim.size(); ++k) {
            const auto &corner = star.rim[k];
            const double expected = corner.tetrahedron < 0 ? 0.0 : 6.0 * volumes[corner.tetrahedron];
            EXPECT_NEAR(volume_between(of, star, corner.node, star.rim[(k + 1) % star.rim.size()].node), expected,
                        1e-18);
        }
}

TEST(Stars, GoOverTheAxisWhereTetrahedraEndAndNowhereElse) {
    const StarsOfBody of;
    std::map<std::array<int, 2>, int> parts_of_edge;
    for (const auto &star : of.stars)
        ++parts_of_edge[star.axis];
    std::set<std::array<int, 2>> outer;
    for (const auto &face : core::outer_faces(of.body.mesh.tetrahedra))
        for (int k = 0; k < 3; ++k)
            outer.insert({std::min(face[k], face[(k + 1) % 3]), std::max(face[k], face[(k + 1) % 3])});
    int num_closed = 0;
    for (const auto &star : of.stars) {
        const bool is_open = parts_of_edge[star.axis] > 1 || outer.count(star.axis) > 0;
        EXPECT_EQ(std::ranges::any_of(star.rim, [&](const auto &corner) { return corner.node == star.axis[0]; }),
                  is_open);
        num_closed += !is_open;
    }
    EXPECT_GT(num_closed, 0);
    EXPECT_GT(of.stars.size(), parts_of_edge.size()) << "two materials meet at some edges";
}

TEST(Stars, AreNotThereWithoutSpringsAroundEdges) {
    const auto body = tests::two_materials(108, 0.25, 0.45);
    const auto parts =
        msm::step_parts(msm::coupled_springs_with_volume(body, msm::find_coupled_springs("nodal_neo_hookean")));
    EXPECT_TRUE(msm::stars_around_edges(parts.value()).empty());
}

} // namespace
} // namespace livermark
