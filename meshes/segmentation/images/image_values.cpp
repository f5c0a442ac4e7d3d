#include "meshes/segmentation/images/image_values.hpp"

#include <algorithm>
#include <cstdlib>
#include <fmt/format.h>
#include <fstream>
#include <iterator>
#include <itkImageFileReader.h>
#include <itkMetaDataObject.h>
#include <itkMetaImageIO.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>
#include <sstream>
#include <string_view>
#include <utility>

#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "meshes/io/mesh_files.hpp"
#include "meshes/segmentation/images/image_headers.hpp"

namespace livermark::segmentation {

namespace {

namespace fs = std::filesystem;
using support::InputError;

constexpr double largest_image = 1 << 28; // voxels; the largest abdominal scans have about this many
constexpr double best_compression = 1100; // zlib cannot do better

itk::ImageIOBase::Pointer reader_of(const fs::path &file) {
    for (const itk::ImageIOBase::Pointer &io :
         {itk::ImageIOBase::Pointer(itk::NiftiImageIO::New()), itk::ImageIOBase::Pointer(itk::NrrdImageIO::New()),
          itk::ImageIOBase::Pointer(itk::MetaImageIO::New())})
        if (io->CanReadFile(file.c_str()))
            return io;
    if (const auto first = meshes::first_bytes(file); first.starts_with("\xef\xbb\xbf"))
        throw InputError("{}: it begins with a byte order mark, which no reader of such images passes over; save its "
                         "header without one, as plain ASCII",
                         file.string());
    else if (first.starts_with("\x1f\x8b"))
        throw InputError("{}: it is compressed by gzip, which its name does not say; call it {}.gz", file.string(),
                         file.filename().string());
    throw InputError("{}: this is not an image that can be read here, or it is damaged from the start; give {}",
                     file.string(), image_formats);
}

/// Type and region of a segment in the words of 3D Slicer's tags: "TerminologyEntry:context~category~type~modifier~
/// context~region~modifier|...", of which type and region are "scheme^value^meaning".
core::SegmentCode code_in_tags(const std::string &tags) {
    constexpr std::string_view key = "TerminologyEntry:";
    constexpr std::size_t type_at = 2, region_at = 5;
    const auto parts_of = [](std::string text, char separator) {
        std::vector<std::string> parts;
        std::istringstream stream(std::move(text));
        for (std::string part; std::getline(stream, part, separator);)
            parts.push_back(part);
        return parts;
    };
    const auto begin = tags.find(key);
    if (begin == std::string::npos)
        return {};
    const auto end = tags.find('|', begin);
    const auto first = begin + key.size();
    auto fields = parts_of(tags.substr(first, end == std::string::npos ? end : end - first), '~');
    fields.resize(region_at + 1);
    auto type = parts_of(fields[type_at], '^'), region = parts_of(fields[region_at], '^');
    type.resize(3);
    region.resize(3);
    return {.type = type[1], .meaning = type[2], .region = region[2]};
}

/// 3D Slicer names its segments in the header: Segment0_LabelValue:=1, Segment0_Name:=Liver.
void read_segments(const itk::MetaDataDictionary &dictionary, ReadValues &read) {
    constexpr int most_segments = 1000;
    for (int s = 0; s < most_segments; ++s) {
        std::string label, name, tags;
        if (!itk::ExposeMetaData(dictionary, fmt::format("Segment{}_LabelValue", s), label))
            break;
        itk::ExposeMetaData(dictionary, fmt::format("Segment{}_Name", s), name);
        itk::ExposeMetaData(dictionary, fmt::format("Segment{}_Tags", s), tags);
        const int number = std::atoi(label.c_str());
        if (number > 0 && !name.empty())
            read.names.emplace(number, name);
        if (auto code = code_in_tags(tags); number > 0 && !code.type.empty())
            read.codes.emplace(number, std::move(code));
    }
}

ReadValues read_values(const fs::path &file) {
    const auto io = reader_of(file);
    check_header(*io, file);
    ReadValues read;
    auto reader = itk::ImageFileReader<Values>::New();
    reader->SetImageIO(io);
    reader->SetFileName(file.string());
    reader->Update();
    read_segments(io->GetMetaDataDictionary(), read);
    read.values = reader->GetOutput();
    read.header = grid_in_header(file);
    return read;
}

/// Whether ITK would take the axes for sheared where they are only rounded.
bool has_rounded_axes(const NiftiHeader &header) {
    constexpr double seen_by_itk = 0.005;
    const double off = off_right_angles(header.sform).degrees;
    return header.sform_code > 0 && off > seen_by_itk && off <= most_degrees_off;
}

std::string name_with_lower_ending(const fs::path &file) {
    const auto name = file.filename().string(), ending = file.extension().string();
    return name.substr(0, name.size() - ending.size()) + support::lower_case(ending);
}

/// ITK goes by endings in lower case. A link has one, with links beside it to whatever a header may name.
fs::path with_lower_ending(const fs::path &file, const fs::path &scratch) {
    const auto lower = name_with_lower_ending(file);
    if (scratch.empty())
        return file;
    std::error_code error;
    const auto whole = fs::absolute(file);
    for (auto entry = fs::directory_iterator(whole.parent_path(), error); !error && entry != fs::directory_iterator();
         entry.increment(error))
        fs::create_symlink(entry->path(), scratch / entry->path().filename(), error);
    fs::create_symlink(whole, scratch / lower, error);
    return scratch / lower;
}

/// ITK finds of two files the second by an ending in the case of the first.
bool is_pair_in_capitals(const fs::path &header) {
    const auto voxels = support::file_ending(header) == ".hdr" ? voxels_of_pair(header) : std::nullopt;
    return voxels && (header.extension() != ".hdr" || name_with_lower_ending(*voxels) != voxels->filename().string());
}

/// Place for a NIfTI header, with its voxels beside it if they are in a file of their own.
fs::path place_in(const fs::path &scratch, const fs::path &header, const std::string &stem = "image") {
    if (support::file_ending(header) != ".hdr")
        return scratch / (stem + ".nii");
    if (const auto voxels = voxels_of_pair(header))
        fs::create_symlink(fs::absolute(*voxels),
                           scratch / (stem + (support::file_ending(*voxels) == ".gz" ? ".img.gz" : ".img")));
    return scratch / (stem + ".hdr");
}

/// Reads a file that stands for another, which messages name.
template <class Read = ReadValues (*)(const fs::path &)>
ReadValues read_in_place_of(const fs::path &file, const fs::path &readable, const Read &read = read_values) {
    try {
        return read(readable);
    } catch (const InputError &error) {
        std::string text = error.what();
        if (const auto at = text.find(readable.string()); at != std::string::npos)
            text.replace(at, readable.string().size(), file.string());
        throw InputError(text);
    }
}

} // namespace

void check_header(itk::ImageIOBase &io, const fs::path &file) {
    if (!fs::is_directory(file) && !read_nifti_header(file) && !is_dicom_file(file))
        check_text_of_header(file);
    check_voxels_beside(file);
    io.SetFileName(file.string());
    io.ReadImageInformation();
    const auto dimensions = io.GetNumberOfDimensions();
    if (dimensions < 3)
        throw InputError("{}: the image has {} dimensions; a segmentation of a body has three", file.string(),
                         dimensions);
    for (unsigned d = 3; d < dimensions; ++d)
        if (io.GetDimensions(d) > 1)
            throw InputError("{}: the image is a series of {} volumes; give one of them", file.string(),
                             io.GetDimensions(d));
    if (io.GetNumberOfComponents() != 1)
        throw InputError("{}: each voxel has {} values; export it as a label map with one label a voxel", file.string(),
                         io.GetNumberOfComponents());
    double voxels = 1.0;
    for (unsigned d = 0; d < 3; ++d)
        voxels *= static_cast<double>(io.GetDimensions(d));
    if (!(voxels > 0.0 && voxels <= largest_image))
        throw InputError("{}: the header speaks of {:.3g} voxels; between 1 and {:.3g} can be read, so crop the image "
                         "around the liver, or check whether the file is damaged",
                         file.string(), voxels, largest_image);
    const auto ending = support::file_ending(file);
    const bool is_detached = ending == ".nhdr" || ending == ".mhd" || ending == ".hdr" || ending == ".img";
    const double bytes = voxels * static_cast<double>(io.GetComponentSize());
    if (!is_detached && bytes > best_compression * static_cast<double>(fs::file_size(file)))
        throw InputError("{}: the header speaks of {:.0f} bytes, more than {} bytes of file can hold; the file is "
                         "damaged or cut off",
                         file.string(), bytes, fs::file_size(file));
    check_all_there(file, voxels, bytes);
}

bool needs_a_copy(const fs::path &file) {
    if (is_nifti_2(file))
        return true;
    if (const auto header = read_nifti_header(file))
        return has_rounded_axes(*header) || is_pair_in_capitals(file);
    return name_with_lower_ending(file) != file.filename().string();
}

ReadValues read_image_values(const fs::path &file, const fs::path &scratch) {
    if (is_nifti_2(file)) {
        const auto copy = place_in(scratch, file, "version_1");
        write_as_nifti_1(file, copy);
        return read_in_place_of(file, copy, [&](const fs::path &path) { return read_image_values(path, scratch); });
    }
    const auto header = read_nifti_header(file);
    if (!header)
        return read_in_place_of(file, with_lower_ending(file, scratch));
    const auto off = off_right_angles(header->sform);
    ReadValues read;
    if (has_rounded_axes(*header)) {
        const auto copy = place_in(scratch, file);
        write_with_right_angles(file, *header, copy);
        read = read_in_place_of(file, copy);
        read.header = grid_in_header(file);
        read.remarks.push_back(off.text + ", and are turned to the nearest axes at right angles");
    } else if (is_pair_in_capitals(file)) {
        const auto link = place_in(scratch, file);
        fs::create_symlink(fs::absolute(file), link);
        read = read_in_place_of(file, link);
    } else if (header->sform_code > 0 && header->qform_code <= 0 && off.degrees > most_degrees_off) {
        throw InputError("{}: the axes of the image are not at right angles ({}); resample it, as with 3D Slicer's "
                         "module Resample Scalar/Vector/DWI Volume",
                         file.string(), off.text);
    } else {
        read = read_values(file);
    }
    for (const auto &[label, name] : nifti_label_names(file, *header))
        read.names.emplace(label, name);
    std::ranges::move(doubts_about_forms(*header), std::back_inserter(read.remarks));
    return read;
}

} // namespace livermark::segmentation
