#include "results/hdf5/io/hdf5_io.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <fcntl.h>
#include <fmt/format.h>
#include <fstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <sys/file.h>
#include <system_error>
#include <unistd.h>
#include <vector>

#include "core/support/input_error.hpp"
#include "core/support/processes/own_process.hpp"
#include "results/hdf5/result_files.hpp"

namespace livermark::results::hdf5 {

namespace {

/// Begin of a superblock: the eight bytes that say it is HDF5, and the version.
constexpr std::string_view first_bytes = "\211HDF\r\n\032\n\003";
/// The writer stays below a megabyte, or takes one row.
constexpr hsize_t largest_chunk_bytes = hsize_t{1} << 28;
/// Deflate makes no more than this of a byte, and shuffle leaves the size as it is.
constexpr hsize_t largest_inflation = 1032;

bool is_our_filter(H5Z_filter_t filter) {
    return filter == H5Z_FILTER_SHUFFLE || filter == H5Z_FILTER_DEFLATE || filter == H5Z_FILTER_FLETCHER32;
}

std::string fault_of_filters(hid_t properties) {
    const int num_filters = H5Pget_nfilters(properties);
    for (int i = 0; i < num_filters; ++i) {
        unsigned flags = 0;
        std::size_t num_values = 0;
        if (!is_our_filter(H5Pget_filter2(properties, static_cast<unsigned>(i), &flags, &num_values, nullptr, 0,
                                          nullptr, nullptr)))
            return "is compressed in a way that is not read";
    }
    return num_filters < 0 ? "is damaged" : "";
}

bool has_possible_chunks(hid_t properties, int rank, std::size_t bytes_per_entry) {
    std::vector<hsize_t> chunk(static_cast<std::size_t>(std::max(rank, 1)));
    if (H5Pget_chunk(properties, rank, chunk.data()) != rank)
        return false;
    hsize_t bytes = bytes_per_entry;
    for (const hsize_t extent : chunk) {
        if (extent == 0 || extent > largest_chunk_bytes)
            return false;
        bytes *= extent;
        if (bytes > largest_chunk_bytes)
            return false;
    }
    return true;
}

/// Whether somebody has locked a file to write, as HDF5 does.
bool is_locked(const std::filesystem::path &path) {
    const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (file < 0)
        return false;
    const bool is_free = flock(file, LOCK_SH | LOCK_NB) == 0 || errno != EWOULDBLOCK;
    close(file);
    return !is_free;
}

} // namespace

Handle text_type(std::size_t length, H5T_cset_t character_set) {
    Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
    if (!type.valid() || H5Tset_size(type.get(), length) < 0 || H5Tset_strpad(type.get(), H5T_STR_NULLPAD) < 0 ||
        H5Tset_cset(type.get(), character_set) < 0)
        throw std::runtime_error("HDF5 cannot make a type of text");
    return type;
}

std::size_t common_length(std::span<const std::string> values) {
    std::size_t length = 1;
    for (const std::string &value : values)
        length = std::max(length, value.size());
    return length;
}

std::string padded(std::span<const std::string> values, std::size_t length) {
    std::string characters;
    for (const std::string &value : values) {
        characters += value;
        characters.append(length - value.size(), '\0');
    }
    return characters;
}

std::vector<std::string> unpadded(const std::string &characters, std::size_t length) {
    std::vector<std::string> values;
    for (std::size_t start = 0; start < characters.size(); start += length) {
        const auto value = characters.substr(start, length);
        values.push_back(value.substr(0, value.find('\0')));
    }
    return values;
}

std::string fault_of_text_type(hid_t type) {
    if (H5Tget_class(type) != H5T_STRING)
        return "is not text";
    if (H5Tis_variable_str(type) != 0)
        return "is text of variable length, which is not read";
    if (const std::size_t length = H5Tget_size(type); length == 0 || length > longest_text)
        return fmt::format("is text of {} bytes, and {} are the most that are read", length, longest_text);
    return {};
}

void check_not_in_use(const std::filesystem::path &path) {
    if (is_locked(path))
        throw FileInUse(fmt::format("{}: another program has the file open to write; close it there, or wait for it",
                                    path.string()));
}

void check_all_parts(const std::filesystem::path &path) {
    const Handle file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
    if (!file.valid())
        return; // the reader says it
    const auto visit_object = [](hid_t, const char *, const H5O_info_t *, void *) -> herr_t { return 0; };
    const auto visit_link = [](hid_t, const char *, const H5L_info_t *, void *) -> herr_t { return 0; };
    if (H5Lvisit(file.get(), H5_INDEX_NAME, H5_ITER_INC, visit_link, nullptr) < 0 ||
        H5Ovisit2(file.get(), H5_INDEX_NAME, H5_ITER_INC, visit_object, nullptr, H5O_INFO_BASIC) < 0)
        throw support::InputError(
            fmt::format("{}: a part of the file is damaged; make it again with the command that wrote it, which its "
                        "attribute 'command' has",
                        path.string()));
}

bool has_checksums(const std::filesystem::path &path) {
    std::array<char, first_bytes.size()> found{};
    std::ifstream(path, std::ios::binary).read(found.data(), found.size());
    return std::ranges::equal(found, first_bytes);
}

std::string fault_of_place(hid_t dataset) {
    const Handle properties(H5Dget_create_plist(dataset), H5Pclose);
    if (!properties.valid())
        return "is damaged";
    const bool is_outside =
        H5Pget_layout(properties.get()) == H5D_VIRTUAL || H5Pget_external_count(properties.get()) != 0;
    return is_outside ? "is kept in another file" : "";
}

std::string fault_of_storage(hid_t dataset) {
    const Handle properties(H5Dget_create_plist(dataset), H5Pclose);
    const Handle space(H5Dget_space(dataset), H5Sclose);
    const Handle type(H5Dget_type(dataset), H5Tclose);
    const hssize_t count = H5Sget_simple_extent_npoints(space.get());
    const std::size_t bytes_per_entry = H5Tget_size(type.get());
    const hsize_t stored = H5Dget_storage_size(dataset);
    if (!properties.valid() || count < 0 || bytes_per_entry == 0)
        return "is damaged";
    if (auto fault = fault_of_filters(properties.get()); !fault.empty())
        return fault;
    // Numbers have eight bytes at most, so a count that stays below this leaves room for their size.
    if (static_cast<hsize_t>(count) > (hsize_t{1} << 60))
        return fmt::format("claims {} entries", count);
    const hsize_t bytes = static_cast<hsize_t>(count) * bytes_per_entry;
    switch (H5Pget_layout(properties.get())) {
    case H5D_COMPACT:
    case H5D_CONTIGUOUS:
        return stored == bytes ? "" : fmt::format("is damaged: {} bytes are kept of {}", stored, bytes);
    case H5D_CHUNKED:
        if (!has_possible_chunks(properties.get(), H5Sget_simple_extent_ndims(space.get()), bytes_per_entry))
            return "is damaged: its chunks cannot be";
        if (bytes / largest_inflation > stored)
            return fmt::format("is damaged: {} bytes cannot be what is kept in {}", bytes, stored);
        return {};
    default:
        return "is kept in a way that is not read";
    }
}

void try_apart(const std::filesystem::path &path, const std::function<void()> &read) {
    if (std::error_code error; !std::filesystem::is_regular_file(path, error) || !has_checksums(path))
        return; // which the reader says better, before HDF5 sees it
    check_not_in_use(path);
    constexpr double bytes_per_byte = 100.0; // compressed, and read into other types
    support::in_own_process(path, support::limits_for(path, bytes_per_byte), [&] {
        read();
        check_all_parts(path);
        return std::string();
    });
}

} // namespace livermark::results::hdf5
