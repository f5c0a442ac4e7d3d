#include "results/hdf5/io/hdf5_text.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <stdexcept>

namespace livermark::results::hdf5 {

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

} // namespace livermark::results::hdf5
