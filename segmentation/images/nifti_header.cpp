#include "segmentation/images/nifti_header.hpp"

#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fmt/format.h>
#include <fstream>
#include <memory>
#include <numbers>
#include <string_view>
#include <system_error>
#include <zlib.h>

#include "support/file_ending.hpp"
#include "support/input_error.hpp"

namespace livermark::segmentation {

namespace {

constexpr std::size_t header_bytes = 348;
/// Places of the fields [byte].
constexpr std::size_t datatype_at = 70, bitpix_at = 72, pixdim_at = 76, vox_offset_at = 108, qform_code_at = 252,
                      sform_code_at = 254, srow_at = 280;

using Bytes = std::array<char, header_bytes>;

template <class Number> Number number_at(const Bytes &bytes, std::size_t place, bool is_swapped) {
    std::array<char, sizeof(Number)> raw{};
    std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(place), raw.size(), raw.begin());
    if (is_swapped)
        std::ranges::reverse(raw);
    Number number{};
    std::memcpy(&number, raw.data(), raw.size());
    return number;
}

void put_float(Bytes &bytes, std::size_t place, float number, bool is_swapped) {
    std::array<char, sizeof(float)> raw{};
    std::memcpy(raw.data(), &number, raw.size());
    if (is_swapped)
        std::ranges::reverse(raw);
    std::ranges::copy(raw, bytes.begin() + static_cast<std::ptrdiff_t>(place));
}

using Stream = std::unique_ptr<gzFile_s, int (*)(gzFile)>;

/// A file beside another, of the same name and another ending, in whatever case.
std::optional<std::filesystem::path> beside(const std::filesystem::path &file, const std::string &ending) {
    std::error_code error;
    const auto stem = file.stem().string();
    const auto folder = std::filesystem::absolute(file).parent_path();
    for (auto entry = std::filesystem::directory_iterator(folder, error);
         !error && entry != std::filesystem::directory_iterator(); entry.increment(error)) {
        const auto name = entry->path().filename().string();
        if (name.size() == stem.size() + ending.size() && name.starts_with(stem) &&
            support::lower_case(name.substr(stem.size())) == ending)
            return file.parent_path() / name;
    }
    return std::nullopt;
}

/// What stands in an extension of the header, whatever it is; at most a megabyte.
std::string extensions_of(const std::filesystem::path &file, double data_offset) {
    constexpr double most_bytes = 1 << 20, begin = header_bytes + 4;
    const bool is_pair = support::file_ending(file) == ".hdr";
    const double end = is_pair ? begin + most_bytes : data_offset;
    if (!(end > begin))
        return {};
    const Stream stream(gzopen(file.c_str(), "rb"), gzclose);
    std::string bytes(static_cast<std::size_t>(std::min(end, begin + most_bytes)), '\0');
    const int count = stream ? gzread(stream.get(), bytes.data(), static_cast<unsigned>(bytes.size())) : 0;
    if (count <= static_cast<int>(begin) || bytes[header_bytes] == '\0') // which says that there is none
        return {};
    return bytes.substr(static_cast<std::size_t>(begin), static_cast<std::size_t>(count - static_cast<int>(begin)));
}

} // namespace

std::filesystem::path header_of_pair(const std::filesystem::path &file) {
    return support::file_ending(file) == ".img" ? beside(file, ".hdr").value_or(file) : file;
}

std::optional<std::filesystem::path> voxels_of_pair(const std::filesystem::path &header) {
    auto plain = beside(header, ".img");
    return plain ? plain : beside(header, ".img.gz");
}

std::map<int, std::string> nifti_label_names(const std::filesystem::path &file, const NiftiHeader &header) {
    constexpr std::string_view element = "<Label ", key = "Key=\"", begin_of_name = "<![CDATA[", end_of_name = "]]>";
    std::map<int, std::string> names;
    const auto text = extensions_of(file, header.data_offset);
    for (auto at = text.find(element); at != std::string::npos; at = text.find(element, at + 1)) {
        const auto end = text.find("</Label>", at);
        const auto number = text.find(key, at), name = text.find(begin_of_name, at);
        const auto end_of = text.find(end_of_name, name);
        if (end == std::string::npos || number > end || name > end || end_of > end)
            continue;
        const int label = std::atoi(text.c_str() + number + key.size());
        const auto first = name + begin_of_name.size();
        if (label > 0 && end_of > first)
            names.emplace(label, support::shown(text.substr(first, end_of - first)));
    }
    return names;
}

bool is_finite(std::span<const char> bytes, bool is_swapped) {
    // The exponent is in the first two bytes of a number that is written from its largest byte on; all ones are no
    // number.
    const auto byte = [&](std::size_t b) {
        return static_cast<unsigned char>(bytes[is_swapped ? b : bytes.size() - 1 - b]);
    };
    const unsigned first = byte(0) << 8U | byte(1), ones = bytes.size() == sizeof(float) ? 0x7f80U : 0x7ff0U;
    return (first & ones) != ones;
}

std::optional<NiftiHeader> read_nifti_header(const std::filesystem::path &file) {
    const Stream stream(gzopen(file.c_str(), "rb"), gzclose); // reads what is not compressed as well
    Bytes bytes{};
    if (!stream || gzread(stream.get(), bytes.data(), bytes.size()) != static_cast<int>(bytes.size()))
        return std::nullopt;
    NiftiHeader header;
    header.is_swapped = number_at<std::int32_t>(bytes, 0, true) == static_cast<std::int32_t>(header_bytes);
    if (!header.is_swapped && number_at<std::int32_t>(bytes, 0, false) != static_cast<std::int32_t>(header_bytes))
        return std::nullopt;
    constexpr std::int16_t float32 = 16, float64 = 64;
    const auto type = number_at<std::int16_t>(bytes, datatype_at, header.is_swapped);
    header.has_floats = type == float32 || type == float64;
    header.bits_per_voxel = number_at<std::int16_t>(bytes, bitpix_at, header.is_swapped);
    header.data_offset = number_at<float>(bytes, vox_offset_at, header.is_swapped);
    header.qform_code = number_at<std::int16_t>(bytes, qform_code_at, header.is_swapped);
    header.sform_code = number_at<std::int16_t>(bytes, sform_code_at, header.is_swapped);
    for (std::size_t a = 0; a < 3; ++a) {
        const auto axis = static_cast<Eigen::Index>(a);
        header.spacing[axis] = number_at<float>(bytes, pixdim_at + 4 * (a + 1), header.is_swapped);
        for (std::size_t c = 0; c < 3; ++c)
            header.sform(static_cast<Eigen::Index>(c), axis) =
                number_at<float>(bytes, srow_at + 16 * c + 4 * a, header.is_swapped);
    }
    return header;
}

std::vector<std::string> doubts_about_forms(const NiftiHeader &header) {
    constexpr double most = 0.01; // of a spacing
    const Eigen::Vector3d spacing = header.sform.colwise().norm();
    const bool disagree = ((spacing - header.spacing).array().abs() > most * header.spacing.array().abs()).any();
    if (header.sform_code <= 0 || !spacing.allFinite() || !header.spacing.allFinite() || !disagree)
        return {};
    return {
        fmt::format("the header disagrees with itself: voxels are {:.3g} x {:.3g} x {:.3g} mm by its pixdim{}, which "
                    "counts here, and {:.3g} x {:.3g} x {:.3g} mm by its sform; export the image again if the first "
                    "are not right",
                    header.spacing.x(), header.spacing.y(), header.spacing.z(),
                    header.qform_code > 0 ? " and qform" : "", spacing.x(), spacing.y(), spacing.z())};
}

AxesOff off_right_angles(const Eigen::Matrix3d &axes) {
    AxesOff worst;
    for (int a = 0; a < 3; ++a)
        for (int b = a + 1; b < 3; ++b) {
            const double cosine = axes.col(a).dot(axes.col(b)) / (axes.col(a).norm() * axes.col(b).norm());
            const double off = std::abs(std::asin(std::clamp(cosine, -1.0, 1.0))) * 180.0 / std::numbers::pi;
            if (!(off <= worst.degrees))
                worst = {off, fmt::format("axes {} and {} are {:.3g} degrees off a right angle", a, b, off)};
        }
    return worst;
}

void write_with_right_angles(const std::filesystem::path &file, const NiftiHeader &header,
                             const std::filesystem::path &to) {
    constexpr double rounding = 0.01;
    const Eigen::Vector3d lengths = header.sform.colwise().norm();
    const Eigen::Matrix3d directions = header.sform * lengths.cwiseInverse().asDiagonal();
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(directions, Eigen::ComputeFullU | Eigen::ComputeFullV);
    // The lengths were rounded with the axes, and ITK compares them with the spacing.
    const bool is_rounded = ((lengths - header.spacing).array().abs() < rounding * lengths.array()).all();
    const Eigen::Matrix3d axes =
        svd.matrixU() * svd.matrixV().transpose() * (is_rounded ? header.spacing : lengths).asDiagonal();
    const Stream stream(gzopen(file.c_str(), "rb"), gzclose);
    Bytes bytes{};
    if (!stream || gzread(stream.get(), bytes.data(), bytes.size()) != static_cast<int>(bytes.size()))
        return;
    for (std::size_t a = 0; a < 3; ++a)
        for (std::size_t c = 0; c < 3; ++c)
            put_float(bytes, srow_at + 16 * c + 4 * a,
                      static_cast<float>(axes(static_cast<Eigen::Index>(c), static_cast<Eigen::Index>(a))),
                      header.is_swapped);
    std::ofstream out(to, std::ios::binary);
    out.write(bytes.data(), bytes.size());
    std::array<char, 1 << 16> buffer{};
    for (int count = 0; (count = gzread(stream.get(), buffer.data(), buffer.size())) > 0;)
        out.write(buffer.data(), count);
}

} // namespace livermark::segmentation
