#include <array>

#include "tests/app/cli/bad_inputs/bad_inputs.hpp"

namespace livermark::tests {

namespace {

namespace fs = std::filesystem;

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

BadInput image(std::string name, std::string what, std::string text, std::string place, std::string remedy) {
    return {.name = std::move(name),
            .what = std::move(what),
            .arguments = "mesh --labels seg.nrrd -o out.msh",
            .file = "seg.nrrd: ",
            .place = std::move(place),
            .remedy = std::move(remedy),
            .files = {{"seg.nrrd", std::move(text)}}};
}

BadInput spoilt_image(std::string name, std::string what, const std::string &from, const std::string &to,
                      std::string place, std::string remedy) {
    return image(std::move(name), std::move(what), replaced(good_image, from, to), std::move(place), std::move(remedy));
}

/// Another value in the first voxel.
std::string with_value(const std::string &type, const std::string &value) {
    return replaced(replaced(good_image, "type: uint8", "type: " + type), "\n1 0 0", "\n" + value + " 0 0");
}

/// The faces of a tetrahedron in STL.
/// @param corner , "x y z"
std::string tetrahedron(const std::array<std::string, 4> &corner) {
    std::string text;
    for (const auto &face : {std::array{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}) {
        text += "facet normal 0 0 0\nouter loop\n";
        for (const int c : face)
            text += "vertex " + corner.at(static_cast<std::size_t>(c)) + "\n";
        text += "endloop\nendfacet\n";
    }
    return text;
}

std::string stl(const std::string &facets) {
    return "solid s\n" + facets + "endsolid s\n";
}

/// The faces of an octahedron in STL: around x, y and the last two corners.
std::string octahedron(const std::array<std::string, 6> &corner) {
    std::string text;
    for (const auto &face :
         {std::array{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}}) {
        text += "facet normal 0 0 0\nouter loop\n";
        for (const int c : face)
            text += "vertex " + corner.at(static_cast<std::size_t>(c)) + "\n";
        text += "endloop\nendfacet\n";
    }
    return text;
}

const std::string good_facets = tetrahedron({"0 0 0", "1 0 0", "0 1 0", "0 0 1"});

BadInput surface_in(std::string name, std::string what, const std::string &file, std::string text, std::string place,
                    std::string remedy) {
    return {.name = std::move(name),
            .what = std::move(what),
            .arguments = "mesh --surfaces " + file + " -o out.msh",
            .file = file + ": ",
            .place = std::move(place),
            .remedy = std::move(remedy),
            .files = {{file, std::move(text)}}};
}

/// The header of a MetaImage of a thousand voxels, but for where they are.
const std::string meta_image = "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
                               "CompressedData = False\nElementSpacing = 2 2 2\nDimSize = 10 10 10\n"
                               "ElementType = MET_UCHAR\n";

BadInput image_in(std::string name, std::string what, const std::string &file, std::string text, std::string place,
                  std::string remedy) {
    return {.name = std::move(name),
            .what = std::move(what),
            .arguments = "mesh --labels " + file + " -o out.msh",
            .file = file + ": ",
            .place = std::move(place),
            .remedy = std::move(remedy),
            .files = {{file, std::move(text)}}};
}

BadInput surface(std::string name, std::string what, std::string text, std::string place, std::string remedy) {
    return {.name = std::move(name),
            .what = std::move(what),
            .arguments = "mesh --surfaces liver.stl -o out.msh",
            .file = "liver.stl: ",
            .place = std::move(place),
            .remedy = std::move(remedy),
            .files = {{"liver.stl", std::move(text)}}};
}

/// The label image of the phantom, in coarse voxels, without its last bytes.
BadInput cut_off(std::string name, std::string what, const std::string &file, std::string place) {
    return {.name = std::move(name),
            .what = std::move(what),
            .arguments = "mesh --labels " + file + " -o out.msh",
            .file = file + ": ",
            .place = std::move(place),
            .remedy = "export or copy it again",
            .prepare = [file](const fs::path &folder) {
                run_child({LIVERMARK_BINARY, "mesh", "--phantom", "--spacing", "0.008", "0.008", "0.008", "-o", file},
                          {.folder = folder});
                fs::resize_file(folder / file, fs::file_size(folder / file) - 30);
            }};
}

BadInput image_words(std::string name, std::string what, std::string arguments, std::string place, std::string remedy) {
    auto row = image(std::move(name), std::move(what), good_image, std::move(place), std::move(remedy));
    row.arguments = std::move(arguments);
    row.file = "";
    return row;
}

} // namespace

std::vector<BadInput> bad_images() {
    auto missing = image_words("MissingImage", "an image that is not there", "mesh --labels nowhere.nii.gz -o out.msh",
                               "No such file", "check the path");
    auto no_series = image_words("FolderWithoutDicom", "a folder without DICOM", "mesh --labels slices -o out.msh",
                                 "holds 0 DICOM series", "a folder with one");
    no_series.prepare = [](const fs::path &folder) { fs::create_directory(folder / "slices"); };
    auto body_there = image_words("BodyIsThere", "a body file in the place of the new one",
                                  "mesh --labels seg.nrrd -o out.msh", "out.toml", "or another -o");
    body_there.files["out.toml"] = good_body;
    auto open_body =
        surface("OpenSurfaceAsABody", "a surface with a hole, straight to a run",
                stl(good_facets.substr(good_facets.find("endfacet\n") + 9)), "is open at (", "fill its holes");
    open_body.arguments = "run --body liver.stl --output out";
    auto lesion_apart = surface("LesionApart", "a lesion that lies outside of the liver", stl(good_facets),
                                "surface 2 of 2", "in the same coordinates");
    lesion_apart.file = "";
    lesion_apart.arguments = "mesh --surfaces liver.stl lesion.stl --unit m --tetrahedra 2000 -o out.msh";
    lesion_apart.files["lesion.stl"] = stl(tetrahedron({"5 0 0", "6 0 0", "5 1 0", "5 0 1"}));
    auto lesion_twice = lesion_apart;
    lesion_twice.name = "LesionTwice";
    lesion_twice.what = "a lesion that is there twice";
    lesion_twice.arguments = "mesh --surfaces liver.stl lesion.stl lesion.stl --unit m --tetrahedra 2000 -o out.msh";
    lesion_twice.files["lesion.stl"] = stl(tetrahedron({"0.1 0.1 0.1", "0.4 0.1 0.1", "0.1 0.4 0.1", "0.1 0.1 0.4"}));
    lesion_twice.place = "all of surface 2 of 3";
    lesion_twice.remedy = "leave it out";
    auto lesion_alone = lesion_apart;
    lesion_alone.name = "LesionInsteadOfTheLiver";
    lesion_alone.what = "the liver in the place of a lesion";
    lesion_alone.arguments = "mesh --surfaces liver.stl liver.stl --unit m --tetrahedra 2000 -o out.msh";
    lesion_alone.place = "fill all of the liver";
    lesion_alone.remedy = "give the liver's first";
    return {
        missing,
        image("EmptyImage", "an empty image", "", "damaged from the start", "give NIfTI"),
        image("RandomImage", "random bytes as an image", random_bytes(), "damaged from the start", "give NIfTI"),
        spoilt_image("FlatImage", "an image of two dimensions",
                     "dimension: 3\nspace: left-posterior-superior\nsizes: 2 2 2\n"
                     "space directions: (2,0,0) (0,3,0) (0,0,4)\nspace origin: (10,20,30)\n",
                     "dimension: 2\nsizes: 4 2\n", "2 dimensions", "has three"),
        spoilt_image("OneSlice", "an image of one slice", "sizes: 2 2 2", "sizes: 4 2 1", "1 voxel thick along axis 2",
                     "has three dimensions"),
        spoilt_image(
            "VectorImage", "two values a voxel",
            "dimension: 3\nspace: left-posterior-superior\nsizes: 2 2 2\nspace directions: (2,0,0)",
            "dimension: 4\nspace: left-posterior-superior\nsizes: 2 2 2 1\nkinds: vector domain domain domain\n"
            "space directions: none (2,0,0)",
            "2 values", "as a label map"),
        image("Probabilities", "probabilities in the place of labels", with_value("float", "0.7"), "has the value 0.7",
              "segment it first"),
        image("NegativeValue", "a scan in the place of labels", with_value("short", "-900"), "has the value -900",
              "segment it first"),
        spoilt_image("NoLiverByName", "names of segments of which none is a liver", "encoding: ascii\n",
                     "encoding: ascii\nSegment0_LabelValue:=1\nSegment0_Name:=stomach\n",
                     "none of its segments is a liver by its name: 1 'stomach'", "with --liver"),
        spoilt_image("MirroredSpace", "a space that would mirror the body", "left-posterior-superior", "3D-left-handed",
                     "3D-left-handed", "such as left-posterior-superior"),
        spoilt_image("EmptyLabels", "a label image without labels", "1 0 0 0", "0 0 0 0", "every voxel is background",
                     "no liver in it"),
        image_words("LabelThatIsNot", "a label that no voxel has", "mesh --labels seg.nrrd --liver 5 -o out.msh",
                    "no voxel has the label 5", "it has 1"),
        image_words("LabelTwice", "a label for liver and tumour",
                    "mesh --labels seg.nrrd --liver 1 --tumours 1 -o out.msh", "label 1 cannot be both",
                    "name it once"),
        spoilt_image("SpacingInMetres", "spacing in metres", "(2,0,0) (0,3,0) (0,0,4)",
                     "(0.002,0,0) (0,0.003,0) (0,0,0.004)", "0.002 mm apart along axis 0", "0.05 to 20 mm is possible"),
        spoilt_image("HugeSpacing", "voxels of half a metre", "(0,0,4)", "(0,0,500)", "500 mm apart along axis 2",
                     "0.05 to 20 mm is possible"),
        spoilt_image("ShearedImage", "axes that are not at right angles", "(0,3,0)", "(1,3,0)", "not at right angles",
                     "resample it"),
        spoilt_image("FourGigabytes", "a header that speaks of four gigabytes", "sizes: 2 2 2", "sizes: 2000 2000 1000",
                     "4e+09 voxels", "crop the image"),
        spoilt_image("MoreThanTheFile", "a header that speaks of more than the file holds", "sizes: 2 2 2",
                     "sizes: 200 200 200", "8000000 bytes", "damaged or cut off"),
        cut_off("TruncatedGzip", "a compressed NIfTI image that was cut off", "seg.nii.gz", "end too early"),
        cut_off("TruncatedNifti", "a NIfTI image that was cut off", "seg.nii", "bytes where header and voxels need"),
        cut_off("TruncatedMetaImage", "a MetaImage that was cut off", "seg.mha", "bytes of voxels where"),
        no_series,
        body_there,
        image_words("ScanForASegmentation", "a scan in the place of a segmentation",
                    "mesh --ct series/ --threshold 100 -o out.msh", "a scan is not a segmentation",
                    "segment it with 3D Slicer"),
        image_words("MeshOfAnotherFormat", "a mesh of another format", "mesh --labels seg.nrrd -o out.vtk", "out.vtk",
                    "end its name in .msh"),
        image_words("TwoSources", "an image and surfaces", "mesh --labels seg.nrrd --surfaces a.stl -o out.msh",
                    "one of --labels, --surfaces and --phantom", "livermark mesh --help"),
        image_words("NoOutput", "no file to write", "mesh --labels seg.nrrd", "-o", "no file to write"),
        image_words("PhantomAsPicture", "a phantom as a picture", "mesh --phantom -o phantom.png", "phantom.png",
                    "end the name in .nii.gz"),
        image_words("PhantomInMillimetres", "voxels of the phantom in millimetres",
                    "mesh --phantom --spacing 1 1 3 -o phantom.nii.gz", "--spacing is 1 m",
                    "between 0.0001 and 0.02 m"),
        surface("EmptySurface", "a surface without triangles", "solid s\nendsolid s\n", "no triangles",
                "export the surface"),
        surface("OpenSurface", "a surface with a hole", stl(good_facets.substr(good_facets.find("endfacet\n") + 9)),
                "is open at (", "fill its holes"),
        surface("SurfaceThatCutsItself", "a surface that cuts itself",
                stl(octahedron({"1 0 0", "-1 0 0", "0 1 0", "0 -1 0", "0.9 0.3 -0.8", "0 0 -1"})), "cuts itself at (",
                "repair it"),
        image_in("PatternOfNames", "a MetaImage whose pattern of names is none", "seg.mhd",
                 meta_image + "ElementDataFile = %s%s%n 1 10 1\n", "is not a pattern", "export or copy it again"),
        image_in("DeviceOfVoxels", "a MetaImage that names a device", "seg.mhd",
                 meta_image + "ElementDataFile = /dev/zero\n", "is not a plain file", "export or copy it again"),
        image_in("NegativeDimensions", "a MetaImage of minus two dimensions", "seg.mha",
                 replaced(meta_image, "NDims = 3", "NDims = -2") + "ElementDataFile = LOCAL\nxxxxxxxxxx\n",
                 "'-2' dimensions", "export or copy it again"),
        surface_in(
            "CornerOutOfRange", "a surface with a corner that is not there", "liver.ply",
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement "
            "face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 90000\n",
            "", "export"),
        surface_in("RandomVtp", "random bytes as VTP", "liver.vtp", random_bytes(), "cannot be converted",
                   "export the surface as STL"),
        surface_in("TruncatedPolydata", "VTK polydata that were cut off", "liver.vtk",
                   "# vtk DataFile Version 3.0\ncut off\nASCII\nDATASET POLYDATA\nPOINTS 4 float\n0 0 0 1 0 0\n",
                   "ends too early", "export the surface as STL"),
        surface_in("CompressedByAnother", "VTP in a compression that cannot be read", "liver.vtp",
                   "<VTKFile type=\"PolyData\" compressor=\"vtkOtherDataCompressor\"><PolyData/></VTKFile>\n",
                   "compressed by vtkOtherDataCompressor", "save it without compression"),
        image("VoxelThatIsNotFinite", "an image with NaN in a voxel", with_value("float", "nan"), "voxel 0",
              "give it a label"),
        image("ImageWithByteOrderMark", "a byte order mark before an image", "\xef\xbb\xbf" + good_image,
              "begins with a byte order mark", "save its header without one"),
        image_in("CompressedUnderAPlainName", "a compressed image whose name does not say so", "seg.nii",
                 std::string("\x1f\x8b\x08\x00", 4) + random_bytes(), "compressed by gzip", "call it seg.nii.gz"),
        image_in("HeaderWithoutVoxels", "the header of a NIfTI pair without its voxels", "seg.hdr",
                 std::string("\x5c\x01\x00\x00", 4) + std::string(344, '\0'), "there is no file 'seg.img'",
                 "export or copy it again"),
        image_in("NrrdWithoutVoxels", "the header of an NRRD image without its voxels", "seg.nhdr",
                 replaced(good_image.substr(0, good_image.find("\n\n") + 1), "ascii", "raw") + "data file: seg.raw\n",
                 "there is no file 'seg.raw'", "export or copy it again"),
        open_body,
        lesion_apart,
        lesion_twice,
        lesion_alone,
    };
}

} // namespace livermark::tests
