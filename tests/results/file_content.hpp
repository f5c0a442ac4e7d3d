#pragma once

#include <filesystem>
#include <gtest/gtest.h>
#include <hdf5.h>
#include <map>
#include <string>

namespace livermark::tests {

/// Size and bytes of each dataset and attribute of an HDF5 file, by its path. The times at which they were made, which
/// files of one content differ in, are not among them.
inline std::map<std::string, std::string> content_of(const std::filesystem::path &path) {
    using Content = std::map<std::string, std::string>;
    static constexpr auto add = [](Content &content, const std::string &name, hid_t type, hid_t space,
                                   const auto &read) {
        const auto count = static_cast<std::size_t>(H5Sget_simple_extent_npoints(space));
        auto &bytes = content[name];
        bytes.assign(count * H5Tget_size(type), '\0');
        if (!bytes.empty()) {
            EXPECT_GE(read(type, bytes.data()), 0) << name;
        }
        bytes += std::to_string(count);
        H5Tclose(type);
        H5Sclose(space);
    };
    const auto visit = [](hid_t root, const char *name, const H5O_info_t *info, void *all) -> herr_t {
        auto &content = *static_cast<Content *>(all);
        const hid_t object = H5Oopen(root, name, H5P_DEFAULT);
        content[name];
        if (info->type == H5O_TYPE_DATASET)
            add(content, name, H5Dget_type(object), H5Dget_space(object),
                [&](hid_t type, void *bytes) { return H5Dread(object, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, bytes); });
        for (hsize_t a = 0; a < info->num_attrs; ++a) {
            const hid_t attribute =
                H5Aopen_by_idx(object, ".", H5_INDEX_NAME, H5_ITER_INC, a, H5P_DEFAULT, H5P_DEFAULT);
            std::string attribute_name(static_cast<std::size_t>(H5Aget_name(attribute, 0, nullptr)), '\0');
            H5Aget_name(attribute, attribute_name.size() + 1, attribute_name.data());
            add(content, name + ("@" + attribute_name), H5Aget_type(attribute), H5Aget_space(attribute),
                [&](hid_t type, void *bytes) { return H5Aread(attribute, type, bytes); });
            H5Aclose(attribute);
        }
        H5Oclose(object);
        return 0;
    };
    Content content;
    const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
    EXPECT_GE(H5Ovisit2(file, H5_INDEX_NAME, H5_ITER_INC, visit, &content, H5O_INFO_BASIC | H5O_INFO_NUM_ATTRS), 0);
    H5Fclose(file);
    return content;
}

/// Both have the same datasets and attributes, with the same bytes.
inline void expect_same_content(const std::filesystem::path &found, const std::filesystem::path &expected) {
    const auto a = content_of(found), b = content_of(expected);
    EXPECT_GT(b.size(), 10U);
    for (const auto &[name, bytes] : b) {
        ASSERT_TRUE(a.contains(name)) << name;
        EXPECT_TRUE(a.at(name) == bytes) << name;
    }
    EXPECT_EQ(a.size(), b.size());
}

} // namespace livermark::tests
