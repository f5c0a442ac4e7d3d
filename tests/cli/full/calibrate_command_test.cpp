#include <algorithm>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>

#include "meshes/io/msh_writer.hpp"
#include "results/hdf5/files/calibration_file.hpp"
#include "results/hdf5/result_file.hpp"
#include "tests/fem_reference/fem_test_bodies.hpp"
#include "tests/livermark_command.hpp"

namespace livermark {
namespace {

using tests::livermark;

/// A box of soft tissue as a user would have it, in a folder of its own.
class CalibrateCommand : public testing::Test {
  protected:
    void SetUp() override {
        folder_ = std::filesystem::path(testing::TempDir()) / "livermark_calibrate" /
                  testing::UnitTest::GetInstance()->current_test_info()->name();
        std::filesystem::remove_all(folder_);
        std::filesystem::create_directories(folder_);
        meshes::write_msh(folder_ / "box.msh", tests::shaken_box_mesh({0.12, 0.08, 0.06}, {6, 4, 3}));
        std::ofstream(folder_ / "box.toml") << "title = \"Box\"\nmesh = \"box.msh\"\n[regions.solid]\ndensity = 1060\n"
                                               "young_modulus = 5000\npoisson_ratio = 0.45\nsource = \"made up\"\n";
        std::ofstream(folder_ / "pull.toml")
            << "title = \"Pull\"\ntarget_peak_displacement = 0.001\n[[condition]]\npatch = \"x_min\"\n"
               "displacement = [0.0, 0.0, 0.0]\n[[condition]]\npatch = \"x_max\"\ntraction = [10.0, 0.0, 0.0]\n";
    }

    std::string in_folder(const std::string &name) const { return (folder_ / name).string(); }

    tests::Outcome calibrate(const std::string &arguments) const {
        return livermark("calibrate " + in_folder("box.toml") + " --constrained x_min " + arguments);
    }

    tests::Outcome run(const std::string &arguments) const {
        return livermark("run --body " + in_folder("box.toml") + " --load-case " + in_folder("pull.toml") +
                         " --reference-on-mesh --output " + in_folder("runs") + " " + arguments);
    }

    std::filesystem::path folder_;
};

TEST_F(CalibrateCommand, MakesSpringsThatARunTakes) {
    const auto outcome = calibrate("--loads 4 --iterations 20");
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    EXPECT_NE(outcome.output.find("held out"), std::string::npos) << outcome.output;
    const auto calibration = results::read_calibration(folder_ / "box.calibrated.h5");
    const auto ran =
        run("--model patch_nodal_volume calibrated_nodal_volume --calibration " + in_folder("box.calibrated.h5"));
    ASSERT_EQ(ran.status, 0) << ran.output;
    const auto result = results::read_result(folder_ / "runs" / "box" / "pull.h5");
    const auto found = std::ranges::find(result.models, "calibrated_nodal_volume", &results::ModelResult::name);
    ASSERT_NE(found, result.models.end());
    ASSERT_TRUE(found->solution.springs);
    EXPECT_EQ(found->solution.springs->stiffness, calibration.springs.stiffness);
}

TEST_F(CalibrateCommand, RefusesWhatDoesNotBelongTogether) {
    ASSERT_EQ(calibrate("--loads 4 --iterations 20").status, 0);
    const auto with_file = " --calibration " + in_folder("box.calibrated.h5");
    const auto expect_refused = [](const tests::Outcome &outcome, const std::string &message) {
        EXPECT_EQ(outcome.status, 2) << outcome.output;
        EXPECT_NE(outcome.output.find(message), std::string::npos) << outcome.output;
        EXPECT_EQ(std::ranges::count(outcome.output, '\n'), 1) << "more than one sentence: " << outcome.output;
    };
    expect_refused(calibrate("--loads 8"), "--restart");
    expect_refused(calibrate("--loads 4 --seed 2"), "--restart");
    expect_refused(calibrate("--loads 4 --law lloyd"), "--restart");
    expect_refused(calibrate("--loads 4 --poisson 0.3"), "not for 5000 Pa and 0.3");
    expect_refused(run("--poisson 0.3" + with_file), "not for 5000 Pa and 0.3");
    expect_refused(run("--calibration " + in_folder("nothing.h5")), "make it with `livermark calibrate`");
    expect_refused(run("--model calibrated_nodal_volume"), "--calibration");
    meshes::write_msh(folder_ / "box.msh", tests::shaken_box_mesh({0.12, 0.08, 0.06}, {5, 4, 3}));
    expect_refused(run(with_file), "another mesh than that of box");
    expect_refused(calibrate("--loads 4"), "another mesh than that of box");
    EXPECT_FALSE(std::filesystem::exists(folder_ / "runs" / "box" / "pull.h5"));
}

TEST_F(CalibrateCommand, RefusesAPatchThatIsNotThere) {
    const auto outcome = livermark("calibrate " + in_folder("box.toml"));
    EXPECT_EQ(outcome.status, 2) << outcome.output;
    EXPECT_NE(outcome.output.find("no patch 'posterior'"), std::string::npos) << outcome.output;
    EXPECT_FALSE(std::filesystem::exists(folder_ / "box.calibrated.h5"));
}

} // namespace
} // namespace livermark
