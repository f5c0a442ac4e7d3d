#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

namespace livermark::support {

/// What somebody else's reader may take for a file.
struct ReaderLimits {
    int seconds = 60;                             ///< of computing; half a minute and three times as long by the clock
    std::uint64_t bytes = std::uint64_t{1} << 30; ///< beside what the process has
};

/// Limits in proportion to the bytes of a file, or of the files in a folder: a file of two kilobytes has no right to
/// gigabytes.
/// @param bytes_per_byte  of memory, of what may be compressed
ReaderLimits limits_for(const std::filesystem::path &file, double bytes_per_byte);

/// Does work on a file in a process of its own, so that a library that crashes, hangs or fills the memory on a damaged
/// file ends that process alone. What the libraries print is dropped.
/// @param file  named in messages
/// @param work  returns what is to come back; may throw InputError. Nothing else of what it does is seen here
/// @throws InputError of the work, or one that says how the process ended
std::string in_own_process(const std::filesystem::path &file, const ReaderLimits &limits,
                           const std::function<std::string()> &work);

} // namespace livermark::support
