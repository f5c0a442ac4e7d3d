#include "tests/fuzz/seed_files.hpp"

#include <array>
#include <cstdint>
#include <cstring>
#include <fmt/format.h>
#include <stdexcept>
#include <type_traits>
#include <zlib.h>

namespace livermark::fuzz {

namespace {

/// Bytes of numbers in the order of this machine, which is that of the formats here.
template <class Number> void put(std::string &bytes, const std::vector<Number> &numbers) {
    static_assert(std::is_arithmetic_v<Number>);
    bytes.append(reinterpret_cast<const char *>(numbers.data()), numbers.size() * sizeof(Number));
}

template <class Number> void write_at(std::string &bytes, std::size_t place, const std::vector<Number> &numbers) {
    std::memcpy(bytes.data() + place, numbers.data(), numbers.size() * sizeof(Number));
}

// --- surfaces: an octahedron of 0.4 L in metres

constexpr std::array<std::array<float, 3>, 6> corners{
    {{0.1F, 0, 0}, {-0.1F, 0, 0}, {0, 0.1F, 0}, {0, -0.1F, 0}, {0, 0, 0.1F}, {0, 0, -0.1F}}};
constexpr std::array<std::array<int, 3>, 8> faces{
    {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}}};

std::string lines_of_corners(const std::string &before) {
    std::string text;
    for (const auto &[x, y, z] : corners)
        text += fmt::format("{}{} {} {}\n", before, x, y, z);
    return text;
}

std::string lines_of_faces(const std::string &before, int first) {
    std::string text;
    for (const auto &[a, b, c] : faces)
        text += fmt::format("{}{} {} {}\n", before, a + first, b + first, c + first);
    return text;
}

std::string ascii_stl() {
    std::string text = "solid octahedron\n";
    for (const auto &face : faces) {
        text += "facet normal 0 0 0\nouter loop\n";
        for (const int corner : face) {
            const auto &[x, y, z] = corners.at(static_cast<std::size_t>(corner));
            text += fmt::format("vertex {} {} {}\n", x, y, z);
        }
        text += "endloop\nendfacet\n";
    }
    return text + "endsolid octahedron\n";
}

std::string binary_stl() {
    std::string bytes(80, '\0');
    put<std::uint32_t>(bytes, {static_cast<std::uint32_t>(faces.size())});
    for (const auto &face : faces) {
        put<float>(bytes, {0, 0, 0});
        for (const int corner : face) {
            const auto &[x, y, z] = corners.at(static_cast<std::size_t>(corner));
            put<float>(bytes, {x, y, z});
        }
        put<std::uint16_t>(bytes, {0});
    }
    return bytes;
}

std::string ply_header(const std::string &format) {
    return fmt::format("ply\nformat {} 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
                       "element face {}\nproperty list uchar int vertex_indices\nend_header\n",
                       format, corners.size(), faces.size());
}

std::string binary_ply() {
    auto bytes = ply_header("binary_little_endian");
    for (const auto &[x, y, z] : corners)
        put<float>(bytes, {x, y, z});
    for (const auto &[a, b, c] : faces) {
        put<std::uint8_t>(bytes, {3});
        put<std::int32_t>(bytes, {a, b, c});
    }
    return bytes;
}

// --- images: 4 x 4 x 4 voxels of 2 mm, a block of liver with a lesion

constexpr std::size_t extent = 4;

std::string voxels() {
    std::string bytes(extent * extent * extent, '\1');
    bytes[0] = '\0';
    bytes[21] = '\2';
    return bytes;
}

std::string digits_of_voxels() {
    std::string text;
    for (const char value : voxels())
        text += fmt::format("{} ", static_cast<int>(value));
    return text + "\n";
}

/// NIfTI-1: https://nifti.nimh.nih.gov/nifti-1/
std::string nifti_header(bool is_apart) {
    std::string bytes(348, '\0');
    write_at<std::int32_t>(bytes, 0, {348});
    write_at<std::int16_t>(bytes, 40, {3, extent, extent, extent, 1, 1, 1, 1});
    write_at<std::int16_t>(bytes, 70, {2, 8}); // unsigned bytes
    write_at<float>(bytes, 76, {1, 2, 2, 2, 1, 1, 1, 1});
    write_at<float>(bytes, 108, {is_apart ? 0.0F : 352.0F, 1, 0});
    bytes[123] = '\2'; // mm
    write_at<std::int16_t>(bytes, 252, {1, 1});
    write_at<float>(bytes, 280, {2, 0, 0, -4, 0, 2, 0, -4, 0, 0, 2, -4});
    bytes.replace(344, 4, is_apart ? std::string("ni1\0", 4) : std::string("n+1\0", 4));
    return bytes;
}

std::string nifti() {
    return nifti_header(false) + std::string(4, '\0') + voxels();
}

/// The second version, with wider fields: https://nifti.nimh.nih.gov/nifti-2/
std::string nifti_2() {
    std::string bytes(544, '\0');
    write_at<std::int32_t>(bytes, 0, {540});
    bytes.replace(4, 8, std::string("n+2\0\r\n\032\n", 8));
    write_at<std::int16_t>(bytes, 12, {2, 8}); // unsigned bytes
    write_at<std::int64_t>(bytes, 16, {3, extent, extent, extent, 1, 1, 1, 1});
    write_at<double>(bytes, 104, {1, 2, 2, 2, 1, 1, 1, 1});
    write_at<std::int64_t>(bytes, 168, {544});
    write_at<double>(bytes, 176, {1, 0});
    write_at<std::int32_t>(bytes, 348, {1});
    write_at<double>(bytes, 400, {2, 0, 0, -4, 0, 2, 0, -4, 0, 0, 2, -4});
    write_at<std::int32_t>(bytes, 500, {2}); // mm
    return bytes + voxels();
}

std::string nrrd_header(const std::string &encoding, const std::string &more) {
    return fmt::format("NRRD0004\ntype: uchar\ndimension: 3\nspace: left-posterior-superior\nsizes: {0} {0} {0}\n"
                       "space directions: (2,0,0) (0,2,0) (0,0,2)\nkinds: domain domain domain\nendian: little\n"
                       "encoding: {1}\nspace origin: (-4,-4,-4)\n{2}",
                       extent, encoding, more);
}

std::string meta_header(const std::string &more) {
    return fmt::format("ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
                       "CompressedData = False\nTransformMatrix = 1 0 0 0 1 0 0 0 1\nOffset = -4 -4 -4\n"
                       "CenterOfRotation = 0 0 0\nElementSpacing = 2 2 2\nDimSize = {0} {0} {0}\n"
                       "ElementType = MET_UCHAR\n{1}",
                       extent, more);
}

/// One slice of a series of MR images (PS3.3 A.4), with labels for intensities.
std::string dicom_slice(int slice) {
    const std::string sop_class = "1.2.840.10008.5.1.4.1.1.4";
    const std::string instance = fmt::format("1.2.3.{}", slice + 1);
    return dicom_start(sop_class) + element(0x00080016, "UI", sop_class) + element(0x00080018, "UI", instance) +
           element(0x00080060, "CS", "MR") + element(0x00180050, "DS", "2") + element(0x00180088, "DS", "2") +
           element(0x0020000d, "UI", "1.2.4") + element(0x0020000e, "UI", "1.2.5") +
           element(0x00200013, "IS", fmt::format("{}", slice + 1)) +
           element(0x00200032, "DS", fmt::format("-4\\-4\\{}", 2 * slice)) +
           element(0x00200037, "DS", "1\\0\\0\\0\\1\\0") + number(0x00280002, 1) +
           element(0x00280004, "CS", "MONOCHROME2") + number(0x00280010, extent) + number(0x00280011, extent) +
           element(0x00280030, "DS", "2\\2") + number(0x00280100, 8) + number(0x00280101, 8) + number(0x00280102, 7) +
           number(0x00280103, 0) + element(0x7fe00010, "OB", voxels().substr(0, extent * extent));
}

/// A segmentation object (PS3.3 A.51) of two segments with a frame each in two slices.
std::string dicom_segmentation() {
    const std::string sop_class = "1.2.840.10008.5.1.4.1.1.66.4";
    std::string per_frame, segments;
    for (const int segment : {1, 2}) {
        segments += item(number(0x00620004, static_cast<std::uint32_t>(segment)) +
                         element(0x00620005, "LO", segment == 1 ? "Liver" : "Tumor"));
        for (const int slice : {0, 1})
            per_frame +=
                item(element(0x00209113, "SQ", item(element(0x00200032, "DS", fmt::format("-4\\-4\\{}", 2 * slice)))) +
                     element(0x0062000a, "SQ", item(number(0x0062000b, static_cast<std::uint32_t>(segment)))));
    }
    const auto shared =
        item(element(0x00209116, "SQ", item(element(0x00200037, "DS", "1\\0\\0\\0\\1\\0"))) +
             element(0x00289110, "SQ", item(element(0x00180050, "DS", "2") + element(0x00280030, "DS", "2\\2"))));
    return dicom_start(sop_class) + element(0x00080016, "UI", sop_class) + element(0x00080060, "CS", "SEG") +
           element(0x00280008, "IS", "4") + number(0x00280010, extent) + number(0x00280011, extent) +
           number(0x00280100, 1) + number(0x00280101, 1) + element(0x00620001, "CS", "BINARY") +
           element(0x00620002, "SQ", segments) + element(0x52009229, "SQ", shared) +
           element(0x52009230, "SQ", per_frame) + element(0x7fe00010, "OB", "\xff\xff\xff\x7f\x10\x03\x10\x01");
}

} // namespace

std::string gzipped(const std::string &bytes) {
    z_stream stream{};
    constexpr int with_gzip_header = 16 + MAX_WBITS, usual_memory = 8;
    if (deflateInit2(&stream, Z_DEFAULT_COMPRESSION, Z_DEFLATED, with_gzip_header, usual_memory, Z_DEFAULT_STRATEGY) !=
        Z_OK)
        throw std::runtime_error("zlib cannot begin");
    auto input = bytes; // zlib wants it writable, and leaves it alone
    std::string output(deflateBound(&stream, input.size()), '\0');
    stream.next_in = reinterpret_cast<Bytef *>(input.data());
    stream.avail_in = static_cast<uInt>(input.size());
    stream.next_out = reinterpret_cast<Bytef *>(output.data());
    stream.avail_out = static_cast<uInt>(output.size());
    deflate(&stream, Z_FINISH);
    output.resize(stream.total_out);
    deflateEnd(&stream);
    return output;
}

std::vector<std::string> kinds_of_seeds() {
    return {"stl", "ply", "obj_off", "nifti", "nrrd", "metaimage", "dicom"};
}

std::vector<SeedFile> seeds_of(std::string_view kind) {
    if (kind == "stl")
        return {{"surface.stl", ascii_stl()}, {"surface.stl", binary_stl()}};
    if (kind == "ply")
        return {{"surface.ply", ply_header("ascii") + lines_of_corners("") + lines_of_faces("3 ", 0)},
                {"surface.ply", binary_ply()}};
    if (kind == "obj_off")
        return {{"surface.obj", "o octahedron\n" + lines_of_corners("v ") + lines_of_faces("f ", 1)},
                {"surface.off", fmt::format("OFF\n{} {} 0\n", corners.size(), faces.size()) + lines_of_corners("") +
                                    lines_of_faces("3 ", 0)}};
    if (kind == "nifti")
        return {{"labels.nii", nifti()},
                {.name = "labels.nii.gz", .bytes = nifti(), .is_gzipped = true},
                {"version_2.nii", nifti_2()},
                {"labels.hdr", nifti_header(true), {{"labels.img", voxels()}}}};
    if (kind == "nrrd")
        return {{"labels.nrrd", nrrd_header("ascii", "\n") + digits_of_voxels()},
                {"labels.nrrd", nrrd_header("raw", "\n") + voxels()},
                {"labels.nhdr", nrrd_header("raw", "data file: labels.raw\n"), {{"labels.raw", voxels()}}},
                {"labels.seg.nrrd", nrrd_header("raw", "Segment0_Name:=liver\nSegment0_LabelValue:=1\n"
                                                       "Segment1_Name:=tumour\nSegment1_LabelValue:=2\n\n") +
                                        voxels()}};
    if (kind == "metaimage")
        return {{"labels.mha", meta_header("ElementDataFile = LOCAL\n") + voxels()},
                {"labels.mhd", meta_header("ElementDataFile = labels.raw\n"), {{"labels.raw", voxels()}}}};
    if (kind == "dicom")
        return {{"object.dcm", dicom_segmentation()},
                {"0.dcm", dicom_slice(0), {{"1.dcm", dicom_slice(1)}, {"2.dcm", dicom_slice(2)}}, true}};
    throw std::invalid_argument(fmt::format("there are no seeds of the kind '{}'", kind));
}

} // namespace livermark::fuzz
