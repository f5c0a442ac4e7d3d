#include "results/hdf5/result_file.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <ctime>
#include <fcntl.h>
#include <fmt/chrono.h>
#include <fstream>
#include <functional>
#include <gtest/gtest.h>
#include <limits>
#include <memory>
#include <regex>
#include <sys/file.h>
#include <sys/resource.h>
#include <unistd.h>

#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "results/hdf5/references.hpp"
#include "tests/bad_input.hpp"
#include "tests/result_folder.hpp"
#include "tests/results/file_content.hpp"
#include "tests/samples/bodies_with_vessels.hpp"
#include "tests/samples/covered_bodies.hpp"
#include "tests/samples/records/sample_result.hpp"

namespace livermark::results {
namespace {

namespace fs = std::filesystem;

/// A result file, and one that is made of what was read from it.
class ResultFile : public tests::ResultFolder {
  protected:
    void expect_back(const Result &written) const {
        write_result(path_, written);
        const auto read = read_result(path_);
        EXPECT_EQ(read.provenance, written.provenance);
        EXPECT_EQ(read.models.size(), written.models.size());
        EXPECT_EQ(problem_key(read.problem), problem_key(written.problem));
        write_result(again_, read);
        tests::expect_same_content(again_, path_);
    }

    const fs::path again_ = fs::path(testing::TempDir()) / fmt::format("livermark_again_{}.h5", getpid());
};

TEST_F(ResultFile, GivesBackWhatWasWritten) {
    const auto sample = tests::sample_result(), still = tests::without_motion(sample);
    expect_back(sample);
    expect_back(still);
    expect_back(tests::sample_result(1000)); // in chunks
    const auto changed = [&](Result result, void (*change)(Result &)) {
        change(result);
        expect_back(result);
    };
    // Springs that models share.
    changed(sample, [](Result &result) { result.models.push_back(tests::stiffer(result.models[1])); });
    changed(sample, [](Result &result) {
        result.problem.load_case.definition.assign(300'000, 'x'); // an attribute of old formats ends at 64 KiB
        result.models[1].summary = "";
        result.models[1].source = "Müller, \u00b5m";
    });
    // Neither constraints nor models.
    changed(sample, [](Result &result) {
        result.models.clear();
        result.reference_uncertainty.reset();
        result.motion_uncertainty.reset();
        result.problem.load_case.touching.reset();
        result.problem.load_case.conditions.clear();
        std::ranges::fill(result.problem.load_case.condition_on, -1);
    });
    changed(still, [](Result &result) {
        result.problem.load_case.press_depth = -0.003;
        result.problem.load_case.conditions[1].kind = core::ConditionKind::press;
    });
    changed(sample, [](Result &result) {
        auto &touching = result.problem.load_case.touching.value();
        touching.shape = {core::ToolFace::square, 0.3, 0.03, touching.press};
    });
    expect_back(tests::with_jaws(sample));
    EXPECT_EQ(read_result(path_).problem.load_case.touching, tests::with_jaws(sample).problem.load_case.touching);
    changed(sample, [](Result &result) { result.problem.body = tests::covered::with_capsule(result.problem.body); });
    EXPECT_EQ(read_result(path_).problem.body->capsule, tests::covered::capsule);
    changed(sample, [](Result &result) { result.problem.body = tests::vessels::with_vessels(result.problem.body); });
    EXPECT_EQ(read_result(path_).problem.body->vessels, tests::vessels::tree);
    changed(sample, [](Result &result) {
        auto body = *result.problem.body;
        for (std::size_t t = 0; t < body.mesh.tetrahedra.size(); ++t)
            body.modulus_factor.push_back(0.5 + 0.1 * static_cast<double>(t % 10));
        result.problem.body = std::make_shared<const core::Body>(std::move(body));
    });
    EXPECT_EQ(read_result(path_).problem.body->modulus_factor[3], 0.5 + 0.1 * 3.0);
    changed(sample, [](Result &result) { result.problem.load_case.foundation.value().normal_only.front() = 0; });
    // A reference that was kept has the probes and no frames; there is no error in frames then.
    changed(sample, [](Result &result) {
        result.models[0].solution.history->frames.clear();
        result.models[1].comparison->history->error.clear();
        result.models[1].comparison->history->frames_reference.clear();
    });
    changed(tests::along_a_path(sample), [](Result &result) { result.models[1].comparison->load_fraction = 0.8; });
    EXPECT_EQ(read_result(path_).models[1].comparison->load_fraction, 0.8);
}

TEST_F(ResultFile, GivesBackASolutionAlone) {
    const Result sample = tests::sample_result();
    for (const auto &model : sample.models) {
        write_solution(path_, model.solution, sample.problem.load_case);
        write_solution(again_, read_solution(path_, sample.problem), sample.problem.load_case);
        tests::expect_same_content(again_, path_);
    }
    EXPECT_THROW(read_result(path_), support::InputError); // it is no result file
}

TEST_F(ResultFile, KeepsNonFiniteDisplacementsOfADivergedSolution) {
    write_result(path_, tests::sample_result());
    const ModelResult model = read_result(path_).models[2];
    EXPECT_EQ(model.solution.status, core::SolutionStatus::diverged);
    EXPECT_TRUE(std::isnan(model.solution.displacement.front().x()));
    EXPECT_EQ(model.solution.displacement.front().y(), std::numeric_limits<double>::infinity());
    EXPECT_TRUE(std::isnan(model.comparison->relative_l2));
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
    EXPECT_THROW(write_result(directory_ / "nowhere" / "result.h5", tests::sample_result()), support::InputError);
    EXPECT_TRUE(files().empty());
}

TEST_F(ResultFile, LeavesNothingBehindWhenTheNameIsTaken) {
    fs::create_directories(path_ / "a directory");
    EXPECT_THROW(write_result(path_, tests::sample_result()), support::InputError);
    EXPECT_EQ(files(), std::vector<std::string>{"result.h5"});
    EXPECT_TRUE(fs::is_directory(path_));
}

TEST_F(ResultFile, LeavesTheEarlierFileWhenTheDiskIsFull) {
    const Result result = tests::sample_result();
    write_result(path_, result);
    const std::string before = support::read_text(path_);

    // A limit on the size of files fails in the middle of the writing, like a full disk.
    std::signal(SIGXFSZ, SIG_IGN);
    rlimit limit{};
    ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &limit), 0);
    const rlimit small{before.size() / 2, limit.rlim_max};
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
    EXPECT_THROW(write_result(path_, result), support::InputError);
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &limit), 0);

    EXPECT_EQ(support::read_text(path_), before);
    EXPECT_EQ(files(), std::vector<std::string>{"result.h5"});
}

TEST_F(ResultFile, LeavesTheEarlierFileWhenTheResultIsInconsistent) {
    Result result = tests::sample_result();
    write_result(path_, result);
    const std::string before = support::read_text(path_);
    const auto spoiled = [&](void (*spoil)(Result &)) {
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
    spoiled([](Result &r) { r.motion_uncertainty->refined = "nobody"; });
    spoiled([](Result &r) { r.models[1].solution.displacement.pop_back(); });
    spoiled([](Result &r) { r.models[1].solution.reaction.clear(); });
    spoiled([](Result &r) { r.models[1].solution.springs->stiffness.pop_back(); });
    spoiled([](Result &r) { r.models[1].comparison->error.pop_back(); });
    spoiled([](Result &r) { r.problem.load_case.value.pop_back(); });
    spoiled([](Result &r) { r.problem.load_case.release.reset(); });
    spoiled([](Result &r) { r.problem.load_case.release->num_steps = 3; });
    spoiled([](Result &r) { r.models[1].solution.history->displacement.pop_back(); });
    spoiled([](Result &r) { r.models[1].solution.history->strain_energy.pop_back(); });
    spoiled([](Result &r) { r.models[1].solution.history->frames.pop_back(); });
    spoiled([](Result &r) { r.models[1].comparison->history->error.pop_back(); });
    spoiled([](Result &r) { r.modes[0].modes.shape.pop_back(); });
    spoiled([](Result &r) { r.modes[0].name = "fem/p2"; });
    spoiled([](Result &r) { r.modes.push_back(r.modes[0]); });
    EXPECT_EQ(support::read_text(path_), before);
    EXPECT_EQ(files(), std::vector<std::string>{"result.h5"});
}

const std::string points = "/mesh/points";
const std::string tetrahedra = "/mesh/tetrahedra";

using StoredDatasets = tests::ResultFolder;

/// An answer of a dataset of a file.
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

class FileInUseElsewhere : public tests::ResultFolder {
  protected:
    void SetUp() override {
        ResultFolder::SetUp();
        write_result(path_, tests::sample_result());
        // Locks belong to what open() gives, so this one is another's.
        file_ = open(path_.c_str(), O_RDWR | O_CLOEXEC);
        ASSERT_EQ(flock(file_, LOCK_EX), 0);
    }
    void TearDown() override {
        close(file_);
        ResultFolder::TearDown();
    }
    int file_ = -1;
};

TEST_F(FileInUseElsewhere, IsNotCalledDamaged) {
    tests::expect_input_error([&] { read_result(path_); },
                              {path_.string(), "another program has the file open to write", "wait for it"});
    EXPECT_THROW(kind_of_file(path_), FileInUse);
    EXPECT_THROW(is_shown_on_page(path_), FileInUse) << "nobody can say whether it is one";
}

TEST_F(FileInUseElsewhere, IsNotMissingInItsFolder) {
    testing::internal::CaptureStderr();
    tests::expect_input_error([&] { read_results(std::array{directory_}); },
                              {"no result file here can be read", "the reasons stand above"});
    EXPECT_NE(testing::internal::GetCapturedStderr().find("another program has the file open"), std::string::npos);
}

TEST_F(FileInUseElsewhere, IsReadOnceItIsClosed) {
    flock(file_, LOCK_UN);
    EXPECT_TRUE(is_shown_on_page(path_));
    EXPECT_EQ(read_results(std::array{directory_}).size(), 1U);
}

Result with_a_larger_body() {
    auto result = tests::sample_result();
    auto body = *result.problem.body;
    for (auto &point : body.mesh.points)
        point *= 1.1;
    result.problem.body = std::make_shared<core::Body>(body);
    return result;
}

TEST(BodiesApart, OneBodyKeepsItsName) {
    std::vector results{tests::sample_result(), tests::sample_result()};
    const auto name = results[0].problem.body->name;
    EXPECT_TRUE(tell_bodies_apart(results).empty());
    for (const auto &result : results)
        EXPECT_EQ(result.problem.body->name, name);
}

TEST(BodiesApart, MeshesOfOneNameAreDifferentBodies) {
    std::vector results{tests::sample_result(), with_a_larger_body(), tests::sample_result()};
    const auto name = results[0].problem.body->name;
    const auto sentences = tell_bodies_apart(results);
    ASSERT_EQ(sentences.size(), 1U);
    EXPECT_NE(sentences[0].find("2 different bodies have the name " + name), std::string::npos) << sentences[0];
    EXPECT_EQ(results[0].problem.body->name, results[2].problem.body->name);
    EXPECT_NE(results[0].problem.body->name, results[1].problem.body->name);
    EXPECT_TRUE(results[1].problem.body->name.starts_with(name + "#"));
    EXPECT_NE(sentences[0].find(results[1].problem.body->name), std::string::npos);
}

bool matches(const std::string &text, const char *pattern) {
    return std::regex_match(text, std::regex(pattern));
}

TEST(Provenance, SaysWhatRunsAndWhere) {
    const Provenance provenance = current_provenance("livermark run --body liver");
    EXPECT_EQ(provenance.command, "livermark run --body liver");
    EXPECT_TRUE(matches(provenance.software_version, R"(\d+\.\d+\.\d+)")) << provenance.software_version;
    EXPECT_TRUE(matches(provenance.git_commit, "[0-9a-f]{40}(-dirty)?|unknown")) << provenance.git_commit;
    EXPECT_TRUE(matches(provenance.compiler, R"(\w+ \d+\..*)")) << provenance.compiler;
    EXPECT_FALSE(provenance.cpu.empty());
    EXPECT_GE(provenance.threads, 1);
#ifdef NDEBUG
    EXPECT_NE(provenance.build_type, "Debug");
#else
    EXPECT_EQ(provenance.build_type, "Debug");
#endif
}

TEST(Provenance, IsOfNowInUtc) {
    const auto text = [](std::time_t time) { return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(time)); };
    const std::string before = text(std::time(nullptr));
    const std::string created = current_provenance("").created;
    EXPECT_TRUE(matches(created, R"(\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ)")) << created;
    EXPECT_GE(created, before);
    EXPECT_LE(created, text(std::time(nullptr) + 1));
}

} // namespace
} // namespace livermark::results
