#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <gtest/gtest.h>
#include <map>
#include <numeric>
#include <set>

#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "meshes/generators/liver_generator.hpp"
#include "meshes/generators/liver_shape.hpp"
#include "meshes/io/body_reader.hpp"
#include "meshes/io/mesh_checks.hpp"
#include "meshes/io/mesh_files.hpp"
#include "tests/bad_input.hpp"

namespace livermark::meshes {
namespace {

using core::Vector3;

const std::filesystem::path committed_meshes = std::filesystem::path(LIVERMARK_SOURCE_DIR) / "meshes";

/// Numbers that each of the two canonical bodies has to have.
struct CanonicalBody {
    std::string name;
    bool tumours;
    int num_tetrahedra;
    double shortest_edge; ///< of the mean
};

void PrintTo(const CanonicalBody &body, std::ostream *stream) {
    *stream << body.name;
}

class CanonicalLiver : public testing::TestWithParam<CanonicalBody> {
  protected:
    core::TetraMesh mesh_ = read_msh(committed_meshes / (GetParam().name + ".msh"));
};

INSTANTIATE_TEST_SUITE_P(Bodies, CanonicalLiver,
                         testing::Values(CanonicalBody{"liver_healthy", false, 15806, 0.35},
                                         CanonicalBody{"liver_tumours", true, 19478, 0.25}),
                         [](const auto &info) { return info.param.name; });

TEST_P(CanonicalLiver, IsReproducedByteForByte) {
    const auto file = std::filesystem::path(testing::TempDir()) / (GetParam().name + ".msh");
    write_msh(file, generate_liver({.tumours = GetParam().tumours}));
    EXPECT_TRUE(support::read_text(file) == support::read_text(committed_meshes / file.filename()))
        << "if the generator was meant to change, make the mesh anew with the command in its .toml";
    std::filesystem::remove(file);
}

TEST_P(CanonicalLiver, MeetsItsFigures) {
    const auto figures = mesh_figures(mesh_);
    EXPECT_NEAR(figures.num_tetrahedra, GetParam().num_tetrahedra, 0.005 * GetParam().num_tetrahedra);
    EXPECT_GE(figures.shortest_edge, GetParam().shortest_edge * figures.mean_edge);
    EXPECT_GE(figures.smallest_quality, 0.2);
    EXPECT_NEAR(figures.volume, 1.5e-3, 0.03 * 1.5e-3);
}

TEST_P(CanonicalLiver, HasTheSizeOfAnAdultLiver) {
    const Vector3 extent = mesh_figures(mesh_).extent;
    EXPECT_NEAR(extent.x(), 0.22, 0.015); // left to right
    EXPECT_NEAR(extent.y(), 0.11, 0.013); // front to back
    EXPECT_NEAR(extent.z(), 0.16, 0.015); // top to bottom
}

TEST_P(CanonicalLiver, LiesAroundTheOriginWithItsBulkOnThePatientsRight) {
    const auto volumes = core::tetrahedron_volumes(mesh_);
    Vector3 centroid = Vector3::Zero();
    for (int t = 0; t < mesh_.num_tetrahedra(); ++t)
        for (const int node : mesh_.tetrahedra[t])
            centroid += volumes[t] / 4.0 * mesh_.points[node];
    centroid /= std::accumulate(volumes.begin(), volumes.end(), 0.0);
    EXPECT_LT(centroid.norm(), 0.002);
    const auto [left, right] = std::ranges::minmax(mesh_.points, {}, [](const Vector3 &p) { return p.x(); });
    EXPECT_GT(right.x(), -1.4 * left.x()); // the thin left lobe reaches further from the centroid
}

TEST_P(CanonicalLiver, HasItsCapsuleOnTheLevelSurface) {
    ASSERT_GT(mesh_.num_boundary_triangles(), 1000);
    for (const auto &triangle : mesh_.boundary_triangles)
        for (const int node : triangle)
            ASSERT_LT(std::abs(liver_level(mesh_.points[node])), 1e-8);
}

TEST_P(CanonicalLiver, HasConnectedPatches) {
    std::map<std::array<int, 2>, std::vector<int>> facets_at_edge;
    for (int t = 0; t < mesh_.num_boundary_triangles(); ++t)
        for (int c = 0; c < 3; ++c) {
            const int a = mesh_.boundary_triangles[t][c];
            const int b = mesh_.boundary_triangles[t][(c + 1) % 3];
            facets_at_edge[{std::min(a, b), std::max(a, b)}].push_back(t);
        }
    // Each facet takes the lowest facet number that reaches it within its patch.
    std::vector<int> piece(mesh_.boundary_triangles.size());
    std::iota(piece.begin(), piece.end(), 0);
    for (bool has_changed = true; has_changed;) {
        has_changed = false;
        for (const auto &[edge, facets] : facets_at_edge) {
            ASSERT_EQ(facets.size(), 2u);
            const int lower = std::min(piece[facets[0]], piece[facets[1]]);
            if (mesh_.boundary_patch[facets[0]] != mesh_.boundary_patch[facets[1]] ||
                piece[facets[0]] == piece[facets[1]])
                continue;
            piece[facets[0]] = piece[facets[1]] = lower;
            has_changed = true;
        }
    }
    std::vector<std::set<int>> pieces(mesh_.patch_names.size());
    for (std::size_t t = 0; t < piece.size(); ++t)
        pieces[mesh_.boundary_patch[t]].insert(piece[t]);
    for (std::size_t p = 0; p < pieces.size(); ++p)
        EXPECT_EQ(pieces[p].size(), 1u) << mesh_.patch_names[p];
}

TEST_P(CanonicalLiver, IsConstrainedOverAnEighthToAFifthOfItsSurface) {
    std::map<std::string, double> area;
    double total = 0.0;
    for (int t = 0; t < mesh_.num_boundary_triangles(); ++t) {
        const double facet = core::area_vector(mesh_, t).norm();
        area[mesh_.patch_names[mesh_.boundary_patch[t]]] += facet;
        total += facet;
    }
    EXPECT_GT(area["posterior"], 0.12 * total);
    EXPECT_LT(area["posterior"], 0.20 * total);
}

TEST_P(CanonicalLiver, IsABodyThatCanBeRead) {
    const auto body = read_body(committed_meshes / (GetParam().name + ".toml"));
    ASSERT_EQ(body.materials.size(), GetParam().tumours ? 7u : 1u);
    EXPECT_EQ(body.mesh.region_names.front(), "parenchyma");
    EXPECT_EQ(body.materials.front().young_modulus, 5000.0);
    for (std::size_t r = 1; r < body.materials.size(); ++r)
        EXPECT_EQ(body.materials[r].young_modulus, 50000.0);
}

class TumourLiver : public testing::Test {
  protected:
    /// Nodes of each region.
    std::vector<std::set<int>> nodes_of_regions() const {
        std::vector<std::set<int>> nodes(mesh_.region_names.size());
        for (int t = 0; t < mesh_.num_tetrahedra(); ++t)
            nodes[mesh_.region[t]].insert(mesh_.tetrahedra[t].begin(), mesh_.tetrahedra[t].end());
        return nodes;
    }

    core::TetraMesh mesh_ = read_msh(committed_meshes / "liver_tumours.msh");
};

TEST_F(TumourLiver, HasSixLesionsOfDifferentSizesInBothLobes) {
    const auto nodes = nodes_of_regions();
    ASSERT_EQ(nodes.size(), 7u);
    constexpr double falciform_x = 0.046;
    int num_left = 0;
    double previous = 0.050;
    for (std::size_t r = 1; r < nodes.size(); ++r) {
        double across = 0.0;
        for (const int i : nodes[r])
            for (const int j : nodes[r])
                across = std::max(across, (mesh_.points[i] - mesh_.points[j]).norm());
        EXPECT_LT(across, r == 1 ? previous : 0.9 * previous) << mesh_.region_names[r];
        EXPECT_GT(across, 0.010) << mesh_.region_names[r];
        previous = across;
        num_left += std::ranges::all_of(nodes[r], [&](int i) { return mesh_.points[i].x() > falciform_x; });
    }
    EXPECT_EQ(num_left, 2);
}

TEST_F(TumourLiver, KeepsLesionsApartAndBelowTheCapsule) {
    const auto nodes = nodes_of_regions();
    ASSERT_EQ(nodes.size(), 7u);
    for (std::size_t r = 1; r < nodes.size(); ++r) {
        ASSERT_FALSE(nodes[r].empty());
        for (const int i : nodes[r]) {
            ASSERT_LT(liver_level(mesh_.points[i]), -0.008) << mesh_.region_names[r];
            for (std::size_t other = r + 1; other < nodes.size(); ++other)
                for (const int j : nodes[other])
                    ASSERT_GT((mesh_.points[i] - mesh_.points[j]).norm(), 0.015)
                        << mesh_.region_names[r] << " and " << mesh_.region_names[other];
        }
    }
}

TEST_F(TumourLiver, GivesEachLesionTheVolumeOfItsEllipsoid) {
    const auto volumes = core::tetrahedron_volumes(mesh_);
    std::vector<double> volume(mesh_.region_names.size(), 0.0);
    for (int t = 0; t < mesh_.num_tetrahedra(); ++t)
        volume[mesh_.region[t]] += volumes[t];
    const auto lesions = liver_lesions();
    ASSERT_EQ(volume.size(), lesions.size() + 1);
    for (std::size_t i = 0; i < lesions.size(); ++i) {
        const double expected = 4.0 / 3.0 * M_PI * lesions[i].semi_axes.prod();
        EXPECT_NEAR(volume[i + 1], expected, 1e-6 * expected) << mesh_.region_names[i + 1];
    }
}

TEST_F(TumourLiver, SharesTheNodesOfItsInterfaces) {
    const auto nodes = nodes_of_regions();
    ASSERT_EQ(nodes.size(), 7u);
    for (std::size_t r = 1; r < nodes.size(); ++r) {
        std::vector<std::array<int, 4>> lesion;
        for (int t = 0; t < mesh_.num_tetrahedra(); ++t)
            if (mesh_.region[t] == static_cast<int>(r))
                lesion.push_back(mesh_.tetrahedra[t]);
        const auto faces = core::outer_faces(lesion);
        ASSERT_FALSE(faces.empty());
        for (const auto &face : faces)
            for (const int node : face)
                ASSERT_TRUE(nodes[0].contains(node)) << mesh_.region_names[r];
    }
}

TEST(LiverGenerator, MakesOtherSizesToo) {
    for (const bool tumours : {false, true}) {
        const auto figures = mesh_figures(generate_liver({.tumours = tumours, .target_tetrahedra = 6000}));
        EXPECT_NEAR(figures.num_tetrahedra, 6000, 120);
        EXPECT_NEAR(figures.volume, 1.5e-3, 0.05 * 1.5e-3);
        EXPECT_GT(figures.smallest_quality, 0.0);
    }
}

TEST(LiverGenerator, RefusesSizesThatCannotShowTheAnatomy) {
    EXPECT_THROW(generate_liver({.target_tetrahedra = 100}), support::InputError);
    EXPECT_THROW(generate_liver({.target_tetrahedra = -1}), support::InputError);
    EXPECT_THROW(generate_liver({.target_tetrahedra = 3000000}), support::InputError);
}

TEST(MshWriter, WritesWhatTheReaderReads) {
    const auto mesh = read_msh(committed_meshes / "liver_tumours.msh");
    const auto file = std::filesystem::path(testing::TempDir()) / "written_again.msh";
    write_msh(file, mesh);
    EXPECT_TRUE(support::read_text(file) == support::read_text(committed_meshes / "liver_tumours.msh"));
    const auto again = read_msh(file);
    EXPECT_EQ(again.points, mesh.points);
    EXPECT_EQ(again.tetrahedra, mesh.tetrahedra);
    EXPECT_EQ(again.boundary_patch, mesh.boundary_patch);
    EXPECT_EQ(again.region_names, mesh.region_names);
    std::filesystem::remove(file);
}

TEST(MshWriter, SaysWhichFileCannotBeWritten) {
    core::TetraMesh mesh;
    mesh.points = {Vector3::Zero()};
    tests::expect_input_error([&] { write_msh("/no such folder/body.msh", mesh); }, {"/no such folder/body.msh"});
}

TEST(MshWriter, WritesAFileThatGmshOpens) {
    const std::string command = "gmsh -0 '" + (committed_meshes / "liver_tumours.msh").string() + "' -o '" +
                                testing::TempDir() + "opened.msh' -format msh41";
    if (std::system("gmsh --version >/dev/null 2>&1") != 0)
        GTEST_SKIP() << "the gmsh command is not installed";
    EXPECT_EQ(std::system((command + " >/dev/null 2>&1").c_str()), 0);
    const auto opened = read_msh(testing::TempDir() + "opened.msh");
    EXPECT_EQ(opened.region_names.size(), 7u);
    EXPECT_EQ(opened.patch_names.size(), 7u);
    std::filesystem::remove(testing::TempDir() + "opened.msh");
}

constexpr int num_variants = 24;

TEST(LiverVariation, IsTheSameForTheSameNumberOnly) {
    const auto variant = draw_liver(7);
    EXPECT_EQ(to_text(variant), to_text(draw_liver(7)));
    EXPECT_EQ(variant.volume, draw_liver(7).volume);
    EXPECT_NE(variant.volume, draw_liver(8).volume);
}

TEST(LiverVariation, StaysWithinPublishedAnatomy) {
    std::set<std::size_t> numbers_of_lesions;
    int num_riedel_lobes = 0;
    for (int number = 1; number <= num_variants; ++number) {
        const auto variant = draw_liver(number);
        EXPECT_GE(variant.volume, 0.9e-3) << number;
        EXPECT_LE(variant.volume, 2.2e-3) << number;
        EXPECT_GT(variant.left_part, 0.05) << number;
        EXPECT_LT(variant.left_part, 0.27) << number;
        EXPECT_LE(variant.lesions.size(), 8U) << number;
        numbers_of_lesions.insert(variant.lesions.size());
        num_riedel_lobes += variant.has_riedel_lobe ? 1 : 0;
    }
    EXPECT_GT(numbers_of_lesions.size(), 4U);
    EXPECT_GT(num_riedel_lobes, 0);
}

TEST(LiverVariation, KeepsLesionsApartAndBelowTheCapsule) {
    std::size_t num_lesions = 0;
    for (int number = 1; number <= num_variants; ++number) {
        const auto variant = draw_liver(number);
        num_lesions += variant.lesions.size();
        for (std::size_t i = 0; i < variant.lesions.size(); ++i) {
            const auto &lesion = variant.lesions[i];
            for (int d = 0; d < 3; ++d)
                for (const double side : {-1.0, 1.0})
                    EXPECT_LT(liver_level(lesion.center + side * lesion.semi_axes[d] * lesion.axes[d], variant.shape),
                              -0.008)
                        << number;
            for (std::size_t j = 0; j < i; ++j) {
                const auto &larger = variant.lesions[j];
                EXPECT_GE(larger.semi_axes.prod(), lesion.semi_axes.prod()) << number;
                EXPECT_GT((lesion.center - larger.center).norm(),
                          lesion.semi_axes.maxCoeff() + larger.semi_axes.maxCoeff() + 0.010)
                    << number;
            }
        }
    }
    EXPECT_GT(num_lesions, static_cast<std::size_t>(num_variants));
}

TEST(LiverVariation, MeshesWithItsVolumeLesionsAndAllSevenPatches) {
    for (const int number : {1, 4, 7}) {
        const auto variant = draw_liver(number);
        const auto mesh = generate_liver(variant, 4000);
        const auto figures = mesh_figures(mesh);
        EXPECT_NEAR(figures.volume, variant.volume, 1e-5 * variant.volume) << number;
        EXPECT_GT(figures.smallest_quality, 0.0) << number;
        EXPECT_EQ(mesh.region_names.size(), variant.lesions.size() + 1) << number;
        EXPECT_EQ(std::set<int>(mesh.boundary_patch.begin(), mesh.boundary_patch.end()).size(), 7U) << number;
        const auto again = generate_liver(variant, 4000);
        EXPECT_EQ(again.points, mesh.points) << number;
        EXPECT_EQ(again.tetrahedra, mesh.tetrahedra) << number;
    }
}

TEST(LiverVariation, RefusesANumberThatIsNone) {
    EXPECT_THROW(draw_liver(0), support::InputError);
    EXPECT_THROW(draw_liver(-3), support::InputError);
}

} // namespace
} // namespace livermark::meshes
