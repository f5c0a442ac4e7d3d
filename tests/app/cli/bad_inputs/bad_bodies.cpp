#include "tests/app/cli/bad_inputs/bad_inputs.hpp"

namespace livermark::tests {

namespace {

BadInput body(std::string name, std::string what, std::string text, std::string place, std::string remedy) {
    return {.name = std::move(name),
            .what = std::move(what),
            .arguments = good_run,
            .file = "bar.toml:",
            .place = std::move(place),
            .remedy = std::move(remedy),
            .files = {{"bar.toml", std::move(text)}, {"case.toml", good_case}},
            .prepare = write_bar};
}

BadInput spoilt_body(std::string name, std::string what, const std::string &from, const std::string &to,
                     std::string place, std::string remedy) {
    return body(std::move(name), std::move(what), replaced(good_body, from, to), std::move(place), std::move(remedy));
}

/// A body that comes as a mesh alone.
BadInput alone(std::string name, std::string what, const std::string &file, std::string text, std::string place,
               std::string remedy) {
    return {.name = std::move(name),
            .what = std::move(what),
            .arguments = "run --body " + file + " --load-case case.toml --output out",
            .file = file + ":",
            .place = std::move(place),
            .remedy = std::move(remedy),
            .files = {{file, std::move(text)}, {"case.toml", good_case}}};
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

} // namespace

std::vector<BadInput> bad_bodies() {
    return {
        body("RandomBytes", "random bytes as a body", random_bytes(), ":1:", "correct the line"),
        body("Truncated", "a body that ends in a word", good_body.substr(0, good_body.find("r\"\n")),
             ":1:", "correct the line"),
        body("EmptyBody", "an empty body", "", "", "save it again"),
        spoilt_body("KeyTwice", "a key that is there twice", "mesh =", "title =", ":2:", "correct the line"),
        spoilt_body("UnknownKey", "a misspelt key of a material", "density", "densty",
                    ":4:", "did you mean 'density'?"),
        spoilt_body("MaterialInWords", "a number in quotes", "= 1000.0", "= \"1000\"", ":4: 'density'",
                    "has to be a finite number"),
        spoilt_body("WrongUnit", "Young's modulus in kPa, written behind it", "= 5000.0", "= \"5 kPa\"",
                    ":5: 'young_modulus'", "has to be a finite number"),
        spoilt_body("NegativeDensity", "a negative density", "= 1000.0", "= -1000.0", ":3:", "has to be positive"),
        spoilt_body("Incompressible", "Poisson's ratio of 1/2", "= 0.3", "= 0.5", ":3:", "between -1 and 0.5"),
        spoilt_body("UnknownUnit", "a unit that nobody knows",
                    "mesh =", "unit = \"inch\"\nmesh =", ":2:", "give m, cm or mm"),
        spoilt_body("UnitOfNothing", "a unit of zero metres",
                    "mesh =", "unit = 0.0\nmesh =", ":2:", "has to be positive"),
        spoilt_body("UnknownRegion", "a material for a region that the mesh lacks", "[regions.solid]",
                    "[regions.tumour]", ":3:", "it has solid"),
        body("RegionWithoutMaterial", "a region without a material",
             good_body.substr(0, good_body.find("[regions")) + "[regions]\n", ":3:", "add [regions.solid]"),
        body("UnknownPatch", "a description of a patch that the mesh lacks",
             good_body + "[patches.top]\ndescription = \"t\"\n", ":8:", "it has x_min"),
        {.name = "MissingMeshOfABody",
         .what = "a body whose mesh is not there",
         .arguments = good_run,
         .file = "other.msh:",
         .place = "",
         .remedy = "check the path",
         .files = {{"bar.toml", replaced(good_body, "bar.msh", "other.msh")}, {"case.toml", good_case}}},
        {.name = "DirectoryAsABody",
         .what = "a directory in the place of a body",
         .arguments = "run --body folder.toml --load-case case.toml --output out",
         .file = "folder.toml:",
         .place = "",
         .remedy = "give a file",
         .files = {{"case.toml", good_case}},
         .prepare = [](const auto &folder) { std::filesystem::create_directory(folder / "folder.toml"); }},
        alone("SizeOfNoOrgan", "a mesh alone, nine kilometres long", "large.msh", thousandfold(good_msh),
              "its longest side is 9000", "set 'unit'"),
        alone("DamagedVtu", "random bytes as VTU", "noise.vtu", random_bytes(), "", "save it as ASCII MSH"),
        alone("IncludedFile", "an Abaqus file that goes on in another", "mesh.inp", "*INCLUDE, INPUT=/dev/zero\n",
              "goes on in another file", "put that into it"),
        alone("TetgenWithoutNodes", "tetrahedra of TetGen without their nodes", "mesh.ele", "1 4 0\n1 1 2 3 4\n",
              "there is no file 'mesh.node'", "is in both"),
        alone("CylindricalCoordinates", "a Nastran file whose nodes are in cylindrical coordinates", "mesh.bdf",
              "CORD2C,5,0,0.,0.,0.,0.,0.,1.\n,1.,0.,0.\nGRID,1,5,0.,0.,0.\nCTETRA,1,1,1,1,1,1\n",
              "node 1 are of the cylindrical system 5", "save all nodes in the basic system"),
        alone("PieceThatLacksPoints", "a piece of a VTU with fewer points than it says", "pieces.vtu",
              "<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid><Piece NumberOfPoints=\"4\" "
              "NumberOfCells=\"0\"><Points>"
              "<DataArray type=\"Float64\" format=\"ascii\">0 0 "
              "0</DataArray></Points></Piece></UnstructuredGrid></VTKFile>",
              "a piece has 1 points and not the 4 that it says", "save it as ASCII MSH"),
        alone("FormatThatIsNotRead", "a mesh of a format that another program converts", "mesh.unv", "    -1\n  2411\n",
              "UNV is not read", "gmsh converts it"),
        alone("HexahedraBesideTetrahedra", "hexahedra beside tetrahedra", "mixed.vtk",
              "# vtk DataFile Version 2.0\nmixed\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 9 double\n0 0 0 1 0 0 1 1 0 "
              "0 1 "
              "0 0 0 1 1 0 1 1 1 1 0 1 1 0.5 0.5 2\nCELLS 2 14\n8 0 1 2 3 4 5 6 7\n4 4 5 6 8\nCELL_TYPES 2\n12\n10\n",
              "1 of type hexahedron", "mesh all of the volume with tetrahedra"),
        body("DeepKey", "a key of ten thousand dots", "a" + dots(10000) + " = 1\n", ":1:", "correct the line"),
        body("DeepValue", "a value of ten thousand brackets", "title = " + std::string(10000, '[') + "\n",
             "nested value depth of 256; correct", "correct the line"),
        {.name = "ImageAsAMesh",
         .what = "an image in the place of a mesh",
         .arguments = "export body.toml case.toml --output out",
         .file = "liver.nii.gz:",
         .place = "an image, not a mesh",
         .remedy = "livermark mesh --labels",
         .files = {{"case.toml", good_case},
                   {"body.toml", "mesh = \"liver.nii.gz\"\n"},
                   {"liver.nii.gz", random_bytes()}}},
        {.name = "SurfaceAsAMesh",
         .what = "a surface in the place of a mesh",
         .arguments = "export body.toml case.toml --output out",
         .file = "liver.stl:",
         .place = "a surface, not a mesh",
         .remedy = "livermark mesh --surfaces",
         .files = {{"case.toml", good_case}, {"body.toml", "mesh = \"liver.stl\"\n"}, {"liver.stl", random_bytes()}}},
        alone("SurfaceOnly", "a surface without a volume", "surface.vtk",
              "# vtk DataFile Version 2.0\nno volume\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 3 double\n0 0 0 1 0 0 0 "
              "1 0\n"
              "CELLS 1 4\n3 0 1 2\nCELL_TYPES 1\n5\n",
              "no tetrahedra", "save it as ASCII MSH"),
    };
}

} // namespace livermark::tests
