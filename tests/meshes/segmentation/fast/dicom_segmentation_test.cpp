#include <array>
#include <cmath>
#include <dcmtk/config/osconfig.h>
#include <dcmtk/dcmfg/fgfracon.h>
#include <dcmtk/dcmfg/fgpixmsr.h>
#include <dcmtk/dcmfg/fgplanor.h>
#include <dcmtk/dcmfg/fgplanpo.h>
#include <dcmtk/dcmseg/segdoc.h>
#include <dcmtk/dcmseg/segment.h>
#include <fmt/format.h>
#include <fstream>
#include <functional>
#include <gtest/gtest.h>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/support/input_error.hpp"
#include "meshes/segmentation/images/image_values.hpp"
#include "meshes/segmentation/images/segmentation.hpp"
#include "tests/bad_input.hpp"
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
    void expect_refused(const Object &object, const std::string &part) const {
        write(directory_ / "a.dcm", object);
        tests::expect_input_error([&] { read_label_image(directory_ / "a.dcm"); }, {part});
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
    expect_refused(scan, "no segmentation object");
    expect_refused(uneven, "not evenly spaced");
    for (const auto &object : {scan, uneven})
        expect_refused(object, "as with 3D Slicer or dcmqi");
    write(directory_ / "a.dcm", {});
    fs::resize_file(directory_ / "a.dcm", fs::file_size(directory_ / "a.dcm") - 4);
    EXPECT_THROW(read_label_image(directory_ / "a.dcm"), support::InputError);
}

} // namespace

/// Segmentation objects that DCMTK writes, as dcmqi and 3D Slicer do by it: its tags, its lengths and its bits.

namespace {

/// 40 pixels a frame: DCMTK 3.6.7 packs frames wrongly whose pixels do not fill bytes (QIICR/dcmqi issue 341). The
/// standard lets frames begin within a byte (PS3.5 8.1.1), as in dicom_segmentation_test.cpp.
constexpr std::array size{8, 5, 4};
constexpr double row_spacing = 0.75, column_spacing = 1.25, slice_spacing = 2.5; // [mm]
const Vector3 origin(-12.5, 30.0, 250.0);                                        // [mm]
const Vector3 along_row(0.0, 1.0, 0.0), along_column(0.0, 0.0, -1.0);            // sagittal

bool is_liver(int i, int j, int k) {
    return i > 0 && j < 4 && k > 0;
}

bool is_lesion(int i, int j, int k) {
    return i == 3 && j > 1 && j < 4 && k == 2;
}

void expect_good(const OFCondition &condition) {
    ASSERT_TRUE(condition.good()) << condition.text();
}

void add_segment(DcmSegmentation &object, const char *label, const CodeSequenceMacro &type) {
    DcmSegment *segment = nullptr;
    expect_good(DcmSegment::create(segment, label, CodeSequenceMacro("123037004", "SCT", "Anatomical Structure"), type,
                                   DcmSegTypes::SAT_MANUAL));
    Uint16 number = 0;
    expect_good(object.addSegment(segment, number));
}

void add_frame(DcmSegmentation &object, Uint16 segment, int k, const std::function<bool(int, int)> &is_inside,
               Uint8 value) {
    std::vector<Uint8> pixels;
    for (int j = 0; j < size[1]; ++j)
        for (int i = 0; i < size[0]; ++i)
            pixels.push_back(is_inside(i, j) ? value : 0);
    const Vector3 place = origin + k * slice_spacing * along_row.cross(along_column);
    const auto text = [](double x) { return OFString(fmt::format("{:.6g}", x).c_str()); };
    const std::unique_ptr<FGPlanePosPatient> position(
        FGPlanePosPatient::createMinimal(text(place.x()), text(place.y()), text(place.z())));
    FGFrameContent content;
    expect_good(content.setStackID("1"));
    expect_good(content.setInStackPositionNumber(static_cast<Uint32>(k + 1)));
    expect_good(content.setDimensionIndexValues(segment, 0));
    expect_good(content.setDimensionIndexValues(static_cast<Uint32>(k + 1), 1));
    OFVector<FGBase *> groups;
    groups.push_back(position.get());
    groups.push_back(&content);
    expect_good(object.addFrame(pixels.data(), segment, groups));
}

void describe(DcmSegmentation &object) {
    const std::unique_ptr<FGPlaneOrientationPatient> orientation(
        FGPlaneOrientationPatient::createMinimal("0", "1", "0", "0", "0", "-1"));
    expect_good(object.addForAllFrames(*orientation));
    FGPixelMeasures measures;
    expect_good(measures.setPixelSpacing(fmt::format("{}\\{}", row_spacing, column_spacing).c_str()));
    expect_good(measures.setSliceThickness(fmt::format("{}", slice_spacing).c_str()));
    expect_good(measures.setSpacingBetweenSlices(fmt::format("{}", slice_spacing).c_str()));
    expect_good(object.addForAllFrames(measures));
    const char *dimensions = "1.2.826.0.1.3680043.8.498.1";
    expect_good(object.getDimensions().addDimensionIndex(DCM_ReferencedSegmentNumber, dimensions,
                                                         DCM_SegmentIdentificationSequence));
    expect_good(
        object.getDimensions().addDimensionIndex(DCM_ImagePositionPatient, dimensions, DCM_PlanePositionSequence));
    object.getFrameOfReference().setFrameOfReferenceUID("1.2.826.0.1.3680043.8.498.2");
    object.getSeries().setSeriesNumber("1");
}

/// @param is_fractional  255 parts instead of bits
void write_by_dcmtk(const std::filesystem::path &file, bool is_fractional) {
    const IODGeneralEquipmentModule::EquipmentInfo equipment("Test", "Test", "1", "1");
    const ContentIdentificationMacro content("1", "LIVER", "a liver and a lesion", "Nobody");
    const auto rows = static_cast<Uint16>(size[1]), columns = static_cast<Uint16>(size[0]);
    DcmSegmentation *made = nullptr;
    if (is_fractional)
        expect_good(DcmSegmentation::createFractionalSegmentation(made, rows, columns, DcmSegTypes::SFT_OCCUPANCY, 255,
                                                                  equipment, content));
    else
        expect_good(DcmSegmentation::createBinarySegmentation(made, rows, columns, equipment, content));
    const std::unique_ptr<DcmSegmentation> object(made);
    add_segment(*object, "Liver", CodeSequenceMacro("10200004", "SCT", "Liver"));
    add_segment(*object, "Lesion", CodeSequenceMacro("52988006", "SCT", "Lesion"));
    describe(*object);
    for (int k = 1; k < size[2]; ++k)
        add_frame(
            *object, 1, k, [k](int i, int j) { return is_liver(i, j, k); }, is_fractional ? 200 : 1);
    add_frame(
        *object, 2, 2, [](int i, int j) { return is_lesion(i, j, 2); }, is_fractional ? 255 : 1);
    expect_good(object->saveFile(file.c_str()));
}

class DcmtkSegmentation : public tests::ResultFolder, public testing::WithParamInterface<bool> {};

TEST_P(DcmtkSegmentation, HasItsLabelsAndItsPlace) {
    ASSERT_TRUE(dcmDataDict.isDictionaryLoaded()) << "DCMTK lacks its dictionary";
    const auto file = directory_ / "seg.dcm";
    write_by_dcmtk(file, GetParam());
    ASSERT_FALSE(HasFatalFailure());
    ASSERT_TRUE(is_dicom_segmentation(file));
    const auto image = read_label_image(file);
    // The first slice is empty, so no frame says that it is there.
    ASSERT_EQ(image.grid.size, (std::array{size[0], size[1], size[2] - 1}));
    const Vector3 normal = along_row.cross(along_column);
    EXPECT_LT((1e3 * image.grid.origin - origin - slice_spacing * normal).norm(), 1e-9);
    EXPECT_LT((1e3 * image.grid.spacing - Vector3(column_spacing, row_spacing, slice_spacing)).norm(), 1e-9);
    EXPECT_LT((image.grid.direction.col(0) - along_row).norm(), 1e-12);
    EXPECT_LT((image.grid.direction.col(1) - along_column).norm(), 1e-12);
    EXPECT_LT((image.grid.direction.col(2) - normal).norm(), 1e-12);
    std::size_t voxel = 0;
    for (int k = 1; k < size[2]; ++k)
        for (int j = 0; j < size[1]; ++j)
            for (int i = 0; i < size[0]; ++i, ++voxel)
                EXPECT_EQ(image.label[voxel], is_lesion(i, j, k)  ? 2
                                              : is_liver(i, j, k) ? 1
                                                                  : 0)
                    << i << " " << j << " " << k;
}

INSTANTIATE_TEST_SUITE_P(BitsAndParts, DcmtkSegmentation, testing::Bool());

} // namespace
} // namespace livermark::segmentation
