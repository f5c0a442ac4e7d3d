#include "meshes/anatomy/liver_patches.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <numbers>

#include "core/mesh/tetra_mesh.hpp"
#include "load_cases/readers/load_case_reader.hpp"
#include "meshes/generators/box_generator.hpp"
#include "meshes/generators/liver_generator.hpp"
#include "meshes/generators/liver_shape.hpp"
#include "meshes/io/body_reader.hpp"
#include "meshes/io/mesh_files.hpp"
#include "tests/bad_input.hpp"
#include "tests/result_folder.hpp"

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
            tests::expect_part(patches->remark, "the confidence is");
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
    tests::expect_part(patches->remark, "which is low");
}

TEST(AnatomicalPatches, OfALiverInTheScannerAreNotTurned) {
    const auto mesh = read_msh(LIVERMARK_SOURCE_DIR "/meshes/liver_healthy.msh");
    EXPECT_LT(fit_liver(mesh).turn(), 0.05);
    EXPECT_NEAR(fit_liver(moved(mesh, {0.0, 0.0, 2.0}, {1.0, 1.0, 1.0})).turn(), 2.0, 0.05);
}

/// Patches that a mesh has named itself share their facets with those that are found.
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
    tests::expect_part(found->remark, "'glued' of the mesh stand beside them");

    mesh.patch_names[1] = "anterior"; // a name of both
    const auto clash = find_anatomical_patches(mesh);
    ASSERT_TRUE(clash);
    EXPECT_EQ(core::facets_in_patch(mesh, "anterior"), glued);
    tests::expect_part(clash->remark, "'anterior' are as the mesh has them");
}

TEST(AnatomicalPatches, LeaveThoseOfTheFileAlone) {
    const auto mesh = read_msh(LIVERMARK_SOURCE_DIR "/meshes/liver_healthy.msh");
    auto same = mesh;
    EXPECT_FALSE(find_anatomical_patches(same));
    EXPECT_EQ(same.boundary_patch, mesh.boundary_patch);
    EXPECT_EQ(same.patch_names, mesh.patch_names);
}

/// Rotations of whole bodies, as rotation vectors: about one axis by 97 degrees, about all, and nearly back to front.
const std::vector<core::Vector3> three_turns{{1.69, 0.0, 0.0}, {0.4, -1.1, 0.7}, {-0.3, 0.5, 2.9}};

Eigen::Matrix3d rotation_by(const core::Vector3 &turn) {
    return Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
}

/// Between the directions of both [degrees].
double apart(const Eigen::Matrix3d &a, const Eigen::Matrix3d &b) {
    return 180.0 / std::numbers::pi * Eigen::AngleAxisd(Eigen::Matrix3d(a.transpose() * b)).angle();
}

class BodyAxesOfFiles : public tests::ResultFolder {
  protected:
    /// A body with this mesh.
    core::Body body_of(const core::TetraMesh &mesh, const std::string &lines) const {
        write_msh(directory_ / "body.msh", mesh);
        auto toml = "mesh = \"body.msh\"\n" + lines + "\n";
        for (const auto &name : mesh.region_names)
            toml += "[regions." + name + "]\ndensity = 1000.0\nyoung_modulus = 5000.0\npoisson_ratio = 0.45\n";
        std::ofstream(directory_ / "body.toml") << toml + image_;
        return read_body(directory_ / "body.toml");
    }

    static core::TetraMesh shipped(const std::string &name) {
        return read_msh(LIVERMARK_SOURCE_DIR "/meshes/" + name + ".msh");
    }

    std::string image_;
};

const core::Vector3 no_stretch(1.0, 1.0, 1.0);

TEST_F(BodyAxesOfFiles, TurnWithBothLiversToWithinHalfADegree) {
    for (const std::string name : {"liver_healthy", "liver_tumours"})
        for (const auto &turn : three_turns) {
            const auto expected = rotation_by(turn);
            const auto found = body_of(moved(plain(shipped(name)), turn, no_stretch), "find_patches = true");
            EXPECT_LT(apart(found.axes.from_lps, expected), 0.5) << name;
            EXPECT_TRUE(found.axes.doubt.empty());
            tests::expect_part(found.assumptions.back(), "directions of load cases turn with it");
            const auto named = body_of(moved(shipped(name), turn, no_stretch), "");
            EXPECT_LT(apart(named.axes.from_lps, expected), 0.5) << name << ", whose file names the patches";
        }
}

TEST_F(BodyAxesOfFiles, AreThoseOfTheMeshWhereTheBodyIsNotTurned) {
    for (const std::string name : {"liver_healthy", "liver_tumours", "beam"}) {
        const auto body = read_body(LIVERMARK_SOURCE_DIR "/meshes/" + name + ".toml");
        EXPECT_EQ(body.axes.from_lps, Eigen::Matrix3d::Identity()) << name;
        EXPECT_TRUE(body.axes.doubt.empty());
        EXPECT_TRUE(body.assumptions.empty());
    }
    const auto found = body_of(plain(shipped("liver_healthy")), "find_patches = true");
    EXPECT_EQ(found.axes.from_lps, Eigen::Matrix3d::Identity());
    for (const int variant : {1, 5, 9, 13, 17, 21}) {
        auto liver = draw_liver(variant);
        liver.lesions.clear();
        const auto body = body_of(generate_liver(liver, 4000), "");
        EXPECT_EQ(body.axes.from_lps, Eigen::Matrix3d::Identity()) << variant;
        EXPECT_TRUE(body.assumptions.empty()) << variant << ": " << body.assumptions.front();
    }
}

TEST_F(BodyAxesOfFiles, AreInDoubtWhereTheHeaderSaysOtherwise) {
    image_ = "[image]\nname = \"liver.nii.gz\"\nspacing = [0.001, 0.001, 0.001]\norientation = \"LPS\"\n";
    const auto turned = moved(plain(shipped("liver_healthy")), three_turns[0], no_stretch);
    const auto body = body_of(turned, "find_patches = true");
    tests::expect_part(body.axes.doubt,
                       "the header of its file says LPS, where its shape is found turned by 97 degrees");
    const auto breathing = std::filesystem::path(LIVERMARK_SOURCE_DIR "/load_cases/breathing.toml");
    tests::expect_input_error([&] { load_cases::read_load_case(breathing, body); },
                              {"breathing.toml:", "the header of its file says LPS", "--picture patches.png"});
    EXPECT_NO_THROW(load_cases::read_load_case(LIVERMARK_SOURCE_DIR "/load_cases/palpation.toml", body));
    const auto decided = body_of(turned, "find_patches = true\naxes = \"registered\"");
    EXPECT_LT(apart(decided.axes.from_lps, rotation_by(three_turns[0])), 0.5);
    EXPECT_TRUE(load_cases::read_load_case(breathing, decided).press_depth > 0.0);
    const auto agrees =
        body_of(moved(plain(shipped("liver_healthy")), {0.0, 0.0, 0.4}, no_stretch), "find_patches = true");
    EXPECT_EQ(agrees.axes.from_lps, Eigen::Matrix3d::Identity());
    tests::expect_part(agrees.assumptions.back(), "in LPS, as the header of its file says");
}

TEST_F(BodyAxesOfFiles, AreInDoubtWhereTheShapeFitsTwoWays) {
    const auto body = body_of(plain(generate_box({0.2, 0.15, 0.1}, 0.02)), "find_patches = true");
    tests::expect_part(body.axes.doubt, "another orientation fits its shape about as well");
    for (const std::string load_case : {"breathing", "traction", "gravity_tilt", "retraction"})
        tests::expect_input_error(
            [&] { load_cases::read_load_case(LIVERMARK_SOURCE_DIR "/load_cases/" + load_case + ".toml", body); },
            {"its directions are those of the patient", "`livermark mesh check BODY --picture patches.png`"});
}

TEST_F(BodyAxesOfFiles, AreWhatTheTomlSays) {
    const auto mesh = generate_box({0.2, 0.15, 0.1}, 0.05);
    Eigen::Matrix3d back_to_front = Eigen::Matrix3d::Identity(), quarter;
    back_to_front.diagonal() << -1.0, -1.0, 1.0;
    quarter << 0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0;
    EXPECT_EQ(body_of(mesh, "axes = \"RAS\"").axes.from_lps, back_to_front);
    EXPECT_EQ(body_of(mesh, "axes = \"ALS\"").axes.from_lps, quarter);
    EXPECT_EQ(body_of(mesh, "axes = [[0, 1, 0], [-1, 0, 0], [0, 0, 1]]").axes.from_lps, quarter);
    EXPECT_EQ(body_of(mesh, "axes = \"LPS\"").axes.from_lps, Eigen::Matrix3d::Identity());
    EXPECT_FALSE(body_of(mesh, "axes = \"unknown\"").axes.doubt.empty());
    for (const auto *mirror_or_nonsense : {"\"LAS\"", "\"LLS\"", "\"up\"", "[[1, 0, 0], [0, 1, 0], [0, 0, 2]]", "7"})
        tests::expect_input_error([&] { body_of(mesh, std::string("axes = ") + mirror_or_nonsense); },
                                  {"body.toml:2", "'axes' has to be three letters"});
    const auto fits_four_ways = plain(generate_box({0.2, 0.15, 0.1}, 0.02));
    for (const auto &[word, backwards] : {std::pair{"LPS", 1.0}, {"RAS", -1.0}}) {
        const auto lying = body_of(fits_four_ways, std::string("find_patches = true\naxes = \"") + word + "\"");
        core::Vector3 area = core::Vector3::Zero();
        for (int f = 0; f < lying.mesh.num_boundary_triangles(); ++f)
            if (lying.mesh.patch_names[lying.mesh.boundary_patch[f]] == "posterior")
                area += core::area_vector(lying.mesh, f);
        EXPECT_GT(backwards * area.normalized().y(), 0.4) << word;
    }
    const auto turned = body_of(mesh, "axes = [[0.6, 0.8, 0], [-0.8, 0.6, 0], [0, 0, 1]]");
    const auto written = body_of(mesh, axes_toml(turned.axes));
    EXPECT_LT((written.axes.from_lps - turned.axes.from_lps).norm(), 1e-12);
}

} // namespace
} // namespace livermark::meshes
