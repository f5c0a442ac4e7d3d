#include <cmath>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "meshes/generators/surface_mesh.hpp"
#include "meshes/io/mesh_files.hpp"
#include "meshes/segmentation/surfaces/surface_file.hpp"
#include "tests/bad_input.hpp"
#include "tests/child.hpp"
#include "tests/result_folder.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark::segmentation {
namespace {

namespace fs = std::filesystem;

class SurfaceFile : public tests::ResultFolder {
  protected:
    struct Read {
        meshes::SurfaceMesh surface;
        std::vector<std::string> remarks;
    };

    Read read(const std::string &name) const {
        Read result;
        result.surface = read_surface(directory_ / name, result.remarks);
        return result;
    }

    void expect_refused(const std::string &name, const std::string &part) const {
        tests::expect_input_error([&] { read(name); }, {part});
    }
};

meshes::SurfaceMesh ball_surface(double radius, const core::Vector3 &centre = {0.0, 0.0, 0.0}) {
    auto surface = meshes::geodesic_sphere(12);
    for (auto &point : surface.points)
        point = centre + radius * point;
    return surface;
}

void write_stl(const fs::path &file, const meshes::SurfaceMesh &surface, std::size_t from = 0) {
    std::ofstream stream(file);
    stream << "solid s\n";
    for (std::size_t t = from; t < surface.triangles.size(); ++t) {
        stream << "facet normal 0 0 0\nouter loop\n";
        for (const int corner : surface.triangles[t]) {
            const auto &p = surface.points[static_cast<std::size_t>(corner)];
            stream << fmt::format("vertex {} {} {}\n", p.x(), p.y(), p.z());
        }
        stream << "endloop\nendfacet\n";
    }
    stream << "endsolid s\n";
}

void write_obj(const fs::path &file, const meshes::SurfaceMesh &surface) {
    std::ofstream stream(file);
    for (const auto &p : surface.points)
        stream << fmt::format("v {} {} {}\n", p.x(), p.y(), p.z());
    for (const auto &t : surface.triangles)
        stream << fmt::format("f {} {} {}\n", t[0] + 1, t[2] + 1, t[1] + 1); // inside out
}

void write_ply(const fs::path &file, const meshes::SurfaceMesh &surface) {
    std::ofstream stream(file);
    stream << fmt::format(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty double z\n"
        "element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        surface.points.size(), surface.triangles.size());
    for (const auto &p : surface.points)
        stream << fmt::format("{} {} {}\n", p.x(), p.y(), p.z());
    for (const auto &t : surface.triangles)
        stream << fmt::format("3 {} {} {}\n", t[0], t[1], t[2]);
}

TEST_F(SurfaceFile, MayBeStlObjOrPly) {
    const auto surface = ball_surface(50.0);
    write_stl(directory_ / "a.stl", surface);
    write_obj(directory_ / "a.obj", surface);
    write_ply(directory_ / "a.ply", surface);
    for (const char *name : {"a.stl", "a.obj", "a.ply"}) {
        SCOPED_TRACE(name);
        const auto [back, remarks] = read(name);
        EXPECT_TRUE(remarks.empty());
        EXPECT_EQ(back.points.size(), surface.points.size());
        EXPECT_EQ(back.triangles.size(), surface.triangles.size());
        EXPECT_NEAR(meshes::enclosed_volume(back) / meshes::enclosed_volume(surface), 1.0, 1e-4);
    }
}

TEST_F(SurfaceFile, ThatIsOpenIsRefusedWithThePlace) {
    const auto ball = ball_surface(50.0);
    write_stl(directory_ / "a.stl", ball, ball.triangles.size() / 20);
    expect_refused("a.stl", "is open at (");
}

/// As decimation leaves it.
TEST_F(SurfaceFile, WithSmallHolesIsWrappedAndSaysSo) {
    auto surface = ball_surface(50.0);
    const double volume = meshes::enclosed_volume(surface);
    const auto num_triangles = surface.triangles.size();
    // One corner with all triangles around it, and a triangle elsewhere.
    const int corner = surface.triangles[num_triangles / 2][0];
    surface.triangles.erase(surface.triangles.begin());
    std::erase_if(surface.triangles, [&](const auto &triangle) { return std::ranges::count(triangle, corner) > 0; });
    ASSERT_LT(surface.triangles.size(), num_triangles - 4);
    write_ply(directory_ / "a.ply", surface);
    const auto [closed, remarks] = read("a.ply");
    tests::expect_one(remarks, "the surface is open; CGAL has wrapped it");
    tests::expect_one(remarks, " %, its volume by ");
    EXPECT_NEAR(meshes::enclosed_volume(closed) / volume, 1.0, 0.02);
    write_ply(directory_ / "b.ply", closed);
    EXPECT_TRUE(read("b.ply").remarks.empty()) << "it is still open";
}

/// Its triangles cannot all look outwards: a strip that is turned once and sewn into the surface has one side only.
TEST_F(SurfaceFile, WhoseTrianglesCannotBeTurnedAlikeIsWrapped) {
    auto surface = ball_surface(50.0);
    const double volume = meshes::enclosed_volume(surface);
    // Two neighbours exchange a corner: what was a square between them is crossed.
    auto &a = surface.triangles[100];
    for (auto &b : surface.triangles) {
        const auto num_shared = std::ranges::count_if(b, [&](int n) { return std::ranges::count(a, n) > 0; });
        if (num_shared != 2)
            continue;
        const auto own = [](const auto &of, const auto &other) {
            return std::ranges::find_if(of, [&](int n) { return std::ranges::count(other, n) == 0; });
        };
        b[own(b, a) - b.begin()] = *own(a, b);
        break;
    }
    write_ply(directory_ / "a.ply", surface);
    const auto [closed, remarks] = read("a.ply");
    tests::expect_one(remarks, "CGAL has wrapped it");
    EXPECT_NEAR(meshes::enclosed_volume(closed) / volume, 1.0, 0.02);
}

/// Both in one.
meshes::SurfaceMesh together(meshes::SurfaceMesh surface, const meshes::SurfaceMesh &other, bool inside_out = false) {
    const int first = static_cast<int>(surface.points.size());
    surface.points.insert(surface.points.end(), other.points.begin(), other.points.end());
    for (auto triangle : other.triangles) {
        for (int &corner : triangle)
            corner += first;
        if (inside_out)
            std::swap(triangle[0], triangle[1]);
        surface.triangles.push_back(triangle);
    }
    return surface;
}

TEST_F(SurfaceFile, WithPartsThatCutEachOtherIsTheirUnion) {
    const double radius = 50.0, apart = 30.0;
    write_ply(directory_ / "a.ply", together(ball_surface(radius), ball_surface(radius, {apart, 0.0, 0.0}), true));
    auto [surface, remarks] = read("a.ply");
    tests::expect_one(remarks, "1 parts that cut the largest one are united with it");
    for (auto &point : surface.points)
        point *= 1e-3;
    const double ball = meshes::enclosed_volume(ball_surface(1e-3 * radius));
    // Two caps of this height are in both balls.
    const double h = radius - 0.5 * apart;
    const double lens = 2.0 * std::numbers::pi * h * h * (3.0 * radius - h) / 3.0 * 1e-9;
    EXPECT_NEAR(region_volumes(voxels_within({surface}, 0.8e-3))[0] / (2.0 * ball - lens), 1.0, 0.01);
}

TEST_F(SurfaceFile, LosesCavitiesAndPartsThatAreElsewhere) {
    const auto liver = ball_surface(50.0);
    write_ply(directory_ / "hollow.ply", together(liver, ball_surface(10.0), true));
    write_ply(directory_ / "apart.ply", together(liver, ball_surface(10.0, {80.0, 0.0, 0.0})));
    const auto hollow = read("hollow.ply"), apart = read("apart.ply");
    tests::expect_one(hollow.remarks, "1 surfaces inside, of 0.8 % of the volume in all, become parenchyma");
    tests::expect_one(apart.remarks,
                      "1 parts that do not touch the largest one, of 0.8 % of its volume in all, are left out");
    for (const auto &read : {hollow, apart})
        EXPECT_NEAR(meshes::enclosed_volume(read.surface) / meshes::enclosed_volume(liver), 1.0, 1e-6);
}

TEST_F(SurfaceFile, ThatCutsItselfInOnePlaceIsRepairedAndSaysSo) {
    auto surface = ball_surface(50.0);
    const double volume = meshes::enclosed_volume(surface);
    auto &pulled = surface.points[surface.triangles[100][0]];
    const core::Vector3 aside = (surface.points[surface.triangles[100][1]] - pulled).normalized();
    pulled += 12.0 * aside; // over its neighbours, which are 5 mm away
    write_ply(directory_ / "a.ply", surface);
    const auto [repaired, remarks] = read("a.ply");
    tests::expect_one(remarks, "CGAL has put other triangles there");
    EXPECT_NEAR(meshes::enclosed_volume(repaired) / volume, 1.0, 0.01);
    write_ply(directory_ / "b.ply", repaired);
    EXPECT_TRUE(read("b.ply").remarks.empty()) << "it still cuts itself";
}

TEST_F(SurfaceFile, OfPolygonsIsCutIntoTriangles) {
    std::ofstream(directory_ / "a.obj") << "v 0 0 0\nv 9 0 0\nv 9 9 0\nv 0 9 0\nv 0 0 9\nv 9 0 9\nv 9 9 9\nv 0 9 9\n"
                                           "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
    const auto [surface, remarks] = read("a.obj");
    tests::expect_one(remarks, "6 polygons are cut into triangles");
    EXPECT_NEAR(meshes::enclosed_volume(surface), 729.0, 1e-9);
}

/// VTK's own writers make the files.
TEST_F(SurfaceFile, MayBePolydataInEveryFormOfVtk) {
    const auto surface = ball_surface(50.0);
    write_stl(directory_ / "a.stl", surface);
    std::ofstream(directory_ / "write.py") << R"(
import vtk
reader = vtk.vtkSTLReader()
reader.SetFileName("a.stl")
strips = vtk.vtkStripper()
strips.SetInputConnection(reader.GetOutputPort())
for name, writer, source, calls in [
        ("ascii.vtk", vtk.vtkPolyDataWriter(), reader, [("SetFileTypeToASCII",)]),
        ("binary.vtk", vtk.vtkPolyDataWriter(), reader, [("SetFileTypeToBinary",)]),
        ("old.vtk", vtk.vtkPolyDataWriter(), reader, [("SetFileTypeToBinary",), ("SetFileVersion", 42)]),
        ("strips.vtk", vtk.vtkPolyDataWriter(), strips, [("SetFileTypeToBinary",)]),
        ("ascii.vtp", vtk.vtkXMLPolyDataWriter(), reader, [("SetDataModeToAscii",)]),
        ("inline.vtp", vtk.vtkXMLPolyDataWriter(), reader, [("SetDataModeToBinary",)]),
        ("plain.vtp", vtk.vtkXMLPolyDataWriter(), reader, [("SetDataModeToAppended",), ("SetCompressorTypeToNone",),
                                                           ("SetEncodeAppendedData", 0)]),
        ("appended.vtp", vtk.vtkXMLPolyDataWriter(), reader, [("SetDataModeToAppended",), ("SetHeaderTypeToUInt64",)])]:
    writer.SetFileName(name)
    writer.SetInputConnection(source.GetOutputPort())
    for call, *arguments in calls:
        getattr(writer, call)(*arguments)
    writer.Write()
)";
    const auto end = tests::run_child({"/usr/bin/python3", "write.py"}, {.folder = directory_});
    ASSERT_EQ(end.status, 0) << end.errors;
    for (const char *name :
         {"ascii.vtk", "binary.vtk", "old.vtk", "strips.vtk", "ascii.vtp", "inline.vtp", "plain.vtp", "appended.vtp"}) {
        SCOPED_TRACE(name);
        EXPECT_TRUE(meshes::is_surface_file(directory_ / name));
        const auto back = read(name).surface;
        EXPECT_EQ(back.points.size(), surface.points.size());
        EXPECT_EQ(back.triangles.size(), surface.triangles.size());
        EXPECT_NEAR(meshes::enclosed_volume(back) / meshes::enclosed_volume(surface), 1.0, 1e-4);
    }
}

TEST_F(SurfaceFile, ThatSaysItIsInRasIsTurnedToLps) {
    const auto surface = ball_surface(50.0, {10.0, 20.0, 30.0});
    write_obj(directory_ / "lps.obj", surface);
    std::ofstream(directory_ / "ras.obj") << "# 3D Slicer output. SPACE=RAS\n"
                                          << support::read_text(directory_ / "lps.obj");
    const auto turned = read("ras.obj");
    tests::expect_one(turned.remarks, "is turned to LPS");
    core::Vector3 middle = core::Vector3::Zero();
    for (const auto &point : turned.surface.points)
        middle += point / static_cast<double>(turned.surface.points.size());
    EXPECT_LT((middle - core::Vector3(-10.0, -20.0, 30.0)).norm(), 1e-3);
}

/// As 3D Slicer and vtk put it into field data.
TEST_F(SurfaceFile, WhoseFieldDataSayRasIsTurnedToLps) {
    const auto surface = ball_surface(50.0, {10.0, 20.0, 30.0});
    std::string points, triangles, offsets;
    for (const auto &p : surface.points)
        points += fmt::format("{} {} {}\n", p.x(), p.y(), p.z());
    for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
        const auto &[a, b, c] = surface.triangles[t];
        triangles += fmt::format("{} {} {}\n", a, b, c);
        offsets += fmt::format("{} ", 3 * t + 3);
    }
    const auto polydata = [&](const std::string &field) {
        return "# vtk DataFile Version 4.2\nball\nASCII\nDATASET POLYDATA\n" + field +
               fmt::format("POINTS {} double\n", surface.points.size()) + points +
               fmt::format("POLYGONS {} {}\n", surface.triangles.size(), 4 * surface.triangles.size());
    };
    auto rows = std::string();
    for (const auto &[a, b, c] : surface.triangles)
        rows += fmt::format("3 {} {} {}\n", a, b, c);
    std::ofstream(directory_ / "ras.vtk") << polydata("FIELD FieldData 1\nSPACE 1 1 string\nRAS\n") << rows;
    std::ofstream(directory_ / "lps.vtk") << polydata("FIELD FieldData 1\nSPACE 1 1 string\nLPS\n") << rows;
    std::ofstream(directory_ / "ras.vtp")
        << "<?xml version=\"1.0\"?><VTKFile type=\"PolyData\" version=\"0.1\" "
           "byte_order=\"LittleEndian\"><PolyData><FieldData>"
           "<Array type=\"String\" Name=\"SPACE\" NumberOfTuples=\"1\" format=\"ascii\">82 65 83 0</Array></FieldData>"
        << fmt::format("<Piece NumberOfPoints=\"{}\" NumberOfPolys=\"{}\">", surface.points.size(),
                       surface.triangles.size())
        << "<Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">" << points
        << "</DataArray></Points><Polys><DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">" << triangles
        << "</DataArray><DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">" << offsets
        << "</DataArray></Polys></Piece></PolyData></VTKFile>";
    auto types = fmt::format("CELL_TYPES {}\n", surface.triangles.size());
    for (std::size_t t = 0; t < surface.triangles.size(); ++t)
        types += "5\n";
    auto grid = polydata("FIELD FieldData 1\nSPACE 1 1 string\nRAS\n");
    grid.replace(grid.find("POLYDATA"), 8, "UNSTRUCTURED_GRID").replace(grid.find("POLYGONS"), 8, "CELLS");
    std::ofstream(directory_ / "ras_grid.vtk") << grid << rows << types;
    for (const auto &[name, sign] :
         {std::pair{"ras.vtk", -1.0}, {"ras.vtp", -1.0}, {"ras_grid.vtk", -1.0}, {"lps.vtk", 1.0}}) {
        SCOPED_TRACE(name);
        const auto [back, remarks] = read(name);
        EXPECT_EQ(remarks.size(), sign < 0.0 ? 1U : 0U);
        core::Vector3 middle = core::Vector3::Zero();
        for (const auto &point : back.points)
            middle += point / static_cast<double>(back.points.size());
        EXPECT_LT((middle - core::Vector3(sign * 10.0, sign * 20.0, 30.0)).norm(), 1e-3);
    }
}

TEST_F(SurfaceFile, OfSeveralClosedPartsIsALesionEach) {
    auto parts = together(ball_surface(10.0), ball_surface(8.0, {40.0, 0.0, 0.0}));
    parts = together(std::move(parts), ball_surface(6.0, {0.0, 40.0, 0.0}));
    parts = together(std::move(parts), ball_surface(5.5, {1.0, 45.3, 2.0})); // cuts the one before
    write_ply(directory_ / "a.ply", parts);
    std::vector<std::string> remarks;
    const auto lesions = read_lesions(directory_ / "a.ply", remarks);
    ASSERT_EQ(lesions.size(), 3U);
    EXPECT_NEAR(meshes::enclosed_volume(lesions[0]) / meshes::enclosed_volume(ball_surface(10.0)), 1.0, 1e-4);
    EXPECT_NEAR(meshes::enclosed_volume(lesions[1]) / meshes::enclosed_volume(ball_surface(8.0)), 1.0, 1e-4);
    tests::expect_one(remarks, "1 parts that cut the largest one are united with it");
}

/// Each was made to end a library by a signal, or to keep it busy.
TEST_F(SurfaceFile, ThatEndsALibraryIsRefused) {
    std::ofstream(directory_ / "index.ply")
        << "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
           "element face 2\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n3 0 1 "
           "90000\n";
    std::ofstream(directory_ / "corners.off") << "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n1900000000 0 1 2\n";
    for (const char *name : {"index.ply", "corners.off"})
        expect_refused(name, name);
}

TEST_F(SurfaceFile, MayBeTheBoundaryOfTetrahedra) {
    const auto mesh = tests::box_mesh({0.2, 0.1, 0.1}, {4, 2, 2});
    meshes::write_msh(directory_ / "box.msh", mesh);
    const auto [surface, remarks] = read("box.msh");
    tests::expect_one(remarks, "the boundary of its tetrahedra is taken");
    EXPECT_EQ(surface.triangles.size(), mesh.boundary_triangles.size());
    EXPECT_NEAR(meshes::enclosed_volume(surface), 0.002, 1e-9);
}

TEST_F(SurfaceFile, ThatIsNoneIsRefused) {
    std::ofstream(directory_ / "a.stl") << "solid nothing\nendsolid\n";
    std::ofstream(directory_ / "a.txt") << "v 0 0 0\n";
    std::ofstream(directory_ / "a.obj") << "v 0 0 0\nv 1 0 nan\nv 0 1 0\nf 1 2 3\n";
    for (const char *name : {"a.stl", "a.txt", "a.obj", "nowhere.stl"})
        expect_refused(name, name);
}

TEST(VoxelsWithin, HaveTheVolumesOfTheSurfaces) {
    const auto liver = ball_surface(0.05);
    const auto lesion = ball_surface(0.012, {0.04, 0.0, 0.0}); // reaches out of it
    const auto voxels = voxels_within({liver, lesion}, 0.8e-3);
    const auto volumes = region_volumes(voxels);
    ASSERT_EQ(voxels.region_names, (std::vector<std::string>{"parenchyma", "tumour_1"}));
    EXPECT_NEAR((volumes[0] + volumes[1]) / meshes::enclosed_volume(liver), 1.0, 2e-3);
    EXPECT_LT(volumes[1], meshes::enclosed_volume(lesion));
    EXPECT_GT(volumes[1], 0.6 * meshes::enclosed_volume(lesion));
    tests::expect_one(voxels.remarks, "are outside the liver and are left out");
    EXPECT_TRUE(voxels_within({liver, ball_surface(0.012)}, 0.8e-3).remarks.empty()) << "all of it is inside";
}

TEST(VoxelsWithin, RefuseALesionElsewhere) {
    EXPECT_THROW(voxels_within({ball_surface(0.05), ball_surface(0.01, {0.2, 0.0, 0.0})}, 2e-3), support::InputError);
}

/// A part of it is beyond the box around the liver, where no voxels are.
TEST(VoxelsWithin, CutALesionAtTheLiverWhereverItReachesOut) {
    const auto liver = ball_surface(0.05);
    const double spacing = 1.5e-3;
    const auto one = voxels_within({liver, ball_surface(0.03, {0.0, 0.0, 0.05})}, spacing); // rows start beside it
    ASSERT_EQ(one.remarks.size(), 1U);
    const double expected = region_volumes(one)[1];
    for (const core::Vector3 &centre :
         {core::Vector3{0.05, 0.0, 0.0}, core::Vector3{-0.05, 0.0, 0.0}, core::Vector3{0.0, -0.05, 0.0}}) {
        SCOPED_TRACE(centre.transpose());
        const auto other = voxels_within({liver, ball_surface(0.03, centre)}, spacing);
        EXPECT_NEAR(region_volumes(other)[1] / expected, 1.0, 0.02);
        tests::expect_one(other.remarks, "are outside the liver");
    }
}

TEST(VoxelsWithin, GiveWhatTwoLesionsShareToTheSmallerAndSaySo) {
    const auto liver = ball_surface(0.05), large = ball_surface(0.02), small = ball_surface(0.012, {0.02, 0.0, 0.0});
    const auto first = voxels_within({liver, large, small}, 1e-3), second = voxels_within({liver, small, large}, 1e-3);
    EXPECT_NEAR(region_volumes(first)[2] / meshes::enclosed_volume(small), 1.0, 0.02);
    EXPECT_EQ(region_volumes(first)[2], region_volumes(second)[1]) << "whatever their order";
    tests::expect_one(first.remarks, "tumour_1 and tumour_2 share");
    tests::expect_part(first.remarks[0], "count as tumour_2, the smaller one");
    EXPECT_TRUE(
        voxels_within({liver, ball_surface(0.01, {0.02, 0.0, 0.0}), ball_surface(0.01, {-0.02, 0.0, 0.0})}, 1e-3)
            .remarks.empty());
}

TEST(VoxelsWithin, RefuseALesionOfWhichNothingIsLeft) {
    const auto liver = ball_surface(0.05), lesion = ball_surface(0.01);
    EXPECT_THROW(voxels_within({liver, lesion, lesion}, 2e-3), support::InputError);
    EXPECT_THROW(voxels_within({liver, liver}, 2e-3), support::InputError) << "nor of the liver";
}

} // namespace
} // namespace livermark::segmentation
