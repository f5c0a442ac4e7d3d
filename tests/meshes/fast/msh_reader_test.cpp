#include <algorithm>
#include <gtest/gtest.h>
#include <random>

#include "meshes/io/mesh_files.hpp"
#include "tests/bad_input.hpp"
#include "tests/golden.hpp"

namespace livermark {
namespace {

/// Two tetrahedra on one face, two regions, a patch of one triangle and an interface triangle.
const std::string good_41 = R"($MeshFormat
4.1 0 8
$EndMeshFormat
$PhysicalNames
3
2 7 "held"
3 1 "soft"
3 2 "hard one"
$EndPhysicalNames
$Entities
0 0 2 2
1 0 0 0 1 1 1 1 7 0
2 0 0 0 1 1 1 0 0
1 0 0 0 1 1 1 1 1 1 1
2 0 0 0 1 1 1 1 2 0
$EndEntities
$Comments
anything
$EndComments
$Nodes
1 5 1 50
3 1 0 5
10
20
30
40
50
0 0 0
1 0 0
0 1 0
0 0 1
1 1 1e0
$EndNodes
$Elements
4 4 1 4
2 1 2 1
1 10 30 20
2 2 2 1
2 20 30 40
3 1 4 1
3 10 20 30 40
3 2 4 1
4 20 50 30 40
$EndElements
)";

/// The same, but for names.
const std::string good_1 = R"($NOD
5
10 0 0 0
20 1 0 0
30 0 1 0
40 0 0 1
50 1 1 1e0
$ENDNOD
$ELM
5
1 2 7 1 3 10 30 20
2 2 0 2 3 20 30 40
11 4 1 1 4 10 20 30 40
12 15 1 1 1 10
13 4 2 2 4 20 50 30 40
$ENDELM
)";

const std::string good_22 = R"($MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
2
2 7 "held"
3 1 "soft"
$EndPhysicalNames
$Nodes
4
1 0 0 0
2 1 0 0
3 0 1 0
4 0 0 1
$EndNodes
$Elements
3
1 15 2 0 1 1
2 2 2 7 1 1 3 2
3 4 2 1 1 1 2 3 4
$EndElements
)";

core::TetraMesh parse_bad(const std::string &text) {
    return meshes::parse_msh(text, "bad.msh");
}

TEST(MshReader, ReadsTheFirstVersionOfTheFormatAsTheLaterOnes) {
    const auto first = meshes::parse_msh(good_1, "first.msh");
    const auto later = meshes::parse_msh(good_41, "later.msh");
    EXPECT_EQ(first.points, later.points);
    EXPECT_EQ(first.tetrahedra, later.tetrahedra);
    EXPECT_EQ(first.region, later.region);
    EXPECT_EQ(first.region_names, (std::vector<std::string>{"region_1", "region_2"}));
    EXPECT_EQ(first.boundary_triangles, later.boundary_triangles);
    EXPECT_EQ(first.boundary_patch, later.boundary_patch);
    EXPECT_EQ(first.patch_names, (std::vector<std::string>{"unnamed", "patch_7"}));
}

TEST(MshReader, KeepsTheNodeOrderOfTheFile) {
    const auto mesh = meshes::parse_msh(good_41, "good.msh");
    ASSERT_EQ(mesh.num_nodes(), 5);
    EXPECT_EQ(mesh.points[4], core::Vector3(1.0, 1.0, 1.0));
    EXPECT_EQ(mesh.tetrahedra[1], (std::array{1, 4, 2, 3}));
}

TEST(MshReader, TakesRegionsAndPatchesFromPhysicalGroups) {
    const auto mesh = meshes::parse_msh(good_41, "good.msh");
    EXPECT_EQ(mesh.region_names, (std::vector<std::string>{"soft", "hard one"}));
    EXPECT_EQ(mesh.region, (std::vector{0, 1}));
    EXPECT_EQ(mesh.patch_names, (std::vector<std::string>{"unnamed", "held"}));
    EXPECT_EQ(mesh.num_boundary_triangles(), 6);
    EXPECT_EQ(std::ranges::count(mesh.boundary_patch, 1), 1);
}

TEST(MshReader, TurnsTheBoundaryOutward) {
    for (const auto &text : {good_41, good_22}) {
        const auto mesh = meshes::parse_msh(text, "good.msh");
        double volume = 0.0; // by the divergence theorem
        for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
            volume += core::area_vector(mesh, f).dot(mesh.points[mesh.boundary_triangles[f][0]]) / 3.0;
        double expected = 0.0;
        for (const double v : core::tetrahedron_volumes(mesh))
            expected += v;
        EXPECT_NEAR(volume, expected, 1e-14);
    }
}

TEST(MshReader, ReadsVersion22) {
    const auto mesh = meshes::parse_msh(good_22, "good.msh");
    EXPECT_EQ(mesh.num_tetrahedra(), 1);
    EXPECT_EQ(mesh.region_names, (std::vector<std::string>{"soft"}));
    EXPECT_EQ(mesh.patch_names, (std::vector<std::string>{"unnamed", "held"}));
}

TEST(MshReader, RefusesBadFilesWithPlaceAndRemedy) {
    using Change = std::pair<const char *, std::string>;
    auto refusals = tests::refusals_after(
        {"2.2 0 8 -> 3 0 8", "2.2 0 8 -> 2.2 1 8", "3 4 2 1 1 1 2 3 4 -> 3 15 2 1 1 1", "3 4 2 1 -> 3 5 2 1",
         "3 4 2 1 -> 3 11 2 1", "$Nodes\n4 -> $Nodes\n-4", "$Nodes\n4 -> $Nodes\n99999999999",
         "$Nodes\n4 -> $Nodes\n2000000000", "$EndNodes -> ", "\"held\" -> \"held"},
        good_22, parse_bad);
    refusals += tests::refusals_after({"11 4 1 1 4  -> 11 4 1 1 3 "}, good_1, parse_bad);
    refusals += tests::refusals_after(
        {"1 1 1e0 -> 1 1 1,0", "4 20 50 30 40 -> 4 20 51 30 40", "1 1 1e0 -> 1 1 nan", "3 10 20 30 40 -> 3 20 10 30 40",
         "0 0 1\n -> 0.5 0.5 0\n", "3 10 20 30 40 -> 3 10 20 30 30", "\n50\n -> \n40\n",
         "3 1 4 1\n3 10 20 30 40 -> 3 1 4 2\n3 10 20 30 40\n9 20 30 10 40", "2 20 30 40 -> 2 20 30 10"},
        good_41, parse_bad);
    for (const auto &[wrong, text] : std::vector<Change>{
             {"Empty", ""},
             {"NotAMesh", "hello"},
             {"FirstVersionThatEndsEarly", good_1.substr(0, good_1.find("$ENDELM"))},
             {"FirstVersionWithLaterSections",
              tests::replaced(tests::replaced(good_1, "$NOD", "$Nodes"), "$ENDNOD", "$EndNodes")},
             {"Truncated", good_41.substr(0, good_41.size() / 2)},
             {"CoincidingNodes",
              tests::replaced(tests::replaced(good_41, "1 1 1e0", "0 0 0"), "4 20 50 30 40", "4 20 30 40 50")},
             {"UnusedNode",
              tests::replaced(tests::replaced(good_41, "4 4 1 4", "3 4 1 4"), "3 2 4 1\n4 20 50 30 40\n", "")}})
        refusals += tests::refusal(wrong, [&] { parse_bad(text); });
    tests::expect_golden("refusals_of_msh_files", refusals);
}

/// A mesh in all forms that programs write it in is the same mesh.
TEST(MshReader, ReadsSignsCommentsAndGroupsThatAreTurnedOver) {
    const auto expected = meshes::parse_msh(good_22, "good.msh");
    const auto comments = "$Comments\nby hand\n$EndComments\n" + good_22;
    const auto signs =
        tests::replaced(tests::replaced(good_22, "1 0 0 0\n", "1 +0 +0.0e+00 0\n"), "3 4 2 1", "3 4 2 +1");
    const auto turned = tests::replaced(good_22, "3 4 2 1", "3 4 2 -1");
    for (const auto &text : {comments, signs, turned}) {
        SCOPED_TRACE(text);
        const auto mesh = meshes::parse_msh(text, "good.msh");
        EXPECT_EQ(mesh.points, expected.points);
        EXPECT_EQ(mesh.tetrahedra, expected.tetrahedra);
        EXPECT_EQ(mesh.region_names, expected.region_names);
        EXPECT_EQ(mesh.boundary_patch, expected.boundary_patch);
    }
    tests::expect_input_error([&] { parse_bad(tests::replaced(good_22, "1 0 0 0\n", "1 +-0 0 0\n")); },
                              {"'+-0' has to be a number"});
}

TEST(MshReader, LeavesOutATriangleThatIsNoFaceAndSaysSo) {
    std::vector<std::string> remarks;
    const auto mesh = meshes::parse_msh(tests::replaced(good_41, "1 10 30 20", "1 10 50 20"), "good.msh", &remarks);
    EXPECT_EQ(mesh.tetrahedra, meshes::parse_msh(good_41, "good.msh").tetrahedra);
    ASSERT_EQ(remarks.size(), 1U);
    EXPECT_EQ(remarks[0], "1 triangles that are not faces of tetrahedra, such as that of nodes 10 50 20, are left out");
}

TEST(MshReader, NamesValuesAndGroupsThatItDoesNotUse) {
    auto text =
        tests::replaced(good_22, "$Nodes", "$PhysicalNames\n2\n1 8 \"ridge\"\n0 9 \"tip\"\n$EndPhysicalNames\n$Nodes") +
        "$NodeData\n1\n\"u\"\n0\n0\n$EndNodeData\n$ElementData\n1\n\"label\"\n0\n0\n$EndElementData\n"
        "$ElementData\n0\n0\n0\n$EndElementData\n$Periodic\n0\n$EndPeriodic\n";
    std::vector<std::string> remarks;
    const auto mesh = meshes::parse_msh(text, "good.msh", &remarks);
    EXPECT_EQ(mesh.tetrahedra, meshes::parse_msh(good_22, "good.msh").tetrahedra);
    EXPECT_EQ(remarks, (std::vector<std::string>{"values in the file are not used: ElementData, NodeData",
                                                 "groups of lines and points are not used: ridge, tip"}));
}

/// Two tetrahedra side by side, of which the second is also in another group.
TEST(MshReader, OfGroupsThatOverlapTheSmallerOneCountsAndItIsSaid) {
    const std::string start = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n3 1 \"liver\"\n3 2 \"lesion\"\n"
                              "$EndPhysicalNames\n$Nodes\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 1 1\n$EndNodes\n";
    const auto repeated =
        start + "$Elements\n3\n1 4 2 1 1 1 2 3 4\n2 4 2 1 1 2 5 3 4\n3 4 2 2 1 2 5 3 4\n$EndElements\n";
    const std::string entities =
        "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n3 1 \"liver\"\n3 2 \"lesion\"\n$EndPhysicalNames\n"
        "$Entities\n0 0 0 2\n1 0 0 0 1 1 1 1 1 0\n2 0 0 0 1 1 1 2 1 2 0\n$EndEntities\n"
        "$Nodes\n1 5 1 5\n3 1 0 5\n1\n2\n3\n4\n5\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 1 1\n$EndNodes\n"
        "$Elements\n2 2 1 2\n3 1 4 1\n1 1 2 3 4\n3 2 4 1\n2 2 5 3 4\n$EndElements\n";
    for (const auto &text : {repeated, entities}) {
        std::vector<std::string> remarks;
        const auto mesh = meshes::parse_msh(text, "good.msh", &remarks);
        EXPECT_EQ(mesh.num_tetrahedra(), 2);
        EXPECT_EQ(mesh.region_names, (std::vector<std::string>{"liver", "lesion"}));
        EXPECT_EQ(mesh.region, (std::vector{0, 1}));
        tests::expect_one(remarks, "'liver' and 'lesion' share 1 elements, which count as 'lesion'");
    }
}

/// Parts that do not touch, or hang on an edge or on a node.
TEST(MshReader, RefusesSeveralParts) {
    std::string refusals;
    for (const auto &[num_nodes, points, nodes] : {std::tuple{8, "5 5 0 0\n6 6 0 0\n7 5 1 0\n8 5 0 1\n", "5 6 7 8"},
                                                   {6, "5 0 -1 0\n6 0 0 -1\n", "1 5 6 2"},
                                                   {7, "5 -1 0 0\n6 0 -1 0\n7 0 0 -1\n", "1 6 5 7"}}) {
        auto text = tests::replaced(good_22, "$Nodes\n4", "$Nodes\n" + std::to_string(num_nodes));
        text = tests::replaced(text, "$EndNodes", std::string(points) + "$EndNodes");
        text = tests::replaced(text, "$Elements\n3", "$Elements\n4");
        text = tests::replaced(text, "$EndElements", "4 4 2 1 1 " + std::string(nodes) + "\n$EndElements");
        refusals += tests::refusal(nodes, [&] { parse_bad(text); });
    }
    tests::expect_golden("refusals_of_several_parts", refusals);
}

/// Everything that others take for granted of a mesh.
void expect_valid(const core::TetraMesh &mesh) {
    ASSERT_GT(mesh.num_tetrahedra(), 0);
    for (const auto &point : mesh.points)
        EXPECT_TRUE(point.allFinite());
    const auto are_nodes = [&](const auto &nodes) {
        return std::ranges::all_of(nodes, [&](int node) { return node >= 0 && node < mesh.num_nodes(); });
    };
    const auto are_below = [](const std::vector<int> &numbers, std::size_t size) {
        return std::ranges::all_of(numbers, [&](int i) { return i >= 0 && static_cast<std::size_t>(i) < size; });
    };
    ASSERT_TRUE(std::ranges::all_of(mesh.tetrahedra, are_nodes));
    ASSERT_TRUE(std::ranges::all_of(mesh.boundary_triangles, are_nodes));
    ASSERT_EQ(std::ssize(mesh.region), mesh.num_tetrahedra());
    ASSERT_EQ(std::ssize(mesh.boundary_patch), mesh.num_boundary_triangles());
    EXPECT_TRUE(are_below(mesh.region, mesh.region_names.size()));
    EXPECT_TRUE(are_below(mesh.boundary_patch, mesh.patch_names.size()));
    EXPECT_GT(std::ranges::min(core::tetrahedron_volumes(mesh)), 0.0);
}

/// Damage anywhere is either harmless or refused; it never crashes and never throws anything else.
TEST(MshReader, SurvivesRandomDamage) {
    std::mt19937 random(3);
    int num_read = 0, num_refused = 0;
    for (int round = 0; round < 3000; ++round) {
        auto text = round % 2 == 0 ? good_41 : good_22;
        const int num_hits = 1 + static_cast<int>(random() % 4);
        for (int hit = 0; hit < num_hits; ++hit)
            text[random() % text.size()] = static_cast<char>(random() % 256);
        if (round % 5 == 0)
            text.resize(random() % text.size());
        SCOPED_TRACE(round);
        try {
            expect_valid(parse_bad(text));
            ++num_read;
        } catch (const support::InputError &error) {
            EXPECT_TRUE(std::string(error.what()).starts_with("bad.msh")) << error.what();
            ++num_refused;
        }
    }
    EXPECT_EQ(num_read + num_refused, 3000);
    // The damage is neither nothing nor everything: 63 were read.
    EXPECT_GT(num_read, 30);
    EXPECT_GT(num_refused, 1000);
}

} // namespace
} // namespace livermark
