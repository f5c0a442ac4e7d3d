#include <algorithm>
#include <fmt/format.h>
#include <itkImage.h>
#include <itkImageFileWriter.h>
#include <itkMetaImageIO.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>
#include <unistd.h>

#include "segmentation/images/image_file.hpp"
#include "support/input_error.hpp"
#include "support/whole_file.hpp"

namespace livermark::segmentation {

namespace {

namespace fs = std::filesystem;
using support::InputError;

constexpr double metres_per_unit_of_itk = 1e-3;

template <class Pixel> void write_image(const fs::path &file, const ImageGrid &grid, const std::vector<Pixel> &pixels) {
    support::check_place(file);
    const auto name = file.filename().string();
    itk::ImageIOBase::Pointer io;
    if (name.ends_with(".nii") || name.ends_with(".nii.gz"))
        io = itk::NiftiImageIO::New();
    else if (name.ends_with(".nrrd"))
        io = itk::NrrdImageIO::New();
    else if (name.ends_with(".mha"))
        io = itk::MetaImageIO::New();
    else
        throw InputError(fmt::format("{}: no such format can be written; end the name in .nii.gz, .nii, .nrrd or .mha",
                                     file.string()));
    using Image = itk::Image<Pixel, 3>;
    auto image = Image::New();
    typename Image::SizeType size;
    typename Image::SpacingType spacing;
    typename Image::PointType origin;
    typename Image::DirectionType direction;
    for (unsigned d = 0; d < 3; ++d) {
        size[d] = static_cast<itk::SizeValueType>(grid.size.at(d));
        spacing[d] = grid.spacing[d] / metres_per_unit_of_itk;
        origin[d] = grid.origin[d] / metres_per_unit_of_itk;
        for (unsigned c = 0; c < 3; ++c)
            direction(c, d) = grid.direction(c, d);
    }
    image->SetRegions(size);
    image->SetSpacing(spacing);
    image->SetOrigin(origin);
    image->SetDirection(direction);
    image->Allocate();
    std::ranges::copy(pixels, image->GetBufferPointer());
    // ITK goes by the end of the name, so the temporary one differs at its start.
    const auto temporary = file.parent_path() / fmt::format(".partial-{}-{}", getpid(), name);
    auto writer = itk::ImageFileWriter<Image>::New();
    writer->SetImageIO(io);
    writer->SetInput(image);
    writer->SetFileName(temporary.string());
    writer->UseCompressionOn();
    std::error_code error;
    try {
        writer->Update();
        fs::rename(temporary, file);
    } catch (const itk::ExceptionObject & /*in words for programmers*/) {
        fs::remove(temporary, error);
        throw InputError(
            fmt::format("{}: cannot be written; make room on the disk or choose another place", file.string()));
    } catch (const fs::filesystem_error &failure) {
        fs::remove(temporary, error);
        throw InputError(fmt::format("{}: cannot be put there ({})", file.string(), failure.code().message()));
    }
}

} // namespace

void write_label_image(const fs::path &file, const LabelImage &image) {
    write_image(file, image.grid, image.label);
}

void write_scan(const fs::path &file, const Scan &scan) {
    write_image(file, scan.grid, scan.grey_value);
}

} // namespace livermark::segmentation
