#pragma once

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

namespace livermark::support {

/// FNV-1a (Fowler, Noll, Vo) of 64 bits: tells contents apart, and is no protection against somebody who wants two of
/// them to look alike.
class FnvHash {
  public:
    /// Bytes of one text, which may come in pieces.
    void add_bytes(std::string_view bytes) {
        for (const char letter : bytes)
            add_byte(static_cast<unsigned char>(letter));
    }
    /// A whole text: two of them are not the same as both in one.
    void add(std::string_view text) {
        add_bytes(text);
        add_byte(0xff);
    }
    std::uint64_t value() const { return value_; }

  private:
    void add_byte(unsigned char byte) {
        value_ ^= byte;
        value_ *= 0x100000001b3ULL;
    }

    std::uint64_t value_ = 0xcbf29ce484222325ULL;
};

/// A text in lower case, in which endings of file names are compared: Windows writes some in upper case.
inline std::string lower_case(std::string text) {
    std::ranges::transform(text, text.begin(), [](unsigned char c) { return std::tolower(c); });
    return text;
}

/// The extension of a file name in lower case, such as ".msh".
inline std::string file_ending(const std::filesystem::path &file) {
    return lower_case(file.extension().string());
}

/// Folder of the bodies, load cases and scripts that ship: the environment variable LIVERMARK_ROOT; or the source tree
/// that this program or extension module lies in, so that a copied tree reads itself; or the one that it was built
/// from.
std::filesystem::path root_folder();

/// Says whether a file could be put there, so that long work need not be done for a place that was misspelt.
/// @throws InputError if it cannot
void check_place(const std::filesystem::path &path);

/// Puts a file in its place when it is whole: under a temporary name in the same directory, then renamed. An earlier
/// file stays as it was if that fails. A process that is killed leaves <name>.<its number>.partial, which no reader
/// takes for the file.
/// @param path  in a directory that exists; no device, whose place the file would take
/// @throws InputError if the place cannot be written to
void write_whole(const std::filesystem::path &path, std::span<const char> bytes);

/// Refuses what is no plain file, such as a directory, a named pipe or a device, which would keep a reader waiting.
/// @throws InputError also if it is not there or may not be read
void check_readable(const std::filesystem::path &file);

/// Reads a whole text file, without the byte order mark that some editors put before it.
/// @throws InputError if it cannot be read
std::string read_text(const std::filesystem::path &file);

/// Claim on the name of a file that long work is going to write, so that no other process writes it meanwhile and one
/// of two results is lost. It is a lock (fcntl) on one byte of the file .livermark.lock in the same folder, which the
/// name chooses: the system gives it back when the process ends, however that ends, and processes that are forked have
/// none of it. The last claim in a folder removes the file. Where a file system has no locks nothing is claimed.
class FileClaim {
  public:
    /// @param file  in a folder that exists; it need not be there itself
    /// @throws InputError if another process has claimed it
    explicit FileClaim(const std::filesystem::path &file);
    ~FileClaim();
    FileClaim(const FileClaim &) = delete;
    FileClaim &operator=(const FileClaim &) = delete;

  private:
    std::filesystem::path lock_;
    long place_ = 0; ///< the byte
    bool is_held_ = false;
};

} // namespace livermark::support
