#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>

#include "meshes/generators/surface_mesh.hpp"
#include "support/whole_file.hpp"
#include "tests/child.hpp"
#include "tests/result_folder.hpp"

namespace livermark::segmentation {
namespace {

namespace fs = std::filesystem;

/// Balls as OFF [mm].
class MadeAgain : public tests::ResultFolder {
  protected:
    void write_ball(const std::string &name, double radius, double x) const {
        auto ball = meshes::geodesic_sphere(8);
        std::ofstream stream(directory_ / name);
        stream << fmt::format("OFF\n{} {} 0\n", ball.points.size(), ball.triangles.size());
        for (const auto &p : ball.points)
            stream << fmt::format("{} {} {}\n", x + radius * p.x(), radius * p.y(), radius * p.z());
        for (const auto &t : ball.triangles)
            stream << fmt::format("3 {} {} {}\n", t[0], t[1], t[2]);
    }

    /// A load without a direction: nobody knows how a ball lies in a patient.
    void write_pressed_case() const {
        std::ofstream(directory_ / "pressed.toml")
            << "title = \"pressed\"\ntarget_peak_displacement = 0.001\n[[condition]]\npatch = \"right_lateral\"\n"
               "displacement = [0.0, 0.0, 0.0]\n[[condition]]\npatch = \"left_lobe_tip\"\npressure = 10.0\n";
    }

    tests::ChildEnd livermark(std::vector<std::string> words) const {
        words.insert(words.begin(), LIVERMARK_BINARY);
        return tests::run_child(words, {.folder = directory_});
    }
};

bool has(const std::string &text, const std::string &part) {
    return text.find(part) != std::string::npos;
}

TEST_F(MadeAgain, TheSameCommandLeavesTheBodyAndAnotherIsRefusedUnlessForced) {
    write_ball("liver.off", 70.0, 0.0);
    const std::vector<std::string> command{"mesh", "--surfaces", "liver.off", "--tetrahedra", "2000", "-o", "a.msh"};
    auto end = livermark(command);
    ASSERT_EQ(end.status, 0) << end.output << end.errors;
    std::ofstream(directory_ / "a.toml", std::ios::app) << "# my material\n";
    end = livermark(command);
    EXPECT_EQ(end.status, 0) << end.errors;
    EXPECT_TRUE(has(end.errors, "a.toml exists already, made by the same command")) << end.errors;
    EXPECT_TRUE(has(support::read_text(directory_ / "a.toml"), "# my material"));
    auto other = command;
    other[4] = "3000";
    end = livermark(other);
    EXPECT_EQ(end.status, 2);
    EXPECT_TRUE(has(end.errors, "made by another command; give --force to overwrite it")) << end.errors;
    other.emplace_back("--force");
    end = livermark(other);
    EXPECT_EQ(end.status, 0) << end.errors;
    EXPECT_FALSE(has(support::read_text(directory_ / "a.toml"), "# my material"));
    other.pop_back();
    EXPECT_EQ(livermark(other).status, 0) << "the same command but for --force";
}

TEST_F(MadeAgain, ASurfaceOfAnotherContentIsSaidHoweverOldItsFileIs) {
    write_ball("liver.off", 70.0, 0.0);
    const std::vector<std::string> command{"mesh", "--surfaces", "liver.off", "--tetrahedra", "2000", "-o", "a.msh"};
    ASSERT_EQ(livermark(command).status, 0);
    write_ball("liver.off", 75.0, 0.0);
    fs::last_write_time(directory_ / "liver.off",
                        fs::last_write_time(directory_ / "a.toml") - std::chrono::seconds(10));
    const auto end = livermark(command);
    EXPECT_EQ(end.status, 2);
    EXPECT_TRUE(has(end.errors, "liver.off has changed since; give --force to make it again")) << end.errors;
}

/// Bodies of a run into one folder are known by what they are made of.
TEST_F(MadeAgain, TwoPatientsWithFilesOfOneNameAreTwoBodies) {
    write_pressed_case();
    const auto run = [&](const std::string &file) {
        const auto end = livermark({"run", "--body", file, "--load-case", "pressed.toml", "--model", "fem_p1",
                                    "--reference-on-mesh", "--output", "runs"});
        EXPECT_EQ(end.status, 0) << end.errors;
        return end;
    };
    const auto num_bodies = [&] {
        return std::ranges::count_if(fs::directory_iterator(directory_ / "runs"), [](const fs::directory_entry &entry) {
            return entry.path().extension() == ".toml" &&
                   fs::exists(fs::path(entry).replace_extension("") / "pressed.h5");
        });
    };
    for (const auto *patient : {"a", "b"})
        fs::create_directories(directory_ / patient);
    write_ball("a/liver.off", 70.0, 0.0);
    write_ball("b/liver.off", 60.0, 0.0);
    run("a/liver.off");
    EXPECT_EQ(num_bodies(), 1);
    EXPECT_TRUE(has(run("b/liver.off").errors, "liver.toml has other content than b/liver.off"));
    EXPECT_EQ(num_bodies(), 2);
    EXPECT_TRUE(has(run("a/liver.off").errors, "runs/liver.toml is used for a/liver.off"));
    EXPECT_TRUE(has(run("b/liver.off").errors, "is used for b/liver.off"));
    EXPECT_EQ(num_bodies(), 2);
    fs::rename(directory_ / "a" / "liver.off", directory_ / "liver.off");
    EXPECT_TRUE(has(run("liver.off").errors, "runs/liver.toml is used for liver.off")) << "the same content";
    write_ball("liver.off", 71.0, 0.0);
    run("liver.off");
    EXPECT_EQ(num_bodies(), 3) << "an edited surface is another body";
}

/// The header stays as it was, and so does all else but the voxels.
TEST_F(MadeAgain, VoxelsInAFileWithASpaceInItsNameAreAPartOfTheBody) {
    write_pressed_case();
    constexpr int side = 24;
    std::ofstream(directory_ / "liver.nhdr")
        << "NRRD0004\ntype: uint8\ndimension: 3\nspace: left-posterior-superior\nsizes: 24 24 24\n"
           "space directions: (8,0,0) (0,8,0) (0,0,8)\nencoding: raw\ndata file: my voxels.raw\n";
    const auto run_with = [&](double radius) {
        std::ofstream voxels(directory_ / "my voxels.raw", std::ios::binary);
        for (int v = 0; v < side * side * side; ++v) {
            const double x = v % side - 11.5, y = v / side % side - 11.5, z = v / (side * side) - 11.5;
            voxels.put(x * x + y * y + z * z < radius * radius ? '\1' : '\0');
        }
        voxels.close();
        const auto end = livermark({"run", "--body", "liver.nhdr", "--load-case", "pressed.toml", "--model", "fem_p1",
                                    "--reference-on-mesh", "--output", "runs"});
        EXPECT_EQ(end.status, 0) << end.errors;
        return end.errors;
    };
    run_with(9.0);
    EXPECT_TRUE(has(run_with(9.0), "runs/liver.toml is used for liver.nhdr"));
    EXPECT_TRUE(has(run_with(8.0), "liver.toml has other content than liver.nhdr"));
}

TEST_F(MadeAgain, SurfacesOfALiverAndALesionGoStraightToTheTable) {
    write_ball("liver.off", 70.0, 0.0);
    write_ball("lesion.off", 20.0, 30.0);
    write_pressed_case();
    const std::vector<std::string> command{"run",          "--body",  "liver.off", "lesion.off",          "--load-case",
                                           "pressed.toml", "--model", "fem_p1",    "--reference-on-mesh", "--output",
                                           "runs"};
    auto end = livermark(command);
    EXPECT_EQ(end.status, 0) << end.errors;
    EXPECT_TRUE(has(end.output, "liver: L2")) << end.output;
    const auto body = support::read_text(directory_ / "runs" / "liver.toml");
    EXPECT_TRUE(has(body, "[regions.tumour_1]"));
    EXPECT_TRUE(
        has(body, "coordinates are assumed to be in mm, from its longest side, which is then 14 cm, and its volume"));
    EXPECT_TRUE(fs::exists(directory_ / "runs" / "liver" / "pressed.h5"));
    end = livermark(command);
    EXPECT_EQ(end.status, 0) << end.errors;
    EXPECT_TRUE(has(end.errors, "is used for liver.off; --force meshes it again")) << end.errors;
}

} // namespace
} // namespace livermark::segmentation
