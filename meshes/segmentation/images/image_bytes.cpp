#include "meshes/segmentation/images/image_headers.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <fmt/format.h>
#include <fstream>
#include <memory>
#include <span>
#include <sstream>
#include <string>
#include <zlib.h>

#include "core/support/files.hpp"
#include "core/support/input_error.hpp"

namespace livermark::segmentation {

namespace {

namespace fs = std::filesystem;

[[noreturn]] void refuse(const fs::path &file, const std::string &what) {
    throw support::InputError("{}: {}; the file is damaged or cut off, so export or copy it again", file.string(),
                              what);
}

/// Hands the bytes of a file on piece by piece, inflated where they are compressed.
template <class Take> void for_each_piece(const fs::path &file, const Take &take) {
    const std::unique_ptr<gzFile_s, int (*)(gzFile)> stream(gzopen(file.c_str(), "rb"), gzclose);
    if (!stream)
        refuse(file, "it cannot be opened");
    std::array<char, 1 << 16> buffer{};
    int count = 0;
    while ((count = gzread(stream.get(), buffer.data(), buffer.size())) > 0)
        take(std::span<const char>(buffer.data(), static_cast<std::size_t>(count)));
    int status = Z_OK;
    gzerror(stream.get(), &status);
    if (count < 0 || status != Z_OK)
        refuse(file, "its compressed data end too early");
}

/// Bytes of a file once it is inflated, or as it is if it is not compressed.
double inflated_size(const fs::path &file) {
    double size = 0.0;
    for_each_piece(file, [&](std::span<const char> bytes) { size += static_cast<double>(bytes.size()); });
    return size;
}

/// ITK takes voxels that are not finite for background, and a lesion may be among them.
/// @param file  that is named
void check_finite(const fs::path &file, const fs::path &voxels, const NiftiHeader &header, double offset,
                  double num_voxels) {
    const auto width = static_cast<std::size_t>(header.bits_per_voxel) / 8;
    auto skipped = static_cast<std::size_t>(offset);
    std::array<char, sizeof(double)> number{};
    std::size_t filled = 0;
    double voxel = 0.0;
    for_each_piece(voxels, [&](std::span<const char> bytes) {
        const auto skip = std::min(skipped, bytes.size());
        skipped -= skip;
        for (const char byte : bytes.subspan(skip)) {
            number.at(filled++) = byte;
            if (filled < width || voxel >= num_voxels)
                continue;
            if (!is_finite({number.data(), width}, header.is_swapped))
                throw support::InputError("{}: voxel {:.0f} is not a finite number; give it a label, or 0 for "
                                          "background, and export the image again",
                                          file.string(), voxel);
            voxel += 1.0;
            filled = 0;
        }
    });
}

void check_nifti_pair(const fs::path &file, double num_voxels) {
    const auto said = read_nifti_header(file);
    const auto voxels = voxels_of_pair(file);
    if (!said || !voxels || !(said->bits_per_voxel > 0))
        return; // of which ITK takes care
    const double wanted = num_voxels * said->bits_per_voxel / 8.0;
    const double offset = said->data_offset;
    if (!std::isfinite(offset) || offset != std::floor(offset))
        refuse(file, fmt::format("its header says that the voxels begin at byte {:g}", offset));
    const double needed = std::max(offset, 0.0) + wanted;
    if (const double size = inflated_size(*voxels); size < needed)
        refuse(file, fmt::format("'{}' holds {:.0f} bytes where {:.0f} are said",
                                 support::shown(voxels->filename().string()), size, needed));
    if (said->has_floats && (said->bits_per_voxel == 32 || said->bits_per_voxel == 64))
        check_finite(file, *voxels, *said, std::max(offset, 0.0), num_voxels);
}

void check_nifti(const fs::path &file, double num_voxels, double data_bytes) {
    constexpr double shortest_header = 348;
    const double size = inflated_size(file);
    double header = shortest_header;
    const auto said = read_nifti_header(file);
    if (said && said->bits_per_voxel > 0) {
        data_bytes = num_voxels * said->bits_per_voxel / 8.0; // ITK speaks of what a slope makes of them
        // ITK reads from the end of the shortest header where it is told something else, and so beside the voxels.
        const double offset = said->data_offset;
        if (!(offset >= shortest_header && offset == std::floor(offset)) && size != shortest_header + data_bytes)
            refuse(file, fmt::format("its header says that the voxels begin at byte {:g}", offset));
        header = std::max(header, offset);
    }
    if (size < header + data_bytes)
        refuse(file,
               fmt::format("it holds {:.0f} bytes where header and voxels need {:.0f}", size, header + data_bytes));
    if (said && said->has_floats && (said->bits_per_voxel == 32 || said->bits_per_voxel == 64))
        check_finite(file, file, *said, header, num_voxels);
}

/// Such as "slice_%03d.raw 1 40 1": the first word goes to printf, which believes whatever it says.
bool is_pattern_of_one_number(const std::string &data_file) {
    const auto word = data_file.substr(0, data_file.find(' '));
    const auto percent = word.find('%');
    const auto letter = word.find_first_not_of("0123456789", percent + 1);
    return letter != std::string::npos && letter - percent <= 3 && word[letter] == 'd' &&
           word.find('%', percent + 1) == std::string::npos;
}

void check_meta_image(const fs::path &file, double data_bytes) {
    std::ifstream stream(file, std::ios::binary);
    std::string line, data_file;
    bool is_compressed = false;
    double compressed = 0.0;
    while (data_file.empty() && std::getline(stream, line)) {
        if (trimmed(line).empty())
            continue;
        const auto separator = line.find_first_of("=:");
        if (separator == std::string::npos)
            refuse(file, fmt::format("its header has the line '{}'", support::shown(line)));
        const auto key = trimmed(line.substr(0, separator)), value = trimmed(line.substr(separator + 1));
        if (key == "CompressedData")
            is_compressed = value == "True" || value == "true" || value == "1";
        else if (key == "CompressedDataSize")
            compressed = std::strtod(value.c_str(), nullptr);
        else if (key == "ElementDataFile")
            data_file = value;
    }
    std::error_code error;
    double present = 0.0;
    if (data_file == "LOCAL")
        present = static_cast<double>(fs::file_size(file, error)) - static_cast<double>(stream.tellg());
    else if (data_file.find('%') != std::string::npos && !is_pattern_of_one_number(data_file))
        refuse(file, fmt::format("'{}' is not a pattern for the names of its slices", support::shown(data_file)));
    else if (data_file != "LIST" && data_file.find('%') == std::string::npos)
        present = static_cast<double>(fs::file_size(file.parent_path() / data_file, error));
    else
        return; // a file for each slice: ITK misses one that is not whole
    if (error)
        refuse(file, fmt::format("there is no file '{}' with its voxels", support::shown(data_file)));
    const double wanted = is_compressed ? compressed : data_bytes;
    if (present < wanted || (is_compressed && wanted == 0.0))
        refuse(file, fmt::format("it holds {:.0f} bytes of voxels where {:.0f} are said", present, wanted));
}

/// MetaIO makes arrays for as many dimensions as a header speaks of, and works on them until a limit of time.
void check_meta_dimensions(const fs::path &file, const std::string &line) {
    constexpr double most_dimensions = 10; // of MetaIO
    const auto separator = line.find_first_of("=:");
    if (separator == std::string::npos || trimmed(line.substr(0, separator)) != "NDims")
        return;
    const auto text = trimmed(line.substr(separator + 1));
    char *end = nullptr;
    const double number = std::strtod(text.c_str(), &end);
    if (end == text.c_str() || *end != '\0' || !(number >= 1 && number <= most_dimensions) ||
        number != std::floor(number))
        refuse(file,
               fmt::format("its header says that it has '{}' dimensions, where a segmentation of a body has three",
                           support::shown(text)));
}

/// "data file: liver.raw"; what is a list or a pattern of names is ITK's to follow.
void check_nrrd_data_file(const fs::path &file, const std::string &line) {
    const auto separator = line.find(':');
    const auto key = support::lower_case(trimmed(line.substr(0, separator)));
    if (separator == std::string::npos || (key != "data file" && key != "datafile"))
        return;
    const auto data_file = trimmed(line.substr(separator + 1));
    std::error_code error;
    if (!data_file.starts_with("LIST") && data_file.find('%') == std::string::npos &&
        !fs::exists(file.parent_path() / data_file, error))
        refuse(file, fmt::format("there is no file '{}' with its voxels", support::shown(data_file)));
}

} // namespace

std::string trimmed(const std::string &text) {
    const auto first = text.find_first_not_of(" \t\r");
    return first == std::string::npos ? "" : text.substr(first, text.find_last_not_of(" \t\r") + 1 - first);
}

void check_voxels_beside(const fs::path &file) {
    if (support::file_ending(file) == ".hdr" && !voxels_of_pair(file))
        refuse(file,
               fmt::format("there is no file '{}' with its voxels", support::shown(file.stem().string()) + ".img"));
}

void check_text_of_header(const fs::path &file) {
    constexpr int most_lines = 100000;
    const auto ending = support::file_ending(file);
    const bool is_meta_image = ending == ".mha" || ending == ".mhd";
    std::ifstream stream(file, std::ios::binary);
    std::string line;
    for (int l = 0; l < most_lines && std::getline(stream, line); ++l) {
        if (!is_meta_image && (line.empty() || line == "\r"))
            return; // the end of a header of NRRD
        if (is_meta_image)
            check_meta_dimensions(file, line);
        else
            check_nrrd_data_file(file, line);
        std::ranges::replace_if(
            line, [](char c) { return c == '=' || c == ':' || c == '\r'; }, ' ');
        std::istringstream words(line);
        for (std::string word; words >> word && word.size() < 4096;) {
            if (word == "LOCAL")
                return; // voxels follow
            std::error_code ignored;
            if (fs::is_other(fs::status(file.parent_path() / word, ignored)))
                refuse(file, fmt::format("'{}', which its header names, is not a plain file", support::shown(word)));
        }
    }
}

void check_all_there(const fs::path &file, double num_voxels, double data_bytes) {
    const auto name = support::lower_case(file.filename().string());
    if (name.ends_with(".nii") || name.ends_with(".nii.gz"))
        check_nifti(file, num_voxels, data_bytes);
    else if (name.ends_with(".hdr"))
        check_nifti_pair(file, num_voxels);
    else if (name.ends_with(".mha") || name.ends_with(".mhd"))
        check_meta_image(file, data_bytes);
}

void check_dicom_pixels(const fs::path &file, std::size_t data_bytes) {
    const auto bytes = support::read_text(file);
    const std::string tag("\xe0\x7f\x10\x00", 4);
    const auto length_at = [&](std::size_t place) {
        std::size_t length = 0;
        for (std::size_t b = 0; b < 4 && place + b < bytes.size(); ++b)
            length |= static_cast<std::size_t>(static_cast<unsigned char>(bytes[place + b])) << (8 * b);
        return length;
    };
    for (auto at = bytes.find(tag); at != std::string::npos; at = bytes.find(tag, at + 1))
        for (const std::size_t header : {8, 12}) // implicit and explicit VR
            if (length_at(at + header - 4) == data_bytes && at + header + data_bytes <= bytes.size())
                return;
    refuse(file, fmt::format("it does not hold the {} bytes of pixels that are said", data_bytes));
}

} // namespace livermark::segmentation
