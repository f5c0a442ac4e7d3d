#include "results/hdf5/hdf5_io.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <climits>
#include <cstring>
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
#include "results/hdf5/result_file.hpp"

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

/// The longest text that is read. The longest that is written is the definition of a load case.
constexpr std::size_t longest_text = 1024 * 1024;

/// Texts that each are padded with null characters to a length.
std::vector<std::string> unpadded(const std::string &characters, std::size_t length) {
    std::vector<std::string> values;
    for (std::size_t start = 0; start < characters.size(); start += length) {
        const auto value = characters.substr(start, length);
        values.push_back(value.substr(0, value.find('\0')));
    }
    return values;
}

/// Reason why a type is not that of texts of fixed length, no longer than the longest; empty if it is.
std::string fault_of_text_type(hid_t type) {
    if (H5Tget_class(type) != H5T_STRING)
        return "is not text";
    if (H5Tis_variable_str(type) != 0)
        return "is text of variable length, which is not read";
    if (const std::size_t length = H5Tget_size(type); length == 0 || length > longest_text)
        return fmt::format("is text of {} bytes, and {} are the most that are read", length, longest_text);
    return {};
}

/// @throws FileInUse if another program has the file open to write
void check_not_in_use(const std::filesystem::path &path) {
    if (is_locked(path))
        throw FileInUse(fmt::format("{}: another program has the file open to write; close it there, or wait for it",
                                    path.string()));
}

/// Opens all groups and datasets and looks at all links of a file, as h5py does before it reads one, so that what no
/// other reader opens is refused here too. Beside a file that is damaged this may crash.
/// @throws support::InputError
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

/// Whether the file begins as OutputFile begins it. Older formats of HDF5 have no checksums, and damage of theirs is
/// only found when HDF5 has run into it.
bool has_checksums(const std::filesystem::path &path) {
    std::array<char, first_bytes.size()> found{};
    std::ifstream(path, std::ios::binary).read(found.data(), found.size());
    return std::ranges::equal(found, first_bytes);
}

/// Reason why the numbers of a dataset are not in the file itself: they are in files beside it, or in datasets of other
/// files; empty if they are. Opens none of these.
std::string fault_of_place(hid_t dataset) {
    const Handle properties(H5Dget_create_plist(dataset), H5Pclose);
    if (!properties.valid())
        return "is damaged";
    const bool is_outside =
        H5Pget_layout(properties.get()) == H5D_VIRTUAL || H5Pget_external_count(properties.get()) != 0;
    return is_outside ? "is kept in another file" : "";
}

/// Reason why a dataset is none that OutputFile writes: filtered in another way, in chunks or of a size
/// that what is in the file cannot come to; empty if it may be read.
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

Handle open_file(const std::filesystem::path &path, const std::string &maker) {
    const std::string name = path.string();
    std::error_code ignored;
    if (const auto status = std::filesystem::status(path, ignored); !std::filesystem::is_regular_file(status))
        throw support::InputError(
            std::filesystem::exists(status)
                ? fmt::format("{}: this is not a plain file; give a file that `{}` wrote", name, maker)
                : fmt::format("{}: there is no such file; check the path, or make it with `{}`", name, maker));
    if (!std::ifstream(path))
        throw support::InputError(
            fmt::format("{}: cannot be read ({}); check its permissions", name, std::strerror(errno)));
    if (has_checksums(path)) {
        Handle file(H5Fopen(name.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
        if (file.valid())
            return file;
        check_not_in_use(path);
        throw support::InputError(
            fmt::format("{}: the file is truncated or damaged; make it again with `{}`", name, maker));
    }
    throw support::InputError(fmt::format(
        "{}: this is not an HDF5 file in the format of this version; give a file that `{}` wrote", name, maker));
}

std::string shape_text(std::span<const hsize_t> shape) {
    return shape.size() == 1 ? fmt::format("({})", shape[0]) : fmt::format("({})", fmt::join(shape, ","));
}

std::string type_text(hid_t type) {
    const std::size_t bits = 8 * H5Tget_size(type);
    switch (H5Tget_class(type)) {
    case H5T_INTEGER:
        return fmt::format("{}-bit {}integers", bits, H5Tget_sign(type) == H5T_SGN_NONE ? "unsigned " : "");
    case H5T_FLOAT:
        return fmt::format("{}-bit floating point numbers", bits);
    case H5T_STRING:
        return "text";
    default:
        return "values of another type";
    }
}

} // namespace

InputFile::InputFile(const std::filesystem::path &path, const std::string &maker)
    : name_(path.string()), maker_(maker), file_(open_file(path, maker)) {}

void InputFile::refuse(const std::string &path, const std::string &fault) const {
    throw support::InputError(fmt::format(
        "{}: {} {}; make the file again with `{}` (results/schema.md says what it holds)", name_, path, fault, maker_));
}

bool InputFile::has(const std::string &path) const {
    // H5Lexists fails if a group on the way is missing, so the way is walked.
    for (std::size_t end = path.find('/', 1);; end = path.find('/', end + 1)) {
        const auto part = path.substr(0, end);
        if (H5Lexists(file_.get(), part.c_str(), H5P_DEFAULT) <= 0)
            return false;
        // HDF5 would follow a link into any file that it names, a named pipe among them.
        H5L_info_t link{};
        if (H5Lget_info(file_.get(), part.c_str(), &link, H5P_DEFAULT) < 0)
            refuse(part, "is damaged");
        if (link.type != H5L_TYPE_HARD)
            refuse(part, "is a link to another place, and links are not followed");
        if (end == std::string::npos)
            return true;
    }
}

bool InputFile::has_attribute(const std::string &path, const std::string &name) const {
    if (path != "/" && !has(path))
        return false;
    return H5Aexists_by_name(file_.get(), path.c_str(), name.c_str(), H5P_DEFAULT) > 0;
}

std::vector<std::string> InputFile::children(const std::string &path) const {
    if (path != "/" && !has(path))
        refuse(path, "is not there as a group");
    const Handle group(H5Gopen2(file_.get(), path.c_str(), H5P_DEFAULT), H5Gclose);
    if (!group.valid())
        refuse(path, "is not there as a group");
    const Handle properties(H5Gget_create_plist(group.get()), H5Pclose);
    unsigned order = 0;
    H5Pget_link_creation_order(properties.get(), &order);
    const H5_index_t index = (order & H5P_CRT_ORDER_TRACKED) != 0 ? H5_INDEX_CRT_ORDER : H5_INDEX_NAME;
    H5G_info_t info{};
    if (H5Gget_info(group.get(), &info) < 0)
        refuse(path, "cannot be read");
    std::vector<std::string> names;
    for (hsize_t i = 0; i < info.nlinks; ++i) {
        const auto name_by_index = [&](char *name, std::size_t size) {
            return H5Lget_name_by_idx(group.get(), ".", index, H5_ITER_INC, i, name, size, H5P_DEFAULT);
        };
        const ssize_t length = name_by_index(nullptr, 0);
        if (length < 0)
            refuse(path, "cannot be read");
        std::string name(static_cast<std::size_t>(length), '\0');
        name_by_index(name.data(), name.size() + 1);
        names.push_back(std::move(name));
    }
    return names;
}

Handle InputFile::open_dataset(const std::string &path, const RowType &type, const Shape &shape) const {
    if (!has(path))
        refuse(path, "is missing");
    Handle dataset(H5Dopen2(file_.get(), path.c_str(), H5P_DEFAULT), H5Dclose);
    if (!dataset.valid())
        refuse(path, "is not a dataset");
    if (const auto fault = fault_of_place(dataset.get()); !fault.empty())
        refuse(path, fault); // before its size is asked for, which opens the files of a virtual one
    const Handle found(H5Dget_type(dataset.get()), H5Tclose);
    if (H5Tequal(found.get(), type.file) <= 0)
        refuse(path, fmt::format("holds {} instead of {}", type_text(found.get()), type_text(type.file)));
    const Handle space(H5Dget_space(dataset.get()), H5Sclose);
    const std::size_t wanted_rank = shape.size() + (type.columns == 1 ? 0 : 1);
    const int rank = H5Sget_simple_extent_ndims(space.get());
    if (rank != static_cast<int>(wanted_rank))
        refuse(path, fmt::format("has rank {} instead of {}", rank, wanted_rank));
    std::vector<hsize_t> extent(wanted_rank);
    H5Sget_simple_extent_dims(space.get(), extent.data(), nullptr);
    auto wanted = extent;
    for (std::size_t d = 0; d < wanted.size(); ++d) {
        if (extent[d] > INT_MAX)
            refuse(path, fmt::format("has {} rows, more than can be numbered", extent[d]));
        if (d == shape.size())
            wanted[d] = type.columns;
        else if (shape[d])
            wanted[d] = *shape[d];
    }
    if (extent != wanted)
        refuse(path, fmt::format("has shape {} instead of {}", shape_text(extent), shape_text(wanted)));
    if (const auto fault = fault_of_storage(dataset.get()); !fault.empty())
        refuse(path, fault);
    return dataset;
}

std::size_t InputFile::count_entries(const Handle &dataset) {
    const Handle space(H5Dget_space(dataset.get()), H5Sclose);
    return static_cast<std::size_t>(H5Sget_simple_extent_npoints(space.get()));
}

void InputFile::read(const Handle &dataset, const std::string &path, const RowType &type, void *rows) const {
    if (count_entries(dataset) > 0 && H5Dread(dataset.get(), type.memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, rows) < 0)
        refuse(path, "is damaged");
}

Handle InputFile::open_attribute(const std::string &path, const std::string &name) const {
    if (path != "/" && !has(path))
        refuse(path, "is missing");
    Handle attribute(H5Aopen_by_name(file_.get(), path.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
    if (!attribute.valid())
        refuse(path, fmt::format("has no attribute {}", name));
    return attribute;
}

std::vector<std::string> InputFile::read_texts(const Handle &attribute, const std::string &where) const {
    const Handle type(H5Aget_type(attribute.get()), H5Tclose);
    if (const auto fault = fault_of_text_type(type.get()); !fault.empty())
        refuse(where, fault);
    const Handle space(H5Aget_space(attribute.get()), H5Sclose);
    const std::size_t length = H5Tget_size(type.get());
    const hssize_t count = H5Sget_simple_extent_npoints(space.get());
    if (count < 0 || static_cast<std::size_t>(count) > longest_text)
        refuse(where, fmt::format("has {} entries", count));
    if (H5Aget_storage_size(attribute.get()) != static_cast<hsize_t>(count) * length)
        refuse(where, "is damaged");
    std::string characters(static_cast<std::size_t>(count) * length, '\0');
    if (!characters.empty() && H5Aread(attribute.get(), type.get(), characters.data()) < 0)
        refuse(where, "is damaged");
    return unpadded(characters, length);
}

std::string InputFile::text(const std::string &path, const std::string &name) const {
    const std::string where = fmt::format("{} attribute {}", path, name);
    const auto values = read_texts(open_attribute(path, name), where);
    if (values.size() != 1)
        refuse(where, fmt::format("holds {} texts instead of one", values.size()));
    return values.front();
}

std::vector<std::string> InputFile::texts(const std::string &path, const std::string &name) const {
    return read_texts(open_attribute(path, name), fmt::format("{} attribute {}", path, name));
}

void InputFile::read_number(const std::string &path, const std::string &name, hid_t file_type, hid_t memory_type,
                            void *value) const {
    const std::string where = fmt::format("{} attribute {}", path, name);
    const Handle attribute = open_attribute(path, name);
    const Handle type(H5Aget_type(attribute.get()), H5Tclose);
    const Handle space(H5Aget_space(attribute.get()), H5Sclose);
    if (H5Tequal(type.get(), file_type) <= 0 || H5Sget_simple_extent_npoints(space.get()) != 1)
        refuse(where, fmt::format("is not one of {}", type_text(file_type)));
    if (H5Aget_storage_size(attribute.get()) != H5Tget_size(file_type) ||
        H5Aread(attribute.get(), memory_type, value) < 0)
        refuse(where, "is damaged");
}

double InputFile::number(const std::string &path, const std::string &name) const {
    double value = 0.0;
    read_number(path, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, &value);
    return value;
}

std::int64_t InputFile::integer(const std::string &path, const std::string &name) const {
    std::int64_t value = 0;
    read_number(path, name, H5T_STD_I64LE, H5T_NATIVE_INT64, &value);
    return value;
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
