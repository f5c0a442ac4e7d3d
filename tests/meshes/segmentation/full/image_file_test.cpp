#include "meshes/segmentation/images/segmentation.hpp"

#include <fstream>
#include <gtest/gtest.h>
#include <itkGDCMImageIO.h>
#include <itkImage.h>
#include <itkImageFileWriter.h>
#include <itkMetaDataObject.h>

#include "core/support/input_error.hpp"
#include "tests/bad_input.hpp"
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

void expect_refused(const fs::path &file, const std::string &part) {
    tests::expect_input_error([&] { read_label_image(file); }, {part});
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

/// Writes numbers over a header of NIfTI that is not compressed.
template <class Number>
void poke_header(const fs::path &file, std::streamoff place, const std::vector<Number> &numbers) {
    std::fstream stream(file, std::ios::binary | std::ios::in | std::ios::out);
    stream.seekp(place);
    stream.write(reinterpret_cast<const char *>(numbers.data()),
                 static_cast<std::streamsize>(numbers.size() * sizeof(Number)));
}

/// An image without rotation, whose qform says nothing.
LabelImage straight_image() {
    auto image = small_image();
    image.grid.direction.setIdentity();
    image.grid.spacing = {0.002, 0.002, 0.002};
    return image;
}

TEST_F(ImageFile, MayHaveASlopeOfWhichWholeNumbersCome) {
    const auto file = directory_ / "a.nii";
    const auto image = straight_image();
    write_label_image(file, image);
    poke_header<float>(file, 112, {0.1F, 0.0F});
    std::fstream stream(file, std::ios::binary | std::ios::in | std::ios::out);
    for (std::size_t v = 0; v < image.label.size(); ++v) {
        const auto stored = static_cast<std::uint16_t>(10 * image.label[v]);
        stream.seekp(static_cast<std::streamoff>(352 + 2 * v));
        stream.write(reinterpret_cast<const char *>(&stored), sizeof stored);
    }
    stream.close();
    EXPECT_EQ(read_label_image(file).label, image.label);
}

TEST_F(ImageFile, MayHaveAxesWithFewDigits) {
    const auto file = directory_ / "a.nii";
    const auto image = straight_image();
    write_label_image(file, image);
    poke_header<std::int16_t>(file, 252, {0, 1});
    poke_header<float>(file, 280, {1.98F, -0.25F, 0.06F, 0.0F, 0.26F, 1.94F, -0.42F, 0.0F, 0.0F, 0.42F, 1.95F, 0.0F});
    const auto back = read_label_image(file);
    EXPECT_EQ(back.label, image.label);
    tests::expect_one(back.remarks, "degrees off a right angle, and are turned");
    EXPECT_TRUE((back.grid.direction.transpose() * back.grid.direction).isIdentity(1e-9));
    poke_header<float>(file, 280, {2.0F, 0.5F});
    expect_refused(file, "axes 0 and 1 are");
}

TEST_F(ImageFile, WhoseFormsDisagreeSaysSo) {
    const auto file = directory_ / "a.nii";
    write_label_image(file, straight_image());
    EXPECT_TRUE(read_label_image(file).remarks.empty());
    poke_header<std::int16_t>(file, 252, {1, 1});
    poke_header<float>(file, 280, {-4.0F, 0.0F, 0.0F, 0.0F, 0.0F, -4.0F, 0.0F, 0.0F, 0.0F, 0.0F, 4.0F, 0.0F});
    const auto back = read_label_image(file);
    tests::expect_one(back.remarks, "voxels are 2 x 2 x 2 mm by its pixdim and qform");
    tests::expect_part(back.remarks[0], "4 x 4 x 4 mm by its sform");
}

TEST_F(ImageFile, OfLabelsThatAreNearlyWholeIsRead) {
    std::ofstream(directory_ / "a.nrrd") << "NRRD0004\ntype: float\ndimension: 3\nspace: left-posterior-superior\n"
                                            "sizes: 2 2 2\nspace directions: (2,0,0) (0,3,0) (0,0,4)\n"
                                            "space origin: (10,20,30)\nencoding: ascii\nSegment0_LabelValue:=2\n"
                                            "Segment0_Name:=Liver\nSegment0_Tags:=Segmentation.Status:inprogress|"
                                            "TerminologyEntry:DICOM list~SCT^123037004^Anatomical Structure~SCT^"
                                            "10200004^Liver~^^~Anatomic list~^^~^^|\n\n1.9999 0 0 1.0004 0 0 0 0\n";
    const auto image = read_label_image(directory_ / "a.nrrd");
    EXPECT_EQ(image.label, (std::vector<std::uint16_t>{2, 0, 0, 1, 0, 0, 0, 0}));
    EXPECT_EQ(image.label_names, (std::map<int, std::string>{{2, "Liver"}}));
    EXPECT_EQ(image.label_codes.at(2).type, "10200004");
    EXPECT_EQ(image.label_codes.at(2).meaning, "Liver");
}

TEST_F(ImageFile, MayHaveItsEndingInUpperCase) {
    const auto image = small_image();
    for (const auto &[name, upper] : {std::pair{"a.nii.gz", "A.NII.GZ"}, {"a.mha", "A.MHA"}, {"a.nrrd", "A.NRRD"}}) {
        SCOPED_TRACE(name);
        write_label_image(directory_ / name, image);
        fs::rename(directory_ / name, directory_ / upper);
        EXPECT_EQ(read_label_image(directory_ / upper).label, image.label);
    }
}

/// Each was made to end a library by a signal, or to keep it busy.
TEST_F(ImageFile, ThatEndsALibraryIsRefused) {
    const std::string meta = "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
                             "CompressedData = False\nElementSpacing = 2 2 2\nDimSize = 10 10 10\n"
                             "ElementType = MET_UCHAR\n";
    const std::string nrrd = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\n",
                      local = "ElementDataFile = LOCAL\n" + std::string(1000, 'x');
    for (const auto &[name, bytes] : std::vector<std::pair<std::string, std::string>>{
             {"pattern.mhd", meta + "ElementDataFile = %n%s%s 1 10 1\n"},
             {"device.mhd", meta + "ElementDataFile = /dev/zero\n"},
             {"device.nhdr", nrrd + "encoding: raw\ndata file: /dev/tty\n"},
             {"dimensions.mha", tests::replaced(meta, "NDims = 3", "NDims = -2") + local},
             {"infinite.mha", meta + "TransformMatrix = 1e308 0 0 0 1 0 0 0 1e308\n" + local},
             {"key.nrrd", nrrd + "space: " + std::string(1500, 's') + "\nencoding: ascii\n\n1\n"}})
        expect_refused(written(name, bytes), name);
}

/// MetaIO spins on these, or reads 3.7 as 3, until a limit.
TEST_F(ImageFile, OfAbsurdlyManyDimensionsIsRefusedBeforeItsReaderSeesIt) {
    const auto text = [](const std::string &dimensions) {
        return "ObjectType = Image\n\nNDims" + dimensions +
               "\nBinaryData = True\nDimSize = 10 10 10\nElementSpacing = 2 2 2\nElementType = MET_UCHAR\n"
               "ElementDataFile = LOCAL\n" +
               std::string(1000, '\1');
    };
    std::ofstream(directory_ / "a.mha") << text(" = 3");
    EXPECT_EQ(read_label_image(directory_ / "a.mha").label.size(), 1000U);
    for (const char *number :
         {" = -1", " = 2147483647", ":99999999999", " = 3e8", " = 0", " = 11", " = abc", " = 3.7", " ="}) {
        std::ofstream(directory_ / "b.mha") << text(number);
        expect_refused(directory_ / "b.mha", "where a segmentation of a body has three");
    }
}

TEST_F(ImageFile, MayHaveLeftHandedAxes) {
    const auto image = small_image(true);
    write_label_image(directory_ / "a.nrrd", image);
    expect_same(read_label_image(directory_ / "a.nrrd"), image);
    EXPECT_LT(image.grid.direction.determinant(), 0.0);
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
        itk::EncapsulateMetaData<std::string>(header, "0018|5100", image.patient_position);
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
    image.patient_position = "HFP";
    write_series(directory_, image);
    const auto back = read_label_image(directory_);
    expect_same(back, image);
    EXPECT_EQ(back.patient_position, "HFP");
}

TEST_F(ImageFile, WithASliceMissingIsRefused) {
    auto image = small_image();
    image.grid.size = {5, 4, 6};
    image.label.resize(120, 3);
    write_series(directory_, image, 2);
    expect_refused(directory_, "not evenly spaced");
}

TEST_F(ImageFile, WithSeveralValuesAVoxelIsRefused) {
    std::ofstream(directory_ / "v.nrrd") << "NRRD0004\ntype: uint8\ndimension: 4\nspace: left-posterior-superior\n"
                                            "sizes: 2 2 2 2\nspace directions: none (2,0,0) (0,3,0) (0,0,4)\n"
                                            "kinds: vector domain domain domain\nspace origin: (0,0,0)\n"
                                            "encoding: ascii\n\n1 0 0 0 0 0 0 0 1 0 0 0 0 0 0 0\n";
    expect_refused(directory_ / "v.nrrd", "has 2 values");
}

TEST_F(ImageFile, ThatIsNoLabelMapIsRefused) {
    write_scan(directory_ / "ct.nii.gz", phantom_scan({.spacing = {0.01, 0.01, 0.01}}));
    expect_refused(directory_ / "ct.nii.gz", "which is not a label");
}

TEST_F(ImageFile, CutOffIsRefused) {
    for (const char *name : {"a.nii", "a.nii.gz", "a.nrrd", "a.mha"}) {
        SCOPED_TRACE(name);
        auto image = phantom_labels({.spacing = {0.004, 0.004, 0.004}});
        write_label_image(directory_ / name, image);
        const auto size = fs::file_size(directory_ / name);
        for (const auto left : {std::uintmax_t{0}, std::uintmax_t{20}, size / 2, size - 40}) {
            fs::resize_file(directory_ / name, left);
            expect_refused(directory_ / name, name);
            write_label_image(directory_ / name, image);
        }
    }
}

TEST_F(ImageFile, KeepsTheNamesOfItsLabelsInNrrdAlone) {
    auto image = small_image();
    image.label_names = {{1, "Liver"}, {3, "Hepatic vein, right = thin"}};
    write_label_image(directory_ / "a.nrrd", image);
    EXPECT_EQ(read_label_image(directory_ / "a.nrrd").label_names, image.label_names);
    for (const char *name : {"a.nii.gz", "a.mha"})
        EXPECT_THROW(write_label_image(directory_ / name, image), support::InputError) << name;
}

TEST_F(ImageFile, NamesNoFormatIsRefused) {
    EXPECT_THROW(write_label_image(directory_ / "a.png", small_image()), support::InputError);
    EXPECT_TRUE(fs::is_empty(directory_));
}

} // namespace
} // namespace livermark::segmentation
