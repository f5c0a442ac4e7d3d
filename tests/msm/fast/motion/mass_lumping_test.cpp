#include <gtest/gtest.h>
#include <numeric>

#include "msm/elastic_body.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

TEST(MassLumping, ConservesTotalMassOfSeveralRegions) {
    auto mesh = tests::box_mesh({0.1, 0.2, 0.3}, {3, 2, 4});
    mesh.region_names = {"light", "heavy"};
    for (std::size_t t = 0; t < mesh.region.size(); t += 3)
        mesh.region[t] = 1;
    core::Body body{"box", mesh, {{1000.0, 5e3, 0.25}, {3000.0, 5e3, 0.25}}};

    double expected = 0.0;
    const auto volumes = core::tetrahedron_volumes(mesh);
    for (std::size_t t = 0; t < volumes.size(); ++t)
        expected += volumes[t] * body.materials[mesh.region[t]].density;
    const auto masses = msm::lumped_masses(body);
    EXPECT_NEAR(std::accumulate(masses.begin(), masses.end(), 0.0), expected, 1e-14 * expected);
}

TEST(MassLumping, GivesAQuarterOfATetrahedronToEachCorner) {
    const auto body = tests::make_body(tests::regular_tetrahedron(0.01), {1060.0, 5e3, 0.25});
    const double volume = core::tetrahedron_volumes(body->mesh).front();
    const auto masses = msm::lumped_masses(*body);
    ASSERT_EQ(masses.size(), 4U);
    for (const double mass : masses)
        EXPECT_DOUBLE_EQ(mass, 1060.0 * volume / 4.0);
}

} // namespace
} // namespace livermark
