#include "segmentation/images/dicom_segmentation.hpp"

#include <cmath>
#include <fmt/format.h>
#include <fstream>
#include <functional>
#include <gtest/gtest.h>
#include <map>
#include <string>
#include <vector>

#include "segmentation/images/image_file.hpp"
#include "segmentation/images/segmentation.hpp"
#include "support/input_error.hpp"
#include "tests/fuzz/seed_files.hpp"
#include "tests/result_folder.hpp"

namespace livermark::segmentation {
namespace {

namespace fs = std::filesystem;
using core::Vector3;

using fuzz::element;
using fuzz::item;
using fuzz::number;

struct Object {
    std::string sop_class = "1.2.840.10008.5.1.4.1.1.66.4";
    std::string kind = "BINARY";
    int rows = 3, columns = 4;
    Vector3 along_row{1.0, 0.0, 0.0}, along_column{0.0, 0.6, 0.8}; ///< a tilted image
    double row_spacing = 1.5, column_spacing = 2.0, slice_spacing = 3.0;
    std::string segments;                                                               ///< items of the sequence
    std::vector<std::pair<int, double>> frames{{1, 0.0}, {1, 1.0}, {1, 3.0}, {2, 1.0}}; ///< segment, slice
    /// Whether a voxel is in a segment.
    std::function<bool(int segment, int i, int j, int k)> is_inside = [](int segment, int i, int j, int) {
        return segment == 1 ? i > 0 : i == 2 && j == 1;
    };
};

std::string pixels_of(const Object &object) {
    std::vector<bool> inside;
    for (const auto &[segment, slice] : object.frames)
        for (int j = 0; j < object.rows; ++j)
            for (int i = 0; i < object.columns; ++i)
                inside.push_back(object.is_inside(segment, i, j, static_cast<int>(std::lround(slice))));
    if (object.kind == "FRACTIONAL") {
        std::string bytes;
        for (const bool is_in : inside)
            bytes += static_cast<char>(is_in ? 100 : 99); // of 200: a half, and less
        return bytes;
    }
    std::string bytes((inside.size() + 7) / 8, '\0');
    for (std::size_t p = 0; p < inside.size(); ++p)
        if (inside[p])
            bytes[p / 8] = static_cast<char>(static_cast<unsigned char>(bytes[p / 8]) | 1U << (p % 8));
    return bytes;
}

void write(const fs::path &file, const Object &object) {
    const Vector3 normal = object.along_row.cross(object.along_column);
    std::string per_frame;
    for (const auto &[segment, slice] : object.frames) {
        const Vector3 place = Vector3(10.0, 20.0, 30.0) + slice * object.slice_spacing * normal;
        per_frame +=
            item(element(0x00209113, "SQ",
                         item(element(0x00200032, "DS",
                                      fmt::format("{:.6g}\\{:.6g}\\{:.6g}", place.x(), place.y(), place.z())))) +
                 element(0x0062000a, "SQ", item(number(0x0062000b, static_cast<std::uint32_t>(segment)))));
    }
    const auto &row = object.along_row, &column = object.along_column;
    const auto shared = item(
        element(0x00209116, "SQ",
                item(element(0x00200037, "DS",
                             fmt::format("{}\\{}\\{}\\{}\\{}\\{}", row.x(), row.y(), row.z(), column.x(), column.y(),
                                         column.z())))) +
        element(0x00289110, "SQ",
                item(element(0x00280030, "DS", fmt::format("{}\\{}", object.row_spacing, object.column_spacing)))));
    const bool are_bits = object.kind == "BINARY";
    std::ofstream(file, std::ios::binary)
        << fuzz::dicom_start(object.sop_class) << element(0x00080016, "UI", object.sop_class)
        << element(0x00080060, "CS", "SEG") << element(0x00280008, "IS", fmt::format("{}", object.frames.size()))
        << number(0x00280010, static_cast<std::uint32_t>(object.rows))
        << number(0x00280011, static_cast<std::uint32_t>(object.columns)) << number(0x00280100, are_bits ? 1 : 8)
        << element(0x00620001, "CS", object.kind)
        << (object.segments.empty() ? "" : element(0x00620002, "SQ", object.segments))
        << (are_bits ? "" : number(0x0062000e, 200)) << element(0x52009229, "SQ", shared)
        << element(0x52009230, "SQ", per_frame) << element(0x7fe00010, "OB", pixels_of(object));
}

class DicomSegmentation : public tests::ResultFolder {
  protected:
    std::string refusal(const Object &object) const {
        write(directory_ / "a.dcm", object);
        try {
            read_label_image(directory_ / "a.dcm");
        } catch (const support::InputError &error) {
            return error.what();
        }
        return "none";
    }
};

void expect_labels(const LabelImage &image, const Object &object) {
    ASSERT_EQ(image.grid.size, (std::array{4, 3, 4}));
    EXPECT_LT((image.grid.spacing - Vector3(2e-3, 1.5e-3, 3e-3)).norm(), 1e-12);
    EXPECT_LT((image.grid.origin - Vector3(0.01, 0.02, 0.03)).norm(), 1e-12);
    EXPECT_LT((image.grid.direction.col(1) - object.along_column).norm(), 1e-12);
    std::size_t voxel = 0;
    for (int k = 0; k < 4; ++k)
        for (int j = 0; j < 3; ++j)
            for (int i = 0; i < 4; ++i, ++voxel) {
                const bool is_lesion = k == 1 && i == 2 && j == 1;            // it wins over the liver around it
                const int expected = is_lesion ? 2 : k != 2 && i > 0 ? 1 : 0; // the third slice has no frame
                EXPECT_EQ(image.label[voxel], expected) << i << " " << j << " " << k;
            }
}

TEST_F(DicomSegmentation, OfBitsOrPartsGivesTheNumbersOfItsSegments) {
    for (const char *kind : {"BINARY", "FRACTIONAL"}) {
        SCOPED_TRACE(kind);
        Object object;
        object.kind = kind;
        write(directory_ / "seg.dcm", object);
        expect_labels(read_label_image(directory_ / "seg.dcm"), object);
    }
}

std::string code(std::uint32_t tag, const std::string &value, const std::string &meaning) {
    return element(
        tag, "SQ",
        item(element(0x00080100, "SH", value) + element(0x00080102, "SH", "SCT") + element(0x00080104, "LO", meaning)));
}

TEST_F(DicomSegmentation, HasNamesAndCodesOfItsSegments) {
    Object object;
    object.segments =
        item(number(0x00620004, 1) + element(0x00620005, "LO", "Liver") + code(0x0062000f, "10200004", "Liver")) +
        item(code(0x00082218, "10200004", "Liver") + number(0x00620004, 2) + code(0x0062000f, "108369006", "Neoplasm"));
    write(directory_ / "seg.dcm", object);
    const auto image = read_label_image(directory_ / "seg.dcm");
    EXPECT_EQ(image.label_names, (std::map<int, std::string>{{1, "Liver"}, {2, "Neoplasm"}}));
    ASSERT_EQ(image.label_codes.size(), 2u);
    EXPECT_EQ(image.label_codes.at(2).type, "108369006");
    EXPECT_EQ(image.label_codes.at(2).region, "Liver");
    EXPECT_EQ(labels_by_role(image).at(core::SegmentRole::lesion), std::vector{2});
}

TEST_F(DicomSegmentation, MayBeAloneInItsFolder) {
    fs::create_directory(directory_ / "series");
    write(directory_ / "series" / "seg.dcm", {});
    expect_labels(read_label_image(directory_ / "series"), {});
}

TEST_F(DicomSegmentation, ThatCannotBeReadNamesAToolThatCan) {
    Object scan, uneven;
    scan.sop_class = "1.2.840.10008.5.1.4.1.1.2";
    uneven.frames[2].second = 2.5;
    uneven.frames.emplace_back(1, 3.2);
    EXPECT_NE(refusal(scan).find("no segmentation object"), std::string::npos) << refusal(scan);
    EXPECT_NE(refusal(uneven).find("not evenly spaced"), std::string::npos) << refusal(uneven);
    for (const auto &object : {scan, uneven})
        EXPECT_NE(refusal(object).find("as with 3D Slicer or dcmqi"), std::string::npos) << refusal(object);
    write(directory_ / "a.dcm", {});
    fs::resize_file(directory_ / "a.dcm", fs::file_size(directory_ / "a.dcm") - 4);
    EXPECT_THROW(read_label_image(directory_ / "a.dcm"), support::InputError);
}

} // namespace
} // namespace livermark::segmentation
