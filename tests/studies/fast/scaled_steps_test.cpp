#include "studies/stability/stability.hpp"

#include <cmath>
#include <fstream>
#include <numeric>

#include "tests/samples/small_bar.hpp"

namespace livermark::studies {
namespace {

/// A bar that is held at one end, with a lump of a hundred times its stiffness in the middle where it has one.
StabilityOptions of_bar_with_lump(const std::string &suite, bool has_lump) {
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
    std::ofstream(folder / "hold.toml")
        << "title = \"hold\"\ntarget_peak_displacement = 0.001\n[[condition]]\npatch = \"x_min\"\n"
           "displacement = [0.0, 0.0, 0.0]\n[[condition]]\npatch = \"x_max\"\ntraction = [10.0, 0.0, 0.0]\n";
    StabilityOptions options;
    options.bodies = {(folder / "bar.toml").string()};
    options.load_case = (folder / "hold.toml").string();
    return options;
}

TEST(ScaledSteps, AreThoseOfTheSoftTissueAndHardlyChangeTheLowestFrequencies) {
    const auto found = find_scaled_steps(of_bar_with_lump("scaled_steps", true), {});
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
    const auto found = find_scaled_steps(of_bar_with_lump("plain_steps", false), {});
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
