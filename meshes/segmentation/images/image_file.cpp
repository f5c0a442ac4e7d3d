#include "meshes/segmentation/images/segmentation.hpp"

#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <gdcmTrace.h>
#include <iterator>
#include <itkGDCMImageIO.h>
#include <itkGDCMSeriesFileNames.h>
#include <itkImage.h>
#include <itkImageFileWriter.h>
#include <itkImageSeriesReader.h>
#include <itkMetaDataObject.h>
#include <itkMetaImageIO.h>
#include <itkMultiThreaderBase.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <unistd.h>

#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "core/support/processes/child_process.hpp"
#include "core/support/processes/own_process.hpp"
#include "meshes/segmentation/images/image_headers.hpp"
#include "meshes/segmentation/images/image_values.hpp"

namespace livermark::segmentation {

namespace {

namespace fs = std::filesystem;
using core::Vector3;
using support::InputError;

constexpr double metres_per_millimetre = 1e-3;
constexpr double finest = 0.05e-3, coarsest = 20e-3; // [m]
constexpr int max_labels_of_image = 1000;

/// Refuses what cannot be, and makes the axes orthonormal to the last digit.
void check_grid(ImageGrid &grid, const std::string &name, std::vector<std::string> &remarks) {
    for (unsigned d = 0; d < 3; ++d) {
        if (grid.size.at(d) < 2)
            throw InputError("{}: the image is {} voxel thick along axis {}; a body has three dimensions", name,
                             grid.size.at(d), d);
        if (!(grid.spacing[d] >= finest && grid.spacing[d] <= coarsest))
            throw InputError("{}: the voxels are {:.3g} mm apart along axis {}, where {} to {} mm is possible; check "
                             "whether the header is in millimetres",
                             name, 1e3 * grid.spacing[d], d, 1e3 * finest, 1e3 * coarsest);
    }
    const auto off = off_right_angles(grid.direction);
    const Vector3 lengths = grid.direction.colwise().norm();
    if (!grid.origin.allFinite() || !lengths.allFinite() || !((lengths.array() - 1.0).abs() < 1e-2).all() ||
        !(off.degrees <= most_degrees_off))
        throw InputError("{}: the axes of the image are not at right angles{}; resample it, as with 3D Slicer's module "
                         "Resample Scalar/Vector/DWI Volume",
                         name, off.text.empty() ? "" : " (" + off.text + ")");
    constexpr double rounding = 0.01;
    if (off.degrees > rounding)
        remarks.push_back(off.text + ", and are turned to the nearest axes at right angles");
    // Headers carry some six digits; the mesh shall not be sheared by the rest.
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(grid.direction, Eigen::ComputeFullU | Eigen::ComputeFullV);
    grid.direction = svd.matrixU() * svd.matrixV().transpose();
}

ImageGrid grid_of(const Values &values, const HeaderGrid &header, const std::string &name,
                  std::vector<std::string> &remarks) {
    ImageGrid grid;
    for (unsigned d = 0; d < 3; ++d) {
        grid.size.at(d) = static_cast<int>(values.GetLargestPossibleRegion().GetSize(d));
        grid.spacing[d] = metres_per_millimetre * values.GetSpacing()[d];
        grid.origin[d] = metres_per_millimetre * values.GetOrigin()[d];
        for (unsigned c = 0; c < 3; ++c)
            grid.direction(c, d) = values.GetDirection()(c, d);
    }
    correct_by_header(grid, header, name, remarks);
    check_grid(grid, name, remarks);
    return grid;
}

LabelImage labels_of(const Values &values, const HeaderGrid &header, const std::string &name) {
    LabelImage image{.name = name, .grid = {}, .label = {}};
    image.grid = grid_of(values, header, name, image.remarks);
    constexpr float most_off = 1e-3F; // a slope and its product are rounded
    const float *value = values.GetBufferPointer();
    image.label.resize(num_voxels(image.grid));
    std::set<std::uint16_t> labels;
    for (std::size_t v = 0; v < image.label.size(); ++v) {
        if (!std::isfinite(value[v]))
            throw InputError(
                "{}: voxel {} is not a finite number; give it a label, or 0 for background, and export the image again",
                name, v);
        const float label = std::round(value[v]);
        if (!(label >= 0.0F && label <= 65535.0F && std::abs(value[v] - label) <= most_off))
            throw InputError("{}: voxel {} has the value {}, which is not a label; this is a scan or a map of "
                             "probabilities, so segment it first, as with 3D Slicer or TotalSegmentator",
                             name, v, value[v]);
        image.label[v] = static_cast<std::uint16_t>(label);
        if (v == 0 || image.label[v] != image.label[v - 1])
            labels.insert(image.label[v]);
        if (labels.size() > max_labels_of_image)
            throw InputError("{}: there are more than {} different values, so this is a scan and not a label map; "
                             "segment it first, as with 3D Slicer or TotalSegmentator",
                             name, max_labels_of_image);
    }
    return image;
}

/// An image of labels: how it is made of what a file holds.
struct Labels {
    using Image = LabelImage;

    static Image of(ReadValues read, const std::string &name) {
        auto image = labels_of(*read.values, read.header, name);
        image.label_names = std::move(read.names);
        image.label_codes = std::move(read.codes);
        image.patient_position = std::move(read.patient_position);
        return image;
    }
    static Image segmentation_object(const fs::path &file) {
        auto image = read_dicom_segmentation(file);
        check_grid(image.grid, image.name, image.remarks);
        return image;
    }
};

/// An image of any values.
struct Scalars {
    using Image = ScalarImage;

    static Image of(const ReadValues &read, const std::string &name) {
        Image image{.name = name, .grid = {}, .value = {}};
        image.grid = grid_of(*read.values, read.header, name, image.remarks);
        const float *value = read.values->GetBufferPointer();
        image.value.assign(value, value + num_voxels(image.grid));
        return image;
    }
    static Image segmentation_object(const fs::path &file) {
        throw InputError("{}: this is a segmentation, and not a map of a modulus; give the map of the elastography",
                         file.string());
    }
};

template <class Kind>
typename Kind::Image read_plain_image(const fs::path &file, const std::string &name, const fs::path &scratch) {
    auto read = read_image_values(file, scratch);
    std::vector<std::string> further;
    for (auto *remarks : {&read.header.remarks, &read.remarks})
        std::ranges::move(*remarks, std::back_inserter(further));
    auto image = Kind::of(std::move(read), name);
    std::ranges::move(further, std::back_inserter(image.remarks));
    return image;
}

template <class Kind> typename Kind::Image read_folder(const fs::path &folder, const std::string &name) {
    auto names = itk::GDCMSeriesFileNames::New();
    names->SetUseSeriesDetails(true);
    names->SetDirectory(folder.string());
    const auto series = names->GetSeriesUIDs();
    if (series.size() != 1)
        throw InputError(
            "{}: the folder holds {} DICOM series; give a folder with the one of the segmentation, or a file: {}",
            folder.string(), series.size(), image_formats);
    const auto files = names->GetFileNames(series.front());
    if (files.size() == 1 && is_dicom_segmentation(files.front()))
        return Kind::segmentation_object(files.front());
    auto io = itk::GDCMImageIO::New();
    check_header(*io, files.front());
    auto reader = itk::ImageSeriesReader<Values>::New();
    reader->SetImageIO(io);
    reader->SetFileNames(files);
    reader->ForceOrthogonalDirectionOff(); // a gantry that was tilted shows in the axes, and is refused
    reader->Update();
    double deviation = 0.0;
    itk::ExposeMetaData(reader->GetOutput()->GetMetaDataDictionary(), "ITK_non_uniform_sampling_deviation", deviation);
    if (deviation > 0.1)
        throw InputError(
            "{}: the slices are not evenly spaced ({:.2g} mm off); a slice may be missing, so export the series again",
            folder.string(), deviation);
    std::string position;
    itk::ExposeMetaData(io->GetMetaDataDictionary(), "0018|5100", position);
    return Kind::of({.values = reader->GetOutput(),
                     .names = {},
                     .codes = {},
                     .header = {}, // GDCM reads it
                     .patient_position = without_padding(std::move(position)),
                     .remarks = {}},
                    name);
}

template <class Kind> typename Kind::Image read_here(const fs::path &file, const fs::path &scratch) {
    itk::Object::GlobalWarningDisplayOff(); // what matters of it is checked here
    gdcm::Trace::WarningOff();
    gdcm::Trace::ErrorOff();
    itk::MultiThreaderBase::SetGlobalDefaultNumberOfThreads(1); // each takes address space
    try {
        auto name = file.has_filename() ? file.filename() : file.parent_path().filename();
        if (std::error_code error; fs::is_directory(file, error))
            return read_folder<Kind>(file, name.string());
        return is_dicom_file(file) ? Kind::segmentation_object(file)
                                   : read_plain_image<Kind>(file, name.string(), scratch);
    } catch (const itk::ExceptionObject & /*in words for programmers*/) {
        throw InputError("{}: cannot be read as an image; it may be damaged or cut off, so export it again",
                         file.string());
    }
}

void put(support::Packer &packer, const std::string &name, const ImageGrid &grid,
         const std::vector<std::string> &remarks) {
    packer.put(name);
    packer.put(grid.size);
    for (const Vector3 &vector : {grid.spacing, grid.origin, Vector3(grid.direction.col(0)),
                                  Vector3(grid.direction.col(1)), Vector3(grid.direction.col(2))})
        packer.put(std::array{vector.x(), vector.y(), vector.z()});
    packer.put(remarks);
}

void get(support::Unpacker &unpacker, std::string &name, ImageGrid &grid, std::vector<std::string> &remarks) {
    unpacker.get(name);
    unpacker.get(grid.size);
    std::array<std::array<double, 3>, 5> vectors{};
    for (auto &vector : vectors)
        unpacker.get(vector);
    const auto vector = [&](std::size_t v) { return Vector3(vectors[v][0], vectors[v][1], vectors[v][2]); };
    grid.spacing = vector(0);
    grid.origin = vector(1);
    for (std::size_t axis = 0; axis < 3; ++axis)
        grid.direction.col(static_cast<Eigen::Index>(axis)) = vector(2 + axis);
    unpacker.get(remarks);
}

std::string packed(const Scalars::Image &image) {
    support::Packer packer;
    put(packer, image.name, image.grid, image.remarks);
    packer.put(image.value);
    return std::move(packer).bytes();
}

void unpack(support::Unpacker &unpacker, Scalars::Image &image) {
    get(unpacker, image.name, image.grid, image.remarks);
    unpacker.get(image.value);
}

std::string packed(const LabelImage &image) {
    support::Packer packer;
    put(packer, image.name, image.grid, image.remarks);
    packer.put(image.label);
    packer.put(image.patient_position);
    packer.put(static_cast<int>(image.label_names.size()));
    for (const auto &[label, name] : image.label_names) {
        packer.put(label);
        packer.put(name);
    }
    packer.put(static_cast<int>(image.label_codes.size()));
    for (const auto &[label, code] : image.label_codes) {
        packer.put(label);
        for (const auto *text : {&code.type, &code.meaning, &code.region})
            packer.put(*text);
    }
    return std::move(packer).bytes();
}

void unpack(support::Unpacker &unpacker, LabelImage &image) {
    get(unpacker, image.name, image.grid, image.remarks);
    unpacker.get(image.label);
    unpacker.get(image.patient_position);
    int num_names = 0;
    unpacker.get(num_names);
    for (int n = 0; n < num_names; ++n) {
        int label = 0;
        unpacker.get(label);
        unpacker.get(image.label_names[label]);
    }
    int num_codes = 0;
    unpacker.get(num_codes);
    for (int c = 0; c < num_codes; ++c) {
        int label = 0;
        unpacker.get(label);
        auto &code = image.label_codes[label];
        for (auto *text : {&code.type, &code.meaning, &code.region})
            unpacker.get(*text);
    }
}

/// Reads a file or folder in a process of its own.
template <class Kind> typename Kind::Image read_apart(const fs::path &given) {
    std::error_code error;
    const auto file = header_of_pair(given);
    const auto status = fs::status(file, error);
    if (!fs::exists(status))
        throw InputError("{}: there is no such file or folder; check the path", file.string());
    if (access(file.c_str(), R_OK) != 0)
        throw InputError("{}: cannot be read; check its permissions", file.string());
    if (!fs::is_directory(status))
        support::check_readable(file);
    else
        for (const auto &entry : fs::directory_iterator(file, error))
            if (std::error_code ignored; fs::is_other(entry.status(ignored)))
                throw InputError("{}: '{}' in it is not a plain file; remove it", file.string(),
                                 entry.path().filename().string());
    std::optional<support::ScratchFolder> scratch; // of this process, which is there whatever becomes of the other
    if (!fs::is_directory(status) && needs_a_copy(file))
        scratch.emplace();
    constexpr double bytes_per_byte = 8000.0; // compressed to a thousandth, in floats and labels
    const auto bytes = support::in_own_process(file, support::limits_for(file, bytes_per_byte), [&] {
        return packed(read_here<Kind>(file, scratch ? scratch->path : fs::path()));
    });
    support::Unpacker unpacker(bytes);
    typename Kind::Image image;
    unpack(unpacker, image);
    return image;
}

} // namespace

LabelImage read_label_image(const fs::path &file) {
    return read_apart<Labels>(file);
}

ScalarImage read_scalar_image(const fs::path &file) {
    return read_apart<Scalars>(file);
}

namespace {

constexpr double metres_per_unit_of_itk = 1e-3;

/// Names of labels as 3D Slicer writes them, for read_segments().
itk::MetaDataDictionary dictionary_of(const std::map<int, std::string> &names) {
    itk::MetaDataDictionary dictionary;
    int segment = 0;
    for (const auto &[label, name] : names) {
        const auto put = [&](const char *key, const std::string &value) {
            itk::EncapsulateMetaData<std::string>(dictionary, fmt::format("Segment{}_{}", segment, key), value);
        };
        put("ID", fmt::format("Segment_{}", label));
        put("Name", name);
        put("LabelValue", std::to_string(label));
        put("Layer", "0");
        ++segment;
    }
    return dictionary;
}

template <class Pixel>
void write_image(const fs::path &file, const ImageGrid &grid, const std::vector<Pixel> &pixels,
                 const std::map<int, std::string> &names = {}) {
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
        throw InputError("{}: no such format can be written; end the name in .nii.gz, .nii, .nrrd or .mha",
                         file.string());
    if (!names.empty() && !name.ends_with(".nrrd"))
        throw InputError("{}: this format keeps no names of segments; end the name in .nrrd", file.string());
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
    image->SetMetaDataDictionary(dictionary_of(names));
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
        throw InputError("{}: cannot be written; make room on the disk or choose another place", file.string());
    } catch (const fs::filesystem_error &failure) {
        fs::remove(temporary, error);
        throw InputError("{}: cannot be put there ({})", file.string(), failure.code().message());
    }
}

} // namespace

void write_label_image(const fs::path &file, const LabelImage &image) {
    write_image(file, image.grid, image.label, image.label_names);
}

void write_scan(const fs::path &file, const Scan &scan) {
    write_image(file, scan.grid, scan.grey_value);
}

} // namespace livermark::segmentation
