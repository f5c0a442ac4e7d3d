#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/error_norms.hpp"
#include "core/mesh/plausible_liver.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

using core::Vector3;

core::Solution constant_solution(const core::TetraMesh &mesh, const Vector3 &displacement) {
    core::Solution solution;
    solution.displacement.assign(mesh.points.size(), displacement);
    solution.reaction = {{0.0, 0.0, 2.0}, {0.0, 0.0, -1.0}};
    solution.strain_energy = 4.0;
    return solution;
}

const auto mesh = tests::box_mesh({0.1, 0.2, 0.1}, {2, 3, 2});

TEST(Comparison, OfASolutionWithItselfIsZero) {
    const auto solution = constant_solution(mesh, {0.0, 1.0, 0.0});
    const auto comparison = core::compare(mesh, {}, solution, solution, "itself");
    EXPECT_EQ(comparison.relative_l2, 0.0);
    EXPECT_EQ(comparison.max_error, 0.0);
    EXPECT_EQ(comparison.energy_error, 0.0);
    EXPECT_EQ(comparison.reaction_error, 0.0);
}

TEST(Comparison, MeasuresAUniformScaleExactly) {
    const auto reference = constant_solution(mesh, {0.0, 0.002, 0.0});
    auto solution = constant_solution(mesh, {0.0, 0.0022, 0.0});
    solution.strain_energy = 3.0;
    solution.reaction[0] = {0.0, 2.0, 2.0};
    const auto comparison = core::compare(mesh, {}, solution, reference, "reference");
    EXPECT_NEAR(comparison.relative_l2, 0.1, 1e-14);
    EXPECT_NEAR(comparison.max_error, 0.0002, 1e-17);
    EXPECT_NEAR(comparison.max_error_relative, 0.1, 1e-13);
    EXPECT_NEAR(comparison.energy_error, -0.25, 1e-15);
    EXPECT_NEAR(comparison.reaction_error, 2.0 / std::sqrt(5.0), 1e-15);
    EXPECT_EQ(comparison.reference, "reference");
}

/// Torsion has reactions without a resultant: what is left of them is rounding, and a ratio of it would mean nothing.
TEST(Comparison, HasNoReactionErrorWhereReactionsHaveNoResultant) {
    auto reference = constant_solution(mesh, {0.0, 0.002, 0.0});
    reference.reaction = {{0.0, 0.0, 1e-9}, {0.0, 0.0, 0.0}};
    auto solution = reference;
    solution.reaction[0].z() = -1e-9;
    EXPECT_TRUE(std::isnan(core::compare(mesh, {}, solution, reference, "reference").reaction_error));
    reference.reaction[0].z() = 1.0;
    EXPECT_NEAR(core::compare(mesh, {}, solution, reference, "reference").reaction_error, 1.0, 1e-8);
}

TEST(Comparison, WeighsNodesByTheirVolume) {
    const auto reference = constant_solution(mesh, {1.0, 0.0, 0.0});
    auto solution = reference;
    solution.displacement[0].x() += 1.0;
    const auto volumes = core::nodal_volumes(mesh);
    const auto comparison = core::compare(mesh, {}, solution, reference, "reference");
    EXPECT_NEAR(comparison.relative_l2, std::sqrt(volumes[0] / (0.1 * 0.2 * 0.1)), 1e-14);
}

TEST(HistoryError, IsRelativeOverAllRecordsAndProbes) {
    const core::History reference{.time = {0.0, 0.1},
                                  .displacement = {{1.0, 0.0, 0.0}, {0.0, 2.0, 0.0}, {0.0, 0.0, 0.0}, {2.0, 0.0, 0.0}},
                                  .kinetic_energy = {},
                                  .strain_energy = {}};
    auto history = reference;
    EXPECT_EQ(core::compare(history, reference, "r").relative_l2, 0.0);
    history.displacement[2] = {0.0, 0.3, -0.6};
    EXPECT_NEAR(core::compare(history, reference, "r").relative_l2, std::sqrt(0.45 / 9.0), 1e-15);
    EXPECT_NEAR(core::compare(history, reference, "r").amplitude_error, std::sqrt(9.45 / 9.0) - 1.0, 1e-15);
    history.displacement[2].x() = std::nan("");
    EXPECT_TRUE(std::isnan(core::compare(history, reference, "r").relative_l2));
    EXPECT_TRUE(std::isnan(core::compare(history, reference, "r").lag));
    history.time[1] = 0.2;
    EXPECT_THROW(core::compare(history, reference, "r"), std::invalid_argument);
}

TEST(HistoryError, IsGivenInEveryFrame) {
    core::History reference{.time = {0.0, 0.1},
                            .displacement = {{1.0, 0.0, 0.0}, {2.0, 0.0, 0.0}},
                            .kinetic_energy = {},
                            .strain_energy = {}};
    reference.frames = {{1.0F, 0.0F, 0.0F}, {0.0F, 2.0F, 0.0F}, {0.0F, 0.0F, 4.0F}};
    auto history = reference;
    history.frames[1] = {0.5F, 2.0F, -1.0F};
    const std::vector<Eigen::Vector3f> expected{{0.0F, 0.0F, 0.0F}, {0.5F, 0.0F, -1.0F}, {0.0F, 0.0F, 0.0F}};
    EXPECT_EQ(core::compare(history, reference, "r").error, expected);
    history.frames.pop_back();
    EXPECT_THROW(core::compare(history, reference, "r"), std::invalid_argument);
    history.frames.clear(); // where only the probes were kept
    EXPECT_EQ(core::compare(history, reference, "r").relative_l2, 0.0);
    EXPECT_TRUE(core::compare(history, reference, "r").error.empty());
}

/// Two probes swing with a period of 0.5 s, seen every 10 ms; the other motion is larger by a tenth and late or early.
TEST(HistoryError, TellsAmplitudeFromDelay) {
    const auto swing = [](double amplitude, double delay) {
        core::History history;
        for (int k = 0; k <= 400; ++k) {
            const double t = 0.01 * k;
            history.time.push_back(t);
            history.displacement.emplace_back(amplitude * std::cos(4.0 * std::numbers::pi * (t - delay)), 0.0, 0.0);
            history.displacement.emplace_back(0.0, amplitude * std::sin(4.0 * std::numbers::pi * (t - delay)), 1e-3);
        }
        return history;
    };
    for (const double delay : {0.0, 0.004, 0.063, -0.087}) {
        const auto found = core::compare(swing(1.1, delay), swing(1.0, 0.0), "r");
        EXPECT_NEAR(found.lag, delay, 1e-4);
        EXPECT_NEAR(found.amplitude_error, 0.1, 1e-5);
    }
}

TEST(Comparison, LetsADivergedSolutionShow) {
    const auto reference = constant_solution(mesh, {1.0, 0.0, 0.0});
    auto solution = reference;
    solution.displacement[3].y() = std::nan("");
    const auto comparison = core::compare(mesh, {}, solution, reference, "reference");
    EXPECT_TRUE(std::isnan(comparison.relative_l2));
    EXPECT_TRUE(std::isnan(comparison.max_error));
}

/// A ball that has slid off leaves rounding behind, of which there are no ratios; on its way there are.
TEST(Comparison, HasNoRatioToAReferenceThatEndsAtRest) {
    core::LoadCase load_case = tests::empty_load_case(mesh);
    tests::prescribe(load_case, mesh, "x_min", Vector3::Zero());
    load_case.path = {0.5, 1.0};
    load_case.conditions.push_back({"touch", core::ConditionKind::touch});
    load_case.touching = core::TouchingTool{.shape = 0.012,
                                            .start = {0.05, 0.1, 0.112},
                                            .press = {0.0, 0.0, -0.005},
                                            .slide = {0.3, 0.0, 0.0},
                                            .constraint = 1};
    const auto slid_off = [](double size, double rounding) {
        auto solution = constant_solution(mesh, {0.0, rounding, 0.0});
        solution.reaction = {{0.0, 0.0, 2.0 * rounding}, {0.0, 0.0, -rounding}};
        solution.strain_energy = rounding * rounding;
        for (const double part : {size, rounding}) {
            auto &point = solution.path.emplace_back();
            point.displacement.assign(mesh.points.size(), Vector3(0.0, part, 0.0).cast<float>());
            point.reaction = {{0.0, 0.0, 2.0 * part}, {0.0, 0.0, -part}};
            point.strain_energy = part * part;
        }
        return solution;
    };
    for (const double rounding : {2e-13, 0.0}) {
        const auto reference = slid_off(0.002, rounding), solution = slid_off(0.0022, 1e-11);
        const auto found = core::compare(mesh, load_case, solution, reference, "reference");
        for (const double ratio : {found.relative_l2, found.max_error_relative, found.energy_error,
                                   found.reaction_error, found.path->reaction_bias, found.tool->stiffness(),
                                   found.tool->worst_place().relative_l2, found.tool->worst_stiffness()})
            EXPECT_TRUE(std::isnan(ratio)) << ratio;
        EXPECT_NEAR(found.max_error, 1e-11, 1e-12);
        EXPECT_NEAR(found.path->worst_relative_l2, 0.1, 1e-5);
        EXPECT_NEAR(found.path->worst_reaction_error, 0.1, 1e-12);
        EXPECT_NEAR(found.tool->along_path()[0], 0.1, 1e-12);
        EXPECT_TRUE(std::isnan(found.tool->along_path()[1]));
    }
    const auto still = slid_off(0.0, 0.0);
    EXPECT_TRUE(std::isnan(core::compare(mesh, load_case, slid_off(0.002, 0.0), still, "reference").relative_l2));
}

TEST(Comparison, RefusesAReferenceThatIsMissingFailedOrStill) {
    const auto solution = constant_solution(mesh, {1.0, 0.0, 0.0});
    EXPECT_THROW(core::compare(mesh, {}, solution, {}, "missing"), std::invalid_argument);
    auto failed = solution;
    failed.status = core::SolutionStatus::not_converged;
    EXPECT_THROW(core::compare(mesh, {}, solution, failed, "failed"), std::invalid_argument);
    EXPECT_THROW(core::compare(mesh, {}, solution, constant_solution(mesh, Vector3::Zero()), "still"),
                 std::invalid_argument);
}

core::PathPoint path_point(const Vector3 &displacement, double force) {
    core::PathPoint point;
    point.displacement.assign(mesh.points.size(), displacement.cast<float>());
    point.reaction = {{0.0, 0.0, force}, {0.0, 0.0, 0.0}};
    point.strain_energy = force;
    return point;
}

/// At the last point that both have come to, as if that were the whole load.
TEST(Comparison, GoesAsFarAsAReferenceThatEndedEarly) {
    auto load_case = tests::empty_load_case(mesh);
    tests::prescribe(load_case, mesh, "x_min", Vector3::Zero());
    tests::prescribe(load_case, mesh, "x_max", {0.01, 0.0, 0.0});
    load_case.path = {0.25, 0.5, 1.0};
    auto reference = constant_solution(mesh, {9.0, 0.0, 0.0});
    reference.status = core::SolutionStatus::not_converged;
    reference.path = {path_point({0.002, 0.0, 0.0}, 1.0), path_point({0.004, 0.0, 0.0}, 2.0)};
    auto solution = constant_solution(mesh, {0.01, 0.0, 0.0});
    solution.path = {path_point({0.003, 0.0, 0.0}, 1.0), path_point({0.005, 0.0, 0.0}, 3.0),
                     path_point({0.01, 0.0, 0.0}, 7.0)};
    EXPECT_EQ(core::num_points_reached(load_case, reference), 2u);
    const auto comparison = core::compare_as_far_as_reached(mesh, load_case, solution, reference, "r");
    ASSERT_TRUE(comparison);
    EXPECT_EQ(comparison->load_fraction, 0.5);
    EXPECT_NEAR(comparison->relative_l2, 0.25, 1e-6);
    EXPECT_NEAR(comparison->reaction_error, 0.5, 1e-12);
    EXPECT_NEAR(comparison->energy_error, 0.5, 1e-12);
    EXPECT_NEAR(comparison->path->worst_relative_l2, 0.5, 1e-6);

    solution.path.resize(1);
    EXPECT_FALSE(core::compare_as_far_as_reached(mesh, load_case, solution, reference, "r"));
    reference.path.clear();
    EXPECT_EQ(core::num_points_reached(load_case, reference), 0u);
    EXPECT_EQ(core::num_points_reached(load_case, solution), 0u) << "it has a solution to the whole load";
}

/// Sentences that are true: what is too large to square has not stood still.
TEST(Comparison, TellsAReferenceThatIsStillFromOneThatIsTooFar) {
    const auto reason = [](double way) {
        const auto reference = constant_solution(mesh, {way, 0.0, 0.0});
        try {
            core::compare(mesh, {}, reference, reference, "r");
        } catch (const std::invalid_argument &error) {
            return std::string(error.what());
        }
        return std::string();
    };
    EXPECT_NE(reason(1e300).find("moves farther than numbers go; give the load case a smaller load"),
              std::string::npos);
    EXPECT_NE(reason(1e-300).find("does not move"), std::string::npos);
}

TEST(Doubts, AreAboutNumbersThatNoTissueHas) {
    const std::vector<core::Material> materials{
        {1060.0, 5000.0, 0.45}, {1.06, 3000.0, 0.45}, {1060.0, 5.0, 0.45}, {1060.0, 3e9, 0.45}};
    const std::vector<std::string> names{"liver", "light", "soft", "stiff"};
    const auto doubts = core::doubts_about_materials(materials, names);
    ASSERT_EQ(doubts.size(), 3u);
    EXPECT_EQ(doubts[0], "region 'light' has a density of 1.06 kg/m^3, which fits no tissue; check whether it is in "
                         "kg/m^3, in which water has 1000");
    EXPECT_NE(doubts[1].find("'soft' has a Young's modulus of 5 Pa"), std::string::npos) << doubts[1];
    EXPECT_NE(doubts[2].find("'stiff'"), std::string::npos) << doubts[2];
}

TEST(Doubts, AreAboutLoadsThatNobodyGives) {
    const auto doubts = [](const Vector3 &traction, const Vector3 &displacement, double acceleration) {
        auto load_case = tests::empty_load_case(mesh);
        load_case.name = "pull";
        tests::prescribe(load_case, mesh, "x_min", displacement);
        tests::pull(load_case, mesh, "x_max", traction);
        load_case.acceleration.z() = acceleration;
        return core::doubts_about_loads(load_case, mesh);
    };
    EXPECT_TRUE(doubts({2e4, 0.0, 0.0}, {0.01, std::nan(""), 0.0}, -9.81).empty());
    const auto all = doubts({0.0, 1e9, 0.0}, {25.0, std::nan(""), 0.0}, -9810.0);
    ASSERT_EQ(all.size(), 3u);
    EXPECT_EQ(all[0],
              "pull: 'x_min' has a displacement of 25 m, and the body is 0.245 m across; check the number, which "
              "is in m unless the load case says its 'unit'");
    EXPECT_NE(all[1].find("'x_max' has a traction of 1e+09 Pa"), std::string::npos) << all[1];
    EXPECT_NE(all[2].find("9.81e+03 m/s^2"), std::string::npos) << all[2];
    const auto force = doubts({1e5, 0.0, 0.0}, Vector3::Zero(), 0.0);
    ASSERT_EQ(force.size(), 1u);
    EXPECT_NE(force[0].find("a force of 2e+03 N"), std::string::npos) << force[0];
    EXPECT_EQ(core::doubts_about_noise(0.3, 0.02).size(), 1u);
    EXPECT_EQ(core::doubts_about_noise(0.3, 3.1).size(), 1u); // of displacements in another unit as well
    EXPECT_EQ(core::doubts_about_noise(0.0003, 0.0029).size(), 1u);
    EXPECT_TRUE(core::doubts_about_noise(0.0003, 0.0031).empty());
}

TEST(Comparison, RefusesOtherNumbersOfReactions) {
    const auto reference = constant_solution(mesh, {1.0, 0.0, 0.0});
    auto solution = reference;
    solution.reaction.pop_back();
    EXPECT_THROW(core::compare(mesh, {}, solution, reference, "reference"), std::invalid_argument);
}

} // namespace
} // namespace livermark
