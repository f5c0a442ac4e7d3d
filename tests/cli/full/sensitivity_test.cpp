#include <algorithm>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>

#include "results/hdf5/files/sensitivity_file.hpp"
#include "tests/livermark_command.hpp"
#include "tests/samples/small_bar.hpp"

namespace livermark {
namespace {

using tests::livermark;

/// A bar that is held at one end and pressed by a round tool on a side.
class SensitivityCommand : public testing::Test {
  protected:
    void SetUp() override {
        folder_ = tests::folder_with_bar("sensitivity", 0.012);
        std::ofstream(folder_ / "press.toml")
            << "title = \"Press\"\n[[condition]]\npatch = \"x_min\"\ndisplacement = [0.0, 0.0, 0.0]\n[[condition]]\n"
               "disc = { patch = \"z_max\", radius = 0.012, profile = \"round\" }\npressure = 20.0\n";
    }

    std::string in_folder(const std::string &name) const { return (folder_ / name).string(); }

    tests::Outcome sensitivity(const std::string &arguments, const std::string &environment = "") const {
        return tests::run_command(environment + " " LIVERMARK_BINARY " sensitivity " + in_folder("bar.toml") +
                                  " --load-case " + in_folder("press.toml") + " --reference-on-mesh --output " +
                                  in_folder("runs") + " " + arguments);
    }

    static bool has_openturns() { return tests::run_command("/usr/bin/python3 -c 'import openturns'").status == 0; }

    std::filesystem::path folder_;
};

TEST_F(SensitivityCommand, SaysWhatAnAnswerIsWorth) {
    if (!has_openturns())
        GTEST_SKIP() << "OpenTURNS is missing; apt-get install python3-openturns";
    const auto outcome = sensitivity("--samples 48 --compare nodal_neo_hookean");
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    for (const auto *part :
         {"Sobol indices", "Error budget", "support_stiffness", "density is not varied",
          "tumour_contrast is not varied", "nodal_neo_hookean is off by", "if support_stiffness were known"})
        EXPECT_NE(outcome.output.find(part), std::string::npos) << part << "\n" << outcome.output;
    const auto file = results::read_sensitivity(folder_ / "runs" / "bar" / "sensitivity.press.h5");
    ASSERT_EQ(file.values.size(), 48u);
    ASSERT_EQ(file.outputs.size(), 2u); // it has no tumour
    const auto &stiffness = file.outputs[0];
    EXPECT_GT(stiffness.deviation, 0.0);
    EXPECT_LT(stiffness.unexplained, 0.3);
    // A bar that is held at one end turns on its support, and its own stiffness matters less.
    const auto index_of = [&](const char *name) {
        return std::ranges::find(file.parameters, name, &results::UncertainParameter::name) - file.parameters.begin();
    };
    EXPECT_GT(stiffness.first_lower[index_of("young_modulus")], 0.0);
    EXPECT_GT(stiffness.first[index_of("support_stiffness")], stiffness.total[index_of("young_modulus")]);
    for (std::size_t p = 0; p < file.parameters.size(); ++p) {
        EXPECT_GE(stiffness.total[p], stiffness.first[p] - 1e-12);
        EXPECT_LE(stiffness.first_lower[p], stiffness.first_upper[p]);
    }
    EXPECT_GT(std::abs(file.budget.models[0].error[0]), 0.0);
    EXPECT_EQ(file.budget.reference, "fem_p2p1");
}

TEST_F(SensitivityCommand, GoesOnWithTheSamplesOfItsFile) {
    if (!has_openturns())
        GTEST_SKIP() << "OpenTURNS is missing; apt-get install python3-openturns";
    ASSERT_EQ(sensitivity("--samples 16 --model fem_p1 --compare fem_p1").status, 0);
    const auto path = folder_ / "runs" / "bar" / "sensitivity.press.h5";
    const auto few = results::read_sensitivity(path);
    const auto more = sensitivity("--samples 20 --model fem_p1 --compare fem_p1");
    ASSERT_EQ(more.status, 0) << more.output;
    EXPECT_NE(more.output.find("sample 16 of 20, kept"), std::string::npos) << more.output;
    EXPECT_EQ(more.output.find("sample 17 of 20, kept"), std::string::npos) << more.output;
    const auto many = results::read_sensitivity(path);
    ASSERT_EQ(many.values.size(), 20u);
    EXPECT_TRUE(std::equal(few.values.begin(), few.values.end(), many.values.begin()));
    const auto other = sensitivity("--samples 20 --model fem_p2 --compare fem_p1");
    EXPECT_EQ(other.output.find("kept"), std::string::npos) << "of another model: " << other.output;
}

TEST_F(SensitivityCommand, RefusesInOneSentence) {
    const auto expect_refused = [](const tests::Outcome &outcome, const std::string &part) {
        EXPECT_EQ(outcome.status, 2) << outcome.output;
        EXPECT_NE(outcome.output.find(part), std::string::npos) << outcome.output;
        EXPECT_EQ(outcome.output.find("Traceback"), std::string::npos) << outcome.output;
    };
    expect_refused(sensitivity("--samples 5"), "need at least");
    expect_refused(sensitivity("--model fem_p9"), "fem_p9");
    expect_refused(livermark("sensitivity " + in_folder("bar.toml")), "palpation");
    // A module in place of OpenTURNS that is not there.
    std::filesystem::create_directories(folder_ / "modules");
    std::ofstream(folder_ / "modules" / "openturns.py")
        << "raise ModuleNotFoundError(\"No module named 'openturns'\")\n";
    expect_refused(sensitivity("--samples 20", "PYTHONPATH=" + in_folder("modules")),
                   "apt-get install python3-openturns");
}

} // namespace
} // namespace livermark
