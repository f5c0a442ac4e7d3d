#include "studies/cutting/moving_cut.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <set>

#include "core/support/input_error.hpp"
#include "studies/models/model_table.hpp"
#include "studies/models/motion/moving_method.hpp"
#include "tests/bad_input.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark::studies {
namespace {

using core::Vector3;

/// A block that is pulled at one side while a blade goes into it from above, to two thirds of its height.
struct BlockUnderBlade {
    explicit BlockUnderBlade(bool is_held = true, const std::array<int, 3> &bricks = {4, 2, 3}) {
        const auto body = tests::make_body(tests::box_mesh({0.04, 0.02, 0.03}, bricks), {1000.0, 5000.0, 0.4});
        const BladeWay way{{Vector3(0.02, -0.01, 0.03), Vector3(0.02, 0.03, 0.03), Vector3(0.02, 0.03, 0.01),
                            Vector3(0.02, -0.01, 0.01)},
                           3};
        stages = grow_cut(body, way, {});
        for (const auto &stage : stages) {
            const auto &mesh = stage.body->mesh;
            auto load_case = tests::empty_load_case(mesh);
            if (is_held)
                tests::prescribe(load_case, mesh, "x_min", Vector3::Zero());
            tests::pull(load_case, mesh, "x_max", {40.0, 0.0, 10.0});
            problems.push_back({stage.body, std::move(load_case)});
        }
    }

    std::vector<CutStage> stages;
    std::vector<core::Problem> problems;
};

TEST(MotionUnderABlade, EndsWhereTheEquilibriumOfItsModelIs) {
    const BlockUnderBlade block;
    const CutMotionOptions options{.methods = {"lloyd", "nodal_springs", "tled", "corotational_implicit"},
                                   .budgets = {5e-4},
                                   .frames_per_step = 4};
    const auto motions = move_under_blade(options, block.stages, block.problems, {});
    const auto all = models::all_models();
    std::set<std::string> seen;
    for (const auto &motion : motions) {
        seen.insert(motion.method);
        const auto solution = support::find_named(all, motion.method, "model").solve(block.problems.back());
        ASSERT_EQ(solution.status, core::SolutionStatus::ok) << motion.method;
        const double wide = opening(block.stages.back(), solution.displacement);
        const double stiffness = stiffness_at_first_tool(block.problems.back(), solution);
        EXPECT_NEAR(motion.opening.back(), wide, 0.01 * wide) << motion.method << ", " << motion.setting;
        EXPECT_NEAR(motion.tool_stiffness.back(), stiffness, 0.01 * stiffness) << motion.method;
        EXPECT_GT(wide, 2e-4);
        // No step fails, and a cut takes time where it parts something and nowhere else.
        ASSERT_EQ(motion.opening.size(), block.stages.size());
        EXPECT_EQ(motion.opening.front(), 0.0);
        for (std::size_t k = 0; k < block.stages.size(); ++k) {
            EXPECT_TRUE(std::isfinite(motion.opening[k])) << motion.method << k;
            EXPECT_GT(motion.tool_stiffness[k], 0.0) << motion.method << k;
            EXPECT_EQ(motion.ready_seconds[k] > 0.0, !block.stages[k].parents.empty()) << motion.method << k;
        }
        EXPECT_GT(motion.worst_frame_seconds, *std::ranges::max_element(motion.ready_seconds));
    }
    EXPECT_EQ(seen.size(), options.methods.size());
}

TEST(MotionUnderABlade, TakesAllSettingsOfMethodsWithAChoice) {
    const BlockUnderBlade block(true, {2, 1, 3});
    const auto motions =
        move_under_blade({.methods = {"xpbd_springs", "tled"}, .budgets = {3e-4}, .frames_per_step = 1}, block.stages,
                         block.problems, {});
    std::multiset<std::string> found, expected{"stable"};
    for (const auto &motion : motions)
        found.insert(motion.setting);
    for (const auto setting : models::all_settings)
        expected.insert(models::to_string(setting));
    EXPECT_EQ(found, expected);
    for (const auto &motion : motions)
        if (motion.setting == models::to_string(models::Setting::ten_iterations)) {
            EXPECT_EQ(motion.iterations, 10);
            EXPECT_GT(motion.steps, 1);
        }
}

Vector3 mean_displacement(const models::FrameBody &body, const std::vector<double> &node_mass) {
    Vector3 sum = Vector3::Zero();
    double mass = 0.0;
    const auto displacement = body.displacement();
    for (std::size_t i = 0; i < node_mass.size(); ++i) {
        sum += node_mass[i] * displacement[i];
        mass += node_mass[i];
    }
    return sum / mass;
}

/// A constant force accelerates the centre of mass of a free body, whatever a blade does to it meanwhile, once
/// iterations have converged.
TEST(MotionUnderABlade, KeepsTheMomentumOfAFreeBody) {
    const BlockUnderBlade block(false);
    std::vector<models::NodalProblem> on_nodes;
    for (const auto &problem : block.problems)
        on_nodes.push_back(models::on_nodes(problem));
    const models::FramesUnderBlade frames{.mass_damping = 2.0};
    const auto methods = models::all_moving_methods();
    for (const char *name : {"lloyd", "patch_nodal_volume", "nodal_springs", "edge_neo_hookean_f", "tled",
                             "tled_nodal_pressure", "corotational_implicit", "xpbd_springs", "xpbd_neo_hookean"}) {
        const auto &method = support::find_named(methods, std::string(name), "method");
        const auto cut = method.under_blade(on_nodes.front(), frames),
                   whole = method.under_blade(on_nodes.front(), frames);
        const auto effort = cut->least_effort().value_or(models::Effort{.steps = 4, .iterations = 60});
        for (auto *body : {cut.get(), whole.get()})
            body->prepare_for(effort);
        Vector3 mean_of_cut = Vector3::Zero(), mean_of_whole = mean_of_cut;
        for (std::size_t k = 0; k < block.stages.size(); ++k) {
            if (!block.stages[k].parents.empty())
                cut->cut(on_nodes[k], block.stages[k].parents);
            for (int frame = 0; frame < 3; ++frame)
                for (auto *body : {cut.get(), whole.get()})
                    body->advance({}, effort);
            mean_of_cut = mean_displacement(*cut, on_nodes[k].node_mass);
            mean_of_whole = mean_displacement(*whole, on_nodes.front().node_mass);
            EXPECT_LT((mean_of_cut - mean_of_whole).norm(), 1e-4 * mean_of_whole.norm()) << name << k;
        }
        EXPECT_GT(mean_of_whole.norm(), 0.01) << name;
        EXPECT_GT(opening(block.stages.back(), cut->displacement()), 1e-4) << name;
    }
}

TEST(MotionUnderABlade, RefusesWhatItCannotDo) {
    const auto fails = [](const CutMotionOptions &options, const std::vector<std::string> &parts) {
        tests::expect_input_error([&] { chosen_methods_under_blade(options); }, parts);
    };
    fails({.methods = {"tlde"}}, {"'tlde'", "did you mean 'tled'?"});
    fails({.methods = {"tled"}, .budgets = {}}, {"--budget is empty"});
    fails({.methods = {"tled"}, .budgets = {0.004, 0.0}}, {"--budget", "give times above 0"});
    fails({.methods = {"all"}, .frames_per_step = 0}, {"--frames is 0", "give 1 to 1000"});
    fails({.methods = {"tled"}, .frames_per_step = 1001}, {"--frames is 1001"});
    EXPECT_TRUE(chosen_methods_under_blade({.methods = {}, .budgets = {}}).empty());
    const auto all = chosen_methods_under_blade({.methods = {"all"}});
    EXPECT_EQ(all.size(), static_cast<std::size_t>(std::ranges::count(models::all_moving_methods(), false,
                                                                      &models::MovingMethod::is_scaled)));
    EXPECT_EQ(chosen_methods_under_blade({.methods = {"tled", "lloyd", "tled"}}),
              (std::vector<std::string>{"lloyd", "tled"}));

    const BlockUnderBlade block;
    EXPECT_NO_THROW(check_loads_of_motion(block.problems.front()));
    const auto refused = [&](const Vector3 &displacement, const std::vector<std::string> &parts) {
        auto problem = block.problems.front();
        tests::prescribe(problem.load_case, problem.body->mesh, "z_min", displacement);
        tests::expect_input_error([&] { check_loads_of_motion(problem); }, parts);
    };
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    refused({nan, nan, 0.0}, {"leaves a component of the displacement free", "give all three components"});
    refused({0.0, 0.0, 1e-3}, {"displaces a place", "tractions or forces"});
}

} // namespace
} // namespace livermark::studies
