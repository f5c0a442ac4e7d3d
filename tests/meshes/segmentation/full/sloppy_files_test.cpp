#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/support/input_error.hpp"
#include "meshes/segmentation/images/segmentation.hpp"
#include "meshes/segmentation/surfaces/surface_file.hpp"
#include "tests/bad_input.hpp"
#include "tests/fuzz/seed_files.hpp"
#include "tests/result_folder.hpp"
#include "tests/samples/test_meshes.hpp"

/// Files as programs write them that take their formats lightly: each means the same as one that is as it should be.
namespace livermark::segmentation {
namespace {

using SloppyFile = tests::ResultFolder;

constexpr int side = 10;

/// A cube of label 1, two voxels inside of the image.
std::string cube_of_voxels() {
    std::string voxels(side * side * side, '\0');
    for (int z = 2; z < side - 2; ++z)
        for (int y = 2; y < side - 2; ++y)
            for (int x = 2; x < side - 2; ++x)
                voxels[static_cast<std::size_t>(x + side * (y + side * z))] = 1;
    return voxels;
}

template <class Number> void put(std::string &bytes, std::size_t at, Number number) {
    std::memcpy(bytes.data() + at, &number, sizeof number);
}

struct Header {
    float slope = 1.0F, offset = 352.0F, pixel = 7.0F;
    bool has_sform = true;
};

std::string image_of(const Header &said) {
    std::string header(352, '\0');
    put<std::int32_t>(header, 0, 348);
    for (const auto &[d, extent] : {std::pair{0, 3}, {1, side}, {2, side}, {3, side}, {4, 1}, {5, 1}, {6, 1}, {7, 1}})
        put<std::int16_t>(header, 40 + 2 * static_cast<std::size_t>(d), static_cast<std::int16_t>(extent));
    put<std::int16_t>(header, 70, 2); // unsigned bytes
    put<std::int16_t>(header, 72, 8);
    put(header, 76, 1.0F);
    for (const std::size_t at : {80U, 84U, 88U})
        put(header, at, at == 80U ? said.pixel : 7.0F);
    put(header, 108, said.offset);
    put(header, 112, said.slope);
    header[123] = 2; // mm
    if (said.has_sform) {
        put<std::int16_t>(header, 254, 1);
        for (const std::size_t at : {280U, 300U, 320U})
            put(header, at, 7.0F);
    }
    std::memcpy(header.data() + 344, "n+1", 4);
    return header + cube_of_voxels();
}

TEST_F(SloppyFile, OfVoxelsHasTheLabelsThatWereMeant) {
    constexpr float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
    const auto image = image_of({}), voxels = cube_of_voxels();
    const std::string nrrd = "NRRD0004\ntype: uint8\ndimension: 3\nspace: left-posterior-superior\nsizes: 10 10 10\n"
                             "space directions: (7,0,0) (0,7,0) (0,0,7)\nencoding: raw\n";
    written("voxels.raw", "some header of a scanner" + voxels);
    const std::vector<std::pair<std::string, std::string>> files{
        {"plain.nii", image},
        {"slope_nan.nii", image_of({.slope = nan})},
        {"slope_infinite.nii", image_of({.slope = infinity})},
        {"mirrored.nii", image_of({.pixel = -7.0F, .has_sform = false})},
        {"short_header.nii", image_of({.offset = 348.0F}).erase(348, 4)},
        {"no_offset.nii", image_of({.offset = 0.0F}).erase(348, 4)},
        {"two_members.nii.gz", fuzz::gzipped(image.substr(0, 600)) + fuzz::gzipped(image.substr(600))},
        {"something_behind.nii.gz", fuzz::gzipped(image) + "something behind"},
        {"from_the_end.nhdr", nrrd + "byte skip: -1\ndata file: voxels.raw\n"},
        {"other_case.nrrd", "NRRD0004\nTYPE: unsigned char" + nrrd.substr(nrrd.find("\ndimension")) + "\n" + voxels},
        {"colons.mha", "ObjectType: Image\n\nNDims: 3\nBinaryData: True\nDimSize: 10 10 10\nElementSpacing: 7 7 7\n"
                       "ElementType: MET_UCHAR\nElementDataFile: LOCAL\n" +
                           voxels}};
    for (const auto &[name, bytes] : files) {
        const auto read = read_label_image(written(name, bytes));
        ASSERT_EQ(read.label.size(), voxels.size()) << name;
        for (std::size_t v = 0; v < voxels.size(); ++v)
            ASSERT_EQ(read.label[v], voxels[v]) << name << ", voxel " << v;
        EXPECT_NEAR(read.grid.spacing.x(), 7e-3, 1e-9) << name;
    }
}

/// The same in two files, whose voxels are of four bytes.
std::pair<std::string, std::string> pair_of(float one_voxel) {
    auto header = image_of({.offset = 0.0F}).substr(0, 348);
    put<std::int16_t>(header, 70, 16); // floating point
    put<std::int16_t>(header, 72, 32);
    std::memcpy(header.data() + 344, "ni1", 4);
    const auto voxels = cube_of_voxels();
    std::string numbers(4 * voxels.size(), '\0');
    for (std::size_t v = 0; v < voxels.size(); ++v)
        put(numbers, 4 * v, v == 555 ? one_voxel : static_cast<float>(voxels[v]));
    return {header, numbers};
}

TEST_F(SloppyFile, OfTwoPartsIsReadByEitherNameInAnyCase) {
    const auto [header, voxels] = pair_of(1.0F);
    for (const auto &[first, second] : {std::pair{"a.hdr", "a.img"}, {"B.HDR", "B.IMG"}, {"c.HDR", "c.img"}}) {
        for (const auto &name : {written(first, header), written(second, voxels)})
            EXPECT_EQ(name.extension().string().size(), 4U);
        for (const char *name : {first, second}) {
            SCOPED_TRACE(name);
            const auto image = read_label_image(directory_ / name);
            EXPECT_EQ(std::ranges::count(image.label, 1), 216);
        }
    }
}

TEST_F(SloppyFile, OfTwoPartsMayHaveRoundedAxes) {
    auto [header, voxels] = pair_of(1.0F);
    put(header, 284, 0.01F); // of srow_x, which was 0
    written("a.hdr", header);
    written("a.img", voxels);
    const auto image = read_label_image(directory_ / "a.hdr");
    EXPECT_EQ(std::ranges::count(image.label, 1), 216);
    ASSERT_FALSE(image.remarks.empty());
    tests::expect_part(image.remarks[0], "turned to the nearest axes");
}

TEST_F(SloppyFile, OfTwoPartsWithAVoxelThatIsNotFiniteIsRefused) {
    for (const float number : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
        const auto [header, voxels] = pair_of(number);
        written("a.hdr", header);
        written("a.img", voxels);
        for (const char *name : {"a.hdr", "a.img"})
            tests::expect_input_error([&] { read_label_image(directory_ / name); },
                                      {"voxel 555 is not a finite number"});
    }
}

TEST_F(SloppyFile, OfTwoPartsThatWasCutOffIsRefused) {
    auto [header, voxels] = pair_of(1.0F);
    written("a.hdr", header);
    const auto expect_refused = [&](const std::string &why) {
        tests::expect_input_error([&] { read_label_image(directory_ / "a.hdr"); }, {"a.hdr: " + why});
    };
    written("a.img", voxels.substr(0, 3000));
    expect_refused("'a.img' holds 3000 bytes where 4000 are said");
    std::filesystem::remove(directory_ / "a.img");
    expect_refused("there is no file 'a.img' with its voxels");
    for (const float offset : {0.5F, std::numeric_limits<float>::infinity()}) {
        put(header, 108, offset);
        written("a.hdr", header);
        written("a.img", voxels);
        expect_refused("its header says that the voxels begin at byte");
    }
}

/// As TotalSegmentator writes it.
TEST_F(SloppyFile, MayNameItsLabelsInAnExtension) {
    const std::string xml = "<CaretExtension><VolumeInformation Index=\"0\"><LabelTable>"
                            "<Label Key=\"1\" Red=\"1\"><![CDATA[liver]]></Label>\n"
                            "<Label Key=\"2\" Red=\"0\"><![CDATA[liver tumour]]></Label>"
                            "<Label Red=\"0\"><![CDATA[none]]></Label><Label Key=\"3\"></Label>"
                            "</LabelTable></VolumeInformation></CaretExtension>";
    auto image = image_of({.offset = static_cast<float>(360 + xml.size())});
    std::string extension(8, '\0');
    put<std::int32_t>(extension, 0, static_cast<std::int32_t>(8 + xml.size()));
    put<std::int32_t>(extension, 4, 30);
    image[348] = 1;
    image.insert(352, extension + xml);
    for (const auto &[name, bytes] :
         {std::pair<std::string, std::string>{"a.nii", image}, {"b.nii.gz", fuzz::gzipped(image)}}) {
        const auto read = read_label_image(written(name, bytes));
        EXPECT_EQ(read.label_names, (std::map<int, std::string>{{1, "liver"}, {2, "liver tumour"}})) << name;
        EXPECT_EQ(std::ranges::count(read.label, 1), 216) << name;
    }
    image[348] = 0; // it says that there is none
    EXPECT_TRUE(read_label_image(written("c.nii", image)).label_names.empty());
}

const auto cube = tests::box_mesh({0.15, 0.15, 0.15}, {1, 1, 1});

std::array<double, 3> corner(int i) {
    const auto &place = cube.points.at(static_cast<std::size_t>(i));
    return {place.x(), place.y(), place.z()};
}

template <class Number> void append(std::string &bytes, Number number, bool is_big_endian = false) {
    std::string part(sizeof number, '\0');
    put(part, 0, number);
    bytes.append(is_big_endian ? std::string(part.rbegin(), part.rend()) : part);
}

std::string binary_stl(std::uint32_t count) {
    std::string bytes = "solid made by a program that likes the word";
    bytes.resize(80, ' ');
    append(bytes, count);
    for (const auto &face : cube.boundary_triangles) {
        for (int i = 0; i < 3; ++i)
            append(bytes, 0.0F);
        for (const int i : face)
            for (const double x : corner(i))
                append(bytes, static_cast<float>(x));
        append(bytes, std::uint16_t{0});
    }
    return bytes;
}

std::string big_endian_ply() {
    std::string bytes = "ply\nformat binary_big_endian 1.0\nelement vertex 8\nproperty double x\nproperty double y\n"
                        "property double z\nproperty uchar red\nelement face 12\n"
                        "property list uchar int vertex_index\nend_header\n";
    for (int i = 0; i < 8; ++i) {
        for (const double x : corner(i))
            append(bytes, x, true);
        bytes += '\7';
    }
    for (const auto &face : cube.boundary_triangles) {
        bytes += '\3';
        for (const int i : face)
            append(bytes, std::int32_t{i}, true);
    }
    return bytes;
}

std::string stl_in_capitals() {
    std::string text = "SOLID CUBE\n";
    for (const auto &face : cube.boundary_triangles) {
        text += "FACET NORMAL 0 0 0\nOUTER LOOP\n";
        for (const int i : face) {
            const auto [x, y, z] = corner(i);
            text += fmt::format("VERTEX {:.6E} {:.6E} {:.6E}\n", x, y, z);
        }
        text += "ENDLOOP\nENDFACET\n";
    }
    return text + "ENDSOLID CUBE\n";
}

TEST_F(SloppyFile, OfASurfaceHasTheTrianglesThatWereMeant) {
    std::string obj = "# x\r\n", off = "OFF # made by hand\r\n# comment\r\n8 12 0\r\n\r\n";
    for (int i = 0; i < 8; ++i) {
        const auto [x, y, z] = corner(i);
        obj += fmt::format("v {} {} {}\r\n", x, y, z);
        off += fmt::format("{} {} {}   # p\r\n", x, y, z);
    }
    for (const auto &[a, b, c] : cube.boundary_triangles) {
        obj += fmt::format("f {}// {}// {}//\r\n", a - 8, b - 8, c - 8);
        off += fmt::format("3 {} {} {} 0.5 0.5 0.5\r\n", a, b, c);
    }
    for (const auto &[name, bytes] : {std::pair<std::string, std::string>{"solid.stl", binary_stl(12)},
                                      {"counted_back.obj", obj},
                                      {"comments.off", off},
                                      {"big_endian.ply", big_endian_ply()},
                                      {"capitals.stl", stl_in_capitals()},
                                      {"MARK.STL", "\xef\xbb\xbf" + stl_in_capitals()},
                                      {"mark.obj", "\xef\xbb\xbf" + obj},
                                      {"mark.off", "\xef\xbb\xbf" + off},
                                      {"lines.obj", obj + "l 1 2\r\np 3\r\n"}}) {
        std::vector<std::string> remarks;
        const auto surface = read_surface(written(name, bytes), remarks);
        EXPECT_EQ(surface.triangles.size(), 12U) << name;
        EXPECT_EQ(surface.points.size(), 8U) << name;
    }
}

TEST_F(SloppyFile, WithAVoxelThatIsNotFiniteIsRefusedByItsNumber) {
    constexpr std::size_t header_bytes = 352, voxel = 345;
    for (const bool is_big_endian : {false, true}) {
        auto header = image_of({}).substr(0, header_bytes);
        put<std::int16_t>(header, 70, 16); // single precision
        put<std::int16_t>(header, 72, 32);
        if (is_big_endian) // first and last byte, and width, of the numbers that are not single bytes
            for (const auto &[first, last, width] : {std::array<std::ptrdiff_t, 3>{0, 4, 4},
                                                     {40, 56, 2},
                                                     {70, 74, 2},
                                                     {76, 120, 4},
                                                     {252, 256, 2},
                                                     {280, 328, 4}})
                for (auto at = first; at < last; at += width)
                    std::reverse(header.begin() + at, header.begin() + at + width);
        const auto with = [&](float value) {
            auto bytes = header;
            for (const char label : cube_of_voxels())
                append(bytes, bytes.size() == header_bytes + 4 * voxel ? value : static_cast<float>(label),
                       is_big_endian);
            return bytes;
        };
        EXPECT_EQ(read_label_image(written("finite.nii", with(1.0F))).label[voxel], 1);
        for (const float value : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()})
            for (const auto &[name, bytes] : {std::pair<std::string, std::string>{"voxel.nii", with(value)},
                                              {"voxel.nii.gz", fuzz::gzipped(with(value))}})
                tests::expect_input_error([&] { read_label_image(written(name, bytes)); },
                                          {"voxel 345 is not a finite number"});
    }
}

TEST_F(SloppyFile, WithAnAbsurdNumberIsRefused) {
    const std::string nrrd = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 10 10 10\nencoding: raw\n";
    written("voxels.raw", cube_of_voxels());
    for (const float offset : {std::numeric_limits<float>::quiet_NaN(), -1e30F, 0.0F, 352.5F, 1e30F})
        EXPECT_THROW(read_label_image(written("offset.nii", image_of({.offset = offset}))), support::InputError)
            << offset;
    for (const auto &[name, bytes] :
         {std::pair<std::string, std::string>{"lines.nhdr", nrrd + "line skip: 999999999\ndata file: voxels.raw\n"},
          {"slices.nhdr", nrrd + "data file: s%06d.raw 1 1000000000 1\n"}})
        EXPECT_THROW(read_label_image(written(name, bytes)), support::InputError) << name;
    const std::string ply = "ply\nformat ascii 1.0\nelement vertex 99999999999\nproperty float x\nproperty float y\n"
                            "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
    std::vector<std::string> remarks;
    for (const auto &[name, bytes] : {std::pair<std::string, std::string>{"count.stl", binary_stl(4294967295U)},
                                      {"count.ply", ply + "0 0 0\n"},
                                      {"word.stl", "solid x\nfacet normal 0 0 0\nouter loop\nvertex 0 0 nan\n"}})
        EXPECT_THROW(read_surface(written(name, bytes), remarks), support::InputError) << name;
}

} // namespace
} // namespace livermark::segmentation
