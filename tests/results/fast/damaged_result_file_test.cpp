#include <cmath>
#include <cstdint>
#include <fstream>
#include <functional>
#include <gtest/gtest.h>
#include <hdf5.h>
#include <limits>
#include <sys/stat.h>

#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "results/hdf5/result_file.hpp"
#include "tests/result_folder.hpp"
#include "tests/samples/records/sample_result.hpp"

namespace livermark::results {
namespace {

namespace fs = std::filesystem;

using DamagedResultFile = tests::ResultFolder;

/// The message with which the reader refuses a file.
std::string refusal_of_file(const fs::path &path) {
    try {
        read_result(path);
    } catch (const support::InputError &error) {
        EXPECT_NE(std::string(error.what()).find(path.string()), std::string::npos) << error.what();
        return error.what();
    }
    ADD_FAILURE() << "the file was read";
    return {};
}

/// Changes a file behind the writer's back.
void tamper(const fs::path &path, const std::function<void(hid_t)> &change) {
    const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
    ASSERT_GE(file, 0);
    change(file);
    H5Fclose(file);
}

template <class T>
void replace(hid_t file, const char *path, hid_t type, const std::vector<hsize_t> &shape, const std::vector<T> &data,
             hid_t memory_type) {
    H5Ldelete(file, path, H5P_DEFAULT);
    const hid_t space = H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr);
    const hid_t dataset = H5Dcreate2(file, path, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    EXPECT_GE(H5Dwrite(dataset, memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data.data()), 0);
    H5Dclose(dataset);
    H5Sclose(space);
}

/// Overwrites one entry of a dataset of rank 1 or 2.
template <class T> void poke(hid_t file, const char *path, hid_t memory_type, std::size_t entry, T value) {
    const hid_t dataset = H5Dopen2(file, path, H5P_DEFAULT);
    const hid_t space = H5Dget_space(dataset);
    std::vector<T> data(static_cast<std::size_t>(H5Sget_simple_extent_npoints(space)));
    H5Dread(dataset, memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data.data());
    data.at(entry) = value;
    EXPECT_GE(H5Dwrite(dataset, memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data.data()), 0);
    H5Sclose(space);
    H5Dclose(dataset);
}

template <class T> void set_attribute(hid_t file, const char *path, const char *name, hid_t type, T value) {
    const hid_t object = H5Oopen(file, path, H5P_DEFAULT);
    const hid_t attribute = H5Aopen(object, name, H5P_DEFAULT);
    EXPECT_GE(H5Awrite(attribute, type, &value), 0);
    H5Aclose(attribute);
    H5Oclose(object);
}

/// Checksums guard each header; h5py looks at all of them when it opens a file, so one that it refuses is refused here.
TEST_F(DamagedResultFile, IsRefusedForAnyHeaderThoughNothingInItIsRead) {
    write_result(path_, tests::sample_result());
    const auto whole = support::read_text(path_);
    std::size_t num_headers = 0;
    for (auto at = whole.find("OHDR"); at != std::string::npos; at = whole.find("OHDR", at + 4)) {
        auto damaged = whole;
        constexpr std::size_t to_times = 8; // behind signature, version and flags
        damaged[at + to_times] = static_cast<char>(damaged[at + to_times] ^ 1);
        std::ofstream(path_, std::ios::binary) << damaged;
        EXPECT_NE(refusal_of_file(path_), "") << "header " << num_headers;
        ++num_headers;
    }
    EXPECT_GT(num_headers, 40U);
}

TEST_F(DamagedResultFile, ReadsFilesFromBeforeTheReferenceHadAnUncertainty) {
    write_result(path_, tests::sample_result());
    tamper(path_, [](hid_t file) {
        EXPECT_GE(H5Ldelete(file, "/reference", H5P_DEFAULT), 0);
        EXPECT_GE(H5Adelete_by_name(file, "/comparisons/springs", "within_uncertainty", H5P_DEFAULT), 0);
        EXPECT_GE(H5Adelete_by_name(file, "/solutions/fem_p2", "solver", H5P_DEFAULT), 0);
    });
    const Result read = read_result(path_);
    EXPECT_FALSE(read.reference_uncertainty);
    EXPECT_EQ(read.models[0].solution.solver, "");
    EXPECT_TRUE(read.models[1].comparison);
}

TEST_F(DamagedResultFile, ReadsFilesFromBeforeStiffnessAtTheTool) {
    write_result(path_, tests::sample_result());
    tamper(path_, [](hid_t file) {
        for (const auto *const group : {"/load_case/load", "/load_case/tool", "/comparisons/springs/tool"})
            EXPECT_GE(H5Ldelete(file, group, H5P_DEFAULT), 0);
        EXPECT_GE(H5Adelete_by_name(file, "/solutions/fem_p2", "observed_stiffness", H5P_DEFAULT), 0);
        EXPECT_GE(H5Adelete_by_name(file, "/reference", "stiffness_uncertainty", H5P_DEFAULT), 0);
    });
    const Result read = read_result(path_);
    EXPECT_TRUE(std::ranges::all_of(read.problem.load_case.load_names(), &std::string::empty));
    EXPECT_FALSE(read.models[1].comparison->tool);
    EXPECT_FALSE(read.models[0].solution.observed_error->stiffness);
    EXPECT_FALSE(read.reference_uncertainty->stiffness);
}

TEST_F(DamagedResultFile, ReadsFilesFromWhenAModelThatFailedHadABandOfErrors) {
    write_result(path_, tests::sample_result());
    const auto add = [&](const char *attribute) {
        tamper(path_, [&](hid_t file) {
            const hid_t group = H5Gcreate2(file, "/comparisons/unfinished", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
            const hid_t space = H5Screate(H5S_SCALAR);
            H5Aclose(H5Acreate2(group, attribute, H5T_IEEE_F64LE, space, H5P_DEFAULT, H5P_DEFAULT));
            H5Sclose(space);
            H5Gclose(group);
        });
    };
    add("band_expected");
    EXPECT_FALSE(read_result(path_).models[3].comparison);
    write_result(path_, tests::sample_result());
    add("something_else");
    EXPECT_NE(refusal_of_file(path_).find("/comparisons/unfinished has no attribute reference"), std::string::npos);
}

TEST_F(DamagedResultFile, RefusesWhatIsNoResultFile) {
    EXPECT_NE(refusal_of_file(path_).find("no such file"), std::string::npos);
    std::ofstream(path_) << "time,displacement\n0,0\n";
    EXPECT_NE(refusal_of_file(path_).find("not an HDF5 file"), std::string::npos);
    fs::remove(path_);
    H5Fclose(H5Fcreate(path_.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT)); // in the oldest format
    EXPECT_NE(refusal_of_file(path_).find("not an HDF5 file in the format"), std::string::npos);
    const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
    H5Pset_libver_bounds(access, H5F_LIBVER_V110, H5F_LIBVER_V110);
    H5Fclose(H5Fcreate(path_.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access));
    H5Pclose(access);
    EXPECT_NE(refusal_of_file(path_).find("schema_version"), std::string::npos);
}

TEST_F(DamagedResultFile, RefusesATruncatedFile) {
    write_result(path_, tests::sample_result());
    fs::resize_file(path_, fs::file_size(path_) / 2);
    EXPECT_NE(refusal_of_file(path_).find("truncated"), std::string::npos);
}

TEST_F(DamagedResultFile, RefusesAnotherSchema) {
    write_result(path_, tests::sample_result());
    tamper(path_, [](hid_t file) { set_attribute(file, "/", "schema_version", H5T_NATIVE_INT, 2); });
    EXPECT_NE(refusal_of_file(path_).find("schema_version is 2"), std::string::npos);
}

/// Jaws are two balls that close, and each exerts something.
TEST_F(DamagedResultFile, RefusesJawsThatAreNone) {
    auto plates = tests::with_jaws(tests::sample_result());
    auto &plate = plates.problem.load_case.touching.value();
    plate.shape = {core::ToolFace::round, 0.3, 0.03, plate.press};
    write_result(path_, plates);
    EXPECT_NE(refusal_of_file(path_).find("/load_case/touch/between"), std::string::npos);
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    const std::vector<std::function<void(hid_t)>> changes{
        [](hid_t file) { poke(file, "/load_case/touch/way", H5T_NATIVE_DOUBLE, 6, 0.1); },
        [](hid_t file) { poke(file, "/load_case/touch/between", H5T_NATIVE_DOUBLE, 1, nan); },
        [](hid_t file) { set_attribute(file, "/load_case/touch", "constraint", H5T_NATIVE_INT, 1); }};
    for (const auto &change : changes) {
        write_result(path_, tests::with_jaws(tests::sample_result()));
        tamper(path_, change);
        EXPECT_NE(refusal_of_file(path_).find("/load_case/touch/between"), std::string::npos);
    }
}

/// A change of a file that a reader has to find.
struct Fault {
    std::string place; ///< that the message names
    std::string says;
    std::function<void(hid_t)> make;
};

TEST_F(DamagedResultFile, NamesThePlaceOfEveryFault) {
    const Result written = tests::sample_result();
    const auto num_nodes = static_cast<int>(written.problem.body->mesh.points.size());
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const std::vector<double> zeros(static_cast<std::size_t>(num_nodes) * 3, 0.0);
    std::vector<Fault> faults;
    const auto missing = [&](const std::string &removed, const std::string &place, const std::string &says) {
        faults.push_back(
            {place, says, [=](hid_t file) { EXPECT_GE(H5Ldelete(file, removed.c_str(), H5P_DEFAULT), 0); }});
    };
    const auto no_attribute = [&](const std::string &place, const std::string &name) {
        faults.push_back({place, "has no attribute " + name,
                          [=](hid_t file) { H5Adelete_by_name(file, place.c_str(), name.c_str(), H5P_DEFAULT); }});
    };
    const auto reshaped = [&](const std::string &place, const std::vector<hsize_t> &shape, const std::string &says,
                              hid_t type = H5T_IEEE_F64LE) {
        faults.push_back(
            {place, says, [=](hid_t file) { replace(file, place.c_str(), type, shape, zeros, H5T_NATIVE_DOUBLE); }});
    };
    const auto number = [&](const std::string &place, std::size_t entry, std::int64_t value, const std::string &says) {
        faults.push_back({place, says, [=](hid_t file) { poke(file, place.c_str(), H5T_NATIVE_INT64, entry, value); }});
    };
    const auto real = [&](const std::string &place, std::size_t entry, double value, const std::string &says) {
        faults.push_back(
            {place, says, [=](hid_t file) { poke(file, place.c_str(), H5T_NATIVE_DOUBLE, entry, value); }});
    };
    const auto attribute = [&](const std::string &at, const char *name, int value, const std::string &place,
                               const std::string &says) {
        faults.push_back(
            {place, says, [=](hid_t file) { set_attribute(file, at.c_str(), name, H5T_NATIVE_INT, value); }});
    };
    for (const std::string place :
         {"/mesh/points", "/solutions/springs/rest_length", "/comparisons/springs/error",
          "/comparisons/springs/tool/relative_l2", "/comparisons/springs/error_frames", "/modes/fem_p2/shape"})
        missing(place, place, "is missing");
    missing("/materials", "/materials/density", "is missing");
    missing("/solutions", "/solutions", "is not there");
    missing("/solutions/fem_p2", "/comparisons/springs", "attribute reference is 'fem_p2'");
    missing("/load_case/release", "/solutions/fem_p2/history", "is there");
    no_attribute("/reference", "reference_uncertainty");
    no_attribute("/mesh/boundary_patch", "names");
    no_attribute("/solutions/springs", "status");
    reshaped("/solutions/fem_p2/displacement", {zeros.size()}, "has rank 1 instead of 2");
    reshaped("/solutions/fem_p2/displacement", {1, 3}, "has shape (1,3) instead of (12,3)");
    reshaped("/load_case/acceleration", {4}, "has shape (4) instead of (3)");
    reshaped("/load_case/acceleration", {3}, "holds 32-bit floating point numbers instead of 64-bit", H5T_IEEE_F32LE);
    reshaped("/load_case/condition", {20}, "holds 64-bit floating point numbers instead of 8-bit unsigned integers");
    reshaped("/comparisons/springs/tool/path", {1, 2}, "has shape (1,2) instead of");
    reshaped("/comparisons/springs/tool/path", {6, 3}, "has 6 points, and /load_case/path 5");
    reshaped("/solutions/fem_p2/history/frames", {12, 3}, "holds 64-bit floating point numbers instead of 32-bit");
    reshaped("/solutions/fem_p2/history/displacement", {2, 1, 3}, "has shape (2,1,3) instead of (53,3,3)");
    reshaped("/solutions/fem_p2/history/displacement", {2, 3}, "has rank 2 instead of 3");
    number("/mesh/tetrahedra", 4, num_nodes, "row 1 holds 12");
    number("/mesh/tetrahedra", 4, -1, "row 1 holds -1");
    number("/mesh/tetrahedra", 0, std::int64_t{1} << 32, "row 0 holds 2147483647"); // clamped
    number("/mesh/tetrahedra", 0, written.problem.body->mesh.tetrahedra[0][1], "row 0 has no positive volume");
    number("/mesh/region", 0, 2, "row 0 holds 2");
    number("/mesh/boundary_triangles", 2, 99, "row 0 holds 99");
    number("/mesh/boundary_patch", 3, -1, "row 3 holds -1");
    number("/load_case/condition", 2, 3, "row 2 holds 3");
    number("/load_case/round_load/facet", 0, 8, "row 0 holds 8");
    number("/load_case/load", 0, 1, "row 0 contradicts /load_case/condition");
    number("/load_case/constraint", 0, 2, "row 0 holds 2");
    number("/load_case/release/probe", 1, num_nodes, "row 1 holds 12");
    number("/solutions/springs/edges", 1, num_nodes, "row 0 holds 12");
    real("/mesh/points", 4, nan, "row 1 is not finite");
    real("/materials/poisson_ratio", 1, 0.5, "row 1 is 0.5");
    real("/materials/density", 0, nan, "row 0 is nan");
    real("/load_case/round_load/radius", 1, -1.0, "row 1 is no length");
    faults.push_back({"/load_case", "rows 15 and 18 are of one place, and have different conditions",
                      [](hid_t file) { poke(file, "/load_case/load", H5T_NATIVE_INT, 15, 2); }});
    attribute("/", "threads", 0, "/", "attribute threads is 0");
    const std::string release = "/load_case/release", history = "/solutions/fem_p2/history";
    attribute(release, "num_steps", 0, release, "attribute num_steps is 0");
    attribute(release, "num_steps", 50, release, "attribute records_per_frame is 2 instead of 1");
    attribute(release, "num_steps", 51, history + "/time", "has shape (53) instead of (52)");
    attribute(history, "forces_per_step", -1, history, "attribute forces_per_step is -1");
    faults.push_back({release, "have to be positive", [=](hid_t file) {
                          set_attribute(file, release.c_str(), "output_interval", H5T_NATIVE_DOUBLE, nan);
                      }});
    EXPECT_EQ(faults.size(), 47U);
    for (const Fault &fault : faults) {
        SCOPED_TRACE(fault.place + " " + fault.says);
        write_result(path_, written);
        tamper(path_, fault.make);
        const std::string message = refusal_of_file(path_);
        EXPECT_NE(message.find(": " + fault.place + " "), std::string::npos) << message;
        EXPECT_NE(message.find(fault.says), std::string::npos) << message;
    }
}

/// Puts a text of another type in the place of an attribute of the root.
void replace_text(hid_t file, const char *name, std::size_t length) {
    H5Adelete(file, name);
    const hid_t type = H5Tcopy(H5T_C_S1);
    H5Tset_size(type, length);
    const hid_t space = H5Screate(H5S_SCALAR);
    const hid_t attribute = H5Acreate2(file, name, type, space, H5P_DEFAULT, H5P_DEFAULT);
    const std::string characters(length == H5T_VARIABLE ? 1 : length, 'x');
    const char *variable = characters.c_str();
    const void *value = length == H5T_VARIABLE ? static_cast<const void *>(&variable) : characters.data();
    EXPECT_GE(H5Awrite(attribute, type, value), 0);
    H5Aclose(attribute);
    H5Sclose(space);
    H5Tclose(type);
}

TEST_F(DamagedResultFile, RefusesTextsOfVariableOrExcessiveLength) {
    write_result(path_, tests::sample_result());
    tamper(path_, [](hid_t file) { replace_text(file, "cpu", H5T_VARIABLE); });
    EXPECT_NE(refusal_of_file(path_).find("/ attribute cpu is text of variable length, which is not read"),
              std::string::npos);
    write_result(path_, tests::sample_result());
    tamper(path_, [](hid_t file) { replace_text(file, "cpu", 2'000'000); });
    EXPECT_NE(refusal_of_file(path_).find("/ attribute cpu is text of 2000000 bytes"), std::string::npos);
}

/// Puts points that nobody wrote in the place of those of the mesh.
void replace_points(hid_t file, hsize_t num_points, const std::function<void(hid_t)> &choose_storage) {
    H5Ldelete(file, "/mesh/points", H5P_DEFAULT);
    const hsize_t shape[] = {num_points, 3};
    const hid_t space = H5Screate_simple(2, shape, nullptr);
    const hid_t properties = H5Pcreate(H5P_DATASET_CREATE);
    choose_storage(properties);
    const hid_t dataset = H5Dcreate2(file, "/mesh/points", H5T_IEEE_F64LE, space, H5P_DEFAULT, properties, H5P_DEFAULT);
    EXPECT_GE(dataset, 0);
    H5Dclose(dataset);
    H5Pclose(properties);
    H5Sclose(space);
}

TEST_F(DamagedResultFile, RefusesStorageThatIsNotOurs) {
    const hsize_t chunk[] = {1000, 3};
    const hsize_t excessive_chunk[] = {100'000'000, 3};
    const std::vector<std::pair<std::string, std::function<void(hid_t)>>> storages{
        {"is damaged: 0 bytes are kept of 2400000000", [](hid_t) {}},
        {"is damaged: 2400000000 bytes cannot be what is kept in 0", [&](hid_t p) { H5Pset_chunk(p, 2, chunk); }},
        {"is damaged: its chunks cannot be", [&](hid_t p) { H5Pset_chunk(p, 2, excessive_chunk); }},
        {"is compressed in a way that is not read",
         [&](hid_t p) {
             H5Pset_chunk(p, 2, chunk);
             H5Pset_scaleoffset(p, H5Z_SO_FLOAT_DSCALE, 3);
         }},
        {"is kept in another file", [](hid_t p) { H5Pset_external(p, "/etc/hostname", 0, H5F_UNLIMITED); }},
    };
    for (const auto &[says, choose] : storages) {
        SCOPED_TRACE(says);
        write_result(path_, tests::sample_result());
        tamper(path_, [&](hid_t file) { replace_points(file, 100'000'000, choose); });
        EXPECT_NE(refusal_of_file(path_).find(": /mesh/points " + says), std::string::npos) << refusal_of_file(path_);
    }
}

/// A pipe that nobody writes to keeps whoever opens it waiting.
TEST_F(DamagedResultFile, RefusesLinksAndOpensNoneOfThem) {
    const auto pipe = directory_ / "pipe";
    ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
    for (const std::string place : {"/mesh", "/mesh/points", "/solutions", "/solutions/springs", "/load_case"})
        for (const bool is_external : {true, false}) {
            SCOPED_TRACE(place);
            write_result(path_, tests::sample_result());
            tamper(path_, [&](hid_t file) {
                EXPECT_GE(H5Ldelete(file, place.c_str(), H5P_DEFAULT), 0);
                const auto made =
                    is_external ? H5Lcreate_external(pipe.c_str(), "/", file, place.c_str(), H5P_DEFAULT, H5P_DEFAULT)
                                : H5Lcreate_soft("/materials", file, place.c_str(), H5P_DEFAULT, H5P_DEFAULT);
                EXPECT_GE(made, 0);
            });
            EXPECT_NE(refusal_of_file(path_).find(": " + place + " is a link to another place"), std::string::npos)
                << refusal_of_file(path_);
        }
    EXPECT_NE(refusal_of_file(pipe).find("this is not a plain file"), std::string::npos);
}

TEST_F(DamagedResultFile, RefusesADatasetThatIsMadeOfAnotherFile) {
    const auto pipe = directory_ / "pipe";
    ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
    write_result(path_, tests::sample_result());
    tamper(path_, [&](hid_t file) {
        replace_points(file, 12, [&](hid_t properties) {
            const hsize_t shape[] = {12, 3};
            const hid_t space = H5Screate_simple(2, shape, nullptr);
            EXPECT_GE(H5Pset_virtual(properties, space, pipe.c_str(), "points", space), 0);
            H5Sclose(space);
        });
    });
    EXPECT_NE(refusal_of_file(path_).find(": /mesh/points is kept in another file"), std::string::npos);
}

/// Only numbers are damaged without notice: where they are not compressed they have no checksum.
TEST_F(DamagedResultFile, IsReadOrRefusedWhateverByteIsWrong) {
    write_result(path_, tests::sample_result());
    std::ifstream stream(path_, std::ios::binary);
    const std::string whole{std::istreambuf_iterator<char>(stream), {}};
    int num_refused = 0, num_tried = 0;
    for (std::size_t place = 0; place < whole.size(); place += 211, ++num_tried) {
        std::string damaged = whole;
        damaged[place] = static_cast<char>(~damaged[place]);
        std::ofstream(path_, std::ios::binary) << damaged;
        try {
            read_result(path_, Origin::own); // what is wrong with it shows here
        } catch (const support::InputError &) {
            ++num_refused;
        }
    }
    EXPECT_GT(num_tried, 100);
    EXPECT_GT(num_refused, num_tried / 3);
}

} // namespace
} // namespace livermark::results
