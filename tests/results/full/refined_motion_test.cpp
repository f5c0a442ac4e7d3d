#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <stdexcept>
#include <string>

#include "core/error_norms.hpp"
#include "core/mesh/refinement.hpp"
#include "fem_reference/linear/linear_elasticity.hpp"
#include "results/records/result.hpp"
#include "studies/models/model_table.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

core::Solution solve(const std::string &name, const core::Problem &problem) {
    for (const auto &model : models::all_models())
        if (model.name == name)
            return model.solve(problem);
    throw std::invalid_argument("no model " + name);
}

/// A block that is held at one side, pulled at a part of another, and let go.
core::Problem let_go(core::Regime regime, double traction) {
    const auto body = tests::make_body(tests::box_mesh({0.1, 0.04, 0.04}, {3, 2, 2}), {1060.0, 5e3, 0.45});
    auto load_case = tests::empty_load_case(body->mesh);
    load_case.regime = regime;
    if (regime == core::Regime::large)
        load_case.path = {0.5, 1.0};
    tests::prescribe(load_case, body->mesh, "x_min", core::Vector3::Zero());
    tests::pull(load_case, body->mesh, "x_max", {0.0, 0.0, traction});
    load_case.release =
        core::Release{30, 0.01, core::rayleigh_damping(0.05, 12.0, 60.0), {{"tip", body->mesh.num_nodes() - 1}}};
    return {body, load_case};
}

/// Motion of mixed elements on a mesh with edges of a half, of an eighth at the rims, in steps of an eighth.
core::History finer(const core::Problem &problem) {
    constexpr int steps = 8;
    auto fine = core::refine_at_rims(core::refine(problem), 2);
    fine.load_case.release->num_steps *= steps;
    fine.load_case.release->output_interval /= steps;
    fem_reference::StaticSolver solver(fine.body, 2, fem_reference::SolverChoice::automatic,
                                       fem_reference::Formulation::mixed);
    const core::History history = *solver.solve_with_motion(fine.load_case).history;
    core::History result;
    for (std::size_t k = 0; k < history.time.size(); k += steps) {
        result.time.push_back(static_cast<double>(k / steps) * problem.load_case.release->output_interval);
        result.displacement.push_back(history.displacement[k]);
    }
    return result;
}

/// By elements that are finer everywhere, in shorter steps: the bar holds what the refined motion is off.
TEST(RefinedMotion, TellsHowFarTheMotionOnTheMeshIsOff) {
    const auto problem = let_go(core::Regime::small, 0.1);
    const auto [on_mesh, refined] = models::moving_reference(core::Regime::small);
    const auto motion = *solve(std::string(on_mesh), problem).history;
    const auto better = *solve(std::string(refined), problem).history;
    ASSERT_TRUE(better.observed_error);
    EXPECT_GT(better.observed_error->order, 0.3);
    EXPECT_TRUE(better.frames.empty());
    const auto bar = results::estimate_motion_uncertainty(motion, "coarse", better, "better");
    const auto truth = finer(problem);
    const double error = core::compare(motion, truth, "truth").relative_l2;
    const double error_of_better = core::compare(better, truth, "truth").relative_l2;
    RecordProperty("error", std::to_string(error));
    RecordProperty("error_of_better", std::to_string(error_of_better));
    RecordProperty("bar", std::to_string(bar.relative_l2));
    EXPECT_LT(error_of_better, 0.5 * error);
    EXPECT_EQ(bar.reference, "better");
    EXPECT_LT(error_of_better, bar.relative_l2);
    EXPECT_NEAR(error, bar.difference, bar.relative_l2);
}

/// In the large regime too, where a second refinement is not affordable and the order is assumed.
TEST(RefinedMotion, MovesHyperelasticElementsOnAFinerMesh) {
    const auto problem = let_go(core::Regime::large, 40.0);
    const auto [on_mesh, refined] = models::moving_reference(core::Regime::large);
    const auto motion = solve(std::string(on_mesh), problem), better = solve(std::string(refined), problem);
    ASSERT_EQ(better.status, core::SolutionStatus::ok) << better.message;
    EXPECT_EQ(better.displacement.size(), problem.body->mesh.points.size());
    EXPECT_GT(better.degrees_of_freedom, motion.degrees_of_freedom);
    ASSERT_TRUE(motion.history && better.history);
    EXPECT_EQ(better.history->time, motion.history->time);
    const auto bar = results::estimate_motion_uncertainty(*motion.history, "coarse", *better.history, "better");
    EXPECT_GT(bar.difference, 1e-4);
    EXPECT_LT(bar.difference, 0.2);
    ASSERT_TRUE(motion.history->observed_error);
    const double steps = std::pow(better.history->time_step / motion.history->time_step, 2);
    EXPECT_GT(motion.history->observed_error->relative_l2, 0.0);
    EXPECT_DOUBLE_EQ(bar.relative_l2, bar.difference + steps * motion.history->observed_error->relative_l2);
}

TEST(RefinedMotion, TakesPartWhereSomethingMoves) {
    auto problem = let_go(core::Regime::small, 0.1);
    const auto all = models::all_models();
    const auto model =
        std::ranges::find(all, models::moving_reference(core::Regime::small).refined, &core::Model::name);
    ASSERT_NE(model, all.end());
    EXPECT_TRUE(model->takes_part_in(problem));
    problem.load_case.release.reset();
    EXPECT_FALSE(model->takes_part_in(problem));
}

} // namespace
} // namespace livermark
