#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <fmt/format.h>
#include <memory>
#include <new>
#include <pthread.h>
#include <stdexcept>

#include "results/hdf5/hdf5_io.hpp"

namespace livermark::results::hdf5 {

namespace {

/// Datasets below this stay in one piece: chunks and filters cost more than they save there.
constexpr std::size_t smallest_chunked_bytes = 16 * 1024;
constexpr std::size_t chunk_bytes = 1024 * 1024;
/// Core driver: bytes by which the memory of the file grows.
constexpr std::size_t memory_increment = 1024 * 1024;
constexpr unsigned deflate_level = 1;

Handle made(hid_t id, Handle::Close close, const std::string &what) {
    if (id < 0)
        throw std::runtime_error("HDF5 cannot make " + what);
    return {id, close};
}

void require(herr_t code, const std::string &what) {
    if (code < 0)
        throw std::runtime_error("HDF5 cannot write " + what);
}

/// Properties of something that is to be made. Its attributes, and its children if it is a group, stand in its header
/// however many they are: the heaps and trees that HDF5 takes for more than eight cost more room, and it does not come
/// out of damage in them in order.
Handle creation_properties(hid_t of) {
    constexpr unsigned always = 65535;
    Handle properties = made(H5Pcreate(of), H5Pclose, "a property list");
    require(H5Pset_attr_phase_change(properties.get(), always, 0), "attributes in a header");
    if (of != H5P_DATASET_CREATE)
        require(H5Pset_link_phase_change(properties.get(), always, 0), "links in a header");
    return properties;
}

/// Rows in each of equal chunks: the last takes as much room as the others.
hsize_t rows_per_chunk(hsize_t num_rows, hsize_t row_bytes) {
    const hsize_t num_chunks = std::min((num_rows * row_bytes + chunk_bytes - 1) / chunk_bytes, num_rows);
    return (num_rows + num_chunks - 1) / num_chunks;
}

/// Integers are compressed, which keeps a checksum of them too. Of the digits of a floating-point number nearly all are
/// random: compression would save a seventh of their room, and take most of the time of writing.
void add_filters(const Handle &properties, hid_t type, const std::string &path) {
    if (H5Tget_class(type) == H5T_FLOAT) {
        require(H5Pset_fletcher32(properties.get()), path);
    } else {
        require(H5Pset_shuffle(properties.get()), path);
        require(H5Pset_deflate(properties.get(), deflate_level), path);
    }
}

/// Memory of a file comes from here, and what HDF5 would free when it closes the file stays with us. (The other way to
/// it, H5Fget_file_image, clears a flag in the superblock behind the back of its checksum.)
struct KeptMemory {
    static void *allocate(std::size_t size, H5FD_file_image_op_t, void *) { return std::malloc(size); }
    static void *copy(void *to, const void *from, std::size_t size, H5FD_file_image_op_t, void *) {
        return std::memcpy(to, from, size);
    }
    static void *resize(void *memory, std::size_t size, H5FD_file_image_op_t, void *) {
        return std::realloc(memory, size);
    }
    static herr_t free(void *memory, H5FD_file_image_op_t reason, void *kept) {
        if (reason == H5FD_FILE_IMAGE_OP_FILE_CLOSE)
            static_cast<std::shared_ptr<void> *>(kept)->reset(memory, std::free);
        else
            std::free(memory);
        return 0;
    }
    static void *same(void *kept) { return kept; }
    static herr_t leave(void *) { return 0; }
};

Handle create_in_memory(std::shared_ptr<void> &kept) {
    const Handle access = made(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, "a property list");
    require(H5Pset_fapl_core(access.get(), memory_increment, false), "to memory");
    H5FD_file_image_callbacks_t callbacks{KeptMemory::allocate,
                                          KeptMemory::copy,
                                          KeptMemory::resize,
                                          KeptMemory::free,
                                          KeptMemory::same,
                                          KeptMemory::leave,
                                          &kept};
    require(H5Pset_file_image_callbacks(access.get(), &callbacks), "to memory");
    // No room is taken in advance, so that the file does not shrink when it is closed.
    require(H5Pset_meta_block_size(access.get(), 0), "to memory");
    require(H5Pset_small_data_block_size(access.get(), 0), "to memory");
    // The formats of HDF5 1.10 have checksums in all that describes the data: damage is found before it is believed.
    require(H5Pset_libver_bounds(access.get(), H5F_LIBVER_V110, H5F_LIBVER_V110), "the formats of version 1.10");
    const Handle properties = creation_properties(H5P_FILE_CREATE);
    return made(H5Fcreate("result", H5F_ACC_TRUNC, properties.get(), access.get()), H5Fclose, "a file in memory");
}

/// A thread may have several files open.
std::recursive_mutex &one_thread() {
    static std::recursive_mutex mutex;
    // Another thread may be in HDF5 while this one makes a process to read in.
    static const bool survives_forks [[maybe_unused]] =
        pthread_atfork([] { mutex.lock(); }, [] { mutex.unlock(); }, [] { new (&mutex) std::recursive_mutex; }) == 0;
    return mutex;
}

/// @param length         bytes, at least 1
/// @param character_set  H5T_CSET_UTF8 or H5T_CSET_ASCII
Handle text_type(std::size_t length, H5T_cset_t character_set) {
    Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
    if (!type.valid() || H5Tset_size(type.get(), length) < 0 || H5Tset_strpad(type.get(), H5T_STR_NULLPAD) < 0 ||
        H5Tset_cset(type.get(), character_set) < 0)
        throw std::runtime_error("HDF5 cannot make a type of text");
    return type;
}

/// As many bytes as the longest has, and never none, which HDF5 does not know.
std::size_t common_length(std::span<const std::string> values) {
    std::size_t length = 1;
    for (const std::string &value : values)
        length = std::max(length, value.size());
    return length;
}

/// All values behind each other, each padded to the length.
std::string padded(std::span<const std::string> values, std::size_t length) {
    std::string characters;
    for (const std::string &value : values) {
        characters += value;
        characters.append(length - value.size(), '\0');
    }
    return characters;
}

} // namespace

Quiet::Quiet() : alone_(one_thread()) {
    H5Eget_auto2(H5E_DEFAULT, &function_, &data_);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    // HDF5 1.10 never gives back what it took for an object header whose checksum is wrong, and at the end of the
    // process prints that it waits for it in vain. The handler comes before that of the library, which is there now;
    // other threads are kept out of the library from then on.
    static const bool ends_quietly [[maybe_unused]] = std::atexit([] {
                                                          one_thread().lock();
                                                          H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
                                                      }) == 0;
}

Quiet::~Quiet() {
    H5Eset_auto2(H5E_DEFAULT, function_, data_);
}

OutputFile::OutputFile(Storage storage) : storage_(storage), file_(create_in_memory(kept_)) {}

void OutputFile::group(const std::string &path, bool keep_order) {
    const Handle properties = creation_properties(H5P_GROUP_CREATE);
    if (keep_order)
        require(H5Pset_link_creation_order(properties.get(), H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED), path);
    made(H5Gcreate2(file_.get(), path.c_str(), H5P_DEFAULT, properties.get(), H5P_DEFAULT), H5Gclose, path);
}

void OutputFile::write(const std::string &path, const RowType &type, std::vector<hsize_t> shape, const void *data,
                       const std::string &units) {
    if (type.columns > 1)
        shape.push_back(type.columns);
    const int rank = static_cast<int>(shape.size());
    const Handle space = made(H5Screate_simple(rank, shape.data(), nullptr), H5Sclose, path);
    const Handle properties = creation_properties(H5P_DATASET_CREATE);
    hsize_t row_bytes = H5Tget_size(type.file);
    for (std::size_t d = 1; d < shape.size(); ++d)
        row_bytes *= shape[d];
    if (storage_ == Storage::chunks && shape[0] * row_bytes >= smallest_chunked_bytes) {
        auto chunk = shape;
        chunk[0] = rows_per_chunk(shape[0], row_bytes);
        require(H5Pset_chunk(properties.get(), rank, chunk.data()), path);
        add_filters(properties, type.file, path);
    }
    {
        const Handle dataset = made(
            H5Dcreate2(file_.get(), path.c_str(), type.file, space.get(), H5P_DEFAULT, properties.get(), H5P_DEFAULT),
            H5Dclose, path);
        if (shape[0] * row_bytes > 0)
            require(H5Dwrite(dataset.get(), type.memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, data), path);
    }
    if (!units.empty())
        text(path, "units", units);
}

void OutputFile::attribute(const std::string &path, const std::string &name, hid_t file_type, hid_t memory_type,
                           const std::optional<hsize_t> &length, const void *data) {
    const std::string where = fmt::format("{} attribute {}", path, name);
    const Handle space = made(length ? H5Screate_simple(1, &*length, nullptr) : H5Screate(H5S_SCALAR), H5Sclose, where);
    const Handle attribute = made(H5Acreate_by_name(file_.get(), path.c_str(), name.c_str(), file_type, space.get(),
                                                    H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                                  H5Aclose, where);
    if (!length || *length > 0)
        require(H5Awrite(attribute.get(), memory_type, data), where);
}

void OutputFile::text(const std::string &path, const std::string &name, const std::string &value) {
    const auto type = text_type(common_length({&value, 1}), H5T_CSET_UTF8);
    attribute(path, name, type.get(), type.get(), std::nullopt, padded({&value, 1}, H5Tget_size(type.get())).data());
}

void OutputFile::texts(const std::string &path, const std::string &name, const std::vector<std::string> &values) {
    const auto type = text_type(common_length(values), H5T_CSET_UTF8);
    attribute(path, name, type.get(), type.get(), values.size(), padded(values, H5Tget_size(type.get())).data());
}

void OutputFile::ascii(const std::string &path, const std::string &name, const std::string &value) {
    const auto type = text_type(value.size(), H5T_CSET_ASCII);
    attribute(path, name, type.get(), type.get(), std::nullopt, value.data());
}

void OutputFile::number(const std::string &path, const std::string &name, double value) {
    attribute(path, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, std::nullopt, &value);
}

void OutputFile::integer(const std::string &path, const std::string &name, std::int64_t value) {
    attribute(path, name, H5T_STD_I64LE, H5T_NATIVE_INT64, std::nullopt, &value);
}

void OutputFile::integers(const std::string &path, const std::string &name, const std::vector<std::int64_t> &values) {
    attribute(path, name, H5T_STD_I64LE, H5T_NATIVE_INT64, values.size(), values.data());
}

void OutputFile::hard_link(const std::string &existing, const std::string &path) {
    require(H5Lcreate_hard(file_.get(), existing.c_str(), file_.get(), path.c_str(), H5P_DEFAULT, H5P_DEFAULT), path);
}

std::vector<char> OutputFile::image() {
    require(H5Fflush(file_.get(), H5F_SCOPE_GLOBAL), "the file in memory");
    const ssize_t size = H5Fget_file_image(file_.get(), nullptr, 0);
    file_ = Handle(-1, H5Fclose);
    if (size <= 0 || !kept_)
        throw std::runtime_error("HDF5 cannot hand over the file in memory");
    const auto *bytes = static_cast<const char *>(kept_.get());
    return {bytes, bytes + size};
}

} // namespace livermark::results::hdf5
