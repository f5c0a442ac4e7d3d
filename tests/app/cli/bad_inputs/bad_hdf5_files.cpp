#include <cstdint>
#include <fstream>
#include <hdf5.h>
#include <limits>
#include <stdexcept>

#include "results/hdf5/result_file.hpp"
#include "tests/app/cli/bad_inputs/bad_inputs.hpp"
#include "tests/samples/records/sample_records.hpp"
#include "tests/samples/records/sample_result.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark::tests {

namespace {

namespace fs = std::filesystem;
using Change = std::function<void(hid_t file)>;

void require(bool is_done) {
    if (!is_done)
        throw std::runtime_error("the HDF5 file cannot be spoilt");
}

Change without(const char *path) {
    return [=](hid_t file) { require(H5Ldelete(file, path, H5P_DEFAULT) >= 0); };
}

Change without_attribute(const char *path, const char *name) {
    return [=](hid_t file) { require(H5Adelete_by_name(file, path, name, H5P_DEFAULT) >= 0); };
}

Change with_attribute(const char *path, const char *name, int value) {
    return [=](hid_t file) {
        const hid_t attribute = H5Aopen_by_name(file, path, name, H5P_DEFAULT, H5P_DEFAULT);
        require(attribute >= 0 && H5Awrite(attribute, H5T_NATIVE_INT, &value) >= 0);
        H5Aclose(attribute);
    };
}

/// A dataset of zeros in the place of the one that was there.
Change with_zeros(const char *path, hid_t type, const std::vector<hsize_t> &shape) {
    return [=](hid_t file) {
        require(H5Ldelete(file, path, H5P_DEFAULT) >= 0);
        const hid_t space = H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr);
        const hid_t dataset = H5Dcreate2(file, path, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
        require(dataset >= 0);
        H5Dclose(dataset);
        H5Sclose(space);
    };
}

/// Another value for one entry of a dataset.
Change with_entry(const char *path, std::size_t entry, double value) {
    return [=](hid_t file) {
        const hid_t dataset = H5Dopen2(file, path, H5P_DEFAULT);
        const hid_t space = H5Dget_space(dataset);
        std::vector<double> all(static_cast<std::size_t>(H5Sget_simple_extent_npoints(space)));
        require(H5Dread(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, all.data()) >= 0);
        all.at(entry) = value;
        require(H5Dwrite(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, all.data()) >= 0);
        H5Sclose(space);
        H5Dclose(dataset);
    };
}

void change(const fs::path &path, const Change &spoil) {
    const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
    require(file >= 0);
    spoil(file);
    H5Fclose(file);
}

/// Something else in the place of a result file.
BadInput in_its_place(std::string what, std::function<void(const fs::path &)> make) {
    return {std::move(what), "table result.h5", {}, [=](const fs::path &folder) { make(folder / "result.h5"); }};
}

/// A result file, spoilt.
BadInput result(std::string what, const Change &spoil) {
    return in_its_place(std::move(what), [=](const fs::path &file) {
        results::write_result(file, sample_result());
        change(file, spoil);
    });
}

/// A folder for a report, with something in it.
BadInput report(std::string what, std::function<void(const fs::path &)> make) {
    return {std::move(what), "report runs", {}, [=](const fs::path &folder) { make(folder / "runs"); }};
}

/// A calibration of the springs of a bar, spoilt, for a run on the good one.
BadInput calibration(std::string what, double poisson_ratio, const Change &spoil) {
    return {std::move(what),
            good_run + " --model calibrated_nodal_volume --calibration springs.h5",
            {{"case.toml", good_case}},
            [=](const fs::path &folder) {
                write_bar(folder);
                const auto body = make_body(box_mesh({0.09, 0.03, 0.03}, {3, 1, 1}), {1000.0, 5000.0, poisson_ratio});
                results::write_calibration(folder / "springs.h5", sample_calibration(*body));
                change(folder / "springs.h5", spoil);
            }};
}

} // namespace

std::vector<BadInput> bad_hdf5_files() {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const auto write = [](const std::string &bytes) {
        return [=](const fs::path &file) { std::ofstream(file, std::ios::binary) << bytes; };
    };
    return {
        in_its_place("a result file that is not there", [](const fs::path &) {}),
        in_its_place("a folder without result files", [](const fs::path &file) { fs::create_directory(file); }),
        in_its_place("an empty result file", write("")),
        in_its_place("random bytes as a result file", write(random_bytes())),
        in_its_place("half a result file",
                     [](const fs::path &file) {
                         results::write_result(file, sample_result());
                         fs::resize_file(file, fs::file_size(file) / 2);
                     }),
        in_its_place("a result file whose first header is damaged",
                     [](const fs::path &file) {
                         results::write_result(file, sample_result());
                         // The superblock says where the object header of the root group begins.
                         constexpr std::streamoff place_of_root = 36;
                         std::fstream stream(file, std::ios::binary | std::ios::in | std::ios::out);
                         std::uint64_t root = 0;
                         stream.seekg(place_of_root).read(reinterpret_cast<char *>(&root), sizeof root);
                         constexpr std::streamoff place_in_message = 20;
                         stream.seekp(static_cast<std::streamoff>(root) + place_in_message).put('\xff');
                     }),
        result("HDF5 that is no result file", without_attribute("/", "schema_version")),
        result("a result file of another version", with_attribute("/", "schema_version", 99)),
        result("a dataset that is missing", without("/mesh/points")),
        result("a dataset that is a link to another file",
               [](hid_t file) {
                   require(H5Ldelete(file, "/mesh/points", H5P_DEFAULT) >= 0);
                   require(H5Lcreate_external("/dev/zero", "/points", file, "/mesh/points", H5P_DEFAULT, H5P_DEFAULT) >=
                           0);
               }),
        result("an attribute that is missing", without_attribute("/solutions/springs", "status")),
        result("a dataset of another shape", with_zeros("/solutions/fem_p2/displacement", H5T_IEEE_F64LE, {1, 3})),
        result("a dataset of another type", with_zeros("/mesh/points", H5T_STD_I32LE, {12, 3})),
        result("a node that is not there", with_entry("/mesh/tetrahedra", 4, 99)),
        result("a tetrahedron without volume", with_entry("/mesh/tetrahedra", 0, 1)),
        result("NaN as a coordinate of a result file", with_entry("/mesh/points", 4, nan)),
        result("Poisson's ratio of 1/2 in a result file", with_entry("/materials/poisson_ratio", 1, 0.5)),
        result("a comparison with a model that is missing", without("/solutions/fem_p2")),
        report("a folder for a report that is not there", [](const fs::path &) {}),
        report("a folder for a report without result files",
               [](const fs::path &folder) { fs::create_directory(folder); }),
        report("nothing but a damaged file for a report",
               [](const fs::path &folder) {
                   fs::create_directories(folder / "bar");
                   results::write_result(folder / "bar" / "bad.h5", sample_result());
                   fs::resize_file(folder / "bar" / "bad.h5", 10000);
               }),
        report("nothing but random bytes for a report",
               [](const fs::path &folder) {
                   fs::create_directory(folder);
                   std::ofstream(folder / "bad.h5", std::ios::binary) << random_bytes();
               }),
        report("a timing file of a report without its clock",
               [](const fs::path &folder) {
                   fs::create_directory(folder);
                   results::write_timings(folder / "timings.h5", sample_timings());
                   change(folder / "timings.h5", without_attribute("/timings/step/newmark/all", "clock"));
               }),
        calibration("HDF5 that is no calibration", 0.3, without("/springs")),
        calibration("a calibration with a negative stiffness", 0.3, with_entry("/springs/stiffness", 3, -1.0)),
        calibration("a calibration for another material", 0.45, [](hid_t) {}),
    };
}

} // namespace livermark::tests
