#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>
#include <regex>
#include <string>
#include <thread>

#include "core/support/files.hpp"
#include "meshes/generators/surface_mesh.hpp"
#include "meshes/io/mesh_checks.hpp"
#include "results/hdf5/result_file.hpp"
#include "tests/bad_input.hpp"
#include "tests/child.hpp"
#include "tests/result_folder.hpp"

namespace livermark {
namespace {

namespace fs = std::filesystem;
using core::Vector3;

/// A field at a place, from the tetrahedron in which it lies deepest, or outside of the body least far.
Vector3 field_at(const core::TetraMesh &mesh, const std::vector<Vector3> &field, const Vector3 &place) {
    double deepest = -INFINITY;
    Vector3 value = Vector3::Zero();
    for (const auto &t : mesh.tetrahedra) {
        std::array<Vector3, 4> corner;
        for (std::size_t c = 0; c < 4; ++c)
            corner.at(c) = mesh.points[static_cast<std::size_t>(t.at(c))];
        if ((corner[0] - place).squaredNorm() > 0.03 * 0.03)
            continue;
        const double volume = core::signed_volume(corner[0], corner[1], corner[2], corner[3]);
        std::array<double, 4> weight{};
        for (std::size_t c = 0; c < 4; ++c) {
            auto moved = corner;
            moved.at(c) = place;
            weight.at(c) = core::signed_volume(moved[0], moved[1], moved[2], moved[3]) / volume;
        }
        if (const double depth = *std::ranges::min_element(weight); depth > deepest) {
            deepest = depth;
            value.setZero();
            for (std::size_t c = 0; c < 4; ++c)
                value += weight.at(c) * field[static_cast<std::size_t>(t.at(c))];
        }
    }
    return value;
}

const core::Solution &reference_of(const results::Result &result) {
    return std::ranges::find(result.models, result.reference_uncertainty->reference, &results::ModelResult::name)
        ->solution;
}

/// Size of the whole force that holds the body [N].
double constrained_force(const results::Result &result) {
    Vector3 sum = Vector3::Zero();
    for (const auto &reaction : reference_of(result).reaction)
        sum += reaction;
    return sum.norm();
}

std::vector<Vector3> carried(const core::TetraMesh &from, const std::vector<Vector3> &field,
                             const core::TetraMesh &to) {
    std::vector<Vector3> result;
    for (const auto &place : to.points)
        result.push_back(field_at(from, field, place));
    return result;
}

/// Relative L2 distance of two fields at the nodes of a mesh.
double distance(const core::TetraMesh &mesh, const std::vector<Vector3> &field, const std::vector<Vector3> &expected) {
    const auto volumes = core::nodal_volumes(mesh);
    double apart = 0.0, size = 0.0;
    for (std::size_t i = 0; i < volumes.size(); ++i) {
        apart += volumes[i] * (field[i] - expected[i]).squaredNorm();
        size += volumes[i] * expected[i].squaredNorm();
    }
    return std::sqrt(apart / size);
}

/// Distance of the references, over the nodes of the second result.
double distance(const results::Result &from, const results::Result &to) {
    const auto &mesh = to.problem.body->mesh;
    return distance(mesh, reference_of(to).displacement,
                    carried(from.problem.body->mesh, reference_of(from).displacement, mesh));
}

/// Error of a field on its way from the nodes of one mesh to those of the other: half of what it loses there and
/// back.
double interpolation_error(const results::Result &from, const results::Result &to) {
    const auto &mesh = to.problem.body->mesh, &other = from.problem.body->mesh;
    const auto &field = reference_of(to).displacement;
    return 0.5 * distance(mesh, carried(other, carried(mesh, field, other), mesh), field);
}

/// The liver with tumours as it ships, but for its patches: their names are changed, so that the rules find them anew.
void write_direct_body(const fs::path &folder) {
    const fs::path meshes = LIVERMARK_SOURCE_DIR "/meshes";
    std::ofstream(folder / "direct.msh") << std::regex_replace(support::read_text(meshes / "liver_tumours.msh"),
                                                               std::regex("\n2 (\\d+) \""), "\n2 $1 \"drawn_");
    auto toml = support::read_text(meshes / "liver_tumours.toml");
    toml.erase(toml.find("[patches"));
    std::ofstream(folder / "direct.toml")
        << std::regex_replace(toml, std::regex("mesh = .*"), "mesh = \"direct.msh\"\nfind_patches = true");
}

TEST(WholeWay, FromAnImageWithVesselsToABodyWithTheirRegions) {
    const auto folder = fs::path(testing::TempDir()) / "livermark_vessels";
    fs::remove_all(folder);
    fs::create_directories(folder);
    const auto livermark = [&](std::vector<std::string> words) {
        words.insert(words.begin(), LIVERMARK_BINARY);
        return tests::run_child(words, {.folder = folder});
    };
    EXPECT_EQ(livermark({"mesh", "--phantom", "--vessels", "--spacing", "0.0015", "0.0015", "0.003", "-o", "seg.nrrd"})
                  .status,
              0);
    const auto made = livermark(
        {"mesh", "--labels", "seg.nrrd", "--tetrahedra", "40000", "--role", "Tumour 6=cyst", "-o", "seg.msh"});
    EXPECT_EQ(made.status, 0) << made.errors;
    EXPECT_NE(made.errors.find("8 'Hepatic vein' in the liver are thinner than"), std::string::npos) << made.errors;
    const auto text = support::read_text(folder / "seg.toml");
    for (const char *region : {"parenchyma", "tumour_5", "cyst_1", "vessel_hepatic", "vessel_portal"})
        EXPECT_NE(text.find(fmt::format("[regions.{}]", region)), std::string::npos) << region;
    EXPECT_EQ(text.find("[regions.tumour_6]"), std::string::npos);
    EXPECT_NE(text.find("10.1016/j.jbiomech.2011.03.029"), std::string::npos) << "the source of the vessels' modulus";
    EXPECT_NE(text.find("surface_from_voxels"), std::string::npos);
}

TEST(WholeWay, FromAnImageToDisplacementsAgreesWithTheMeshOfTheSameShape) {
    const auto folder = fs::path(testing::TempDir()) / "livermark_whole_way";
    fs::remove_all(folder);
    fs::create_directories(folder);
    write_direct_body(folder);
    const auto livermark = [&](std::vector<std::string> words) {
        words.insert(words.begin(), LIVERMARK_BINARY);
        const auto end = tests::run_child(words, {.folder = folder});
        EXPECT_EQ(end.status, 0) << end.errors;
    };
    livermark({"mesh", "--phantom", "-o", "phantom.nii.gz"});
    livermark({"run", "--body", "phantom.nii.gz", "direct.toml", "--load-case", "gravity_tilt", "traction", "--model",
               "lloyd", "--output", "runs"});
    for (const char *load_case : {"gravity_tilt.h5", "traction.h5"}) {
        SCOPED_TRACE(load_case);
        const auto scanned = results::read_result(folder / "runs" / "phantom" / load_case);
        const auto direct = results::read_result(folder / "runs" / "direct" / load_case);
        EXPECT_TRUE(scanned.problem.body->assumptions.front().starts_with("made of the segmentation phantom.nii.gz"));
        EXPECT_TRUE(scanned.problem.body->assumptions.back().starts_with("the body is in LPS, as the header of its "
                                                                         "file says"))
            << scanned.problem.body->assumptions.back();
        const double volume = meshes::mesh_figures(direct.problem.body->mesh).volume;
        // Facets cut the corners of a round shape, and bending goes with the third power of how thick a lobe is; what
        // is pulled ends where a facet ends.
        const double geometric =
            3.0 * std::abs(meshes::mesh_figures(scanned.problem.body->mesh).volume / volume - 1.0) +
            std::abs(constrained_force(scanned) / constrained_force(direct) - 1.0);
        const double uncertainty =
            scanned.reference_uncertainty->relative_l2 + direct.reference_uncertainty->relative_l2;
        const double interpolation = interpolation_error(direct, scanned);
        const double apart = distance(direct, scanned);
        EXPECT_LT(apart, uncertainty + geometric + interpolation);
        RecordProperty(fmt::format("{}_percent", load_case),
                       fmt::format("{:.2f} of {:.2f} + {:.2f} + {:.2f}", 100.0 * apart, 100.0 * uncertainty,
                                   100.0 * geometric, 100.0 * interpolation));
        fmt::print("{}: {:.2f} % apart, uncertainty {:.2f} %, geometry {:.2f} %, interpolation {:.2f} %\n", load_case,
                   100.0 * apart, 100.0 * uncertainty, 100.0 * geometric, 100.0 * interpolation);
    }
}

} // namespace
} // namespace livermark

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

TEST_F(MadeAgain, TheSameCommandLeavesTheBodyAndAnotherIsRefusedUnlessForced) {
    write_ball("liver.off", 70.0, 0.0);
    const std::vector<std::string> command{"mesh", "--surfaces", "liver.off", "--tetrahedra", "2000", "-o", "a.msh"};
    auto end = livermark(command);
    ASSERT_EQ(end.status, 0) << end.output << end.errors;
    std::ofstream(directory_ / "a.toml", std::ios::app) << "# my material\n";
    end = livermark(command);
    EXPECT_EQ(end.status, 0) << end.errors;
    tests::expect_part(end.errors, "a.toml exists already, made by the same command");
    tests::expect_part(support::read_text(directory_ / "a.toml"), "# my material");
    auto other = command;
    other[4] = "3000";
    end = livermark(other);
    EXPECT_EQ(end.status, 2);
    tests::expect_part(end.errors, "made by another command; give --force to overwrite it");
    other.emplace_back("--force");
    end = livermark(other);
    EXPECT_EQ(end.status, 0) << end.errors;
    EXPECT_EQ(support::read_text(directory_ / "a.toml").find("# my material"), std::string::npos);
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
    tests::expect_part(end.errors, "liver.off has changed since; give --force to make it again");
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
    tests::expect_part(run("b/liver.off").errors, "liver.toml has other content than b/liver.off");
    EXPECT_EQ(num_bodies(), 2);
    tests::expect_part(run("a/liver.off").errors, "runs/liver.toml is used for a/liver.off");
    tests::expect_part(run("b/liver.off").errors, "is used for b/liver.off");
    EXPECT_EQ(num_bodies(), 2);
    fs::rename(directory_ / "a" / "liver.off", directory_ / "liver.off");
    tests::expect_part(run("liver.off").errors, "runs/liver.toml is used for liver.off");
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
    tests::expect_part(run_with(9.0), "runs/liver.toml is used for liver.nhdr");
    tests::expect_part(run_with(8.0), "liver.toml has other content than liver.nhdr");
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
    tests::expect_part(end.output, "liver: L2");
    const auto body = support::read_text(directory_ / "runs" / "liver.toml");
    tests::expect_part(body, "[regions.tumour_1]");
    tests::expect_part(
        body, "coordinates are assumed to be in mm, from its longest side, which is then 14 cm, and its volume");
    EXPECT_TRUE(fs::exists(directory_ / "runs" / "liver" / "pressed.h5"));
    end = livermark(command);
    EXPECT_EQ(end.status, 0) << end.errors;
    tests::expect_part(end.errors, "is used for liver.off; --force meshes it again");
}

class EndedProgram : public tests::ResultFolder {};

/// Whether the program that makes bodies works on a file.
bool is_segmenting(const std::string &file) {
    std::error_code error;
    return std::ranges::any_of(fs::directory_iterator("/proc", error), [&](const fs::directory_entry &process) {
        std::ifstream stream(process.path() / "cmdline");
        std::string words;
        std::getline(stream, words); // of a process that ends meanwhile, an iterator of the buffer would throw
        return words.find("livermark-segment") != std::string::npos && words.find(file) != std::string::npos;
    });
}

/// As by `kill`, a time limit or a shell that is closed, of which only the program that was started hears.
TEST_F(EndedProgram, EndsTheOneThatItHasStarted) {
    const auto image = (directory_ / "phantom.nii.gz").string();
    const auto made =
        tests::run_child({LIVERMARK_BINARY, "mesh", "--phantom", "--spacing", "0.004", "0.004", "0.004", "-o", image},
                         {.folder = directory_});
    ASSERT_EQ(made.status, 0) << made.errors;
    for (const int signal : {SIGTERM, SIGHUP, SIGKILL}) {
        SCOPED_TRACE(signal);
        const auto end = tests::run_child(
            {LIVERMARK_BINARY, "mesh", "--labels", image, "--tetrahedra", "200000", "-o", "body.msh"},
            {.folder = directory_, .killed_when = [&] { return is_segmenting(image); }, .kill_signal = signal});
        EXPECT_EQ(end.signal, signal) << end.errors;
        const auto limit = std::chrono::steady_clock::now() + std::chrono::seconds(20);
        while (is_segmenting(image) && std::chrono::steady_clock::now() < limit)
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
        EXPECT_FALSE(is_segmenting(image));
        EXPECT_FALSE(fs::exists(directory_ / "body.msh"));
    }
}

} // namespace
} // namespace livermark::segmentation
