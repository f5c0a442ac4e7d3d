#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "core/error_norms.hpp"
#include "core/load_case.hpp"
#include "core/relaxation.hpp"
#include "core/tool/tool_stiffness.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
const core::PronySeries two_branches{.name = "two", .moduli = {0.3, 0.2}, .times = {1.86, 51.3}};

/// The stresses of the branches at the end of steps of a linear ramp of s to 1.
std::vector<double> after_ramp(const core::PronySeries &relaxation, double duration, int num_steps) {
    std::vector<double> stress(relaxation.moduli.size(), 0.0);
    const auto branches = core::branch_steps(relaxation, duration / num_steps);
    for (int n = 0; n < num_steps; ++n)
        for (std::size_t k = 0; k < stress.size(); ++k)
            stress[k] = branches[k].fade * stress[k] + branches[k].gain / num_steps;
    return stress;
}

TEST(BranchStep, FollowsARampExactlyWhateverItsLength) {
    for (const double duration : {1e-6, 0.1, 3.0, 80.0, 1e5})
        for (const int num_steps : {1, 2, 17}) {
            const auto stress = after_ramp(two_branches, duration, num_steps);
            for (std::size_t k = 0; k < stress.size(); ++k) {
                const double x = duration / two_branches.times[k];
                const double exact = -two_branches.moduli[k] * std::expm1(-x) / x;
                EXPECT_NEAR(stress[k], exact, 1e-13 * exact) << duration << " s in " << num_steps << " steps";
            }
        }
}

TEST(BranchStep, AStepOfNoLengthIsElasticAndAnEndlessOneLetsAllFade) {
    const auto jump = core::branch_steps(two_branches, 0.0), endless = core::branch_steps(two_branches, infinity);
    for (std::size_t k = 0; k < jump.size(); ++k) {
        EXPECT_EQ(jump[k].fade, 1.0);
        EXPECT_EQ(jump[k].gain, two_branches.moduli[k]);
        EXPECT_EQ(jump[k].dissipated(1.0, 1.0, 1.0), 0.0);
        EXPECT_EQ(endless[k].fade, 0.0);
        EXPECT_EQ(endless[k].gain, 0.0);
        EXPECT_EQ(endless[k].dissipated(1.0, 0.0, 0.0), endless[k].stored(1.0)) << "all that was stored is lost";
    }
    EXPECT_DOUBLE_EQ(core::instant_part(two_branches, jump), 1.0);
    EXPECT_DOUBLE_EQ(core::instant_part(two_branches, endless), 0.5);
    EXPECT_DOUBLE_EQ(two_branches.remaining(), 0.5);
}

TEST(BranchStep, InfiniteAndZeroTimesAreTheTwoElasticLimits) {
    const core::PronySeries limits{.name = "limits", .moduli = {0.25, 0.5}, .times = {infinity, 0.0}};
    for (const double step : {1e-9, 1.0, 1e9}) {
        const auto branches = core::branch_steps(limits, step);
        EXPECT_EQ(branches[0].fade, 1.0);
        EXPECT_EQ(branches[0].gain, 0.25);
        EXPECT_EQ(branches[0].dissipated(1.0, 1.0, 1.0), 0.0);
        EXPECT_EQ(branches[1].fade, 0.0);
        EXPECT_EQ(branches[1].gain, 0.0);
    }
}

TEST(BranchStep, DissipatesWhatAFineSumGives) {
    const double before = 0.7, change = -1.3;
    for (const double x : {1e-4, 0.019, 0.021, 0.5, 4.0, 60.0}) {
        const core::PronySeries one{.name = "one", .moduli = {0.4}, .times = {2.0}};
        const double step = 2.0 * x;
        const int num_parts = 20'000;
        double sum = 0.0; // of h^2 / (g tau) by the midpoint rule
        for (int i = 0; i < num_parts; ++i) {
            const double t = (i + 0.5) / num_parts;
            const double h = std::exp(-x * t) * before + 0.4 * -std::expm1(-x * t) / x * change;
            sum += h * h / (0.4 * 2.0) * step / num_parts;
        }
        const auto branch = core::branch_steps(one, step).front();
        EXPECT_NEAR(branch.dissipated(before * before, before * change, change * change), sum, 3e-6 * sum) << x;
    }
}

TEST(BranchStep, TurnsIntoHeatWhatWasDoneAndIsNotStored) {
    for (const double x : {1e-7, 0.3, 20.0})
        for (const double before : {0.0, -0.2, 0.9}) {
            const core::PronySeries one{.name = "one", .moduli = {0.4}, .times = {1.0}};
            const auto branch = core::branch_steps(one, x).front();
            const double change = 0.8, after = branch.fade * before + branch.gain * change;
            // h = steady + (before - steady) exp(-x t), in the mean over the step
            const double steady = 0.4 * change / x, mean = steady + (before - steady) * -std::expm1(-x) / x;
            const double done = mean * change;
            EXPECT_NEAR(branch.dissipated(before * before, before * change, change * change),
                        done - branch.stored(after * after) + branch.stored(before * before), 1e-8);
        }
}

TEST(SlowHistory, EndsAtTheLastWholeLoad) {
    core::SlowHistory history{.relaxation = two_branches, .times = {0.0, 1.0, 2.0, 3.0, 4.0}, .factors = {}};
    history.factors = {0.0, 1.0, 1.0, 1.0, 0.0};
    EXPECT_EQ(history.whole_load_record(), 3);
    history.factors = {0.0, 1.0, 0.0, 1.0, 1.0};
    EXPECT_EQ(history.whole_load_record(), 4);
}

TEST(SlowHistory, TellsLoadCasesApartAndIsNotScaled) {
    const auto mesh = tests::box_mesh({0.1, 0.1, 0.1}, {1, 1, 1});
    auto load_case = tests::empty_load_case(mesh);
    tests::pull(load_case, mesh, "x_max", {10.0, 0.0, 0.0});
    auto slow = load_case;
    slow.slow_history = {.relaxation = two_branches, .times = {0.0, 1.0}, .factors = {0.0, 1.0}};
    EXPECT_EQ(load_case.num_path_points(), 0U);
    EXPECT_EQ(slow.num_path_points(), 2U);
    EXPECT_FALSE(core::are_statically_equal(load_case, slow));
    auto slower = slow;
    slower.slow_history->times.back() = 2.0;
    EXPECT_FALSE(core::are_statically_equal(slow, slower));
    EXPECT_TRUE(core::are_statically_equal(slow, slow));
    EXPECT_EQ(core::scaled(slow, 2.0).slow_history, slow.slow_history);
}

using core::Vector3;

/// A cube that is pushed in at one side, three times, and a path of forces.
struct PushedCube {
    core::TetraMesh mesh = tests::box_mesh({0.1, 0.1, 0.1}, {1, 1, 1});
    core::LoadCase load_case = tests::empty_load_case(mesh);
    core::Solution solution{};

    explicit PushedCube(const std::vector<double> &forces) {
        tests::prescribe(load_case, mesh, "x_min", Vector3::Zero());
        tests::prescribe(load_case, mesh, "x_max", {-0.001, 0.0, 0.0});
        load_case.slow_history = {.relaxation = {.name = "one", .moduli = {0.5}, .times = {1.0}},
                                  .times = {0.0, 1.0, 2.0, 3.0},
                                  .factors = {0.0, 1.0, 1.0, 0.0},
                                  .last_cycle = 0};
        solution.displacement.assign(mesh.points.size(), {0.001, 0.0, 0.0});
        solution.strain_energy = 1.0;
        for (const double force : forces) {
            auto &point = solution.path.emplace_back();
            point.displacement.assign(mesh.points.size(), Eigen::Vector3f::Zero());
            point.reaction = {Vector3::Zero(), Vector3(-force, 0.3, 0.0)};
            point.work = 2.0 * force;
        }
        solution.reaction = {Vector3::Zero(), Vector3(-1.0, 0.3, 0.0)};
    }
};

TEST(SlowResponse, IsTheForceOfAToolAlongItsWay) {
    const PushedCube cube({0.0, 2.0, 1.5, -0.25});
    const auto responses = core::slow_responses(cube.mesh, cube.load_case, cube.solution);
    ASSERT_EQ(responses.size(), 1U) << "what stays where it is is no tool";
    EXPECT_EQ(responses[0].place, "x_max");
    EXPECT_TRUE(responses[0].is_force);
    EXPECT_EQ(responses[0].values, (std::vector<double>{0.0, 2.0, 1.5, -0.25}));
}

TEST(SlowResponse, IsTheDisplacementOfAGivenTraction) {
    PushedCube cube({0.0, 2.0, 1.5, -0.25});
    auto pulled = tests::empty_load_case(cube.mesh);
    tests::prescribe(pulled, cube.mesh, "x_min", Vector3::Zero());
    tests::pull(pulled, cube.mesh, "x_max", {0.0, 0.0, 40.0});
    pulled.slow_history = cube.load_case.slow_history;
    for (std::size_t k = 0; k < cube.solution.path.size(); ++k)
        for (std::size_t node = 0; node < cube.mesh.points.size(); ++node)
            cube.solution.path[k].displacement[node] = {1.0F, 2.0F, 0.5F * static_cast<float>(k)};
    const auto responses = core::slow_responses(cube.mesh, pulled, cube.solution);
    ASSERT_EQ(responses.size(), 1U);
    EXPECT_FALSE(responses[0].is_force);
    for (std::size_t k = 0; k < 4; ++k)
        EXPECT_NEAR(responses[0].values[k], 0.5 * static_cast<double>(k), 1e-12);
}

TEST(SlowComparison, IsOfTheForceOverTheLargestOfTheReference) {
    const PushedCube reference({0.0, 2.0, 1.5, 0.5}), model({0.0, 2.2, 1.6, 0.0});
    const auto found =
        core::compare_slow_histories(reference.mesh, reference.load_case, model.solution, reference.solution);
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->worst_error, 0.25, 1e-12);
    EXPECT_NEAR(found->median_error, 0.1, 1e-12);
    EXPECT_NEAR(found->lost_energy, -1.0, 1e-12);
    EXPECT_EQ(found->place, "x_max");
    const auto same = core::compare(reference.mesh, reference.load_case, model.solution, reference.solution, "cube");
    EXPECT_EQ(same.slow, found);
    EXPECT_FALSE(same.path) << "that is of paths of loads";
}

/// Work that the body gives back is no heat: here a cycle stores 0.4 J more at its end.
TEST(SlowComparison, IsOfHeatByTheSameRule) {
    PushedCube reference({0.0, 2.0, 1.5, 0.5}), model({0.0, 2.2, 1.6, 0.6});
    for (auto *const cube : {&reference, &model})
        cube->solution.path.back().strain_energy = 0.4;
    const auto &history = *reference.load_case.slow_history;
    const auto error = [&] {
        return core::compare_slow_histories(reference.mesh, reference.load_case, model.solution, reference.solution)
            ->lost_energy;
    };
    EXPECT_NEAR(core::lost_energy(history, reference.solution), 1.0 - 0.4, 1e-15);
    EXPECT_NEAR(error(), 0.8 / 0.6 - 1.0, 1e-12);
    model.solution.path.front().dissipated_energy = 0.0;
    model.solution.path.back().dissipated_energy = 0.7; // its work is summed in long steps
    EXPECT_NEAR(core::lost_energy(history, model.solution), 0.7, 1e-15);
    EXPECT_NEAR(error(), 0.8 / 0.6 - 1.0, 1e-12) << "by the rule that both have";
    reference.solution.path.front().dissipated_energy = 0.0;
    reference.solution.path.back().dissipated_energy = 0.7;
    EXPECT_NEAR(error(), 0.0, 1e-12);
    reference.solution.path.back().dissipated_energy = 1e-12;
    EXPECT_TRUE(std::isnan(error())) << "a ratio to rounding";
}

TEST(SlowComparison, KnowsNothingOfAWayThatEndedEarly) {
    const PushedCube reference({0.0, 2.0, 1.5, 0.5}), model({0.0, 2.2});
    const auto found =
        core::compare_slow_histories(reference.mesh, reference.load_case, model.solution, reference.solution);
    ASSERT_TRUE(found);
    EXPECT_TRUE(std::isnan(found->worst_error));
    EXPECT_TRUE(std::isnan(found->lost_energy));
    EXPECT_FALSE(core::compare_slow_histories(reference.mesh, reference.load_case, reference.solution, model.solution));
}

} // namespace
} // namespace livermark
