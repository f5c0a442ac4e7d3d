#include "studies/calibration/patch_loads.hpp"

#include <algorithm>
#include <gtest/gtest.h>

#include "load_cases/places/facets.hpp"
#include "tests/bad_input.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark::studies {
namespace {

const core::TetraMesh brick = tests::box_mesh({0.12, 0.08, 0.06}, {12, 8, 6});

TEST(PatchLoads, PullAtADiscOfTheFreeSurface) {
    const auto loads = random_patch_loads(brick, "x_min", 20, 1);
    ASSERT_EQ(loads.size(), 20u);
    for (const auto &load : loads) {
        std::vector<core::Vector3> centroids, normals;
        for (int f = 0; f < brick.num_boundary_triangles(); ++f) {
            const bool is_constrained = brick.patch_names[brick.boundary_patch[f]] == "x_min";
            EXPECT_EQ(load.is_constrained(f), is_constrained);
            if (!load.is_loaded(f))
                continue;
            EXPECT_NEAR(load.value[f].norm(), 1.0, 1e-12);
            centroids.push_back(load_cases::facet_centroid(brick, f));
            normals.push_back(core::area_vector(brick, f).normalized());
        }
        ASSERT_FALSE(centroids.empty());
        for (const auto &a : centroids)
            for (const auto &b : centroids)
                EXPECT_LE((a - b).norm(), 2 * 0.030);
        for (const auto &a : normals)
            for (const auto &b : normals)
                EXPECT_GE(a.dot(b), -0.5 - 1e-12) << "each is within 60 degrees of the normal of one facet";
    }
}

TEST(PatchLoads, AreTheSameForOneSeedAndOthersForAnother) {
    const auto loads = random_patch_loads(brick, "x_min", 6, 1);
    const auto same = random_patch_loads(brick, "x_min", 9, 1), other = random_patch_loads(brick, "x_min", 6, 2);
    for (std::size_t l = 0; l < loads.size(); ++l) {
        EXPECT_TRUE(core::are_statically_equal(loads[l], same[l])) << "more loads begin with the same";
        EXPECT_FALSE(core::are_statically_equal(loads[l], other[l]));
        for (std::size_t m = 0; m < l; ++m)
            EXPECT_FALSE(core::are_statically_equal(loads[l], loads[m]));
    }
}

TEST(PatchLoads, NeedAPatchToConstrainAndAFreeFacet) {
    tests::expect_input_error([] { random_patch_loads(brick, "posterior", 1, 1); },
                              {"no patch 'posterior'", "choose with --constrained among x_min, x_max"});
    tests::expect_input_error([] { random_patch_loads(tests::regular_tetrahedron(0.05), "surface", 1, 1); },
                              {"all of the surface belongs to patch 'surface'", "constrain a smaller one"});
}

} // namespace
} // namespace livermark::studies
