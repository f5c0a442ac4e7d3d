#include "core/tool/slow_response.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "core/error_norms.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

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
