#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <stdexcept>

#include "results/hdf5_io.hpp"

namespace livermark::results::hdf5 {

namespace {

/// Datasets below this stay in one piece: chunks and filters cost more than they save there.
constexpr std::size_t smallest_compressed_bytes = 16 * 1024;
constexpr std::size_t chunk_bytes = 1024 * 1024;
/// Core driver: bytes by which the memory of the file grows.
constexpr std::size_t memory_increment = 1024 * 1024;
constexpr unsigned deflate_level = 4;

Handle made(hid_t id, Handle::Close close, const std::string &what) {
    if (id < 0)
        throw std::runtime_error("HDF5 cannot make " + what);
    return {id, close};
}

void require(herr_t code, const std::string &what) {
    if (code < 0)
        throw std::runtime_error("HDF5 cannot write " + what);
}

Handle create_in_memory() {
    const Handle access = made(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, "a property list");
    require(H5Pset_fapl_core(access.get(), memory_increment, false), "to memory");
    return made(H5Fcreate("result", H5F_ACC_TRUNC, H5P_DEFAULT, access.get()), H5Fclose, "a file in memory");
}

Handle utf8_text() {
    Handle type = made(H5Tcopy(H5T_C_S1), H5Tclose, "a string type");
    require(H5Tset_size(type.get(), H5T_VARIABLE), "a string type");
    require(H5Tset_cset(type.get(), H5T_CSET_UTF8), "a string type");
    return type;
}

} // namespace

Quiet::Quiet() {
    H5Eget_auto2(H5E_DEFAULT, &function_, &data_);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

Quiet::~Quiet() {
    H5Eset_auto2(H5E_DEFAULT, function_, data_);
}

OutputFile::OutputFile() : file_(create_in_memory()) {}

void OutputFile::group(const std::string &path, bool keep_order) {
    const Handle properties = made(H5Pcreate(H5P_GROUP_CREATE), H5Pclose, "a property list");
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
    const Handle properties = made(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, "a property list");
    hsize_t row_bytes = H5Tget_size(type.file);
    for (std::size_t d = 1; d < shape.size(); ++d)
        row_bytes *= shape[d];
    if (shape[0] * row_bytes >= smallest_compressed_bytes) {
        auto chunk = shape;
        chunk[0] = std::clamp<hsize_t>(chunk_bytes / row_bytes, 1, shape[0]);
        require(H5Pset_chunk(properties.get(), rank, chunk.data()), path);
        require(H5Pset_shuffle(properties.get()), path);
        require(H5Pset_deflate(properties.get(), deflate_level), path);
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
    const Handle type = utf8_text();
    const char *characters = value.c_str();
    attribute(path, name, type.get(), type.get(), std::nullopt, &characters);
}

void OutputFile::texts(const std::string &path, const std::string &name, const std::vector<std::string> &values) {
    const Handle type = utf8_text();
    std::vector<const char *> characters;
    for (const std::string &value : values)
        characters.push_back(value.c_str());
    attribute(path, name, type.get(), type.get(), characters.size(), characters.data());
}

void OutputFile::ascii(const std::string &path, const std::string &name, const std::string &value) {
    const Handle type = made(H5Tcopy(H5T_C_S1), H5Tclose, "a string type");
    require(H5Tset_size(type.get(), value.size()), name);
    require(H5Tset_strpad(type.get(), H5T_STR_NULLPAD), name);
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
    if (size <= 0)
        throw std::runtime_error("HDF5 cannot hand over the file in memory");
    std::vector<char> bytes(static_cast<std::size_t>(size));
    if (H5Fget_file_image(file_.get(), bytes.data(), bytes.size()) != size)
        throw std::runtime_error("HDF5 cannot hand over the file in memory");
    return bytes;
}

} // namespace livermark::results::hdf5
