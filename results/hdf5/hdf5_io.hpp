#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <hdf5.h>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

/// The little of HDF5 that result files need, and checks that a file from outside has to pass before HDF5 is asked for
/// its content: HDF5 1.10.8 believes too much of what a damaged file says of itself. Texts are characters of fixed
/// length, padded with null characters, because variable-length texts are kept in a global heap that has no checksum,
/// and HDF5 1.10.8 copies beyond the end of a damaged one (H5HG_read). Internal to results/: no other header includes
/// hdf5.h.
namespace livermark::results::hdf5 {

/// An HDF5 identifier that is closed at the end of its scope.
class Handle {
  public:
    using Close = herr_t (*)(hid_t);
    Handle(hid_t id, Close close) : id_(id), close_(close) {}
    Handle(Handle &&other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
    Handle &operator=(Handle &&other) noexcept {
        std::swap(id_, other.id_);
        std::swap(close_, other.close_);
        return *this;
    }
    ~Handle() {
        if (id_ >= 0)
            close_(id_);
    }
    hid_t get() const { return id_; }
    bool valid() const { return id_ >= 0; }

  private:
    hid_t id_;
    Close close_;
};

/// Keeps HDF5 from printing its error stack to the terminal while it lives; afterwards the printing is as before,
/// because other libraries in the program use HDF5 too. Keeps other threads waiting that want the same: HDF5 as it is
/// packaged is for one thread at a time, also on different files.
class Quiet {
  public:
    Quiet();
    ~Quiet();
    Quiet(const Quiet &) = delete;
    Quiet &operator=(const Quiet &) = delete;

  private:
    std::unique_lock<std::recursive_mutex> alone_;
    H5E_auto2_t function_ = nullptr;
    void *data_ = nullptr;
};

/// Layout of one element of a C++ array in memory and as a row of a dataset. One column means a dataset of rank 1.
struct RowType {
    hid_t memory;
    hid_t file;
    hsize_t columns;
};

template <class T> struct RowTypeOf;
template <> struct RowTypeOf<double> {
    static RowType get() { return {H5T_NATIVE_DOUBLE, H5T_IEEE_F64LE, 1}; }
};
template <> struct RowTypeOf<Eigen::Vector3d> {
    static RowType get() { return {H5T_NATIVE_DOUBLE, H5T_IEEE_F64LE, 3}; }
};
template <> struct RowTypeOf<Eigen::Vector3f> {
    static RowType get() { return {H5T_NATIVE_FLOAT, H5T_IEEE_F32LE, 3}; }
};
template <> struct RowTypeOf<int> {
    static RowType get() { return {H5T_NATIVE_INT, H5T_STD_I32LE, 1}; }
};
template <> struct RowTypeOf<std::int64_t> {
    static RowType get() { return {H5T_NATIVE_INT64, H5T_STD_I64LE, 1}; }
};
template <> struct RowTypeOf<std::uint8_t> {
    static RowType get() { return {H5T_NATIVE_UINT8, H5T_STD_U8LE, 1}; }
};
/// Node numbers: int in memory, int64 in the file. Reading clamps a number beyond int, and every reader refuses it
/// then, as no mesh has that many nodes.
template <std::size_t columns> struct RowTypeOf<std::array<int, columns>> {
    static RowType get() { return {H5T_NATIVE_INT, H5T_STD_I64LE, columns}; }
};

/// A file that grows in memory, so that a full disk is met by plain file writing and never inside HDF5, which does not
/// come out of a failed close in order.
/// @throws std::runtime_error from every function if HDF5 refuses
class OutputFile {
  public:
    /// Storage of datasets that are not small: in chunks with checksums, integers compressed; or as they are.
    enum class Storage { chunks, plain };

    explicit OutputFile(Storage storage = Storage::chunks);

    /// @param keep_order  remember the order in which children are made
    void group(const std::string &path, bool keep_order = false);

    /// @param units  empty for a quantity that has none
    template <class T> void dataset(const std::string &path, const std::vector<T> &rows, const std::string &units) {
        write(path, RowTypeOf<T>::get(), {rows.size()}, rows.data(), units);
    }

    /// Blocks of equally many rows, one behind the other: a dataset with one more dimension.
    /// @param rows_per_block  divides the number of rows
    template <class T>
    void blocks(const std::string &path, const std::vector<T> &rows, std::size_t rows_per_block,
                const std::string &units) {
        write(path, RowTypeOf<T>::get(), {rows.size() / rows_per_block, rows_per_block}, rows.data(), units);
    }

    /// Texts are UTF-8 of fixed length, padded with null characters to the longest.
    void text(const std::string &path, const std::string &name, const std::string &value);
    void texts(const std::string &path, const std::string &name, const std::vector<std::string> &values);
    /// The same of ASCII characters, which is what VTK asks for.
    void ascii(const std::string &path, const std::string &name, const std::string &value);
    void number(const std::string &path, const std::string &name, double value);
    void integer(const std::string &path, const std::string &name, std::int64_t value);
    void integers(const std::string &path, const std::string &name, const std::vector<std::int64_t> &values);

    /// A second name for a dataset.
    void hard_link(const std::string &existing, const std::string &path);

    /// Closes the file, which is then of no more use.
    /// @return all of it, byte by byte
    std::vector<char> image();

  private:
    /// @param shape  without the columns of a row
    void write(const std::string &path, const RowType &type, std::vector<hsize_t> shape, const void *data,
               const std::string &units);
    void attribute(const std::string &path, const std::string &name, hid_t file_type, hid_t memory_type,
                   const std::optional<hsize_t> &length, const void *data);

    Quiet quiet_;
    Storage storage_;
    std::shared_ptr<void> kept_; ///< memory of the file when HDF5 has closed it
    Handle file_;
};

/// A file from outside: whatever is not as expected is a support::InputError that names the file and the place in it.
class InputFile {
  public:
    /// @param maker  the command that writes such files, for messages
    explicit InputFile(const std::filesystem::path &path, const std::string &maker = "livermark run");

    bool has(const std::string &path) const;
    bool has_attribute(const std::string &path, const std::string &name) const;

    /// Names of what is in a group, in the order of making if the group keeps it, else alphabetical.
    std::vector<std::string> children(const std::string &path) const;

    /// @param num_rows  expected number, or nothing where the file decides
    template <class T>
    std::vector<T> dataset(const std::string &path, const std::optional<std::size_t> &num_rows = std::nullopt) const {
        return rows<T>(path, {num_rows});
    }

    /// All rows of the blocks that OutputFile::blocks writes.
    template <class T>
    std::vector<T> blocks(const std::string &path, std::size_t num_blocks, std::size_t rows_per_block) const {
        return rows<T>(path, {num_blocks, rows_per_block});
    }

    /// The same where the file decides how many blocks there are.
    template <class T> std::vector<T> blocks(const std::string &path, std::size_t rows_per_block) const {
        return rows<T>(path, {std::nullopt, rows_per_block});
    }

    std::string text(const std::string &path, const std::string &name) const;
    std::vector<std::string> texts(const std::string &path, const std::string &name) const;
    double number(const std::string &path, const std::string &name) const;
    std::int64_t integer(const std::string &path, const std::string &name) const;

    /// @throws support::InputError always: "<file>: <path> <fault>; <remedy>"
    [[noreturn]] void refuse(const std::string &path, const std::string &fault) const;

  private:
    /// Shape without the columns of a row; nothing where the file decides.
    using Shape = std::vector<std::optional<std::size_t>>;
    template <class T> std::vector<T> rows(const std::string &path, const Shape &shape) const {
        const RowType type = RowTypeOf<T>::get();
        const Handle opened = open_dataset(path, type, shape);
        std::vector<T> rows(count_entries(opened) / type.columns);
        read(opened, path, type, rows.data());
        return rows;
    }
    Handle open_dataset(const std::string &path, const RowType &type, const Shape &shape) const;
    static std::size_t count_entries(const Handle &dataset);
    void read(const Handle &dataset, const std::string &path, const RowType &type, void *rows) const;
    Handle open_attribute(const std::string &path, const std::string &name) const;
    std::vector<std::string> read_texts(const Handle &attribute, const std::string &where) const;
    void read_number(const std::string &path, const std::string &name, hid_t file_type, hid_t memory_type,
                     void *value) const;

    Quiet quiet_;
    std::string name_;
    std::string maker_;
    Handle file_;
};

/// Lets a reader try a file in a process of its own. HDF5 1.10 crashes on files whose checksums are right and whose
/// contents are not, and does so again in the same place: after that the file may be read here.
/// @param read  may throw InputError
/// @throws support::InputError of the reader, or one that says how the process ended; FileInUse
void try_apart(const std::filesystem::path &path, const std::function<void()> &read);

/// Reads a file from outside.
template <class Read> auto read_once_tried(const std::filesystem::path &path, const Read &read) {
    try_apart(path, [&] { read(); });
    return read();
}

} // namespace livermark::results::hdf5
