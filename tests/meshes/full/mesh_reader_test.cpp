#include "meshes/io/mesh_files.hpp"

#include <cmath>
#include <filesystem>
#include <fmt/ranges.h>
#include <fstream>
#include <gtest/gtest.h>
#include <set>
#include <sys/stat.h>
#include <utility>

#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "core/support/toml_input.hpp"
#include "meshes/generators/box_generator.hpp"
#include "meshes/io/body_reader.hpp"
#include "tests/bad_input.hpp"
#include "tests/livermark_command.hpp"

namespace livermark {
namespace {

namespace fs = std::filesystem;

const fs::path beam = LIVERMARK_SOURCE_DIR "/meshes/beam.msh";

fs::path mesh_folder() {
    const std::string name = testing::UnitTest::GetInstance()->current_test_info()->name();
    auto folder = fs::path(testing::TempDir()) / "livermark_mesh_reader" / fs::path(name).filename();
    fs::create_directories(folder);
    return folder;
}

/// The beam as meshio writes it, in a unit of so many per metre.
fs::path saved_as(const std::string &name, const std::string &arguments = "", double per_metre = 1.0) {
    const auto file = mesh_folder() / name;
    const auto program =
        fmt::format("import meshio; m = meshio.read('{}'); c = [(b.type, b.data) for b in m.cells]; "
                    "meshio.Mesh(m.points * {}, c, cell_data={{'gmsh:physical': m.cell_data['gmsh:physical'], "
                    "'gmsh:geometrical': m.cell_data['gmsh:geometrical']}}).write('{}'{})",
                    beam.string(), per_metre, file.string(), arguments);
    const auto outcome = tests::run_command("/usr/bin/python3 -c \"" + program + "\"");
    EXPECT_EQ(outcome.status, 0) << outcome.output;
    return file;
}

struct Format {
    const char *name;
    const char *arguments;
};

void PrintTo(const Format &format, std::ostream *out) {
    *out << format.name;
}

class MeshReader : public testing::TestWithParam<Format> {};

TEST_P(MeshReader, ReadsTheSameTetrahedra) {
    std::vector<std::string> remarks;
    const auto expected = meshes::read_msh(beam);
    const auto found = meshes::read_mesh(saved_as(GetParam().name, GetParam().arguments), remarks);
    ASSERT_EQ(found.num_nodes(), expected.num_nodes());
    EXPECT_EQ(found.tetrahedra, expected.tetrahedra);
    for (int i = 0; i < found.num_nodes(); ++i)
        EXPECT_LT((found.points[i] - expected.points[i]).norm(), 1e-12) << i;
}

INSTANTIATE_TEST_SUITE_P(Formats, MeshReader,
                         testing::Values(Format{"beam.vtu", ""}, Format{"beam.vtk", ""}, Format{"beam.inp", ""},
                                         Format{"binary_2.msh", ", file_format='gmsh22', binary=True"},
                                         Format{"beam.mesh", ""}, Format{"beam.nas", ""}, Format{"beam.avs", ""}),
                         [](const auto &info) {
                             std::string name = info.param.name;
                             name.replace(name.find('.'), 1, "_");
                             return name;
                         });

TEST(MeshReader, KeepsRegionsAndPatches) {
    std::vector<std::string> remarks;
    const auto mesh = meshes::read_mesh(saved_as("beam.vtu"), remarks);
    EXPECT_EQ(mesh.region_names.size(), 1u);
    EXPECT_EQ(mesh.patch_names.size(), 6u);
}

TEST(MeshReader, RefusesWhatIsNoMeshWithTheRemedy) {
    std::vector<std::string> remarks;
    const auto expect_refusal = [&](const fs::path &file, const std::string &part) {
        tests::expect_input_error([&] { meshes::read_mesh(file, remarks); }, {part, file.filename().string()});
    };
    expect_refusal("/nowhere/liver.vtu", "check the path");
    const auto folder = mesh_folder();
    for (const char *name : {"noise.vtu", "noise.vtk", "noise.inp", "noise.xyz"}) {
        std::ofstream(folder / name) << "\x7f no mesh \x01\n 1 2 3\n";
        expect_refusal(folder / name, "cannot be converted");
    }
    std::ofstream(folder / "surface.vtk") << "# vtk DataFile Version 2.0\nno volume\nASCII\nDATASET UNSTRUCTURED_GRID\n"
                                             "POINTS 3 double\n0 0 0 1 0 0 0 1 0\nCELLS 1 4\n3 0 1 2\n"
                                             "CELL_TYPES 1\n5\n";
    expect_refusal(folder / "surface.vtk", "there are no tetrahedra in it");
}

TEST(MeshReader, TurnsInvertedTetrahedraAndDropsUnusedNodesAndSaysSo) {
    const auto file = mesh_folder() / "turned.vtk";
    std::ofstream(file) << "# vtk DataFile Version 2.0\nturned\nASCII\nDATASET UNSTRUCTURED_GRID\n"
                           "POINTS 5 double\n0 0 0 1 0 0 9 9 9 0 1 0 0 0 1\nCELLS 1 5\n4 0 3 1 4\nCELL_TYPES 1\n10\n";
    std::vector<std::string> remarks;
    const auto mesh = meshes::read_mesh(file, remarks);
    EXPECT_EQ(mesh.num_nodes(), 4);
    EXPECT_EQ(remarks, (std::vector<std::string>{"1 inverted tetrahedra are turned",
                                                 "1 nodes that no tetrahedron uses are left out"}));
}

/// Two tetrahedra side by side as VTK, with more behind.
fs::path two_tetrahedra(const std::string &name, const std::string &cell_data, const std::string &cells = "") {
    const auto file = mesh_folder() / name;
    const int num_cells = cells.empty() ? 2 : 3;
    std::ofstream(file) << "# vtk DataFile Version 2.0\ntwo\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 5 double\n"
                           "0 0 0 0.1 0 0 0 0.1 0 0 0 0.1 0.1 0.1 0.1\n"
                        << fmt::format("CELLS {} {}\n4 0 1 2 3\n4 1 4 2 3\n{}CELL_TYPES {}\n10\n10\n{}", num_cells,
                                       cells.empty() ? 10 : 14, cells, num_cells, cells.empty() ? "" : "5\n")
                        << cell_data;
    return file;
}

TEST(MeshReader, TakesAnyWholeNumbersOfCellsForRegionsAndNamesWhatItDoesNotUse) {
    for (const std::string name : {"labels", "MaterialIds", "medit:ref"}) {
        SCOPED_TRACE(name);
        std::vector<std::string> remarks;
        const auto mesh = meshes::read_mesh(
            two_tetrahedra(name + ".vtk",
                           "CELL_DATA 2\nSCALARS quality double 1\nLOOKUP_TABLE default\n0.3\n0.7\nSCALARS " + name +
                               " int 1\nLOOKUP_TABLE default\n4\n9\n"),
            remarks);
        EXPECT_EQ(mesh.region_names, (std::vector<std::string>{"region_4", "region_9"}));
        EXPECT_EQ(mesh.region, (std::vector{0, 1}));
        ASSERT_FALSE(remarks.empty());
        EXPECT_EQ(remarks.back(), "values of cells that are not used: quality");
    }
}

TEST(MeshReader, TurnsAMeshInRasToLpsAndSaysSo) {
    const auto lps = two_tetrahedra("lps.vtk", "");
    auto text = support::read_text(lps);
    std::ofstream(mesh_folder() / "ras.vtk")
        << text.replace(text.find("\ntwo\n"), 5, "\n3D Slicer output. SPACE=RAS\n");
    std::vector<std::string> remarks;
    const auto expected = meshes::read_mesh(lps, remarks);
    EXPECT_TRUE(remarks.empty());
    const auto turned = meshes::read_mesh(mesh_folder() / "ras.vtk", remarks);
    EXPECT_EQ(remarks, (std::vector<std::string>{"it says that it is in RAS, and is turned to LPS"}));
    EXPECT_EQ(turned.tetrahedra, expected.tetrahedra);
    for (int i = 0; i < expected.num_nodes(); ++i)
        EXPECT_EQ(turned.points[i], expected.points[i].cwiseProduct(core::Vector3(-1.0, -1.0, 1.0)));
    text = support::read_text(lps);
    std::ofstream(mesh_folder() / "said_lps.vtk")
        << text.replace(text.find("\ntwo\n"), 5, "\n3D Slicer output. SPACE=LPS\n");
    remarks.clear();
    EXPECT_EQ(meshes::read_mesh(mesh_folder() / "said_lps.vtk", remarks).points, expected.points);
    EXPECT_EQ(remarks, (std::vector<std::string>{"it says that it is in LPS"}));
}

TEST(MeshReader, TakesTheWordOfTheFileForTheAxesOfABody) {
    const auto body = meshes::generate_box({0.2, 0.15, 0.1}, 0.05);
    const auto without = mesh_folder() / "no_word.vtk", with = mesh_folder() / "word.vtk";
    for (const auto &[file, title] : {std::pair{without, "box"}, {with, "box SPACE=LPS"}}) {
        std::ofstream out(file);
        out << "# vtk DataFile Version 2.0\n"
            << title << "\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS " << body.num_nodes() << " double\n";
        for (const auto &point : body.points)
            out << point.transpose() << '\n';
        out << "CELLS " << body.tetrahedra.size() << ' ' << 5 * body.tetrahedra.size() << '\n';
        for (const auto &t : body.tetrahedra)
            out << fmt::format("4 {}\n", fmt::join(t, " "));
        out << "CELL_TYPES " << body.tetrahedra.size() << '\n';
        for (std::size_t t = 0; t < body.tetrahedra.size(); ++t)
            out << "10\n";
    }
    tests::expect_part(meshes::read_body(without).axes.doubt, "another orientation fits");
    const auto orientation = meshes::orientation_remarks(with);
    EXPECT_EQ(meshes::read_body(with).axes.doubt.find("another orientation fits"), std::string::npos);
    ASSERT_FALSE(orientation.empty());
    tests::expect_part(orientation.back(), "the header of its file says");
}

TEST(MeshReader, JoinsThePiecesOfAFile) {
    const auto piece = [](const std::string &points) {
        const auto array = [](const char *type, const char *name, const std::string &values) {
            return fmt::format("<DataArray type=\"{}\" Name=\"{}\" format=\"ascii\">{}</DataArray>", type, name,
                               values);
        };
        return "<Piece NumberOfPoints=\"4\" NumberOfCells=\"1\"><Points>" + array("Float64", "Points", points) +
               "</Points><Cells>" + array("Int32", "connectivity", "0 1 2 3") + array("Int32", "offsets", "4") +
               array("UInt8", "types", "10") + "</Cells></Piece>";
    };
    const auto file = mesh_folder() / "pieces.vtu";
    std::ofstream(file) << "<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid>"
                        << piece("0 0 0 .1 0 0 0 .1 0 0 0 .1") << piece(".1 0 0 .1 .1 .1 0 .1 0 0 0 .1")
                        << "</UnstructuredGrid></VTKFile>";
    std::vector<std::string> remarks;
    const auto mesh = meshes::read_mesh(file, remarks);
    EXPECT_EQ(mesh.num_nodes(), 5);
    EXPECT_EQ(mesh.num_tetrahedra(), 2);
    EXPECT_EQ(mesh.boundary_triangles.size(), 6u) << "the face between them is inside";
    EXPECT_EQ(remarks, (std::vector<std::string>{"its 2 pieces are joined at 3 nodes that they share"}));
}

TEST(MeshReader, LeavesOutAStrayTriangleOfAConvertedMeshAndSaysSo) {
    std::vector<std::string> remarks;
    const auto mesh = meshes::read_mesh(two_tetrahedra("stray.vtk", "", "3 0 1 4\n"), remarks);
    EXPECT_EQ(mesh.num_tetrahedra(), 2);
    tests::expect_one(remarks, "such as that of nodes 1 2 5, are left out");
}

TEST(MeshReader, HasTheNumbersOfTheFileInRefusals) {
    const auto file = mesh_folder() / "flat.vtk";
    std::ofstream(file)
        << "# vtk DataFile Version 2.0\nflat\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 6 double\n"
           "9 9 9 0 0 0 1 0 0 0 1 0 0 0 1 0 0 2\nCELLS 3 14\n3 1 3 2\n4 1 2 3 4\n4 1 2 3 3\nCELL_TYPES 3\n5\n10\n10\n";
    std::vector<std::string> remarks;
    tests::expect_input_error([&] { meshes::read_mesh(file, remarks); }, {"flat.vtk: tetrahedron 3 is flat"});
}

TEST(MeshReader, DoesNotWaitForAPipe) {
    const auto pipe = mesh_folder() / "pipe.msh";
    fs::remove(pipe);
    ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
    std::vector<std::string> remarks;
    EXPECT_THROW(meshes::read_mesh(pipe, remarks), support::InputError);
}

/// A mesh without a .toml: millimetres are found out, and what was assumed is said.
TEST(BodyOfAMesh, IsInMetresAndSaysWhatItAssumed) {
    const auto body = meshes::read_body(saved_as("beam.vtu", "", 1000.0));
    EXPECT_EQ(body.name, "beam");
    EXPECT_NEAR(body.mesh.points.at(0).norm(), meshes::read_msh(beam).points.at(0).norm(), 1e-9);
    ASSERT_EQ(body.materials.size(), 1u);
    EXPECT_EQ(body.materials[0].young_modulus, 5000.0);
    ASSERT_GE(body.assumptions.size(), 2u);
    tests::expect_part(body.assumptions[0], "assumed to be in mm");
    core::TetraMesh huge = body.mesh;
    for (auto &point : huge.points)
        point *= 1e6;
    EXPECT_THROW(meshes::guess_unit(huge.points, 1.0, "huge.vtu"), support::InputError);
    EXPECT_THROW(support::metres_per_unit("inch", "here"), support::InputError);
    EXPECT_THROW(support::metres_per_unit("-0.1", "here"), support::InputError);
    EXPECT_EQ(support::metres_per_unit("0.025", "here"), 0.025);
    EXPECT_THROW(support::metres_per_unit("1e300", "here"), support::InputError);
}

/// The boundary of a block in units of its longest side, with half of its box inside.
meshes::UnitGuess guess_of_block(double longest) {
    const std::vector<core::Vector3> points{{0, 0, 0}, {longest, 0.7 * longest, 0.6 * longest}};
    return meshes::guess_unit(points, 0.5 * 0.42 * std::pow(longest, 3), "block.vtu");
}

TEST(UnitGuess, SaysLengthAndVolumeWhereBothMakeAnAdultLiver) {
    for (const auto &[longest, unit] : {std::pair{0.2, "m"}, {20.0, "cm"}, {200.0, "mm"}}) {
        const auto guess = guess_of_block(longest);
        EXPECT_EQ(guess.unit, unit);
        tests::expect_part(guess.remark, "20 cm, and its volume, which is then 1.68 L");
    }
}

TEST(UnitGuess, SaysBothReadingsWhereTheyDisagree) {
    const auto guess = guess_of_block(9.6);
    EXPECT_EQ(guess.unit, "cm");
    for (const auto *part : {"9.6 cm", "0.19 L", "0.5 to 4 L", "a unit of 0.02 m would make it 1.5 L"})
        tests::expect_part(guess.remark, part);
}

} // namespace
} // namespace livermark
