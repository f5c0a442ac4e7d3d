#include "studies/modes/modes.hpp"

#include <cmath>
#include <fstream>

#include "results/hdf5/result_file.hpp"
#include "tests/bad_input.hpp"
#include "tests/samples/small_bar.hpp"

namespace livermark::studies {
namespace {

class ModesStudy : public testing::Test {
  protected:
    void SetUp() override {
        const auto folder = tests::folder_with_bar("modes_study");
        std::ofstream(folder / "hang.toml")
            << "title = \"hang\"\ntarget_peak_displacement = 0.001\nacceleration = [0.0, 0.0, -0.1]\n"
               "[[condition]]\npatch = \"x_min\"\ndisplacement = [0.0, 0.0, 0.0]\n";
        options.bodies = {(folder / "bar.toml").string()};
        options.load_case = (folder / "hang.toml").string();
        options.output = (folder / "runs").string();
        options.count = 3;
    }
    ModesOptions options;
};

TEST_F(ModesStudy, FindsAsManyModesOfEachModelAsAskedForTheLowestFirst) {
    const auto found = find_modes(options, "test", {});
    ASSERT_EQ(found.of_body.size(), 1u);
    const auto &result = found.of_body[0];
    ASSERT_EQ(result.modes.size(), 3u);
    for (std::size_t m = 0; m < 3; ++m) {
        EXPECT_EQ(result.modes[m].name, options.models[m]);
        const auto &frequency = result.modes[m].modes.angular_frequency;
        ASSERT_EQ(frequency.size(), 3u);
        EXPECT_GT(frequency[0], 0.0);
        EXPECT_LE(frequency[0], frequency[1]);
        EXPECT_LE(frequency[1], frequency[2]);
    }
    // Linear elements are too stiff, so that they vibrate faster than quadratic ones.
    EXPECT_GT(result.modes[0].modes.angular_frequency[0], result.modes[1].modes.angular_frequency[0]);
    const auto file = std::filesystem::path(options.output) / "bar" / "modes.hang.h5";
    EXPECT_EQ(results::read_result(file).modes.at(2).modes.angular_frequency, result.modes[2].modes.angular_frequency);
}

TEST_F(ModesStudy, FrequenciesGoWithTheRootOfYoungsModulus) {
    const auto soft = find_modes(options, "test", {});
    options.material.young_modulus = 4.0 * 5000.0;
    const auto stiff = find_modes(options, "test", {});
    for (std::size_t m = 0; m < 3; ++m)
        for (std::size_t k = 0; k < 3; ++k)
            EXPECT_NEAR(stiff.of_body[0].modes[m].modes.angular_frequency[k] /
                            soft.of_body[0].modes[m].modes.angular_frequency[k],
                        2.0, 1e-6);
}

TEST_F(ModesStudy, RefusesModelsWithoutModesAndTwins) {
    options.models = {"fem_p2p1"};
    tests::expect_input_error([&] { find_modes(options, "test", {}); }, {"no model with modes 'fem_p2p1'"});
    options.models = {"lloyd", "lloyd"};
    tests::expect_input_error([&] { find_modes(options, "test", {}); }, {"asked for twice"});
}

} // namespace
} // namespace livermark::studies
