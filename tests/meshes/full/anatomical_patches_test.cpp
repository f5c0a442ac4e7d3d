#include "meshes/anatomy/anatomical_patches.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

#include "core/mesh/patches.hpp"
#include "meshes/anatomy/liver_registration.hpp"
#include "meshes/generators/box_generator.hpp"
#include "meshes/generators/liver/liver_generator.hpp"
#include "meshes/generators/liver/liver_variation.hpp"
#include "meshes/io/msh_reader.hpp"

namespace livermark::meshes {
namespace {

/// Part of the area that is in a patch in both meshes, of that which is in it in either.
double overlap(const core::TetraMesh &a, const core::TetraMesh &b, const std::string &patch) {
    double both = 0.0, either = 0.0;
    for (int f = 0; f < a.num_boundary_triangles(); ++f) {
        const bool in_a = a.patch_names[a.boundary_patch[f]] == patch;
        const bool in_b = b.patch_names[b.boundary_patch[f]] == patch;
        const double area = core::area_vector(a, f).norm();
        both += in_a && in_b ? area : 0.0;
        either += in_a || in_b ? area : 0.0;
    }
    return both / either;
}

/// Without names for the parts of its boundary.
core::TetraMesh plain(core::TetraMesh mesh) {
    mesh.patch_names = {"surface"};
    std::ranges::fill(mesh.boundary_patch, 0);
    return mesh;
}

/// Turned, and longer or shorter along the axes that it then has.
core::TetraMesh moved(core::TetraMesh mesh, const core::Vector3 &turn, const core::Vector3 &stretch) {
    Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
    if (turn.norm() > 0.0)
        rotation = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
    for (auto &point : mesh.points)
        point = stretch.asDiagonal() * (rotation * point) + core::Vector3(0.3, -0.2, 0.1);
    return mesh;
}

/// The generator knows the anatomy.
TEST(AnatomicalPatches, AreThoseOfTheGeneratorInEveryOrientation) {
    for (const std::string name : {"liver_healthy", "liver_tumours"}) {
        const auto mesh = read_msh(LIVERMARK_SOURCE_DIR "/meshes/" + name + ".msh");
        for (const auto &[turn, stretch] : {std::pair{core::Vector3(0.0, 0.0, 0.0), core::Vector3(1.0, 1.0, 1.0)},
                                            {core::Vector3(0.0, 0.0, 3.1), core::Vector3(1.0, 1.0, 1.0)},
                                            {core::Vector3(1.0, 2.0, 0.5), core::Vector3(1.0, 1.0, 1.0)},
                                            {core::Vector3(0.0, 0.0, 0.0), core::Vector3(0.9, 1.2, 1.0)},
                                            {core::Vector3(-2.0, 0.3, 1.5), core::Vector3(1.1, 0.9, 1.15)}}) {
            auto found = moved(plain(mesh), turn, stretch);
            const auto patches = find_anatomical_patches(found);
            ASSERT_TRUE(patches);
            EXPECT_NE(patches->remark.find("the confidence is"), std::string::npos) << patches->remark;
            for (const auto &patch : mesh.patch_names)
                EXPECT_GT(overlap(mesh, found, patch), 0.8) << name << " " << patch << ": " << patches->remark;
        }
    }
}

/// The odd variants do as well, but take time.
class OtherLiver : public testing::TestWithParam<int> {};

TEST_P(OtherLiver, HasThePatchesOfTheGeneratorInAnyOrientation) {
    auto variant = draw_liver(GetParam());
    variant.lesions.clear(); // which no patch depends on
    const auto mesh = generate_liver(variant);
    const double angle = GetParam();
    auto found = moved(plain(mesh), angle * core::Vector3(0.6, -0.5, 0.3), core::Vector3(1.0, 1.0, 1.0));
    const auto patches = find_anatomical_patches(found);
    ASSERT_TRUE(patches);
    EXPECT_EQ(patches->remark.find("which is low"), std::string::npos) << patches->remark;
    for (const auto &patch : mesh.patch_names)
        EXPECT_GT(overlap(mesh, found, patch), 0.8) << patch << ": " << patches->remark;
    EXPECT_GT(patches->confidence, 0.5) << patches->remark;
}

INSTANTIATE_TEST_SUITE_P(AnatomicalPatches, OtherLiver, testing::Values(2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24));

/// Bent as no liver of the generator is, and folded.
core::TetraMesh crooked(core::TetraMesh mesh) {
    for (auto &p : mesh.points) {
        p.z() += 2.5 * p.x() * p.x() - 0.006 * std::sin(60.0 * p.y());
        p.y() += 0.008 * std::cos(50.0 * p.x()) + 0.3 * p.z();
    }
    return mesh;
}

TEST(AnatomicalPatches, OfACrookedLiverAreTheSameInEveryOrientation) {
    const auto mesh = crooked(plain(read_msh(LIVERMARK_SOURCE_DIR "/meshes/liver_tumours.msh")));
    auto first = mesh;
    find_anatomical_patches(first);
    EXPECT_EQ(first.patch_names.size(), 7U);
    auto again = mesh;
    find_anatomical_patches(again);
    EXPECT_EQ(again.boundary_patch, first.boundary_patch);
    for (int turn = 1; turn <= 8; ++turn) {
        auto turned =
            moved(mesh, core::Vector3(1.3 * turn, 2.1 - turn, 0.2 * turn * turn), core::Vector3(1.0, 1.0, 1.0));
        find_anatomical_patches(turned);
        for (const auto &patch : first.patch_names)
            EXPECT_GT(overlap(first, turned, patch), 0.99) << patch << " in turn " << turn;
    }
}

/// Left lobes may be shorter than any of the generator's.
TEST(AnatomicalPatches, AreAllThereOnALiverWithAShortLeftLobe) {
    const auto mesh = read_msh(LIVERMARK_SOURCE_DIR "/meshes/liver_healthy.msh");
    for (const double part : {0.7, 0.5, 0.3}) {
        auto found = plain(mesh);
        constexpr double kept = 0.05; // [m]
        for (auto &point : found.points)
            point.x() = std::min(point.x(), kept + part * (point.x() - kept));
        const auto patches = find_anatomical_patches(found);
        ASSERT_TRUE(patches);
        EXPECT_EQ(found.patch_names.size(), 7U) << part << ": " << patches->remark;
        EXPECT_LT(fit_liver(found).turn(), 0.5) << part;
        double tip = 0.0, all = 0.0, reach = 0.0;
        for (int f = 0; f < found.num_boundary_triangles(); ++f) {
            const double area = core::area_vector(found, f).norm();
            const bool is_tip = found.patch_names[found.boundary_patch[f]] == "left_lobe_tip";
            all += area;
            tip += is_tip ? area : 0.0;
            for (const int node : found.boundary_triangles[f])
                reach = std::max(reach, is_tip ? found.points[node].x() : 0.0);
        }
        EXPECT_GT(tip / all, 0.02) << part;
        double end = 0.0;
        for (const auto &point : found.points)
            end = std::max(end, point.x());
        EXPECT_EQ(reach, end) << part << ": the tip is not at the end of the lobe";
    }
}

TEST(AnatomicalPatches, OfABodyThatFitsTwoWaysHaveNoConfidence) {
    auto box = plain(generate_box({0.2, 0.15, 0.1}, 0.02));
    const auto patches = find_anatomical_patches(box);
    ASSERT_TRUE(patches);
    EXPECT_NE(patches->remark.find("which is low"), std::string::npos) << patches->remark;
}

TEST(AnatomicalPatches, OfALiverInTheScannerAreNotTurned) {
    const auto mesh = read_msh(LIVERMARK_SOURCE_DIR "/meshes/liver_healthy.msh");
    EXPECT_LT(fit_liver(mesh).turn(), 0.05);
    EXPECT_NEAR(fit_liver(moved(mesh, {0.0, 0.0, 2.0}, {1.0, 1.0, 1.0})).turn(), 2.0, 0.05);
}

/// What a mesh has named itself shares its facets with what is found.
TEST(AnatomicalPatches, StandBesideThoseOfTheFile) {
    auto mesh = plain(read_msh(LIVERMARK_SOURCE_DIR "/meshes/liver_healthy.msh"));
    auto alone = mesh;
    ASSERT_TRUE(find_anatomical_patches(alone));
    mesh.patch_names.emplace_back("glued");
    std::vector<int> glued;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (mesh.points[mesh.boundary_triangles[f][0]].z() < -0.02) {
            mesh.boundary_patch[f] = 1;
            glued.push_back(f);
        }
    auto both = mesh;
    const auto found = find_anatomical_patches(both);
    ASSERT_TRUE(found);
    EXPECT_EQ(core::facets_in_patch(both, "glued"), glued);
    for (const auto &patch : alone.patch_names)
        EXPECT_EQ(core::facets_in_patch(both, patch), core::facets_in_patch(alone, patch)) << patch;
    EXPECT_NE(found->remark.find("'glued' of the mesh stand beside them"), std::string::npos) << found->remark;

    mesh.patch_names[1] = "anterior"; // a name of both
    const auto clash = find_anatomical_patches(mesh);
    ASSERT_TRUE(clash);
    EXPECT_EQ(core::facets_in_patch(mesh, "anterior"), glued);
    EXPECT_NE(clash->remark.find("'anterior' are as the mesh has them"), std::string::npos) << clash->remark;
}

TEST(AnatomicalPatches, LeaveThoseOfTheFileAlone) {
    const auto mesh = read_msh(LIVERMARK_SOURCE_DIR "/meshes/liver_healthy.msh");
    auto same = mesh;
    EXPECT_FALSE(find_anatomical_patches(same));
    EXPECT_EQ(same.boundary_patch, mesh.boundary_patch);
    EXPECT_EQ(same.patch_names, mesh.patch_names);
}

} // namespace
} // namespace livermark::meshes
