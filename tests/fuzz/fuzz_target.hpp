#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <span>
#include <string>
#include <unistd.h>

#include "core/support/input_error.hpp"

/// The function that libFuzzer calls. A target is one source, which includes this and defines read().
namespace livermark::fuzz {

using Input = std::span<const std::uint8_t>;

/// Reads an input.
/// @throws support::InputError, the right end of bad input
void read(Input input);

inline std::string as_text(Input input) {
    return {input.begin(), input.end()};
}

/// The input as a file in memory, for readers that take a path; one for each process and extension.
inline std::filesystem::path as_file(Input input, const char *extension) {
    const std::filesystem::path memory = "/dev/shm";
    const auto path = (std::filesystem::exists(memory) ? memory : std::filesystem::temp_directory_path()) /
                      fmt::format("livermark_fuzz_{}{}", getpid(), extension);
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char *>(input.data()), static_cast<std::streamsize>(input.size()));
    return path;
}

} // namespace livermark::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t *data, std::size_t size) {
    try {
        livermark::fuzz::read({data, size});
    } catch (const livermark::support::InputError &) {
    }
    return 0;
}
