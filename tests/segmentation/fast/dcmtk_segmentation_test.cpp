#include <dcmtk/config/osconfig.h>

#include <array>
#include <dcmtk/dcmfg/fgfracon.h>
#include <dcmtk/dcmfg/fgpixmsr.h>
#include <dcmtk/dcmfg/fgplanor.h>
#include <dcmtk/dcmfg/fgplanpo.h>
#include <dcmtk/dcmseg/segdoc.h>
#include <dcmtk/dcmseg/segment.h>
#include <fmt/format.h>
#include <functional>
#include <gtest/gtest.h>
#include <memory>

#include "segmentation/images/dicom_segmentation.hpp"
#include "segmentation/images/image_file.hpp"
#include "tests/result_folder.hpp"

/// Segmentation objects that DCMTK writes, as dcmqi and 3D Slicer do by it: its tags, its lengths and its bits.
namespace livermark::segmentation {
namespace {

using core::Vector3;

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
