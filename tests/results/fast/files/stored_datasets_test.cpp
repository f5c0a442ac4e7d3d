// How datasets lie in a result file.
#include <cstdint>
#include <fstream>
#include <functional>
#include <gtest/gtest.h>
#include <hdf5.h>

#include "core/support/input_error.hpp"
#include "results/hdf5/result_file.hpp"
#include "tests/result_folder.hpp"
#include "tests/samples/records/sample_result.hpp"

namespace livermark::results {
namespace {

namespace fs = std::filesystem;

using StoredDatasets = tests::ResultFolder;

const std::string points = "/mesh/points";
const std::string tetrahedra = "/mesh/tetrahedra";

/// What a function makes of a dataset of a file.
template <class T> T ask(const fs::path &path, const std::string &name, const std::function<T(hid_t)> &question) {
    const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
    const hid_t dataset = H5Dopen2(file, name.c_str(), H5P_DEFAULT);
    EXPECT_GE(dataset, 0) << name;
    const T answer = question(dataset);
    H5Dclose(dataset);
    H5Fclose(file);
    return answer;
}

hsize_t stored_bytes(const fs::path &path, const std::string &name) {
    return ask<hsize_t>(path, name, H5Dget_storage_size);
}

haddr_t place_in_file(const fs::path &path, const std::string &name) {
    return ask<haddr_t>(path, name, [](hid_t dataset) {
        H5O_info_t info;
        EXPECT_GE(H5Oget_info2(dataset, &info, H5O_INFO_BASIC), 0);
        return info.addr;
    });
}

haddr_t place_of_first_chunk(const fs::path &path, const std::string &name) {
    return ask<haddr_t>(path, name, [](hid_t dataset) {
        constexpr hsize_t first_row[] = {0, 0};
        haddr_t place = HADDR_UNDEF;
        EXPECT_GE(H5Dget_chunk_info_by_coord(dataset, first_row, nullptr, &place, nullptr), 0);
        return place;
    });
}

TEST_F(StoredDatasets, IntegersAreCompressedAndNumbersHaveAChecksum) {
    const auto result = tests::sample_result(1000);
    write_result(path_, result);
    const auto &mesh = result.problem.body->mesh;
    EXPECT_LT(stored_bytes(path_, tetrahedra), mesh.tetrahedra.size() * 4 * sizeof(std::int64_t) / 3);
    constexpr std::size_t checksum_bytes = 4;
    EXPECT_EQ(stored_bytes(path_, points), mesh.points.size() * 3 * sizeof(double) + checksum_bytes);
}

TEST_F(StoredDatasets, ChunksAreOfOneSize) {
    const auto result = tests::without_motion(tests::sample_result(12'000)); // points of little more than a megabyte
    write_result(path_, result);
    const auto chunk_rows = ask<hsize_t>(path_, points, [](hid_t dataset) {
        hsize_t chunk[2] = {};
        const hid_t properties = H5Dget_create_plist(dataset);
        EXPECT_EQ(H5Pget_chunk(properties, 2, chunk), 2);
        H5Pclose(properties);
        return chunk[0];
    });
    const auto num_points = result.problem.body->mesh.points.size();
    EXPECT_GT(chunk_rows, num_points / 3);
    EXPECT_LE(2 * chunk_rows, num_points + 1);
}

TEST_F(StoredDatasets, AWrongDigitIsFound) {
    write_result(path_, tests::sample_result(1000));
    for (const auto &name : {points, tetrahedra}) {
        const auto place = static_cast<std::streamoff>(place_of_first_chunk(path_, name)) + 1000;
        std::fstream file(path_, std::ios::in | std::ios::out | std::ios::binary);
        file.seekg(place);
        const auto byte = static_cast<char>(file.get());
        file.seekp(place).put(static_cast<char>(~byte)).flush();
        EXPECT_THROW(read_result(path_), support::InputError) << name;
        file.seekp(place).put(byte);
    }
    EXPECT_NO_THROW(read_result(path_));
}

TEST_F(StoredDatasets, SpringsOfModelsShareWhatIsTheSame) {
    auto result = tests::sample_result();
    result.models.push_back(tests::stiffer(result.models[1]));
    write_result(path_, result);
    const auto is_shared = [&](const std::string &field) {
        return place_in_file(path_, "/solutions/springs/" + field) ==
               place_in_file(path_, "/solutions/stiffer/" + field);
    };
    EXPECT_TRUE(is_shared("node_mass"));
    EXPECT_TRUE(is_shared("edges"));
    EXPECT_TRUE(is_shared("rest_length"));
    EXPECT_FALSE(is_shared("stiffness"));
}

} // namespace
} // namespace livermark::results
