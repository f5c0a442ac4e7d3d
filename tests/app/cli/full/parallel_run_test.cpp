#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <string_view>

#include "meshes/io/mesh_files.hpp"
#include "results/hdf5/result_file.hpp"
#include "tests/fem_reference/fem_test_bodies.hpp"
#include "tests/livermark_command.hpp"

namespace livermark {
namespace {

const results::ModelResult &model_of(const results::Result &result, std::string_view name) {
    const auto found = std::ranges::find(result.models, name, &results::ModelResult::name);
    if (found == result.models.end())
        throw std::out_of_range("the result has no such model");
    return *found;
}

constexpr const char *on_two_ranks = LIVERMARK_MPIRUN " 2 " LIVERMARK_BINARY " ";

} // namespace

/// A whole run on two ranks: the finite elements of both, springs of the first, and one file with the same table.
TEST(ParallelRun, GivesTheDisplacementsReactionsAndErrorsOfASerialRun) {
    const auto folder = std::filesystem::path(testing::TempDir()) / "livermark_parallel_run";
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
    meshes::write_msh(folder / "box.msh", tests::shaken_box_mesh({0.1, 0.08, 0.06}, {4, 3, 3}));
    std::ofstream(folder / "box.toml") << "title = \"box\"\nmesh = \"box.msh\"\n[regions.solid]\ndensity = 1060.0\n"
                                          "young_modulus = 5000.0\npoisson_ratio = 0.45\nsource = \"test\"\n";
    std::ofstream(folder / "hang.toml")
        << "title = \"hang\"\ntarget_peak_displacement = 0.001\nscale_to_target = true\n"
           "acceleration = [0.0, 0.1, -0.2]\n"
           "[[condition]]\npatch = \"x_min\"\ndisplacement = [0.0, 0.0, 0.0]\n"
           "[[condition]]\npatch = \"x_max\"\ntraction = [5.0, 0.0, 1.0]\n";
    const auto arguments = [&](const char *runs) {
        return "run --body " + (folder / "box.toml").string() + " --load-case " + (folder / "hang.toml").string() +
               " --model lloyd fem_p1 fem_p2 --output " + (folder / runs).string();
    };
    const auto serial_run = tests::livermark(arguments("serial"));
    ASSERT_EQ(serial_run.status, 0) << serial_run.output;
    const auto parallel_run = tests::run_command(on_two_ranks + arguments("parallel"));
    ASSERT_EQ(parallel_run.status, 0) << parallel_run.output;
    EXPECT_EQ(tests::count(parallel_run.output, "Result files are in"), 1u) << parallel_run.output;

    const auto serial = results::read_result(folder / "serial" / "box" / "hang.h5");
    const auto parallel = results::read_result(folder / "parallel" / "box" / "hang.h5");
    EXPECT_NE(serial.problem.load_case.load_scale, 1.0);
    EXPECT_NEAR(parallel.problem.load_case.load_scale, serial.problem.load_case.load_scale, 1e-8);
    for (const auto *name : {"fem_p1", "fem_p2", "lloyd"}) {
        const auto &expected = model_of(serial, name);
        const auto &found = model_of(parallel, name);
        EXPECT_LT(tests::relative_difference(found.solution.displacement, expected.solution.displacement), 1e-8)
            << name;
        EXPECT_LT(tests::relative_difference(found.solution.reaction, expected.solution.reaction), 1e-8) << name;
        EXPECT_EQ(found.solution.solver.starts_with("CG + ML on 2 ranks, "), found.name.starts_with("fem_"))
            << found.solution.solver;
        ASSERT_TRUE(found.comparison && expected.comparison) << name;
        EXPECT_NEAR(found.comparison->relative_l2, expected.comparison->relative_l2, 1e-5) << name;
    }
    ASSERT_TRUE(parallel.reference_uncertainty.has_value());
    EXPECT_EQ(parallel.reference_uncertainty->reference, serial.reference_uncertainty->reference);
    EXPECT_NEAR(parallel.reference_uncertainty->relative_l2, serial.reference_uncertainty->relative_l2, 1e-5);
}

TEST(ParallelRun, RefusesBadInputOnceWithStatusTwo) {
    for (const auto &[arguments, message] : std::array<std::array<std::string, 2>, 4>{{
             {"run --body liver_healty", "did you mean 'liver_healthy'?"},
             {"run --fem-solver direct", "works on one rank only"},
             {"run --young soft", "--young"},
             {"rnu", "did you mean 'run'?"},
         }}) {
        const auto outcome = tests::run_command(on_two_ranks + arguments);
        EXPECT_EQ(outcome.status, 2) << outcome.output;
        EXPECT_EQ(tests::count(outcome.output, message), 1u) << outcome.output;
    }
}

TEST(ParallelRun, SpeaksWithOneVoice) {
    const auto outcome = tests::run_command(std::string(on_two_ranks) + "list bodies");
    EXPECT_EQ(outcome.status, 0) << outcome.output;
    EXPECT_EQ(tests::count(outcome.output, "liver_healthy"), 1u) << outcome.output;
}

} // namespace livermark
