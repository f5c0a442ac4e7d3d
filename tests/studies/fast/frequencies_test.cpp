#include <cmath>
#include <fstream>
#include <numeric>

#include "results/hdf5/result_file.hpp"
#include "studies/frequencies/frequencies.hpp"
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
    ASSERT_EQ(found.records.size(), 1u);
    const auto &result = found.records[0];
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
            EXPECT_NEAR(stiff.records[0].modes[m].modes.angular_frequency[k] /
                            soft.records[0].modes[m].modes.angular_frequency[k],
                        2.0, 1e-6);
}

TEST_F(ModesStudy, RefusesModelsWithoutModesAndTwins) {
    options.models = {"fem_p2p1"};
    tests::expect_input_error([&] { find_modes(options, "test", {}); }, {"no model with modes 'fem_p2p1'"});
    options.models = {"lloyd", "lloyd"};
    tests::expect_input_error([&] { find_modes(options, "test", {}); }, {"asked for twice"});
}

/// A bar that is held at one end, with a lump of a hundred times its stiffness in the middle where it has one.
StabilityOptions options_of_bar_with_lump(const std::string &suite, bool has_lump) {
    const auto folder = tests::folder_with_bar(suite, 0.012);
    auto mesh = meshes::generate_box({0.09, 0.03, 0.03}, 0.012);
    if (has_lump) {
        mesh.region_names.emplace_back("lump");
        for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
            core::Vector3 centre = core::Vector3::Zero();
            for (const int node : mesh.tetrahedra[t])
                centre += mesh.points[node] / 4.0;
            mesh.region[t] = std::abs(centre.x() - 0.045) < 0.02 ? 1 : 0;
        }
        meshes::write_msh(folder / "bar.msh", mesh);
        std::ofstream(folder / "bar.toml", std::ios::app) << "[regions.lump]\ndensity = 1000.0\nyoung_modulus = "
                                                             "500000.0\npoisson_ratio = 0.3\nsource = \"made up\"\n";
    }
    tests::write_pull(folder, "hold");
    StabilityOptions options;
    options.bodies = {(folder / "bar.toml").string()};
    options.load_case = (folder / "hold.toml").string();
    return options;
}

TEST(ScaledSteps, AreThoseOfTheSoftTissueAndHardlyChangeTheLowestFrequencies) {
    const auto found = find_scaled_steps(options_of_bar_with_lump("scaled_steps", true), {});
    ASSERT_GE(found.size(), 4U);
    for (const auto &steps : found) {
        EXPECT_LT(steps.critical_time_step, 0.25 * steps.critical_time_step_of_rest) << steps.model;
        EXPECT_GT(steps.scaled_critical_time_step, 0.7 * steps.critical_time_step_of_rest) << steps.model;
        EXPECT_GT(steps.largest_factor, 16.0) << steps.model;
        EXPECT_GT(steps.nodes_of_rate[2] + steps.nodes_of_rate[3], 0U) << steps.model;
        EXPECT_GT(steps.tetrahedra_with_a_ring, steps.tetrahedra_at_stiff_nodes) << steps.model;
        EXPECT_GT(steps.first_change, 0.0) << steps.model;
        EXPECT_LT(steps.first_change, 1e-3) << steps.model;
        EXPECT_GE(steps.largest_change, steps.first_change) << steps.model;
        EXPECT_GT(steps.seconds_per_step, 0.0) << steps.model;
    }
}

TEST(ScaledSteps, AreThePlainOnesWhereNothingIsStiff) {
    const auto found = find_scaled_steps(options_of_bar_with_lump("plain_steps", false), {});
    ASSERT_GE(found.size(), 4U);
    for (const auto &steps : found) {
        EXPECT_EQ(steps.scaled_critical_time_step, steps.critical_time_step) << steps.model;
        EXPECT_EQ(steps.num_scaled_nodes, 0U) << steps.model;
        EXPECT_EQ(steps.largest_change, 0.0) << steps.model;
        EXPECT_EQ(steps.nodes_of_rate[0], std::accumulate(steps.nodes_of_rate.begin(), steps.nodes_of_rate.end(), 0UL))
            << steps.model;
    }
}

} // namespace
} // namespace livermark::studies
