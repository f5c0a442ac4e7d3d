#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <map>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include "core/mesh/plausible_liver.hpp"
#include "core/mesh/tetra_mesh.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark::core {
namespace {

TEST(BoundingBox, TouchesThePointsOnEverySide) {
    const std::vector<Vector3> points{{1.0, -2.0, 3.0}, {-1.0, 5.0, 3.5}, {0.0, 0.0, 7.0}};
    const auto box = bounding_box(points);
    EXPECT_EQ(box.min(), Vector3(-1.0, -2.0, 3.0));
    EXPECT_EQ(box.max(), Vector3(1.0, 5.0, 7.0));
    EXPECT_DOUBLE_EQ(extent(points), std::sqrt(4.0 + 49.0 + 16.0));
    EXPECT_EQ(extent(std::vector{points[1]}), 0.0);
    EXPECT_TRUE(bounding_box({}).isEmpty());
}

} // namespace
} // namespace livermark::core

namespace livermark {
namespace {

TEST(EdgeTable, HasEachEdgeOnceInLexicographicOrder) {
    const auto mesh = tests::box_mesh({0.3, 0.2, 0.1}, {3, 2, 1});
    std::set<std::array<int, 2>> expected;
    for (const auto &nodes : mesh.tetrahedra)
        for (const auto &[a, b] : core::tetrahedron_edges)
            expected.insert({std::min(nodes[a], nodes[b]), std::max(nodes[a], nodes[b])});
    EXPECT_TRUE(std::ranges::equal(core::edge_table(mesh.tetrahedra).edges, expected));
}

TEST(EdgeTable, LetsEachTetrahedronFindItsEdges) {
    const auto mesh = tests::box_mesh({0.3, 0.2, 0.1}, {3, 2, 1});
    const auto table = core::edge_table(mesh.tetrahedra);
    ASSERT_EQ(table.tetrahedron_edge.size(), mesh.tetrahedra.size());
    for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t)
        for (std::size_t e = 0; e < 6; ++e) {
            const auto &nodes = mesh.tetrahedra[t];
            const auto [a, b] = core::tetrahedron_edges[e];
            EXPECT_EQ(table.edges[table.tetrahedron_edge[t][e]],
                      (std::array{std::min(nodes[a], nodes[b]), std::max(nodes[a], nodes[b])}));
        }
}

TEST(EdgeTable, OfNoTetrahedraIsEmpty) {
    EXPECT_TRUE(core::edge_table({}).edges.empty());
}

using Tetrahedra = std::vector<std::array<int, 4>>;

std::array<int, 3> face_of(const std::array<int, 4> &nodes, int face) {
    const auto &[a, b, c] = core::tetrahedron_faces[face];
    return {nodes[a], nodes[b], nodes[c]};
}

template <class Nodes> Nodes ascending(Nodes nodes) {
    std::ranges::sort(nodes);
    return nodes;
}

/// A box with some of its tetrahedra taken out, so that there are holes and parts, in no order.
Tetrahedra box_with_holes(unsigned int seed) {
    auto tetrahedra = tests::box_mesh({0.3, 0.2, 0.1}, {4, 3, 2}).tetrahedra;
    std::mt19937 random(seed);
    std::ranges::shuffle(tetrahedra, random);
    tetrahedra.resize(tetrahedra.size() / 3);
    return tetrahedra;
}

TEST(Faces, AreOuterWhereOneTetrahedronHasThem) {
    for (const unsigned int seed : {1U, 2U, 3U}) {
        const auto tetrahedra = box_with_holes(seed);
        std::map<std::array<int, 3>, int> num_owners;
        for (const auto &nodes : tetrahedra)
            for (int face = 0; face < 4; ++face)
                ++num_owners[ascending(face_of(nodes, face))];
        std::vector<std::array<int, 3>> expected;
        for (const auto &nodes : tetrahedra)
            for (int face = 0; face < 4; ++face)
                if (num_owners[ascending(face_of(nodes, face))] == 1)
                    expected.push_back(face_of(nodes, face));
        EXPECT_LT(expected.size(), 4 * tetrahedra.size());
        EXPECT_EQ(core::outer_faces(tetrahedra), expected);
    }
}

/// Each tetrahedron takes the lowest number in its part, again and again; numbers of parts are then as they come.
std::vector<int> slow_parts(const Tetrahedra &tetrahedra, const std::function<bool(int, int)> &are_joined) {
    const auto num = static_cast<int>(tetrahedra.size());
    const auto share_a_face = [&](int s, int t) {
        return std::ranges::count_if(tetrahedra[s],
                                     [&](int node) { return std::ranges::count(tetrahedra[t], node) > 0; }) == 3;
    };
    std::vector<int> lowest(tetrahedra.size());
    for (int t = 0; t < num; ++t)
        lowest[t] = t;
    for (bool changed = true; changed;) {
        changed = false;
        for (int s = 0; s < num; ++s)
            for (int t = 0; t < num; ++t)
                if (lowest[s] < lowest[t] && share_a_face(s, t) && are_joined(s, t)) {
                    lowest[t] = lowest[s];
                    changed = true;
                }
    }
    std::map<int, int> number;
    std::vector<int> part;
    for (const int least : lowest)
        part.push_back(number.try_emplace(least, static_cast<int>(number.size())).first->second);
    return part;
}

TEST(Faces, JoinTetrahedraToParts) {
    for (const unsigned int seed : {1U, 2U, 3U}) {
        const auto tetrahedra = box_with_holes(seed);
        const auto always = [](int, int) { return true; };
        const auto alike = [](int s, int t) { return s % 2 == t % 2; };
        const auto parts = core::parts_by_faces(tetrahedra);
        EXPECT_GT(std::ranges::max(parts), 0);
        EXPECT_EQ(parts, slow_parts(tetrahedra, always));
        EXPECT_EQ(core::parts_by_faces(tetrahedra, alike), slow_parts(tetrahedra, alike));
    }
}

TEST(Faces, OfTetrahedraThatRepeatTellTheFirstThatDoes) {
    auto tetrahedra = box_with_holes(1);
    const auto num = static_cast<int>(tetrahedra.size());
    EXPECT_FALSE(core::tetrahedra_of_same_nodes(tetrahedra));
    tetrahedra.push_back(tetrahedra[20]);
    tetrahedra.push_back(tetrahedra[5]);
    tetrahedra.push_back(tetrahedra[20]);
    std::ranges::reverse(tetrahedra.back());
    EXPECT_EQ(core::tetrahedra_of_same_nodes(tetrahedra), (std::pair{20, num}));
}

} // namespace
} // namespace livermark

namespace livermark::core {
namespace {

TEST(Overlaps, OfNodesAreFoundWithinABillionthOfTheExtent) {
    std::vector<Vector3> points{{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}};
    EXPECT_FALSE(nodes_in_one_place(points));
    points.emplace_back(0.0, 1.0 + 1e-8, 0.0);
    EXPECT_FALSE(nodes_in_one_place(points));
    points.emplace_back(1e-10, 1.0, 0.0);
    EXPECT_EQ(nodes_in_one_place(points), (std::pair{2, 5}));
    EXPECT_FALSE(nodes_in_one_place(points, [](int a, int b) { return a + b == 7; }));
    EXPECT_FALSE(nodes_in_one_place({}));
}

TEST(Overlaps, OfTetrahedraAreFoundInAnyOrderOfTheirNodes) {
    std::vector<std::array<int, 4>> tetrahedra{{0, 1, 2, 3}, {1, 2, 3, 4}};
    EXPECT_FALSE(tetrahedra_of_same_nodes(tetrahedra));
    EXPECT_FALSE(face_of_too_many(sorted_faces(tetrahedra)));
    tetrahedra.push_back({3, 1, 5, 2});
    EXPECT_FALSE(tetrahedra_of_same_nodes(tetrahedra));
    EXPECT_EQ(face_of_too_many(sorted_faces(tetrahedra)), (std::array{1, 2, 3}));
    tetrahedra.push_back({4, 3, 2, 1});
    EXPECT_EQ(tetrahedra_of_same_nodes(tetrahedra), (std::pair{1, 3}));
}

TEST(Overlaps, KnowEachFaceAsOftenAsThereAreTetrahedra) {
    const std::vector<std::array<int, 4>> tetrahedra{{0, 1, 2, 3}, {4, 3, 2, 1}};
    const auto faces = sorted_faces(tetrahedra);
    EXPECT_EQ(faces.size(), 8U);
    EXPECT_EQ(std::ranges::count(faces, std::array{1, 2, 3}, &TetrahedronFace::nodes), 2);
}

using enum SegmentRole;

void expect_role(SegmentRole role, std::initializer_list<const char *> names) {
    for (const char *name : names)
        EXPECT_EQ(role_of_name(name), role) << name;
}

/// Spellings of 3D Slicer, TotalSegmentator, LiTS, MSD, CHAOS, AbdomenAtlas, 3D-IRCADb and collections of TCIA.
TEST(SegmentNames, OfALiverAreWholePhrases) {
    expect_role(liver, {"liver",
                        "Liver",
                        "LIVER",
                        "Liver parenchyma",
                        "liver_right_lobe",
                        "whole liver",
                        "Liver mask",
                        "liver_segment_1",
                        "liver_segment_4a",
                        "Couinaud segment IV",
                        "LiverSegmentation",
                        "Hepatic",
                        "Liver_Remnant",
                        "Right lobe of the liver",
                        "Leber",
                        "foie",
                        "Liver without tumours",
                        "liver with lesions",
                        "liver1",
                        "parenchyma",
                        "Liver (CT, manual)"});
    expect_role(other, {"Liver bed", "Non-liver", "nonliver", "Liver capsule", "outside of liver", "stomach", "lung",
                        "lung_upper_lobe_left", "lung parenchyma", "spleen", "Tissue around liver", "hepatic flexure",
                        "leftkidney", "portion"});
}

TEST(SegmentNames, OfLesionsAreThoseOfTheLiver) {
    expect_role(lesion, {"Neoplasm",
                         "Neoplasm, Primary",
                         "Malignant neoplasm",
                         "Hemangioma",
                         "haemangioma",
                         "tumor",
                         "Tumour",
                         "tumour_1",
                         "cancer",
                         "liver_tumor",
                         "livertumor01",
                         "liver_lesion",
                         "Mass",
                         "HCC 2",
                         "Metastasis",
                         "colorectal metastasis",
                         "metastasis from colon",
                         "Lesion in liver",
                         "FNH",
                         "Nodule",
                         "necrosis",
                         "vascular lesion",
                         "Tumor of the bile duct",
                         "LiverTumor",
                         "kidney metastasis of the liver"});
    expect_role(other, {"kidney_cyst_left", "lung_tumor", "pancreas_tumor", "colon_cancer_primaries", "lung nodules",
                        "Lymph node metastasis", "Non-tumour", "peritumoral", "tumor bed", "healthy tissue of tumor",
                        "metastasectomie", "massive"});
}

TEST(SegmentNames, OfCystsAreNoTumours) {
    expect_role(cyst,
                {"Liver cyst", "Cyst", "liverkyst", "livercyst02", "cyst_1", "Simple cysts", "Hydatid cyst", "Zyste"});
    expect_role(lesion, {"cystadenoma", "cystic lesion"});
    expect_role(other, {"kidney_cyst_left", "renal cyst", "non-cyst"});
}

TEST(SegmentNames, OfTheGallbladderAreItsOwn) {
    expect_role(gallbladder, {"gallbladder", "Gallbladder", "gall_bladder", "Gall Bladder"});
    expect_role(other, {"gallbladder cancer", "gallbladder bed"});
}

TEST(SegmentNames, OfVesselsSayWhich) {
    const auto expect_kind = [](VesselKind kind, std::initializer_list<const char *> names) {
        for (const char *name : names)
            EXPECT_EQ(kind_of_vessel(name, {}), kind) << name;
    };
    expect_kind(VesselKind::portal, {"Portal vein", "portalvein", "portal_vein_and_splenic_vein", "PV"});
    expect_kind(VesselKind::hepatic,
                {"Hepatic vein", "hepatic_veins", "HV", "Hepatic venous system", "vessel_hepatic_vein"});
    expect_kind(VesselKind::artery, {"artery", "Hepatic artery"});
    expect_kind(VesselKind::beside,
                {"inferior_vena_cava", "venacava", "aorta", "IVC", "splenic artery", "lung_vessels"});
    expect_kind(VesselKind::any, {"liver_vessels", "Vessel", "venoussystem", "Bile duct"});
    EXPECT_EQ(kind_of_vessel("tubes", {.type = "32764006", .meaning = "Portal vein"}), VesselKind::portal);
    EXPECT_EQ(kind_of_vessel("portal", {.type = "59820001", .meaning = "Blood vessel"}), VesselKind::portal);
}

TEST(SegmentNames, OfVesselsAndDuctsAreTheirOwn) {
    expect_role(
        vessel,
        {"liver_vessels",      "Vessel",      "Hepatic vein",  "portal vein",      "portal_vein_and_splenic_vein",
         "inferior_vena_cava", "postcava",    "portalvein",    "venacava",         "artery",
         "Hepatic artery",     "aorta",       "Bile duct",     "common bile duct", "biliarysystem",
         "tumour vessels",     "cystic duct", "Liver vessels", "venoussystem",     "IVC"});
}

TEST(SegmentNames, ThatProgramsGiveSayNothing) {
    expect_role(unnamed, {"", "1", "Segment_1", "label 2", "Label_Value_3", "Class 1", "ROI 4", "Segmentation",
                          "unknown", "x", "Tissue"});
}

TEST(SegmentNames, CodesDecideBeforeWords) {
    EXPECT_EQ(role_of_segment("Segment_1", {.type = "108369006", .meaning = "Neoplasm"}), lesion);
    EXPECT_EQ(role_of_segment("green", {.type = "M-8FFFF", .meaning = ""}), lesion);
    EXPECT_EQ(role_of_segment("green", {.type = "M-81703", .meaning = ""}), lesion) << "hepatocellular carcinoma";
    EXPECT_EQ(role_of_segment("green", {.type = "367643001", .meaning = "Cyst"}), cyst);
    EXPECT_EQ(role_of_segment("green", {.type = "M-3340A", .meaning = "Cyst", .region = "Kidney"}), other);
    EXPECT_EQ(role_of_segment("green", {.type = "28231008", .meaning = ""}), gallbladder);
    EXPECT_EQ(role_of_segment("Foie 2", {.type = "T-62000", .meaning = "Liver"}), liver);
    EXPECT_EQ(role_of_segment("Liver", {.type = "8993003", .meaning = "Hepatic vein"}), vessel);
    EXPECT_EQ(role_of_segment("Segment_2", {.type = "999", .meaning = "Hemangioma"}), lesion) << "by the words";
    EXPECT_EQ(role_of_segment("Liver", {.type = "85756007", .meaning = "Tissue"}), liver) << "the code says nothing";
    EXPECT_EQ(role_of_segment("Segment_1", {.type = "85756007", .meaning = "Tissue"}), unnamed);
    EXPECT_EQ(role_of_segment("Segment_1", {.type = "69695003", .meaning = "Stomach"}), other);
    EXPECT_EQ(role_of_segment("tumour", {.type = "108369006", .meaning = "Neoplasm", .region = "Kidney"}), other);
    EXPECT_EQ(role_of_segment("tumour", {.type = "108369006", .meaning = "Neoplasm", .region = "Liver"}), lesion);
}

} // namespace
} // namespace livermark::core
