#include <algorithm>
#include <filesystem>
#include <gtest/gtest.h>
#include <numbers>
#include <ostream>
#include <set>

#include "msm/spring_law.hpp"
#include "tests/test_meshes.hpp"

namespace livermark {

namespace msm {
void PrintTo(const SpringLaw &law, std::ostream *out) {
    *out << law.name;
}
} // namespace msm

namespace {

class EverySpringLaw : public testing::TestWithParam<msm::SpringLaw> {};

TEST_P(EverySpringLaw, StatesWhatItIsAndWhereItComesFrom) {
    EXPECT_FALSE(GetParam().summary.empty());
    EXPECT_FALSE(GetParam().source.empty());
}

TEST_P(EverySpringLaw, GivesEveryEdgeAPositiveStiffness) {
    const auto body = tests::make_body(tests::box_mesh({0.1, 0.12, 0.08}, {3, 4, 2}), {1060.0, 5e3, 0.25});
    const auto table = core::edge_table(body->mesh.tetrahedra);
    const auto stiffness = GetParam().stiffness(*body, table);
    ASSERT_EQ(stiffness.size(), table.edges.size());
    EXPECT_GT(std::ranges::min(stiffness), 0.0);
}

/// Central springs of a regular tetrahedron that match isotropic elasticity have k = (2 sqrt 2 / 25) l E
/// (Lloyd et al. 2007); every law for irregular meshes has to fall back to it.
TEST_P(EverySpringLaw, IsLloydsFactorOnARegularTetrahedron) {
    const double edge = 0.013;
    const double young_modulus = 4200.0;
    const auto body = tests::make_body(tests::regular_tetrahedron(edge), {1060.0, young_modulus, 0.25});
    const auto stiffness = GetParam().stiffness(*body, core::edge_table(body->mesh.tetrahedra));
    const double expected = 2.0 * std::numbers::sqrt2 / 25.0 * edge * young_modulus;
    for (const double k : stiffness)
        EXPECT_NEAR(k, expected, 1e-13 * expected);
}

TEST_P(EverySpringLaw, IsProportionalToYoungsModulus) {
    const auto mesh = tests::box_mesh({0.1, 0.12, 0.08}, {2, 2, 2});
    const auto table = core::edge_table(mesh.tetrahedra);
    const auto soft = GetParam().stiffness(*tests::make_body(mesh, {1060.0, 1.0, 0.25}), table);
    const auto hard = GetParam().stiffness(*tests::make_body(mesh, {1060.0, 10.0, 0.25}), table);
    for (std::size_t s = 0; s < soft.size(); ++s)
        EXPECT_NEAR(hard[s], 10.0 * soft[s], 1e-12 * hard[s]);
}

INSTANTIATE_TEST_SUITE_P(SpringLaws, EverySpringLaw,
                         testing::ValuesIn(msm::all_spring_laws().begin(), msm::all_spring_laws().end()),
                         [](const auto &info) { return info.param.name; });

TEST(SpringLawTable, HasEveryFileOfItsFolderUnderItsName) {
    std::set<std::string> files;
    for (const auto &file : std::filesystem::directory_iterator(LIVERMARK_SOURCE_DIR "/msm/spring_laws"))
        files.insert(file.path().stem().string());
    std::set<std::string> names;
    for (const auto &law : msm::all_spring_laws())
        names.insert(law.name);
    EXPECT_EQ(names, files);
}

} // namespace
} // namespace livermark
