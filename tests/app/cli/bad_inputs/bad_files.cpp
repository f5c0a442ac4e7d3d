#include <array>
#include <fmt/format.h>

#include "tests/app/cli/bad_inputs/bad_inputs.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark::tests {

namespace {

namespace fs = std::filesystem;

/// The good mesh, spoilt or replaced.
BadInput mesh(std::string what, std::string text) {
    return {std::move(what), "mesh check two.msh", {{"two.msh", std::move(text)}}};
}

BadInput spoilt_mesh(std::string what, const std::string &from, const std::string &to) {
    return mesh(std::move(what), replaced(good_msh, from, to));
}

std::string up_to(const std::string &end) {
    return good_msh.substr(0, good_msh.find(end));
}

BadInput body(std::string what, std::string text) {
    return {std::move(what), good_run, {{"bar.toml", std::move(text)}, {"case.toml", good_case}}, write_bar};
}

/// A body with a map of stiffness.
BadInput moduli(std::string what, std::string text) {
    return {std::move(what),
            good_run,
            {{"bar.toml", good_body + "[stiffness_map]\nfile = \"moduli.txt\"\n"},
             {"case.toml", good_case},
             {"moduli.txt", std::move(text)}},
            write_bar};
}

/// A body with vessels as lines.
/// @param keys  of [vessels] beside the file
BadInput vessels(std::string what, const std::string &keys, std::string swc) {
    return {std::move(what),
            good_run,
            {{"bar.toml", good_body + "[vessels]\nfile = \"vessels.swc\"\n" + keys},
             {"case.toml", good_case},
             {"vessels.swc", std::move(swc)}},
            write_bar};
}

BadInput spoilt_body(std::string what, const std::string &from, const std::string &to) {
    return body(std::move(what), replaced(good_body, from, to));
}

/// A body that comes as a mesh alone.
BadInput alone(std::string what, const std::string &file, std::string text) {
    return {std::move(what),
            "run --body " + file + " --load-case case.toml --output out",
            {{file, std::move(text)}, {"case.toml", good_case}}};
}

std::string thousandfold(std::string msh) {
    for (const char *node : {"2 1 0 0", "3 0 1 0", "4 0 0 1"}) {
        std::string larger = node;
        larger.replace(larger.find('1', 1), 1, "9000");
        msh = replaced(msh, node, larger);
    }
    return replaced(msh, "5 1 1 1", "5 9000 9000 9000");
}

std::string dots(int count) {
    std::string text;
    for (int i = 0; i < count; ++i)
        text += ".a";
    return text;
}

BadInput solution(std::string what, const std::string &file, std::string text) {
    return {std::move(what),
            "score bar.toml case.toml " + file + " --reference-on-mesh --output scores",
            {{"case.toml", good_case}, {file, std::move(text)}},
            write_bar};
}

/// No displacement at the nodes of the bar, in a unit of so many per metre.
std::string csv(double per_metre) {
    std::string text = "x,y,z,ux,uy,uz\n";
    for (const auto &point : box_mesh({0.09, 0.03, 0.03}, {3, 1, 1}).points)
        text += fmt::format("{},{},{},0,0,0\n", per_metre * point.x(), per_metre * point.y(), per_metre * point.z());
    return text;
}

/// Eight voxels, of which one is liver.
const std::string good_image = R"(NRRD0004
type: uint8
dimension: 3
space: left-posterior-superior
sizes: 2 2 2
space directions: (2,0,0) (0,3,0) (0,0,4)
space origin: (10,20,30)
encoding: ascii

1 0 0 0 0 0 0 0
)";

BadInput image_in(std::string what, const std::string &file, std::string text) {
    return {std::move(what), "mesh --labels " + file + " -o out.msh", {{file, std::move(text)}}};
}

BadInput image(std::string what, std::string text) {
    return image_in(std::move(what), "seg.nrrd", std::move(text));
}

BadInput spoilt_image(std::string what, const std::string &from, const std::string &to) {
    return image(std::move(what), replaced(good_image, from, to));
}

BadInput image_words(std::string what, std::string arguments) {
    return {std::move(what), std::move(arguments), {{"seg.nrrd", good_image}}};
}

/// Another value in the first voxel.
std::string with_value(const std::string &type, const std::string &value) {
    return replaced(replaced(good_image, "type: uint8", "type: " + type), "\n1 0 0", "\n" + value + " 0 0");
}

/// Faces in STL.
/// @param corner , "x y z"
template <std::size_t num_corners, std::size_t num_faces>
std::string facets(const std::array<std::string, num_corners> &corner,
                   const std::array<std::array<int, 3>, num_faces> &faces) {
    std::string text;
    for (const auto &face : faces) {
        text += "facet normal 0 0 0\nouter loop\n";
        for (const int c : face)
            text += "vertex " + corner.at(static_cast<std::size_t>(c)) + "\n";
        text += "endloop\nendfacet\n";
    }
    return text;
}

std::string tetrahedron(const std::array<std::string, 4> &corner) {
    return facets<4, 4>(corner, {{{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}});
}

/// An octahedron around x, y and the last two corners.
std::string octahedron(const std::array<std::string, 6> &corner) {
    return facets<6, 8>(corner,
                        {{{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}}});
}

std::string stl(const std::string &facets_of_solid) {
    return "solid s\n" + facets_of_solid + "endsolid s\n";
}

const std::string good_facets = tetrahedron({"0 0 0", "1 0 0", "0 1 0", "0 0 1"});
const std::string open_facets = good_facets.substr(good_facets.find("endfacet\n") + 9);

/// The header of a MetaImage of a thousand voxels, but for where they are.
const std::string meta_image = "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
                               "CompressedData = False\nElementSpacing = 2 2 2\nDimSize = 10 10 10\n"
                               "ElementType = MET_UCHAR\n";

BadInput surface_in(std::string what, const std::string &file, std::string text) {
    return {std::move(what), "mesh --surfaces " + file + " -o out.msh", {{file, std::move(text)}}};
}

BadInput surface(std::string what, std::string text) {
    return surface_in(std::move(what), "liver.stl", std::move(text));
}

/// A liver and its lesions.
BadInput lesions(std::string what, const std::string &files, std::string lesion) {
    return {std::move(what),
            "mesh --surfaces " + files + " --unit m --tetrahedra 2000 -o out.msh",
            {{"liver.stl", stl(good_facets)}, {"lesion.stl", stl(lesion)}}};
}

/// The label image of the phantom, in coarse voxels, without its last bytes.
BadInput cut_off(std::string what, const std::string &file) {
    return {std::move(what), "mesh --labels " + file + " -o out.msh", {}, [file](const fs::path &folder) {
                run_child({LIVERMARK_BINARY, "mesh", "--phantom", "--spacing", "0.008", "0.008", "0.008", "-o", file},
                          {.folder = folder});
                fs::resize_file(folder / file, fs::file_size(folder / file) - 30);
            }};
}

} // namespace

std::vector<BadInput> bad_meshes() {
    const std::string two = "2 4 2 1 1 1 2 3 4\n3 4 2 1 1 2 3 4 5\n";
    return {
        {
            "a mesh that is not there",
            "mesh check nowhere.msh",
        },
        mesh("an empty mesh", ""),
        mesh("random bytes as a mesh", random_bytes()),
        mesh("a tetrahedron of three nodes in MSH 1",
             "$NOD\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$ENDNOD\n$ELM\n1\n1 4 1 1 3 1 2 3\n$ENDELM\n"),
        mesh("a mesh in MSH 1 that ends in its nodes", "$NOD\n4\n1 0 0 0\n2 1 0"),
        mesh("a mesh that ends in a node", up_to(" 0 1\n5")),
        mesh("a mesh that ends before its elements", up_to("$Elements")),
        spoilt_mesh("NaN as a coordinate", "2 1 0 0\n", "2 1 nan 0\n"),
        spoilt_mesh("decimal commas", "3 0 1 0\n", "3 0 0,5 0\n"),
        spoilt_mesh("an inverted tetrahedron", "1 1 2 3 4\n", "1 2 1 3 4\n"),
        spoilt_mesh("a flat tetrahedron", "4 0 0 1\n", "4 0.5 0.5 0\n"),
        mesh("a tetrahedron that is there twice",
             replaced(replaced(good_msh, "$Elements\n3\n", "$Elements\n4\n"), two, two + "4 4 2 1 1 3 1 2 4\n")),
        spoilt_mesh("two nodes of one number", "3 0 1 0\n", "2 0 1 0\n"),
        spoilt_mesh("two nodes in one place", "5 1 1 1\n", "5 0 0 1\n"),
        spoilt_mesh("a node that no tetrahedron has", "3 4 2 1 1 2 3 4 5\n", "3 15 2 1 1 5\n"),
        spoilt_mesh("a tetrahedron with a node that is not there", "2 3 4 5\n", "2 3 4 9\n"),
        mesh("two parts that do not touch",
             replaced(replaced(good_msh, "5\n1 0 0 0\n", "8\n6 5 0 0\n7 5 1 0\n8 5 0 1\n1 0 0 0\n"), "2 3 4 5\n",
                      "7 6 8 5\n")),
        mesh("three tetrahedra on one face",
             replaced(replaced(replaced(good_msh, "5\n1 0 0 0\n", "6\n6 2 2 2\n1 0 0 0\n"), "$Elements\n3\n",
                               "$Elements\n4\n"),
                      "2 3 4 5\n", "2 3 4 5\n4 4 2 1 1 2 3 4 6\n")),
        mesh("two parts that hang on an edge",
             replaced(replaced(replaced(good_msh, "5\n1 0 0 0\n", "6\n6 0 -1 0\n1 0 0 0\n"), "5 1 1 1\n", "5 0 0 -1\n"),
                      "2 3 4 5\n", "1 6 5 2\n")),
        mesh("a triangle in two patches",
             replaced(replaced(good_msh, "$Elements\n3\n", "$Elements\n4\n"), two, two + "4 2 2 7 1 1 2 3\n")),
        spoilt_mesh("quadratic tetrahedra", "3 4 2 1 1 2 3 4 5\n", "3 11 2 1 1 2 3 4 5 1 2 3 4 5 1\n"),
        spoilt_mesh("text in a mesh that says it is binary", "2.2 0 8", "2.2 1 8"),
        spoilt_mesh("a mesh in partitions", "$Nodes", "$PartitionedEntities"),
        spoilt_mesh("five billion nodes", "$Nodes\n5\n", "$Nodes\n5000000000\n"),
        spoilt_mesh("more nodes announced than there are", "$Nodes\n5\n", "$Nodes\n2000000000\n"),
    };
}

std::vector<BadInput> bad_bodies() {
    return {
        body("random bytes as a body", random_bytes()),
        body("a body that ends in a word", good_body.substr(0, good_body.find("r\"\n"))),
        body("an empty body", ""),
        spoilt_body("a key that is there twice", "mesh =", "title ="),
        spoilt_body("a misspelt key of a material", "density", "densty"),
        spoilt_body("a number in quotes", "= 1000.0", "= \"1000\""),
        spoilt_body("Young's modulus in kPa, written behind it", "= 5000.0", "= \"5 kPa\""),
        spoilt_body("a negative density", "= 1000.0", "= -1000.0"),
        spoilt_body("Poisson's ratio of 1/2", "= 0.3", "= 0.5"),
        spoilt_body("a unit that nobody knows", "mesh =", "unit = \"inch\"\nmesh ="),
        spoilt_body("a unit of zero metres", "mesh =", "unit = 0.0\nmesh ="),
        spoilt_body("a material for a region that the mesh lacks", "[regions.solid]", "[regions.tumour]"),
        body("a region without a material", good_body.substr(0, good_body.find("[regions")) + "[regions]\n"),
        body("a capsule as thick as a finger", good_body + "[capsule]\nthickness = 0.02\nyoung_modulus = 8e6\n"),
        body("a capsule without a modulus", good_body + "[capsule]\nthickness = 2e-5\n"),
        body("a capsule with a Poisson's ratio",
             good_body + "[capsule]\nthickness = 2e-5\nyoung_modulus = 8e6\npoisson_ratio = 0.3\n"),
        body("a map of stiffness that is not there", good_body + "[stiffness_map]\nfile = \"moduli.txt\"\n"),
        moduli("a map of stiffness for another mesh", "5000\n6000\n"),
        moduli("a map of stiffness with words", "5000\nsoft\n"),
        moduli("a map of stiffness that is negative", "-5000\n"),
        body("vessels that are not there", good_body + "[vessels]\nfile = \"vessels.swc\"\n"),
        vessels("vessels without a radius", "", "1 0 0.1 0.1 0.1 0 -1\n2 0 0.2 0.2 0.2 0 1\n"),
        vessels("vessels whose points no line joins", "", "1 0 0.1 0.1 0.1 0.01 -1\n2 0 0.2 0.2 0.2 0.01 -1\n"),
        vessels("vessels behind a point that is not there", "", "1 0 0.1 0.1 0.1 0.01 -1\n2 0 0.2 0.2 0.2 0.01 9\n"),
        vessels("vessels in another unit than the body", "", "1 0 100 100 100 10 -1\n2 0 200 200 200 10 1\n"),
        vessels("vessels with a wall thicker than they are", "wall_ratio = 1.5\n",
                "1 0 0.1 0.1 0.1 0.01 -1\n2 0 0.2 0.2 0.2 0.01 1\n"),
        body("a description of a patch that the mesh lacks", good_body + "[patches.top]\ndescription = \"t\"\n"),
        {"a body whose mesh is not there",
         good_run,
         {{"bar.toml", replaced(good_body, "bar.msh", "other.msh")}, {"case.toml", good_case}}},
        {"a directory in the place of a body",
         "run --body folder.toml --load-case case.toml --output out",
         {{"case.toml", good_case}},
         [](const auto &folder) { std::filesystem::create_directory(folder / "folder.toml"); }},
        alone("a mesh alone, nine kilometres long", "large.msh", thousandfold(good_msh)),
        alone("random bytes as VTU", "noise.vtu", random_bytes()),
        alone("an Abaqus file that goes on in another", "mesh.inp", "*INCLUDE, INPUT=/dev/zero\n"),
        alone("tetrahedra of TetGen without their nodes", "mesh.ele", "1 4 0\n1 1 2 3 4\n"),
        alone("a Nastran file whose nodes are in cylindrical coordinates", "mesh.bdf",
              "CORD2C,5,0,0.,0.,0.,0.,0.,1.\n,1.,0.,0.\nGRID,1,5,0.,0.,0.\nCTETRA,1,1,1,1,1,1\n"),
        alone("a piece of a VTU with fewer points than it says", "pieces.vtu",
              "<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid><Piece NumberOfPoints=\"4\" "
              "NumberOfCells=\"0\"><Points>"
              "<DataArray type=\"Float64\" format=\"ascii\">0 0 "
              "0</DataArray></Points></Piece></UnstructuredGrid></VTKFile>"),
        alone("a mesh of a format that another program converts", "mesh.unv", "    -1\n  2411\n"),
        alone("hexahedra beside tetrahedra", "mixed.vtk",
              "# vtk DataFile Version 2.0\nmixed\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 9 double\n0 0 0 1 0 0 1 1 0 "
              "0 1 "
              "0 0 0 1 1 0 1 1 1 1 0 1 1 0.5 0.5 2\nCELLS 2 14\n8 0 1 2 3 4 5 6 7\n4 4 5 6 8\nCELL_TYPES 2\n12\n10\n"),
        body("a key of ten thousand dots", "a" + dots(10000) + " = 1\n"),
        body("a value of ten thousand brackets", "title = " + std::string(10000, '[') + "\n"),
        {"an image in the place of a mesh",
         "export body.toml case.toml --output out",
         {{"case.toml", good_case}, {"body.toml", "mesh = \"liver.nii.gz\"\n"}, {"liver.nii.gz", random_bytes()}}},
        {"a surface in the place of a mesh",
         "export body.toml case.toml --output out",
         {{"case.toml", good_case}, {"body.toml", "mesh = \"liver.stl\"\n"}, {"liver.stl", random_bytes()}}},
        alone("a surface without a volume", "surface.vtk",
              "# vtk DataFile Version 2.0\nno volume\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 3 double\n0 0 0 1 0 0 0 "
              "1 0\n"
              "CELLS 1 4\n3 0 1 2\nCELL_TYPES 1\n5\n"),
    };
}

std::vector<BadInput> bad_solutions() {
    const std::string header = "x,y,z,ux,uy,uz\n";
    return {
        {"a solution that is not there",
         "score bar.toml case.toml solution.csv --reference-on-mesh --output scores",
         {{"case.toml", good_case}},
         write_bar},
        solution("an empty solution file", "solution.csv", ""),
        solution("random bytes as a solution", "solution.csv", random_bytes()),
        solution("a solution without its first line", "solution.csv", "0,0,0,0,0,0\n"),
        solution("five numbers for a node", "solution.csv", header + "0,0,0,0,0\n"),
        solution("NaN as a displacement", "solution.csv", header + "0,0,0,0,nan,0\n"),
        solution("a solution in millimetres", "solution.csv", csv(1000.0)),
        solution("a solution on another mesh", "solution.csv", csv(1.5)),
        solution("two displacements for one node", "solution.csv", csv(1.0) + "0,0,0,1,1,1\n"),
        solution("random bytes as a solution in HDF5", "solution.h5", random_bytes()),
        {"a solution of a load case in motion",
         "score bar.toml case.toml solution.csv --reference-on-mesh --output scores",
         {{"case.toml", good_release}, {"solution.csv", csv(1.0)}},
         write_bar},
        {"an entry that is not there", "score --entry entry.toml --output scores"},
        {"an entry without problems",
         "score --entry entry.toml --output scores",
         {{"entry.toml", "engine = \"jelly\"\nversion = \"1\"\nmachine = \"a laptop\"\n"}}},
        {"an entry with a misspelt key",
         "score --entry entry.toml --output scores",
         {{"entry.toml", "engin = \"jelly\"\n"}}},
    };
}

std::vector<BadInput> bad_images() {
    return {
        image_words("an image that is not there", "mesh --labels nowhere.nii.gz -o out.msh"),
        image("an empty image", ""),
        image("random bytes as an image", random_bytes()),
        spoilt_image("an image of two dimensions",
                     "dimension: 3\nspace: left-posterior-superior\nsizes: 2 2 2\n"
                     "space directions: (2,0,0) (0,3,0) (0,0,4)\nspace origin: (10,20,30)\n",
                     "dimension: 2\nsizes: 4 2\n"),
        spoilt_image("an image of one slice", "sizes: 2 2 2", "sizes: 4 2 1"),
        spoilt_image(
            "two values a voxel",
            "dimension: 3\nspace: left-posterior-superior\nsizes: 2 2 2\nspace directions: (2,0,0)",
            "dimension: 4\nspace: left-posterior-superior\nsizes: 2 2 2 1\nkinds: vector domain domain domain\n"
            "space directions: none (2,0,0)"),
        image("probabilities in the place of labels", with_value("float", "0.7")),
        image("a scan in the place of labels", with_value("short", "-900")),
        spoilt_image("names of segments of which none is a liver", "encoding: ascii\n",
                     "encoding: ascii\nSegment0_LabelValue:=1\nSegment0_Name:=stomach\n"),
        spoilt_image("a space that would mirror the body", "left-posterior-superior", "3D-left-handed"),
        spoilt_image("a label image without labels", "1 0 0 0", "0 0 0 0"),
        image_words("a label that no voxel has", "mesh --labels seg.nrrd --liver 5 -o out.msh"),
        image_words("a label for liver and tumour", "mesh --labels seg.nrrd --liver 1 --tumours 1 -o out.msh"),
        image_words("a role that is none", "mesh --labels seg.nrrd --role 1=kidney -o out.msh"),
        image_words("a role of a segment that is not there", "mesh --labels seg.nrrd --role stomach=ignore -o out.msh"),
        image_words("two roles of a label", "mesh --labels seg.nrrd --liver 1 --role 1=cyst -o out.msh"),
        image_words("a role without a label image", "mesh --surfaces a.stl --role 1=cyst -o out.msh"),
        spoilt_image("spacing in metres", "(2,0,0) (0,3,0) (0,0,4)", "(0.002,0,0) (0,0.003,0) (0,0,0.004)"),
        spoilt_image("voxels of half a metre", "(0,0,4)", "(0,0,500)"),
        spoilt_image("axes that are not at right angles", "(0,3,0)", "(1,3,0)"),
        spoilt_image("a header that speaks of four gigabytes", "sizes: 2 2 2", "sizes: 2000 2000 1000"),
        spoilt_image("a header that speaks of more than the file holds", "sizes: 2 2 2", "sizes: 200 200 200"),
        cut_off("a compressed NIfTI image that was cut off", "seg.nii.gz"),
        cut_off("a NIfTI image that was cut off", "seg.nii"),
        cut_off("a MetaImage that was cut off", "seg.mha"),
        {"a folder without DICOM",
         "mesh --labels slices -o out.msh",
         {},
         [](const fs::path &folder) { fs::create_directory(folder / "slices"); }},
        {"a body file in the place of the new one",
         "mesh --labels seg.nrrd -o out.msh",
         {{"seg.nrrd", good_image}, {"out.toml", good_body}}},
        image_words("a scan in the place of a segmentation", "mesh --ct series/ --threshold 100 -o out.msh"),
        image_words("a mesh of another format", "mesh --labels seg.nrrd -o out.vtk"),
        image_words("an image and surfaces", "mesh --labels seg.nrrd --surfaces a.stl -o out.msh"),
        image_words("no file to write", "mesh --labels seg.nrrd"),
        image_words("a phantom as a picture", "mesh --phantom -o phantom.png"),
        image_words("names in a format that keeps none", "mesh --phantom --vessels -o phantom.nii.gz"),
        image_words("voxels of the phantom in millimetres", "mesh --phantom --spacing 1 1 3 -o phantom.nii.gz"),
        surface("a surface without triangles", "solid s\nendsolid s\n"),
        surface("a surface with a hole", stl(open_facets)),
        surface("a surface that cuts itself",
                stl(octahedron({"1 0 0", "-1 0 0", "0 1 0", "0 -1 0", "0.9 0.3 -0.8", "0 0 -1"}))),
        image_in("a MetaImage whose pattern of names is none", "seg.mhd",
                 meta_image + "ElementDataFile = %s%s%n 1 10 1\n"),
        image_in("a MetaImage that names a device", "seg.mhd", meta_image + "ElementDataFile = /dev/zero\n"),
        image_in("a MetaImage of minus two dimensions", "seg.mha",
                 replaced(meta_image, "NDims = 3", "NDims = -2") + "ElementDataFile = LOCAL\nxxxxxxxxxx\n"),
        surface_in(
            "a surface with a corner that is not there", "liver.ply",
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement "
            "face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 90000\n"),
        surface_in("random bytes as VTP", "liver.vtp", random_bytes()),
        surface_in("VTK polydata that were cut off", "liver.vtk",
                   "# vtk DataFile Version 3.0\ncut off\nASCII\nDATASET POLYDATA\nPOINTS 4 float\n0 0 0 1 0 0\n"),
        surface_in("VTP in a compression that cannot be read", "liver.vtp",
                   "<VTKFile type=\"PolyData\" compressor=\"vtkOtherDataCompressor\"><PolyData/></VTKFile>\n"),
        image("an image with NaN in a voxel", with_value("float", "nan")),
        image("a byte order mark before an image", "\xef\xbb\xbf" + good_image),
        image_in("a compressed image whose name does not say so", "seg.nii",
                 std::string("\x1f\x8b\x08\x00", 4) + random_bytes()),
        image_in("the header of a NIfTI pair without its voxels", "seg.hdr",
                 std::string("\x5c\x01\x00\x00", 4) + std::string(344, '\0')),
        image_in("the header of an NRRD image without its voxels", "seg.nhdr",
                 replaced(good_image.substr(0, good_image.find("\n\n") + 1), "ascii", "raw") + "data file: seg.raw\n"),
        {"a surface with a hole, straight to a run",
         "run --body liver.stl --output out",
         {{"liver.stl", stl(open_facets)}}},
        lesions("a lesion that lies outside of the liver", "liver.stl lesion.stl",
                tetrahedron({"5 0 0", "6 0 0", "5 1 0", "5 0 1"})),
        lesions("a lesion that is there twice", "liver.stl lesion.stl lesion.stl",
                tetrahedron({"0.1 0.1 0.1", "0.4 0.1 0.1", "0.1 0.4 0.1", "0.1 0.1 0.4"})),
        lesions("the liver in the place of a lesion", "liver.stl liver.stl", good_facets),
    };
}

} // namespace livermark::tests
