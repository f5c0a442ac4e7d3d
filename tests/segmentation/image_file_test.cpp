#include "segmentation/image_file.hpp"

#include <fstream>
#include <gtest/gtest.h>
#include <itkGDCMImageIO.h>
#include <itkImage.h>
#include <itkImageFileWriter.h>
#include <itkMetaDataObject.h>

#include "segmentation/phantom.hpp"
#include "support/input_error.hpp"
#include "tests/result_folder.hpp"

namespace livermark::segmentation {
namespace {

namespace fs = std::filesystem;

using ImageFile = tests::ResultFolder;

/// An image of anisotropic voxels with axes that are turned, and a mirrored one if wanted.
LabelImage small_image(bool mirrored = false) {
    LabelImage image{.name = "",
                     .grid = phantom_labels({.spacing = {0.02, 0.02, 0.02}, .turn = {0.1, -0.2, 0.3}}).grid,
                     .label = {}};
    image.grid.size = {5, 4, 3};
    image.grid.spacing = {0.0007, 0.0008, 0.003};
    if (mirrored)
        image.grid.direction.col(2) *= -1.0;
    for (std::size_t v = 0; v < num_voxels(image.grid); ++v)
        image.label.push_back(static_cast<std::uint16_t>(v % 7));
    return image;
}

void expect_same(const LabelImage &a, const LabelImage &b) {
    EXPECT_EQ(a.label, b.label);
    EXPECT_EQ(a.grid.size, b.grid.size);
    EXPECT_TRUE(a.grid.spacing.isApprox(b.grid.spacing, 1e-6));
    EXPECT_TRUE(a.grid.origin.isApprox(b.grid.origin, 1e-6)) << a.grid.origin << "\n" << b.grid.origin;
    EXPECT_TRUE(a.grid.direction.isApprox(b.grid.direction, 1e-5)) << a.grid.direction << "\n" << b.grid.direction;
}

/// The sentence that a file is refused with.
std::string refusal(const fs::path &file) {
    try {
        read_label_image(file);
    } catch (const support::InputError &error) {
        return error.what();
    }
    return "none";
}

TEST_F(ImageFile, ComesBackAsItWasInEveryFormat) {
    for (const char *name : {"a.nii", "a.nii.gz", "a.nrrd", "a.mha"}) {
        SCOPED_TRACE(name);
        const auto image = small_image();
        write_label_image(directory_ / name, image);
        const auto back = read_label_image(directory_ / name);
        expect_same(back, image);
        EXPECT_EQ(back.name, name);
        EXPECT_EQ(std::distance(fs::directory_iterator(directory_), {}), 1) << "something else is left";
        fs::remove(directory_ / name);
    }
}

TEST_F(ImageFile, MayHaveLeftHandedAxes) {
    const auto image = small_image(true);
    write_label_image(directory_ / "a.nrrd", image);
    expect_same(read_label_image(directory_ / "a.nrrd"), image);
    EXPECT_LT(image.grid.direction.determinant(), 0.0);
}

TEST_F(ImageFile, PlacesInTheWorldAreLpsInMetres) {
    // The header of another program, by hand: RAS in NRRD says that x and y point the other way.
    std::ofstream(directory_ / "a.nrrd") << "NRRD0004\ntype: uint8\ndimension: 3\nspace: right-anterior-superior\n"
                                            "sizes: 2 2 2\nspace directions: (2,0,0) (0,3,0) (0,0,4)\n"
                                            "space origin: (10,20,30)\nencoding: ascii\n\n1 0 0 0 0 0 0 0\n";
    const auto image = read_label_image(directory_ / "a.nrrd");
    EXPECT_TRUE(to_world(image.grid, {0, 0, 0}).isApprox(core::Vector3(-0.010, -0.020, 0.030), 1e-9));
    EXPECT_TRUE(to_world(image.grid, {0.002, 0.003, 0.004}).isApprox(core::Vector3(-0.012, -0.023, 0.034), 1e-9));
}

/// Writes each slice of an image as DICOM.
void write_series(const fs::path &folder, const LabelImage &image, int left_out = -1) {
    using Slice = itk::Image<std::uint16_t, 3>;
    for (int k = 0; k < image.grid.size[2]; ++k) {
        if (k == left_out)
            continue;
        auto slice = Slice::New();
        slice->SetRegions(
            Slice::SizeType{{static_cast<unsigned>(image.grid.size[0]), static_cast<unsigned>(image.grid.size[1]), 1}});
        const auto place = to_world(image.grid, {0.0, 0.0, k * image.grid.spacing[2]});
        Slice::SpacingType spacing;
        Slice::PointType origin;
        Slice::DirectionType direction;
        for (unsigned d = 0; d < 3; ++d) {
            spacing[d] = 1e3 * image.grid.spacing[d];
            origin[d] = 1e3 * place[d];
            for (unsigned c = 0; c < 3; ++c)
                direction(c, d) = image.grid.direction(c, d);
        }
        slice->SetSpacing(spacing);
        slice->SetOrigin(origin);
        slice->SetDirection(direction);
        slice->Allocate();
        const auto first = image.label.begin() + k * image.grid.size[0] * image.grid.size[1];
        std::copy_n(first, image.grid.size[0] * image.grid.size[1], slice->GetBufferPointer());
        auto io = itk::GDCMImageIO::New();
        io->KeepOriginalUIDOn();
        auto &header = slice->GetMetaDataDictionary();
        itk::EncapsulateMetaData<std::string>(header, "0008|0060", "CT");
        itk::EncapsulateMetaData<std::string>(header, "0020|000d", "1.2.826.0.1.3680043.2.1125.1");
        itk::EncapsulateMetaData<std::string>(header, "0020|000e", "1.2.826.0.1.3680043.2.1125.2");
        itk::EncapsulateMetaData<std::string>(header, "0020|0052", "1.2.826.0.1.3680043.2.1125.3");
        itk::EncapsulateMetaData<std::string>(header, "0008|0018",
                                              "1.2.826.0.1.3680043.2.1125.4." + std::to_string(k + 1));
        itk::EncapsulateMetaData<std::string>(header, "0020|0013", std::to_string(k + 1));
        auto writer = itk::ImageFileWriter<Slice>::New();
        writer->SetImageIO(io);
        writer->SetInput(slice);
        writer->SetFileName((folder / (std::to_string(9 - k) + ".dcm")).string()); // not in the order of their names
        writer->Update();
    }
}

TEST_F(ImageFile, MayBeAFolderOfDicomSlices) {
    auto image = small_image();
    image.grid.size = {5, 4, 6};
    image.label.resize(120, 3);
    write_series(directory_, image);
    expect_same(read_label_image(directory_), image);
}

TEST_F(ImageFile, WithASliceMissingIsRefused) {
    auto image = small_image();
    image.grid.size = {5, 4, 6};
    image.label.resize(120, 3);
    write_series(directory_, image, 2);
    EXPECT_NE(refusal(directory_).find("not evenly spaced"), std::string::npos) << refusal(directory_);
}

TEST_F(ImageFile, WithSeveralValuesAVoxelIsRefused) {
    std::ofstream(directory_ / "v.nrrd") << "NRRD0004\ntype: uint8\ndimension: 4\nspace: left-posterior-superior\n"
                                            "sizes: 2 2 2 2\nspace directions: none (2,0,0) (0,3,0) (0,0,4)\n"
                                            "kinds: vector domain domain domain\nspace origin: (0,0,0)\n"
                                            "encoding: ascii\n\n1 0 0 0 0 0 0 0 1 0 0 0 0 0 0 0\n";
    EXPECT_NE(refusal(directory_ / "v.nrrd").find("has 2 values"), std::string::npos) << refusal(directory_ / "v.nrrd");
}

TEST_F(ImageFile, ThatIsNoLabelMapIsRefused) {
    write_scan(directory_ / "ct.nii.gz", phantom_scan({.spacing = {0.01, 0.01, 0.01}}));
    EXPECT_NE(refusal(directory_ / "ct.nii.gz").find("which is no label"), std::string::npos);
}

TEST_F(ImageFile, CutOffIsRefused) {
    for (const char *name : {"a.nii", "a.nii.gz", "a.nrrd", "a.mha"}) {
        SCOPED_TRACE(name);
        auto image = phantom_labels({.spacing = {0.004, 0.004, 0.004}});
        write_label_image(directory_ / name, image);
        const auto size = fs::file_size(directory_ / name);
        for (const auto left : {std::uintmax_t{0}, std::uintmax_t{20}, size / 2, size - 40}) {
            fs::resize_file(directory_ / name, left);
            EXPECT_NE(refusal(directory_ / name).find(name), std::string::npos) << left << " of " << size << " bytes";
            write_label_image(directory_ / name, image);
        }
    }
}

TEST_F(ImageFile, NamesNoFormatIsRefused) {
    EXPECT_THROW(write_label_image(directory_ / "a.png", small_image()), support::InputError);
    EXPECT_TRUE(fs::is_empty(directory_));
}

} // namespace
} // namespace livermark::segmentation
