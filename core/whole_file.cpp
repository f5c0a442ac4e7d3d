#include "core/whole_file.hpp"

#include <fmt/format.h>
#include <fstream>
#include <system_error>
#include <unistd.h>

#include "core/input_error.hpp"

namespace livermark::core {

namespace {

/// @param target  named in messages
void write_bytes(const std::filesystem::path &path, const std::filesystem::path &target, std::span<const char> bytes) {
    std::ofstream stream(path, std::ios::binary | std::ios::trunc);
    if (!stream)
        throw InputError(fmt::format(
            "{}: cannot make a file in this directory; check that the directory exists and can be written to",
            target.string()));
    stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    stream.close();
    if (!stream)
        throw InputError(fmt::format("{}: cannot write {} bytes; make room on the disk or choose another place",
                                     target.string(), bytes.size()));
}

} // namespace

void write_whole(const std::filesystem::path &path, std::span<const char> bytes) {
    const auto target = std::filesystem::absolute(path);
    // The process number keeps two runs that write the same file from writing into each other's.
    auto temporary = target;
    temporary += fmt::format(".{}.partial", getpid());
    try {
        write_bytes(temporary, target, bytes);
        std::error_code error;
        std::filesystem::rename(temporary, target, error);
        if (error)
            throw InputError(fmt::format("{}: cannot put the file there: {}; choose another place", target.string(),
                                         error.message()));
    } catch (...) {
        std::error_code ignored;
        std::filesystem::remove(temporary, ignored);
        throw;
    }
}

} // namespace livermark::core
