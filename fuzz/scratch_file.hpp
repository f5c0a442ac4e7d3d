#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <unistd.h>

namespace livermark::fuzz {

/// The input as a file in memory, for readers that take a path; one for each process and extension.
inline std::filesystem::path as_file(const std::uint8_t *data, std::size_t size, const char *extension) {
    const std::filesystem::path memory = "/dev/shm";
    const auto path = (std::filesystem::exists(memory) ? memory : std::filesystem::temp_directory_path()) /
                      fmt::format("livermark_fuzz_{}{}", getpid(), extension);
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char *>(data), static_cast<std::streamsize>(size));
    return path;
}

} // namespace livermark::fuzz
