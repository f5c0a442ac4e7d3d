#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>
#include <ranges>

#include "load_cases/readers/load_case_reader.hpp"
#include "meshes/io/mesh_files.hpp"
#include "results/hdf5/result_file.hpp"
#include "tests/livermark_command.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

constexpr double target_peak = 0.0015; // m

/// A box as files, with a load case that is driven in every way: the command scales it and multiplies it.
class ScaledRun : public testing::Test {
  protected:
    void SetUp() override {
        const auto *test = testing::UnitTest::GetInstance()->current_test_info();
        folder_ = std::filesystem::path(testing::TempDir()) / "livermark_load_scaling" / test->name();
        std::filesystem::remove_all(folder_);
        std::filesystem::create_directories(folder_);
        meshes::write_msh(folder_ / "box.msh", mesh_);
        std::ofstream(folder_ / "box.toml") << "title = \"box\"\nmesh = \"box.msh\"\n[regions.solid]\n"
                                               "density = 1060.0\nyoung_modulus = 5000.0\npoisson_ratio = 0.45\n"
                                               "source = \"test\"\n";
        std::ofstream(folder_ / "all.toml")
            << "title = \"all\"\ntarget_peak_displacement = " << target_peak << "\nscale_to_target = true\n"
            << "acceleration = [0.0, 0.1, -0.2]\n"
               "[[condition]]\npatch = \"x_min\"\ndisplacement = [0.0, 0.0, 0.0]\n"
               "[[condition]]\npatch = \"y_max\"\npressure = 20.0\n"
               "[[condition]]\npatch = \"x_max\"\ndisplacement = [\"free\", \"free\", 0.0004]\n";
    }

    tests::Outcome run(const std::string &options) const {
        return tests::livermark(
            fmt::format("run --reference-on-mesh --model fem_p1 fem_p2 lloyd --body {} --load-case {} --output {} {}",
                        (folder_ / "box.toml").string(), (folder_ / "all.toml").string(), folder_.string(), options));
    }
    results::Result result(const std::string &name) const {
        return results::read_result(folder_ / "box" / (name + ".h5"));
    }
    core::LoadCase as_written() const { return load_cases::read_load_case(folder_ / "all.toml", mesh_); }
    bool exists(const std::string &name) const { return std::filesystem::exists(folder_ / "box" / (name + ".h5")); }

    const std::filesystem::path &folder() const { return folder_; }

  private:
    core::TetraMesh mesh_ = tests::box_mesh({0.1, 0.08, 0.06}, {4, 3, 3});
    std::filesystem::path folder_;
};

const std::vector<core::Vector3> &displacement_of(const results::Result &result, const std::string &model) {
    return std::ranges::find(result.models, model, &results::ModelResult::name)->solution.displacement;
}

TEST_F(ScaledRun, BaselineReachesTheTargetAndTheFactorIsKept) {
    const auto outcome = run("--tables");
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    const auto found = result("all");
    const auto lengths = [](const core::Vector3 &u) { return u.norm(); };
    const auto &load_case = found.problem.load_case;
    // The factor has six digits, so the peak is as much off as the seventh may be.
    EXPECT_EQ(fmt::format("{}", std::stod(fmt::format("{:.5e}", load_case.load_scale))),
              fmt::format("{}", load_case.load_scale));
    EXPECT_NEAR(std::ranges::max(displacement_of(found, "fem_p1") | std::views::transform(lengths)), target_peak,
                5e-6 * target_peak);
    EXPECT_GT(std::abs(load_case.load_scale - 1.0), 0.1);
    EXPECT_NE(outcome.output.find(fmt::format("box all {:.4g}", load_case.load_scale)), std::string::npos)
        << outcome.output;
    const auto expected = core::scaled(as_written(), load_case.load_scale);
    EXPECT_EQ(load_case.acceleration, expected.acceleration);
    for (std::size_t f = 0; f < expected.value.size(); ++f)
        for (int c = 0; c < 3; ++c)
            if (!std::isnan(expected.value[f][c])) {
                EXPECT_EQ(load_case.value[f][c], expected.value[f][c]);
            }
}

TEST_F(ScaledRun, AmplitudesMultiplyTheScaledLoad) {
    const auto outcome = run("--amplitude 2,0.5");
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    EXPECT_FALSE(exists("all"));
    const auto small = result("all@0.5"), large = result("all@2");
    EXPECT_NEAR(large.problem.load_case.load_scale, 4.0 * small.problem.load_case.load_scale, 1e-12);
    const auto &u = displacement_of(small, "fem_p2"), &u_large = displacement_of(large, "fem_p2");
    for (std::size_t i = 0; i < u.size(); ++i)
        EXPECT_LT((u_large[i] - 4.0 * u[i]).norm(), 1e-10 * target_peak);
    // The springs leave their linearised solution in proportion to the load, at first.
    const auto nonlinearity = [](const results::Result &result) {
        return std::ranges::find(result.models, "lloyd", &results::ModelResult::name)->solution.nonlinearity;
    };
    EXPECT_NEAR(nonlinearity(large) / nonlinearity(small), 4.0, 0.5);
    EXPECT_NE(outcome.output.find("below 5 % up to"), std::string::npos) << outcome.output;
    EXPECT_LT(outcome.output.find("x 0.5 [%]"), outcome.output.find("x 2 [%]")) << outcome.output;
}

TEST_F(ScaledRun, LoadCasesThatDoNotFitABodyAreLeftOutUnlessBothWereNamed) {
    const auto root = folder() / "root";
    for (const auto *name : {"meshes", "load_cases"})
        std::filesystem::create_directories(root / name);
    for (const auto *name : {"box.toml", "box.msh"})
        std::filesystem::copy_file(folder() / name, root / "meshes" / name);
    std::filesystem::copy_file(folder() / "all.toml", root / "load_cases" / "all.toml");
    std::ofstream(root / "load_cases" / "nowhere.toml") << "title = \"none\"\ntarget_peak_displacement = 0.001\n"
                                                           "[[condition]]\npatch = \"antenna\"\npush = 0.001\n";
    const std::string fault = "nowhere.toml:4: the body has no patch 'antenna'";
    ASSERT_EQ(setenv("LIVERMARK_ROOT", root.c_str(), 1), 0);
    const auto in_root = [&](const std::string &names) {
        return tests::livermark(
            fmt::format("run --reference-on-mesh --model lloyd --output {} {}", folder().string(), names));
    };
    const auto all = in_root(""), body = in_root("--body box"), both = in_root("--body box --load-case nowhere"),
               load_case = in_root("--load-case nowhere");
    unsetenv("LIVERMARK_ROOT");
    for (const auto &outcome : {all, body}) {
        EXPECT_EQ(outcome.status, 0) << outcome.output;
        EXPECT_NE(outcome.output.find("livermark: left out on box: nowhere, because the body has no patch 'antenna'\n"),
                  std::string::npos)
            << outcome.output;
    }
    EXPECT_TRUE(exists("all"));
    for (const auto &outcome : {both, load_case}) { // the latter fits no body
        EXPECT_EQ(outcome.status, 2) << outcome.output;
        EXPECT_NE(outcome.output.find(fault), std::string::npos) << outcome.output;
        EXPECT_EQ(std::ranges::count(outcome.output, '\n'), 1) << outcome.output;
    }
}

TEST_F(ScaledRun, AmplitudesThatAreNotPositiveAreRefused) {
    for (const auto *amplitude : {"0", "-1", "1,-1", "much"}) {
        const auto outcome = run(fmt::format("--amplitude {}", amplitude));
        EXPECT_EQ(outcome.status, 2) << outcome.output;
        EXPECT_NE(outcome.output.find("--amplitude"), std::string::npos) << outcome.output;
    }
}

} // namespace
} // namespace livermark
