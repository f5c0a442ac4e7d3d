#include "support/whole_file.hpp"

#include <cerrno>
#include <cstring>
#include <fmt/format.h>
#include <fstream>
#include <sstream>
#include <string_view>
#include <system_error>
#include <unistd.h>
#include <utility>

#include "support/input_error.hpp"

namespace livermark::support {

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

void check_place(const std::filesystem::path &path) {
    std::error_code error;
    const auto status = std::filesystem::status(path, error);
    if (std::filesystem::is_directory(status))
        throw InputError(fmt::format("{}: this is a directory; give the name of a file", path.string()));
    // The renaming would put a plain file in the place of a device such as /dev/null.
    if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status))
        throw InputError(fmt::format("{}: this is not a plain file; choose another place", path.string()));
    const auto directory = path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
    if (!std::filesystem::is_directory(directory, error))
        throw InputError(fmt::format("{}: there is no directory {}; make it or choose another place", path.string(),
                                     directory.string()));
    if (access(directory.c_str(), W_OK | X_OK) != 0)
        throw InputError(
            fmt::format("{}: cannot make a file in this directory ({}); choose another place or check its permissions",
                        path.string(), std::strerror(errno)));
}

void write_whole(const std::filesystem::path &path, std::span<const char> bytes) {
    check_place(path);
    const auto target = std::filesystem::absolute(path);
    // The process number keeps two runs that write the same file from writing into each other's.
    auto temporary = target;
    temporary += fmt::format(".{}.partial", getpid());
    try {
        write_bytes(temporary, path, bytes);
        std::error_code error;
        std::filesystem::rename(temporary, target, error);
        if (error)
            throw InputError(
                fmt::format("{}: cannot put the file there: {}; choose another place", path.string(), error.message()));
    } catch (...) {
        std::error_code ignored;
        std::filesystem::remove(temporary, ignored);
        throw;
    }
}

void check_readable(const std::filesystem::path &file) {
    std::error_code ignored;
    const auto status = std::filesystem::status(file, ignored);
    if (std::filesystem::is_directory(status))
        throw InputError(fmt::format("{}: this is a directory; give a file", file.string()));
    if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status))
        throw InputError(fmt::format("{}: this is not a plain file; copy what it gives into one", file.string()));
    if (access(file.c_str(), R_OK) != 0)
        throw InputError(fmt::format("{}: cannot be read ({}); check the path and its permissions", file.string(),
                                     std::strerror(errno)));
}

std::string read_text(const std::filesystem::path &file) {
    constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";
    check_readable(file);
    std::ifstream stream(file, std::ios::binary);
    if (!stream)
        throw InputError(fmt::format("{}: cannot be read ({}); check the path and its permissions", file.string(),
                                     std::strerror(errno)));
    std::ostringstream text;
    if (!(text << stream.rdbuf()))
        throw InputError(fmt::format("{}: the file is empty; save it again", file.string()));
    auto bytes = std::move(text).str();
    return bytes.starts_with(byte_order_mark) ? bytes.substr(byte_order_mark.size()) : bytes;
}

} // namespace livermark::support
