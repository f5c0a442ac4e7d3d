#include "results/result_file.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <functional>
#include <gtest/gtest.h>
#include <hdf5.h>
#include <limits>
#include <sys/resource.h>

#include "core/input_error.hpp"
#include "tests/sample_result.hpp"

namespace livermark::results {
namespace {

namespace fs = std::filesystem;

/// An empty directory for each test.
class ResultFile : public testing::Test {
  protected:
    void SetUp() override {
        const auto *test = testing::UnitTest::GetInstance()->current_test_info();
        directory_ = fs::path(testing::TempDir()) / (std::string("livermark_result_file_") + test->name());
        fs::remove_all(directory_);
        fs::create_directories(directory_);
        path_ = directory_ / "result.h5";
    }
    void TearDown() override { fs::remove_all(directory_); }

    std::vector<std::string> files() const {
        std::vector<std::string> names;
        for (const auto &entry : fs::directory_iterator(directory_))
            names.push_back(entry.path().filename());
        return names;
    }

    fs::path directory_;
    fs::path path_;
};

std::string content(const fs::path &path) {
    std::ifstream stream(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

/// Bit by bit, so that NaN equals NaN and -0 differs from 0.
template <class T> bool same_bits(const std::vector<T> &a, const std::vector<T> &b) {
    return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}
bool same_bits(double a, double b) {
    return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

void expect_equal(const core::TetraMesh &a, const core::TetraMesh &b) {
    EXPECT_TRUE(same_bits(a.points, b.points));
    EXPECT_EQ(a.tetrahedra, b.tetrahedra);
    EXPECT_EQ(a.region, b.region);
    EXPECT_EQ(a.region_names, b.region_names);
    EXPECT_EQ(a.boundary_triangles, b.boundary_triangles);
    EXPECT_EQ(a.boundary_patch, b.boundary_patch);
    EXPECT_EQ(a.patch_names, b.patch_names);
}

void expect_equal(const core::Release &a, const core::Release &b) {
    EXPECT_EQ(a.num_steps, b.num_steps);
    EXPECT_EQ(a.output_interval, b.output_interval);
    EXPECT_EQ(a.damping.alpha, b.damping.alpha);
    EXPECT_EQ(a.damping.beta, b.damping.beta);
    ASSERT_EQ(a.probes.size(), b.probes.size());
    for (std::size_t q = 0; q < a.probes.size(); ++q) {
        EXPECT_EQ(a.probes[q].name, b.probes[q].name);
        EXPECT_EQ(a.probes[q].node, b.probes[q].node);
    }
}

void expect_equal(const core::History &a, const core::History &b) {
    EXPECT_TRUE(same_bits(a.time, b.time));
    EXPECT_TRUE(same_bits(a.displacement, b.displacement));
    EXPECT_TRUE(same_bits(a.kinetic_energy, b.kinetic_energy));
    EXPECT_TRUE(same_bits(a.strain_energy, b.strain_energy));
    EXPECT_EQ(a.setup_seconds, b.setup_seconds);
    EXPECT_EQ(a.solve_seconds, b.solve_seconds);
}

void expect_equal(const core::LoadCase &a, const core::LoadCase &b) {
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.title, b.title);
    EXPECT_EQ(a.definition, b.definition);
    EXPECT_EQ(a.target_peak_displacement, b.target_peak_displacement);
    EXPECT_EQ(a.load_scale, b.load_scale);
    EXPECT_EQ(a.condition, b.condition);
    EXPECT_TRUE(same_bits(a.value, b.value));
    EXPECT_EQ(a.acceleration, b.acceleration);
    EXPECT_EQ(a.constraint_names, b.constraint_names);
    EXPECT_EQ(a.constraint, b.constraint);
    ASSERT_EQ(a.release.has_value(), b.release.has_value());
    if (a.release)
        expect_equal(*a.release, *b.release);
}

void expect_equal(const core::Solution &a, const core::Solution &b) {
    EXPECT_EQ(a.status, b.status);
    EXPECT_EQ(a.message, b.message);
    EXPECT_EQ(a.solver, b.solver);
    EXPECT_TRUE(same_bits(a.displacement, b.displacement));
    EXPECT_TRUE(same_bits(a.reaction, b.reaction));
    EXPECT_TRUE(same_bits(a.strain_energy, b.strain_energy));
    EXPECT_TRUE(same_bits(a.nonlinearity, b.nonlinearity));
    ASSERT_EQ(a.explicit_steps.has_value(), b.explicit_steps.has_value());
    if (a.explicit_steps) {
        EXPECT_TRUE(same_bits(a.explicit_steps->critical_time_step, b.explicit_steps->critical_time_step));
        EXPECT_TRUE(same_bits(a.explicit_steps->seconds_per_step, b.explicit_steps->seconds_per_step));
    }
    EXPECT_EQ(a.degrees_of_freedom, b.degrees_of_freedom);
    EXPECT_EQ(a.setup_seconds, b.setup_seconds);
    EXPECT_EQ(a.solve_seconds, b.solve_seconds);
    ASSERT_EQ(a.history.has_value(), b.history.has_value());
    if (a.history)
        expect_equal(*a.history, *b.history);
    ASSERT_EQ(a.springs.has_value(), b.springs.has_value());
    if (!a.springs)
        return;
    EXPECT_TRUE(same_bits(a.springs->node_mass, b.springs->node_mass));
    EXPECT_EQ(a.springs->edges, b.springs->edges);
    EXPECT_TRUE(same_bits(a.springs->stiffness, b.springs->stiffness));
    EXPECT_TRUE(same_bits(a.springs->rest_length, b.springs->rest_length));
}

void expect_equal(const core::Comparison &a, const core::Comparison &b) {
    EXPECT_EQ(a.reference, b.reference);
    EXPECT_TRUE(same_bits(a.relative_l2, b.relative_l2));
    EXPECT_TRUE(same_bits(a.max_error, b.max_error));
    EXPECT_TRUE(same_bits(a.max_error_relative, b.max_error_relative));
    EXPECT_TRUE(same_bits(a.energy_error, b.energy_error));
    EXPECT_TRUE(same_bits(a.reaction_error, b.reaction_error));
    EXPECT_EQ(a.history, b.history);
    EXPECT_TRUE(same_bits(a.error, b.error));
}

void expect_equal(const Result &a, const Result &b) {
    EXPECT_EQ(a.provenance, b.provenance);
    EXPECT_EQ(a.problem.body->name, b.problem.body->name);
    expect_equal(a.problem.body->mesh, b.problem.body->mesh);
    EXPECT_TRUE(same_bits(a.problem.body->materials, b.problem.body->materials));
    expect_equal(a.problem.load_case, b.problem.load_case);
    EXPECT_EQ(a.reference_uncertainty, b.reference_uncertainty);
    ASSERT_EQ(a.models.size(), b.models.size());
    for (std::size_t m = 0; m < a.models.size(); ++m) {
        SCOPED_TRACE(a.models[m].name);
        EXPECT_EQ(a.models[m].name, b.models[m].name);
        EXPECT_EQ(a.models[m].summary, b.models[m].summary);
        EXPECT_EQ(a.models[m].source, b.models[m].source);
        expect_equal(a.models[m].solution, b.models[m].solution);
        EXPECT_EQ(a.models[m].band, b.models[m].band);
        ASSERT_EQ(a.models[m].comparison.has_value(), b.models[m].comparison.has_value());
        if (a.models[m].comparison)
            expect_equal(*a.models[m].comparison, *b.models[m].comparison);
    }
    ASSERT_EQ(a.modes.size(), b.modes.size());
    for (std::size_t m = 0; m < a.modes.size(); ++m) {
        EXPECT_EQ(a.modes[m].name, b.modes[m].name);
        EXPECT_EQ(a.modes[m].modes.angular_frequency, b.modes[m].modes.angular_frequency);
        EXPECT_TRUE(same_bits(a.modes[m].modes.shape, b.modes[m].modes.shape));
        EXPECT_EQ(a.modes[m].modes.degrees_of_freedom, b.modes[m].modes.degrees_of_freedom);
        EXPECT_EQ(a.modes[m].modes.seconds, b.modes[m].modes.seconds);
    }
}

/// The message with which the reader refuses a file.
std::string refusal(const fs::path &path) {
    try {
        read_result(path);
    } catch (const core::InputError &error) {
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

TEST_F(ResultFile, GivesBackWhatWasWritten) {
    const Result written = tests::sample_result();
    write_result(path_, written);
    expect_equal(read_result(path_), written);
    EXPECT_EQ(files(), std::vector<std::string>{"result.h5"});
}

TEST_F(ResultFile, ReadsFilesFromBeforeTheReferenceHadAnUncertainty) {
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

TEST_F(ResultFile, GivesBackWhatWasWrittenWhenCompressed) {
    const Result written = tests::sample_result(1000);
    write_result(path_, written);
    expect_equal(read_result(path_), written);
    const std::size_t uncompressed =
        written.problem.body->mesh.points.size() * 3 * sizeof(double) *
            (1 + written.models.size() + static_cast<std::size_t>(written.modes[0].modes.count())) +
        written.problem.body->mesh.tetrahedra.size() * 2 * 4 * sizeof(std::int64_t);
    EXPECT_LT(fs::file_size(path_), uncompressed / 2);
}

TEST_F(ResultFile, KeepsNonFiniteDisplacementsOfADivergedSolution) {
    write_result(path_, tests::sample_result());
    const ModelResult model = read_result(path_).models[2];
    EXPECT_EQ(model.solution.status, core::SolutionStatus::diverged);
    EXPECT_TRUE(std::isnan(model.solution.displacement.front().x()));
    EXPECT_EQ(model.solution.displacement.front().y(), std::numeric_limits<double>::infinity());
    EXPECT_TRUE(std::isnan(model.comparison->relative_l2));
}

TEST_F(ResultFile, HoldsAProblemWithoutConstraintsAndModels) {
    Result written = tests::sample_result();
    written.models.clear();
    written.reference_uncertainty.reset();
    written.problem.load_case.constraint_names.clear();
    std::ranges::fill(written.problem.load_case.constraint, -1);
    std::ranges::fill(written.problem.load_case.condition, core::FacetCondition::free);
    write_result(path_, written);
    expect_equal(read_result(path_), written);
}

TEST_F(ResultFile, HoldsAStaticLoadCase) {
    Result written = tests::sample_result();
    written.problem.load_case.release.reset();
    written.modes.clear();
    for (auto &model : written.models) {
        model.solution.history.reset();
        if (model.comparison) {
            model.comparison->history.reset();
        }
    }
    write_result(path_, written);
    expect_equal(read_result(path_), written);
}

TEST_F(ResultFile, ReplacesAnEarlierFile) {
    Result result = tests::sample_result();
    write_result(path_, result);
    result.provenance.command = "another command";
    write_result(path_, result);
    EXPECT_EQ(read_result(path_).provenance.command, "another command");
    EXPECT_EQ(files(), std::vector<std::string>{"result.h5"});
}

TEST_F(ResultFile, RefusesADirectoryThatIsMissing) {
    EXPECT_THROW(write_result(directory_ / "nowhere" / "result.h5", tests::sample_result()), core::InputError);
    EXPECT_TRUE(files().empty());
}

TEST_F(ResultFile, LeavesNothingBehindWhenTheNameIsTaken) {
    fs::create_directories(path_ / "a directory");
    EXPECT_THROW(write_result(path_, tests::sample_result()), core::InputError);
    EXPECT_EQ(files(), std::vector<std::string>{"result.h5"});
    EXPECT_TRUE(fs::is_directory(path_));
}

TEST_F(ResultFile, LeavesTheEarlierFileWhenTheDiskIsFull) {
    const Result result = tests::sample_result();
    write_result(path_, result);
    const std::string before = content(path_);

    // A limit on the size of files fails in the middle of the writing, like a full disk.
    std::signal(SIGXFSZ, SIG_IGN);
    rlimit limit{};
    ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &limit), 0);
    const rlimit small{before.size() / 2, limit.rlim_max};
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
    EXPECT_THROW(write_result(path_, result), core::InputError);
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &limit), 0);

    EXPECT_EQ(content(path_), before);
    EXPECT_EQ(files(), std::vector<std::string>{"result.h5"});
}

TEST_F(ResultFile, LeavesTheEarlierFileWhenTheResultIsInconsistent) {
    Result result = tests::sample_result();
    write_result(path_, result);
    const std::string before = content(path_);
    const auto spoiled = [&](const std::function<void(Result &)> &spoil) {
        Result copy = result;
        spoil(copy);
        EXPECT_THROW(write_result(path_, copy), std::invalid_argument);
    };
    spoiled([](Result &r) { r.models[1].name = "fem_p2"; });
    spoiled([](Result &r) { r.models[1].name = "fem/p2"; });
    spoiled([](Result &r) { r.models[1].name = "fem.p2"; });
    spoiled([](Result &r) { r.models[1].name = ""; });
    spoiled([](Result &r) { r.models[1].comparison->reference = "nobody"; });
    spoiled([](Result &r) { r.reference_uncertainty->reference = "nobody"; });
    spoiled([](Result &r) { r.models[1].solution.displacement.pop_back(); });
    spoiled([](Result &r) { r.models[1].solution.reaction.clear(); });
    spoiled([](Result &r) { r.models[1].solution.springs->stiffness.pop_back(); });
    spoiled([](Result &r) { r.models[1].comparison->error.pop_back(); });
    spoiled([](Result &r) { r.problem.load_case.value.pop_back(); });
    spoiled([](Result &r) { r.problem.load_case.release.reset(); });
    spoiled([](Result &r) { r.problem.load_case.release->num_steps = 3; });
    spoiled([](Result &r) { r.models[1].solution.history->displacement.pop_back(); });
    spoiled([](Result &r) { r.models[1].solution.history->strain_energy.pop_back(); });
    spoiled([](Result &r) { r.modes[0].modes.shape.pop_back(); });
    spoiled([](Result &r) { r.modes[0].name = "fem/p2"; });
    spoiled([](Result &r) { r.modes.push_back(r.modes[0]); });
    EXPECT_EQ(content(path_), before);
    EXPECT_EQ(files(), std::vector<std::string>{"result.h5"});
}

TEST_F(ResultFile, RefusesWhatIsNoResultFile) {
    EXPECT_NE(refusal(path_).find("no such file"), std::string::npos);
    std::ofstream(path_) << "time,displacement\n0,0\n";
    EXPECT_NE(refusal(path_).find("not an HDF5 file"), std::string::npos);
    fs::remove(path_);
    H5Fclose(H5Fcreate(path_.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT)); // in the oldest format
    EXPECT_NE(refusal(path_).find("not an HDF5 file in the format"), std::string::npos);
    const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
    H5Pset_libver_bounds(access, H5F_LIBVER_V110, H5F_LIBVER_V110);
    H5Fclose(H5Fcreate(path_.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access));
    H5Pclose(access);
    EXPECT_NE(refusal(path_).find("schema_version"), std::string::npos);
}

TEST_F(ResultFile, RefusesATruncatedFile) {
    write_result(path_, tests::sample_result());
    fs::resize_file(path_, fs::file_size(path_) / 2);
    EXPECT_NE(refusal(path_).find("truncated"), std::string::npos);
}

TEST_F(ResultFile, RefusesAnotherSchema) {
    write_result(path_, tests::sample_result());
    tamper(path_, [](hid_t file) { set_attribute(file, "/", "schema_version", H5T_NATIVE_INT, 2); });
    EXPECT_NE(refusal(path_).find("schema_version is 2"), std::string::npos);
}

struct Fault {
    const char *place; ///< what the message must name
    std::string says;
    std::function<void(hid_t)> make;
};

TEST_F(ResultFile, NamesThePlaceOfEveryFault) {
    const Result written = tests::sample_result();
    const auto num_nodes = static_cast<int>(written.problem.body->mesh.points.size());
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const std::vector<double> row_of_zeros(static_cast<std::size_t>(num_nodes) * 3, 0.0);
    const auto remove = [](const char *path) {
        return [path](hid_t file) { EXPECT_GE(H5Ldelete(file, path, H5P_DEFAULT), 0); };
    };
    const std::vector<Fault> faults{
        {"/mesh/points", "is missing", remove("/mesh/points")},
        {"/materials/density", "is missing", remove("/materials")},
        {"/solutions", "is not there", remove("/solutions")},
        {"/solutions/springs/rest_length", "is missing", remove("/solutions/springs/rest_length")},
        {"/comparisons/springs/error", "is missing", remove("/comparisons/springs/error")},
        {"/reference", "has no attribute reference_uncertainty",
         [](hid_t file) { H5Adelete_by_name(file, "/reference", "reference_uncertainty", H5P_DEFAULT); }},
        {"/mesh/boundary_patch", "has no attribute names",
         [](hid_t file) { H5Adelete_by_name(file, "/mesh/boundary_patch", "names", H5P_DEFAULT); }},
        {"/solutions/springs", "has no attribute status",
         [](hid_t file) { H5Adelete_by_name(file, "/solutions/springs", "status", H5P_DEFAULT); }},
        {"/solutions/fem_p2/displacement", "has rank 1 instead of 2",
         [&](hid_t file) {
             replace(file, "/solutions/fem_p2/displacement", H5T_IEEE_F64LE, {row_of_zeros.size()}, row_of_zeros,
                     H5T_NATIVE_DOUBLE);
         }},
        {"/solutions/fem_p2/displacement", "has shape (1,3) instead of (12,3)",
         [&](hid_t file) {
             replace(file, "/solutions/fem_p2/displacement", H5T_IEEE_F64LE, {1, 3}, row_of_zeros, H5T_NATIVE_DOUBLE);
         }},
        {"/load_case/acceleration", "has shape (4) instead of (3)",
         [&](hid_t file) {
             replace(file, "/load_case/acceleration", H5T_IEEE_F64LE, {4}, row_of_zeros, H5T_NATIVE_DOUBLE);
         }},
        {"/load_case/acceleration", "holds 32-bit floating point numbers instead of 64-bit",
         [&](hid_t file) {
             replace(file, "/load_case/acceleration", H5T_IEEE_F32LE, {3}, row_of_zeros, H5T_NATIVE_DOUBLE);
         }},
        {"/load_case/condition", "holds 64-bit floating point numbers instead of 8-bit unsigned integers",
         [&](hid_t file) {
             replace(file, "/load_case/condition", H5T_IEEE_F64LE, {20}, row_of_zeros, H5T_NATIVE_DOUBLE);
         }},
        {"/mesh/points", "row 1 is not finite",
         [&](hid_t file) { poke(file, "/mesh/points", H5T_NATIVE_DOUBLE, 4, nan); }},
        {"/mesh/tetrahedra", "row 1 holds 12",
         [&](hid_t file) { poke(file, "/mesh/tetrahedra", H5T_NATIVE_INT, 4, num_nodes); }},
        {"/mesh/tetrahedra", "row 1 holds -1",
         [&](hid_t file) { poke(file, "/mesh/tetrahedra", H5T_NATIVE_INT, 4, -1); }},
        {"/mesh/tetrahedra", "row 0 holds 2147483647", // clamped
         [&](hid_t file) { poke(file, "/mesh/tetrahedra", H5T_NATIVE_INT64, 0, std::int64_t{1} << 32); }},
        {"/mesh/tetrahedra", "row 0 has no positive volume",
         [&](hid_t file) {
             poke(file, "/mesh/tetrahedra", H5T_NATIVE_INT, 0, written.problem.body->mesh.tetrahedra[0][1]);
         }},
        {"/mesh/region", "row 0 holds 2", [](hid_t file) { poke(file, "/mesh/region", H5T_NATIVE_INT, 0, 2); }},
        {"/mesh/boundary_triangles", "row 0 holds 99",
         [](hid_t file) { poke(file, "/mesh/boundary_triangles", H5T_NATIVE_INT, 2, 99); }},
        {"/mesh/boundary_patch", "row 3 holds -1",
         [](hid_t file) { poke(file, "/mesh/boundary_patch", H5T_NATIVE_INT, 3, -1); }},
        {"/materials/poisson_ratio", "row 1 is 0.5",
         [](hid_t file) { poke(file, "/materials/poisson_ratio", H5T_NATIVE_DOUBLE, 1, 0.5); }},
        {"/materials/density", "row 0 is nan",
         [&](hid_t file) { poke(file, "/materials/density", H5T_NATIVE_DOUBLE, 0, nan); }},
        {"/load_case/condition", "row 2 holds 3",
         [](hid_t file) { poke(file, "/load_case/condition", H5T_NATIVE_INT, 2, 3); }},
        {"/load_case/constraint", "row 0 holds 2",
         [](hid_t file) { poke(file, "/load_case/constraint", H5T_NATIVE_INT, 0, 2); }},
        {"/", "attribute threads is 0", [](hid_t file) { set_attribute(file, "/", "threads", H5T_NATIVE_INT, 0); }},
        {"/comparisons/springs", "attribute reference is 'fem_p2'", remove("/solutions/fem_p2")},
        {"/comparisons/springs", "are no band",
         [&](hid_t file) { set_attribute(file, "/comparisons/springs", "band_margin", H5T_NATIVE_DOUBLE, nan); }},
        {"/load_case/release", "attribute num_steps is 0",
         [](hid_t file) { set_attribute(file, "/load_case/release", "num_steps", H5T_NATIVE_INT, 0); }},
        {"/load_case/release", "have to be positive",
         [&](hid_t file) { set_attribute(file, "/load_case/release", "output_interval", H5T_NATIVE_DOUBLE, nan); }},
        {"/load_case/release/probe", "row 1 holds 12",
         [&](hid_t file) { poke(file, "/load_case/release/probe", H5T_NATIVE_INT, 1, num_nodes); }},
        {"/solutions/fem_p2/history", "is there", remove("/load_case/release")},
        {"/solutions/fem_p2/history/time", "has shape (5) instead of (4)",
         [](hid_t file) { set_attribute(file, "/load_case/release", "num_steps", H5T_NATIVE_INT, 3); }},
        {"/solutions/fem_p2/history/displacement", "has shape (2,1,3) instead of (5,3,3)",
         [&](hid_t file) {
             replace(file, "/solutions/fem_p2/history/displacement", H5T_IEEE_F64LE, {2, 1, 3}, row_of_zeros,
                     H5T_NATIVE_DOUBLE);
         }},
        {"/solutions/fem_p2/history/displacement", "has rank 2 instead of 3",
         [&](hid_t file) {
             replace(file, "/solutions/fem_p2/history/displacement", H5T_IEEE_F64LE, {2, 3}, row_of_zeros,
                     H5T_NATIVE_DOUBLE);
         }},
        {"/modes/fem_p2/shape", "is missing", remove("/modes/fem_p2/shape")},
        {"/solutions/springs/edges", "row 0 holds 12",
         [&](hid_t file) { poke(file, "/solutions/springs/edges", H5T_NATIVE_INT, 1, num_nodes); }},
    };
    for (const Fault &fault : faults) {
        SCOPED_TRACE(std::string(fault.place) + " " + fault.says);
        write_result(path_, written);
        tamper(path_, fault.make);
        const std::string message = refusal(path_);
        EXPECT_NE(message.find(std::string(": ") + fault.place + " "), std::string::npos) << message;
        EXPECT_NE(message.find(fault.says), std::string::npos) << message;
    }
}

} // namespace
} // namespace livermark::results
