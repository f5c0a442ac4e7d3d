#include "meshes/segmentation/images/image_headers.hpp"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fmt/format.h>
#include <fstream>
#include <limits>
#include <memory>
#include <numbers>
#include <string_view>
#include <system_error>
#include <zlib.h>

#include "core/support/files.hpp"
#include "core/support/input_error.hpp"

namespace livermark::segmentation {

namespace {

constexpr std::size_t header_bytes = 348;
/// Places of the fields [byte].
constexpr std::size_t dim_at = 40, datatype_at = 70, bitpix_at = 72, pixdim_at = 76, vox_offset_at = 108,
                      slope_at = 112, units_at = 123, qform_code_at = 252, sform_code_at = 254, quatern_at = 256,
                      qoffset_at = 268, srow_at = 280, magic_at = 344;
constexpr std::size_t header_bytes_2 = 540; // of NIfTI-2, whose fields are wider

using Bytes = std::array<char, header_bytes>;
using Bytes2 = std::array<char, header_bytes_2>;

template <class Number> Number number_at(std::span<const char> bytes, std::size_t place, bool is_swapped) {
    std::array<char, sizeof(Number)> raw{};
    std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(place), raw.size(), raw.begin());
    if (is_swapped)
        std::ranges::reverse(raw);
    Number number{};
    std::memcpy(&number, raw.data(), raw.size());
    return number;
}

template <class Number> void put_number(Bytes &bytes, std::size_t place, Number number, bool is_swapped = false) {
    std::array<char, sizeof(Number)> raw{};
    std::memcpy(raw.data(), &number, raw.size());
    if (is_swapped)
        std::ranges::reverse(raw);
    std::ranges::copy(raw, bytes.begin() + static_cast<std::ptrdiff_t>(place));
}

/// Axes of a unit quaternion of which the header has the last three numbers.
/// @param handedness  -1 if the third axis points the other way
Eigen::Matrix3d axes_of(const Eigen::Vector3d &quaternion, double handedness) {
    const double first = std::sqrt(std::max(0.0, 1.0 - quaternion.squaredNorm()));
    Eigen::Matrix3d axes =
        Eigen::Quaterniond(first, quaternion.x(), quaternion.y(), quaternion.z()).normalized().toRotationMatrix();
    axes.col(2) *= handedness;
    return axes;
}

using Stream = std::unique_ptr<gzFile_s, int (*)(gzFile)>;

void copy_rest(gzFile stream, std::ofstream &out) {
    std::array<char, 1 << 16> buffer{};
    for (int count = 0; (count = gzread(stream, buffer.data(), buffer.size())) > 0;)
        out.write(buffer.data(), count);
}

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

/// Contents of an extension of the header, whatever it is; at most a megabyte.
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
    constexpr int unit_bits = 7, metres = 1, micrometres = 3;
    const int unit = bytes[units_at] & unit_bits;
    header.metres_per_unit = unit == metres ? 1.0 : unit == micrometres ? 1e-6 : 1e-3;
    header.is_nifti = bytes[magic_at] == 'n' && (bytes[magic_at + 1] == '+' || bytes[magic_at + 1] == 'i');
    header.has_floats = type == float32 || type == float64;
    header.bits_per_voxel = number_at<std::int16_t>(bytes, bitpix_at, header.is_swapped);
    header.data_offset = number_at<float>(bytes, vox_offset_at, header.is_swapped);
    header.qform_code = number_at<std::int16_t>(bytes, qform_code_at, header.is_swapped);
    header.sform_code = number_at<std::int16_t>(bytes, sform_code_at, header.is_swapped);
    Eigen::Vector3d quaternion;
    for (std::size_t a = 0; a < 3; ++a) {
        const auto axis = static_cast<Eigen::Index>(a);
        header.size.at(a) = number_at<std::int16_t>(bytes, dim_at + 2 * (a + 1), header.is_swapped);
        quaternion[axis] = number_at<float>(bytes, quatern_at + 4 * a, header.is_swapped);
        header.qform_origin[axis] = number_at<float>(bytes, qoffset_at + 4 * a, header.is_swapped);
        header.sform_origin[axis] = number_at<float>(bytes, srow_at + 16 * a + 12, header.is_swapped);
        header.spacing[axis] = number_at<float>(bytes, pixdim_at + 4 * (a + 1), header.is_swapped);
        for (std::size_t c = 0; c < 3; ++c)
            header.sform(static_cast<Eigen::Index>(c), axis) =
                number_at<float>(bytes, srow_at + 16 * c + 4 * a, header.is_swapped);
    }
    if (!header.is_nifti) { // Analyze 7.5 has other things in these places
        header.qform_code = header.sform_code = 0;
        header.metres_per_unit = 1e-3;
    }
    header.qform = axes_of(quaternion, number_at<float>(bytes, pixdim_at, header.is_swapped) < 0.0F ? -1.0 : 1.0);
    return header;
}

bool is_nifti_2(const std::filesystem::path &file) {
    const Stream stream(gzopen(file.c_str(), "rb"), gzclose);
    std::array<char, 8> bytes{};
    if (!stream || gzread(stream.get(), bytes.data(), bytes.size()) != static_cast<int>(bytes.size()))
        return false;
    const auto says = [&](bool is_swapped) {
        return number_at<std::int32_t>(bytes, 0, is_swapped) == static_cast<std::int32_t>(header_bytes_2);
    };
    return bytes[4] == 'n' && bytes[6] == '2' && (says(false) || says(true));
}

void write_as_nifti_1(const std::filesystem::path &file, const std::filesystem::path &to) {
    const Stream stream(gzopen(file.c_str(), "rb"), gzclose);
    Bytes2 from{};
    if (!stream || gzread(stream.get(), from.data(), from.size()) != static_cast<int>(from.size()))
        throw support::InputError("{}: its header ends too early; export it again", file.string());
    const bool is_swapped = number_at<std::int32_t>(from, 0, false) != static_cast<std::int32_t>(header_bytes_2);
    const auto real = [&](std::size_t place) { return number_at<double>(from, place, is_swapped); };
    const auto whole = [&](std::size_t place) { return number_at<std::int32_t>(from, place, is_swapped); };
    const auto half = [&](std::size_t place) { return number_at<std::int16_t>(from, place, is_swapped); };
    const auto wide = [&](std::size_t place) { return number_at<std::int64_t>(from, place, is_swapped); };
    // Voxels keep the byte order of the file, so the header has to say it too.
    Bytes header{};
    const auto put = [&](std::size_t place, auto number) { put_number(header, place, number, is_swapped); };
    const auto put_float = [&](std::size_t place, double number) { put(place, static_cast<float>(number)); };
    put(0, static_cast<std::int32_t>(header_bytes));
    for (std::size_t d = 0; d < 8; ++d) {
        const auto extent = wide(16 + 8 * d);
        if (extent < 0 || extent > std::numeric_limits<std::int16_t>::max())
            throw support::InputError("{}: its header speaks of {} voxels along an axis; crop the image around the "
                                      "liver, or check whether the file is damaged",
                                      file.string(), extent);
        put(dim_at + 2 * d, static_cast<std::int16_t>(extent));
        put_float(pixdim_at + 4 * d, real(104 + 8 * d));
    }
    put(datatype_at, half(12));
    put(bitpix_at, half(14));
    const bool is_pair = from[5] == 'i';
    constexpr std::int64_t shorter = header_bytes_2 - header_bytes;
    put_float(vox_offset_at, static_cast<double>(is_pair ? wide(168) : wide(168) - shorter));
    put_float(slope_at, real(176));
    put_float(slope_at + 4, real(184));
    header[units_at] = static_cast<char>(whole(500));
    put(qform_code_at, static_cast<std::int16_t>(whole(344)));
    put(sform_code_at, static_cast<std::int16_t>(whole(348)));
    for (std::size_t c = 0; c < 3; ++c) {
        put_float(quatern_at + 4 * c, real(352 + 8 * c));
        put_float(qoffset_at + 4 * c, real(376 + 8 * c));
    }
    for (std::size_t c = 0; c < 12; ++c)
        put_float(srow_at + 4 * c, real(400 + 8 * c));
    std::ranges::copy(std::string_view(is_pair ? "ni1" : "n+1"), header.begin() + magic_at);
    std::ofstream out(to, std::ios::binary);
    out.write(header.data(), header.size());
    copy_rest(stream.get(), out);
}

std::vector<std::string> doubts_about_forms(const NiftiHeader &header) {
    constexpr double most = 0.01; // of a spacing
    const double millimetres = 1e3 * header.metres_per_unit;
    const Eigen::Vector3d spacing = header.sform.colwise().norm();
    const bool disagree = ((spacing - header.spacing).array().abs() > most * header.spacing.array().abs()).any();
    if (header.sform_code <= 0 || !spacing.allFinite() || !header.spacing.allFinite() || !disagree)
        return {};
    return {
        fmt::format("the header disagrees with itself: voxels are {:.3g} x {:.3g} x {:.3g} mm by its pixdim{}, which "
                    "counts here, and {:.3g} x {:.3g} x {:.3g} mm by its sform; export the image again if the first "
                    "are not right",
                    millimetres * header.spacing.x(), millimetres * header.spacing.y(),
                    millimetres * header.spacing.z(), header.qform_code > 0 ? " and qform" : "",
                    millimetres * spacing.x(), millimetres * spacing.y(), millimetres * spacing.z())};
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
            put_number(bytes, srow_at + 16 * c + 4 * a,
                       static_cast<float>(axes(static_cast<Eigen::Index>(c), static_cast<Eigen::Index>(a))),
                       header.is_swapped);
    std::ofstream out(to, std::ios::binary);
    out.write(bytes.data(), bytes.size());
    copy_rest(stream.get(), out);
}

} // namespace livermark::segmentation
