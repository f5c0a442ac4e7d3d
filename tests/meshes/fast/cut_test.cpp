#include "meshes/cutting/cut.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>

#include "core/mesh/tetra_mesh.hpp"
#include "meshes/cutting/cut_reader.hpp"
#include "meshes/cutting/parting.hpp"
#include "meshes/generators/box_generator.hpp"
#include "meshes/io/mesh_checks.hpp"
#include "meshes/io/mesh_files.hpp"
#include "tests/bad_input.hpp"
#include "tests/cut_checks.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {

namespace {

using core::Vector3;
using meshes::BladeCut;
using meshes::CutWay;
using meshes::HalfSpaceCut;
using meshes::RegionCut;
using meshes::SmallPieces;

const Vector3 bar_size(0.12, 0.04, 0.04);
const Vector3 middle_of_lump(0.06, 0.02, 0.02);

/// A bar of soft tissue with a lump in the middle.
core::Body bar_with_lump(double edge = 0.008, meshes::BoxTopology topology = meshes::BoxTopology::body_centred) {
    core::Body body{.name = "bar", .mesh = meshes::generate_box(bar_size, edge, topology), .materials = {}};
    body.materials = {{1000.0, 5000.0, 0.45}, {1100.0, 50000.0, 0.45}};
    body.mesh.region_names.emplace_back("lump");
    for (std::size_t t = 0; t < body.mesh.tetrahedra.size(); ++t) {
        Vector3 middle = Vector3::Zero();
        for (const int node : body.mesh.tetrahedra[t])
            middle += 0.25 * body.mesh.points[node];
        body.mesh.region[t] = (middle - middle_of_lump).norm() < 0.011 ? 1 : 0;
    }
    return body;
}

/// Across the bar at some x, from above to a depth.
BladeCut blade_at(double x, double depth, double thickness = 0.0) {
    const double z = bar_size.z() - depth;
    return {{Vector3(x, -0.1, z), Vector3(x, 0.2, z), Vector3(x, 0.2, 0.1), Vector3(x, -0.1, 0.1)}, thickness};
}

double area_of(const core::TetraMesh &mesh, const std::string &patch) {
    double area = 0.0;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (mesh.patch_names[mesh.boundary_patch[f]] == patch)
            area += core::area_vector(mesh, f).norm();
    return area;
}

/// Cuts of a load case, whose lengths are in the unit that it says; normals have none.
TEST(CutReader, TakesLengthsInTheUnitOfTheLoadCase) {
    const auto file = std::filesystem::temp_directory_path() / "cut_reader_unit.toml";
    std::ofstream(file)
        << "unit = \"mm\"\n[[cut]]\nregion = \"lump\"\nmargin = 5\n"
           "[[cut]]\nhalf_space = { point = [20, 0, 10], normal = [2, 0, 0] }\n"
           "[[cut]]\nblade = { corners = [[0, 0, 1], [0, 2, 1], [0, 2, 9], [0, 0, 9]], thickness = 3 }\n";
    const auto cuts = meshes::cuts_of_file(file);
    std::filesystem::remove(file);
    ASSERT_EQ(cuts.size(), 3u);
    EXPECT_DOUBLE_EQ(std::get<RegionCut>(cuts[0].tool).margin, 0.005);
    EXPECT_LT((std::get<HalfSpaceCut>(cuts[1].tool).point - Vector3(0.02, 0.0, 0.01)).norm(), 1e-15);
    EXPECT_EQ(std::get<HalfSpaceCut>(cuts[1].tool).normal, Vector3(2.0, 0.0, 0.0));
    EXPECT_LT((std::get<BladeCut>(cuts[2].tool).corners[2] - Vector3(0.0, 0.002, 0.009)).norm(), 1e-15);
    EXPECT_DOUBLE_EQ(std::get<BladeCut>(cuts[2].tool).thickness, 0.003);
}

/// Tetrahedra that a cut leaves, cleaned.
meshes::CleanMesh cleaned(const core::TetraMesh &mesh, const std::vector<bool> &alive) {
    const auto neighbours = core::face_neighbours(mesh.tetrahedra);
    meshes::Faces was_outer(neighbours.size());
    for (std::size_t t = 0; t < neighbours.size(); ++t)
        for (std::size_t k = 0; k < 4; ++k)
            was_outer[t][k] = neighbours[t][k] < 0;
    return meshes::clean_up(mesh, alive, neighbours, was_outer);
}

/// Some bricks of a box as they are left by a cut.
meshes::CleanMesh clean_bricks(const core::TetraMesh &mesh, const std::function<bool(const Vector3 &)> &stays) {
    std::vector<bool> alive;
    for (const auto &nodes : mesh.tetrahedra) {
        Vector3 middle = Vector3::Zero();
        for (const int node : nodes)
            middle += 0.25 * mesh.points[node];
        alive.push_back(stays(middle));
    }
    return cleaned(mesh, alive);
}

class CutBody : public testing::TestWithParam<CutWay> {};

} // namespace

TEST_P(CutBody, HalfSpaceLeavesWhatIsOnTheOtherSide) {
    const auto body = bar_with_lump();
    const auto after = meshes::cut(body, {HalfSpaceCut{{0.093, 0.0, 0.0}, {1.0, 0.0, 0.0}}, GetParam()});
    EXPECT_EQ(tests::fault_of(body, {HalfSpaceCut{Vector3::Zero(), Vector3::UnitX()}, GetParam()}, after), "");
    const double wanted = (bar_size.x() - 0.093) * bar_size.y() * bar_size.z();
    EXPECT_NEAR(after.removed_volume, wanted, 0.1 * wanted);
    const std::vector<std::string> names{"x_min", "y_min", "y_max", "z_min", "z_max", "wound"};
    EXPECT_EQ(after.body.mesh.patch_names, names);
    EXPECT_EQ(after.body.mesh.region_names, body.mesh.region_names);
    EXPECT_GT(after.wound_area, 0.99 * bar_size.y() * bar_size.z());
}

TEST_P(CutBody, RegionGoesWithItsNameItsMaterialAndItsMargin) {
    const auto body = bar_with_lump();
    const auto after = meshes::cut(body, {RegionCut{"lump", 0.004}, GetParam()});
    EXPECT_EQ(tests::fault_of(body, {RegionCut{}, GetParam()}, after), "");
    EXPECT_EQ(after.body.mesh.region_names, std::vector<std::string>{"solid"});
    ASSERT_EQ(after.body.materials.size(), 1u);
    EXPECT_EQ(after.body.materials[0].young_modulus, 5000.0);
    EXPECT_GT(after.removed_volume, 5e-6); // a ball of 11 mm has 5.6 mL
    for (const char *side : {"x_min", "x_max", "y_min", "y_max", "z_min", "z_max"})
        EXPECT_DOUBLE_EQ(area_of(after.body.mesh, side), area_of(body.mesh, side));
}

/// The facets of a wound around a ball are chords, which come nearer to it than their corners.
TEST_P(CutBody, KnowsHowNearTheWoundComesToTheRegion) {
    constexpr double margin = 0.004;
    const auto body = bar_with_lump();
    const auto after = meshes::cut(body, {RegionCut{"lump", margin}, GetParam()});
    std::vector<Vector3> lump, wound;
    for (std::size_t t = 0; t < body.mesh.tetrahedra.size(); ++t)
        if (body.mesh.region[t] == 1)
            for (const int node : body.mesh.tetrahedra[t])
                lump.push_back(body.mesh.points[node]);
    const auto &mesh = after.body.mesh;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (mesh.patch_names[mesh.boundary_patch[f]] == core::wound_patch)
            for (const int node : mesh.boundary_triangles[f])
                wound.push_back(mesh.points[node]);
    double nearest_corners = std::numeric_limits<double>::infinity();
    for (const auto &a : lump)
        for (const auto &b : wound)
            nearest_corners = std::min(nearest_corners, (a - b).norm());
    EXPECT_LE(after.least_margin, nearest_corners);
    if (GetParam() == CutWay::exact) {
        EXPECT_LT(after.least_margin, margin);
        EXPECT_GT(after.least_margin, 0.5 * margin);
    }
    tests::expect_part(after.notes.front(), "mm from the region where it is nearest");
    const auto half = meshes::cut(body, {HalfSpaceCut{{0.093, 0.0, 0.0}, {1.0, 0.0, 0.0}}, GetParam()});
    EXPECT_TRUE(std::isnan(half.least_margin));
}

TEST_P(CutBody, BladeWithoutThicknessPartsAndTakesNothingAway) {
    const auto body = bar_with_lump();
    const auto after = meshes::cut(body, {blade_at(0.031, 0.025), GetParam()});
    EXPECT_EQ(tests::fault_of(body, {blade_at(0.031, 0.025), GetParam()}, after), "");
    EXPECT_EQ(after.removed_volume, 0.0);
    EXPECT_GT(after.wound_area, 2.0 * 0.8 * 0.020 * bar_size.y()); // both sides, as deep as facets let it go
    const auto opening = [&](double z) {                           // a pair of nodes in one place
        int num_pairs = 0;
        const auto &points = after.body.mesh.points;
        for (std::size_t i = 0; i < points.size(); ++i)
            for (std::size_t j = i + 1; j < points.size(); ++j)
                num_pairs += points[i] == points[j] && points[i].z() >= z;
        return num_pairs;
    };
    EXPECT_GT(opening(bar_size.z()), 2);
    EXPECT_EQ(opening(0.0), opening(bar_size.z() - 0.034)); // none below the end of the blade
}

TEST_P(CutBody, ThickBladeTakesAsMuchAwayAsItSweeps) {
    const auto body = bar_with_lump(0.006);
    const auto blade = blade_at(0.031, 0.025, 0.01);
    const auto after = meshes::cut(body, {blade, GetParam()});
    EXPECT_EQ(tests::fault_of(body, {blade, GetParam()}, after), "");
    const double swept = 0.01 * 0.025 * bar_size.y(); // and half a cylinder at its end
    if (GetParam() == CutWay::exact)
        EXPECT_NEAR(after.removed_volume, swept + 0.5 * 3.14159 * 0.005 * 0.005 * bar_size.y(), 0.06 * swept);
    else
        EXPECT_GT(after.removed_volume, swept); // all that it touches
}

TEST_P(CutBody, PieceThatFloatsIsRefusedRemovedOrKept) {
    const auto body = bar_with_lump();
    const auto blade = blade_at(0.031, 1.0);
    EXPECT_THROW(meshes::cut(body, {blade, GetParam()}), meshes::CutNotOnBody);
    const auto removed = meshes::cut(body, {blade, GetParam(), SmallPieces::remove});
    const auto kept = meshes::cut(body, {blade, GetParam(), SmallPieces::keep});
    EXPECT_TRUE(removed.small_pieces.empty());
    ASSERT_EQ(kept.small_pieces.size(), 1u);
    EXPECT_EQ(kept.small_pieces[0].name, "bar_piece_2");
    EXPECT_NEAR(meshes::mesh_figures(kept.small_pieces[0].mesh).volume, removed.removed_volume,
                1e-12 * removed.removed_volume);
    EXPECT_NEAR(removed.removed_volume, 0.031 * bar_size.y() * bar_size.z(), 0.12 * removed.removed_volume);
    EXPECT_EQ(tests::fault_of(body, {blade, GetParam(), SmallPieces::keep}, kept), "");
}

TEST_P(CutBody, IsRefusedWhereItMissesOrTakesAll) {
    const auto body = bar_with_lump();
    const auto cut = [&](const meshes::CutTool &tool) { meshes::cut(body, {tool, GetParam()}); };
    EXPECT_THROW(cut(HalfSpaceCut{{0.2, 0.0, 0.0}, {1.0, 0.0, 0.0}}), meshes::CutNotOnBody);
    EXPECT_THROW(cut(HalfSpaceCut{{-0.2, 0.0, 0.0}, {1.0, 0.0, 0.0}}), meshes::CutNotOnBody);
    EXPECT_THROW(cut(blade_at(0.3, 0.02)), meshes::CutNotOnBody);
    EXPECT_THROW(cut(blade_at(0.3, 0.02, 0.01)), meshes::CutNotOnBody);
    EXPECT_THROW(cut(RegionCut{"tumour_1", 0.0}), meshes::CutNotOnBody);
    EXPECT_THROW(cut(RegionCut{"lump", 1.0}), meshes::CutNotOnBody);
    EXPECT_THROW(cut(RegionCut{"lump", -0.001}), support::InputError);
    EXPECT_THROW(cut(RegionCut{"lump", std::numeric_limits<double>::infinity()}), support::InputError);
    EXPECT_THROW(cut(HalfSpaceCut{Vector3::Zero(), Vector3::Zero()}), support::InputError);
    EXPECT_THROW(cut(HalfSpaceCut{Vector3::Constant(std::nan("")), Vector3::UnitX()}), support::InputError);
    EXPECT_THROW(cut(blade_at(0.03, 0.02, -0.01)), support::InputError);
    EXPECT_THROW(cut(BladeCut{{Vector3::Zero(), Vector3::UnitX(), 2.0 * Vector3::UnitX(), Vector3::UnitY()}, 0.0}),
                 support::InputError);
}

TEST_P(CutBody, SecondTimeCutsNothing) {
    const auto body = bar_with_lump();
    for (const meshes::CutTool &tool : std::vector<meshes::CutTool>{HalfSpaceCut{{0.083, 0.0, 0.0}, {1.0, 0.0, 0.0}},
                                                                    RegionCut{"lump", 0.004}, blade_at(0.031, 0.025)}) {
        const auto once = meshes::cut(body, {tool, GetParam()});
        EXPECT_THROW(meshes::cut(once.body, {tool, GetParam()}), meshes::CutNotOnBody) << to_text(tool);
        EXPECT_THROW(meshes::cut(body, std::vector<meshes::Cut>{{tool, GetParam()}, {tool, GetParam()}}),
                     support::InputError);
    }
}

TEST_P(CutBody, IsReadBackFromItsFileThoughNodesAreThereTwice) {
    const auto body = bar_with_lump();
    const auto after = meshes::cut(body, {blade_at(0.031, 0.025), GetParam()}).body.mesh;
    const auto file = std::filesystem::path(testing::TempDir()) / "livermark_cut_bar.msh";
    meshes::write_msh(file, after);
    const auto read = meshes::read_msh(file);
    EXPECT_EQ(read.points, after.points);
    EXPECT_EQ(read.patch_names, after.patch_names);
    EXPECT_DOUBLE_EQ(area_of(read, "wound"), area_of(after, "wound"));
    auto unnamed = after; // without the wound two nodes in one place are a mistake
    std::ranges::replace(unnamed.patch_names, "wound", "gap");
    meshes::write_msh(file, unnamed);
    EXPECT_THROW(meshes::read_msh(file), support::InputError);
    std::filesystem::remove(file);
}

TEST_P(CutBody, CutsFollowOneAnother) {
    const auto body = bar_with_lump();
    const auto after = meshes::cut(body, std::vector<meshes::Cut>{{RegionCut{"lump", 0.002}, GetParam()},
                                                                  {HalfSpaceCut{{0.1, 0, 0}, {1, 0, 0}}, GetParam()}});
    EXPECT_EQ(after.mesh.region_names, std::vector<std::string>{"solid"});
    EXPECT_EQ(std::ranges::count(after.mesh.patch_names, "wound"), 1);
    EXPECT_EQ(std::ranges::count(after.mesh.patch_names, "x_max"), 0);
    EXPECT_FALSE(after.assumptions.empty());
}

TEST_P(CutBody, SameCutGivesTheSameMesh) {
    const auto body = bar_with_lump();
    const meshes::Cut cut{RegionCut{"lump", 0.004}, GetParam()};
    const auto one = meshes::cut(body, cut).body.mesh, other = meshes::cut(body, cut).body.mesh;
    EXPECT_EQ(one.points, other.points);
    EXPECT_EQ(one.tetrahedra, other.tetrahedra);
}

INSTANTIATE_TEST_SUITE_P(Ways, CutBody, testing::Values(CutWay::facets, CutWay::exact));

TEST(ExactCut, PutsNodesInsideOnTheSurface) {
    const auto body = bar_with_lump(0.006, meshes::BoxTopology::delaunay);
    const Vector3 normal = Vector3(1.0, 0.3, 0.2).normalized(), point(0.083, 0.02, 0.02);
    const auto mesh = meshes::cut(body, {HalfSpaceCut{point, normal}, CutWay::exact}).body.mesh;
    std::vector<bool> is_in_wound(mesh.points.size(), false), is_outside(mesh.points.size(), false);
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        for (const int node : mesh.boundary_triangles[f])
            (mesh.patch_names[mesh.boundary_patch[f]] == "wound" ? is_in_wound : is_outside)[node] = true;
    int num_inside = 0;
    for (std::size_t node = 0; node < mesh.points.size(); ++node)
        if (is_in_wound[node]) {
            const double distance = std::abs(normal.dot(mesh.points[node] - point));
            EXPECT_LT(distance, is_outside[node] ? 0.25 * 0.006 : 1e-12);
            num_inside += !is_outside[node];
        }
    EXPECT_GT(num_inside, 15);
    EXPECT_GT(meshes::mesh_figures(mesh).smallest_quality, 0.1);
}

/// On a lattice a plane may go through centroids, which are on one side then.
TEST(FacetCut, PartsThroughCentroids) {
    auto body = *tests::make_body(tests::box_mesh({0.09, 0.03, 0.03}, {3, 1, 1}), {1000.0, 5000.0, 0.3});
    const meshes::Cut cut{BladeCut{{Vector3(0.045, -1, -1), {0.045, 1, -1}, {0.045, 1, 1}, {0.045, -1, 1}}, 0.0},
                          CutWay::facets, SmallPieces::keep};
    const auto after = meshes::cut(body, cut);
    EXPECT_EQ(tests::fault_of(body, cut, after), "");
    EXPECT_EQ(after.small_pieces.size(), 1u);
    EXPECT_EQ(after.removed_volume, 0.0);
}

TEST(FacetCut, ComesNearerToTheExactOneOnFinerMeshes) {
    const auto relative_area = [](double edge) {
        const auto body = bar_with_lump(edge);
        const HalfSpaceCut tool{{0.09, 0.02, 0.02}, {1.0, 0.37, 0.21}};
        const auto facets = meshes::cut(body, {tool, CutWay::facets}), exact = meshes::cut(body, {tool, CutWay::exact});
        return std::abs(facets.removed_volume - exact.removed_volume) / exact.removed_volume;
    };
    EXPECT_LT(relative_area(0.004), 0.06);
}

TEST(CleanUp, PartsThatMeetAtAnEdgeAreTwoPieces) {
    const auto mesh = tests::box_mesh({2.0, 2.0, 1.0}, {2, 2, 1});
    const auto clean = clean_bricks(mesh, [](const Vector3 &x) { return (x.x() < 1.0) == (x.y() < 1.0); });
    ASSERT_EQ(clean.pieces.size(), 2u);
    EXPECT_EQ(clean.pieces[0].size(), clean.pieces[1].size());
}

TEST(CleanUp, EdgeAtWhichTheWoundTouchesItselfIsOpened) {
    const auto mesh = tests::box_mesh({4.0, 4.0, 1.0}, {4, 4, 1});
    const auto clean = clean_bricks(mesh, [](const Vector3 &x) {
        const bool is_first = x.x() > 1.0 && x.x() < 2.0 && x.y() > 1.0 && x.y() < 2.0;
        const bool is_second = x.x() > 2.0 && x.x() < 3.0 && x.y() > 2.0 && x.y() < 3.0;
        return !is_first && !is_second;
    });
    EXPECT_GT(clean.num_hinges, 0);
    ASSERT_EQ(clean.pieces.size(), 1u);
    EXPECT_TRUE(
        meshes::pinched_nodes(clean.pieces[0], mesh.tetrahedra, core::face_neighbours(mesh.tetrahedra), clean.is_wound)
            .empty());
}

TEST(CleanUp, TetrahedraThatAloneJoinTwoPartsAreNoBridge) {
    auto mesh = tests::box_mesh({3.0, 1.0, 1.0}, {3, 1, 1});
    // Of the brick in the middle the tetrahedra at the faces to its neighbours with the one between them.
    const auto neighbours = core::face_neighbours(mesh.tetrahedra);
    std::vector<bool> alive(mesh.tetrahedra.size(), false);
    const auto x_of = [&](int t) {
        double x = 0.0;
        for (const int node : mesh.tetrahedra[t])
            x += 0.25 * mesh.points[node].x();
        return x;
    };
    std::vector<int> in_the_middle;
    for (int t = 0; t < mesh.num_tetrahedra(); ++t)
        (x_of(t) > 1.0 && x_of(t) < 2.0) ? in_the_middle.push_back(t) : void(alive[t] = true);
    const auto touches = [&](int t, bool left) {
        return std::ranges::any_of(
            neighbours[t], [&](int other) { return other >= 0 && (left ? x_of(other) < 1.0 : x_of(other) > 2.0); });
    };
    const auto is_in_the_middle = [&](int t) { return t >= 0 && x_of(t) > 1.0 && x_of(t) < 2.0; };
    bool has_chain = false;
    for (const int a : in_the_middle)
        for (const int b : neighbours[a])
            for (const int c : b >= 0 ? neighbours[b] : std::array{-1, -1, -1, -1})
                if (!has_chain && is_in_the_middle(b) && is_in_the_middle(c) && touches(a, true) && touches(c, false))
                    has_chain = alive[a] = alive[b] = alive[c] = true;
    ASSERT_TRUE(has_chain);
    const auto clean = cleaned(mesh, alive);
    EXPECT_GE(clean.num_bridges, 1);
    ASSERT_EQ(clean.pieces.size(), 2u);
    EXPECT_EQ(clean.pieces[0].size() + clean.pieces[1].size() + clean.num_bridges + clean.num_spikes, 6u + 3u + 6u);
}

TEST(RandomCuts, AreCleanOrRefusedOnSmallBodies) {
    for (const auto topology :
         {meshes::BoxTopology::body_centred, meshes::BoxTopology::kuhn, meshes::BoxTopology::delaunay}) {
        const auto tried = tests::try_random_cuts(bar_with_lump(0.009, topology), 60, 1);
        EXPECT_EQ(tried.num_cut + tried.num_refused, 60);
        EXPECT_GT(tried.num_cut, 30);
        for (const auto &fault : tried.faults)
            ADD_FAILURE() << fault;
    }
}

} // namespace livermark
