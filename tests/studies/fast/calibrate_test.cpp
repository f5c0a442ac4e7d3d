#include "studies/calibration/calibrate.hpp"

#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <numeric>

#include "meshes/io/msh_writer.hpp"
#include "tests/bad_input.hpp"
#include "tests/fem_reference/fem_test_bodies.hpp"

namespace livermark::studies {
namespace {

/// A box of soft tissue as a user would have it, in a folder of its own.
class Calibrate : public testing::Test {
  protected:
    void SetUp() override {
        folder_ = std::filesystem::path(testing::TempDir()) / "livermark_calibrate_study" /
                  testing::UnitTest::GetInstance()->current_test_info()->name();
        std::filesystem::remove_all(folder_);
        std::filesystem::create_directories(folder_);
        meshes::write_msh(folder_ / "box.msh", tests::shaken_box_mesh({0.12, 0.08, 0.06}, {6, 4, 3}));
        std::ofstream(folder_ / "box.toml") << "title = \"Box\"\nmesh = \"box.msh\"\n[regions.solid]\ndensity = 1060\n"
                                               "young_modulus = 5000\npoisson_ratio = 0.45\nsource = \"made up\"\n";
        options_.body = (folder_ / "box.toml").string();
        options_.constrained = "x_min";
    }

    CalibrationResult after(int num_iterations, const std::string &output = {}) {
        options_.num_iterations = num_iterations;
        options_.output = output.empty() ? output : (folder_ / output).string();
        return calibrate(options_, "test", {});
    }

    std::filesystem::path folder_;
    CalibrateOptions options_;
};

double mean_error(const std::vector<double> &errors, const std::vector<std::uint8_t> &held_out, bool of_held_out) {
    double sum = 0.0;
    int count = 0;
    for (std::size_t l = 0; l < errors.size(); ++l)
        if ((held_out[l] != 0) == of_held_out) {
            sum += errors[l];
            ++count;
        }
    return sum / count;
}

TEST_F(Calibrate, LowersTheErrorUnderLoadsThatHadNoPartInIt) {
    const auto [calibration, file] = after(40);
    EXPECT_EQ(file, folder_ / "box.calibrated.h5");
    EXPECT_EQ(calibration.iterations, 40);
    EXPECT_EQ(calibration.body, "box");
    ASSERT_EQ(calibration.held_out.size(), 24u);
    EXPECT_EQ(std::accumulate(calibration.held_out.begin(), calibration.held_out.end(), 0), 6);
    for (const bool held_out : {false, true}) {
        const double before = mean_error(calibration.error_before, calibration.held_out, held_out);
        const double after = mean_error(calibration.error_after, calibration.held_out, held_out);
        EXPECT_GT(before, 0.01) << held_out;
        EXPECT_LT(after, before) << held_out;
    }
    EXPECT_EQ(results::read_calibration(file).springs.stiffness, calibration.springs.stiffness);
}

TEST_F(Calibrate, GoesOnAsIfItHadNeverStopped) {
    options_.num_loads = 4;
    const auto whole = after(40, "whole.h5").calibration;
    const auto part = after(20, "parts.h5").calibration;
    const auto parts = after(40, "parts.h5").calibration;
    EXPECT_NE(part.springs.stiffness, whole.springs.stiffness);
    EXPECT_EQ(parts.iterations, 40);
    EXPECT_EQ(parts.springs.stiffness, whole.springs.stiffness);
    EXPECT_EQ(parts.error_before, whole.error_before);
    EXPECT_EQ(parts.error_after, whole.error_after);

    options_.restart = true;
    EXPECT_EQ(after(20, "parts.h5").calibration.springs.stiffness, part.springs.stiffness);
}

TEST_F(Calibrate, DoesNotGoOnWithAnotherCalibration) {
    options_.num_loads = 4;
    after(20);
    options_.penalty *= 2.0;
    tests::expect_input_error([&] { after(40); }, {"box.calibrated.h5", "--restart"});
}

} // namespace
} // namespace livermark::studies
