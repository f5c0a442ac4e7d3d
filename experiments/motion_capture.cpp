#include "experiments/motion_capture.hpp"

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fmt/format.h>
#include <string>

#include "support/input_error.hpp"
#include "support/whole_file.hpp"

namespace livermark::experiments {

namespace {

constexpr std::size_t block = 512; ///< [bytes]
constexpr char key = 0x50;         ///< second byte of every C3D file
constexpr char intel = 84;         ///< kind of processor, in the header of the parameters

template <class T> T value_at(const std::string &bytes, std::size_t offset) {
    static_assert(std::endian::native == std::endian::little);
    T value{};
    std::memcpy(&value, bytes.data() + offset, sizeof(T));
    return value;
}

} // namespace

MotionCapture read_motion_capture(const std::filesystem::path &file) {
    const auto bytes = support::read_text(file);
    const auto refuse = [&](const std::string &fault) {
        throw support::InputError(fmt::format("{}: {}; export the points as C3D with floating-point numbers, without "
                                              "analog channels and gaps",
                                              file.string(), fault));
    };
    if (bytes.size() < 2 * block || bytes[1] != key)
        refuse("this is no C3D file");
    const auto parameters = block * (static_cast<std::uint8_t>(bytes[0]) - std::size_t{1});
    if (bytes[0] == 0 || parameters + 4 > bytes.size() || bytes[parameters + 3] != intel)
        refuse("its numbers are not in the order of Intel processors");
    MotionCapture capture;
    capture.num_markers = value_at<std::uint16_t>(bytes, 2);
    const int num_analog = value_at<std::uint16_t>(bytes, 4);
    const int num_frames = value_at<std::uint16_t>(bytes, 8) - value_at<std::uint16_t>(bytes, 6) + 1;
    const auto scale = value_at<float>(bytes, 12);
    const std::size_t data = block * (std::size_t{value_at<std::uint16_t>(bytes, 16)} - 1);
    capture.frame_rate = value_at<float>(bytes, 20);
    if (num_analog != 0)
        refuse("it has analog channels");
    if (!(scale < 0.0F))
        refuse("its numbers are integers");
    if (capture.num_markers == 0 || num_frames < 1 || !(capture.frame_rate > 0.0) || !std::isfinite(capture.frame_rate))
        refuse("its header says that there are no points, no frames or no rate");
    constexpr std::size_t size_of_point = 4 * sizeof(float); // x, y, z, and how good they are
    const auto num_points = static_cast<std::size_t>(capture.num_markers) * static_cast<std::size_t>(num_frames);
    if (data < block || data > bytes.size() || (bytes.size() - data) / size_of_point < num_points)
        refuse(fmt::format("it ends before its {} frames of {} points", num_frames, capture.num_markers));
    for (std::size_t p = 0; p < num_points; ++p) {
        const std::size_t at = data + p * size_of_point;
        core::Vector3 &position = capture.positions.emplace_back();
        for (int i = 0; i < 3; ++i)
            position[i] = value_at<float>(bytes, at + static_cast<std::size_t>(i) * sizeof(float));
        if (!position.allFinite() || value_at<float>(bytes, at + 3 * sizeof(float)) < 0.0F)
            refuse(fmt::format("point {} was not seen in frame {}", p % capture.num_markers, p / capture.num_markers));
    }
    return capture;
}

} // namespace livermark::experiments
