#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "core/error_norms.hpp"
#include "core/mesh/refinement.hpp"
#include "load_cases/readers/load_case_reader.hpp"
#include "meshes/io/body_reader.hpp"
#include "studies/models/model_table.hpp"
#include "tests/samples/random_needles.hpp"
#include "tests/studies/insertions.hpp"

namespace livermark {
namespace {

constexpr std::array depths{0.1, 0.3, 1.0}; ///< of the press

core::Problem large_touch() {
    const std::filesystem::path root = LIVERMARK_SOURCE_DIR;
    const auto body = std::make_shared<const core::Body>(meshes::read_body(root / "meshes" / "liver_healthy.toml"));
    return {body, load_cases::read_load_case(root / "load_cases" / "touching" / "large_touch.toml", body->mesh)};
}

/// Forces of fem_p2p1_neo_hookean on the mesh at the depths, see docs/studies/contact.md.
constexpr std::array reference{0.0309, 0.1440, 0.7820}; // N

/// The mesh, and meshes that are refined at rims and below the ball again and again, as fem_p2p1_neo_hookean_refined
/// has them.
core::Problem refined_below_ball(const core::Problem &coarse) {
    constexpr double around_touch = 1.5;
    const auto &ball = *coarse.load_case.touching;
    const core::InteriorPlace place{ball.first_point(), std::sqrt(ball.shape.radius * ball.press.norm())};
    return core::refine_at_rims_and_near(coarse, std::span(&place, 1), around_touch).problem;
}

/// The error of the reference that the meshes tell: of its displacement and force at the whole depth, and of its
/// force on the way.
TEST(TouchedLiver, TheReferenceKnowsItsError) {
    constexpr std::size_t num_meshes = 4;
    auto problem = large_touch();
    problem.load_case.path = {depths.begin(), depths.end()};
    const auto num_nodes = problem.body->mesh.points.size();
    const auto models = models::all_models();
    const auto model = std::ranges::find(models, "fem_p2p1_neo_hookean", &core::Model::name);
    ASSERT_NE(model, models.end());
    std::vector<core::Solution> levels;
    std::array<std::vector<double>, depths.size()> forces; // of the meshes
    auto refined = problem;
    while (levels.size() < num_meshes) {
        if (!levels.empty())
            refined = refined_below_ball(refined);
        auto solution = model->solve(refined);
        ASSERT_EQ(solution.status, core::SolutionStatus::ok) << solution.message;
        ASSERT_EQ(solution.path.size(), depths.size());
        fmt::print("{} tetrahedra, {} unknowns, {:.0f} s:", refined.body->mesh.tetrahedra.size(),
                   solution.degrees_of_freedom, solution.setup_seconds + solution.solve_seconds);
        for (std::size_t i = 0; i < depths.size(); ++i) {
            forces[i].push_back(solution.path[i].reaction.back().norm());
            fmt::print(" {:.4f}", forces[i].back());
        }
        fmt::print(" N; {}\n", solution.solver);
        std::fflush(stdout);
        solution.displacement.resize(num_nodes); // the nodes of the mesh come first
        for (auto &point : solution.path)
            point.displacement.resize(num_nodes);
        levels.push_back(std::move(solution));
        if (levels.size() < 3)
            continue;
        const auto error = *core::extrapolated(problem.body->mesh, problem.load_case, levels).observed_error;
        fmt::print("{} meshes: order {:.2f}, displacement {:.2f} %, force {:.2f} %; bars of the forces", levels.size(),
                   error.order, 100.0 * error.relative_l2, 100.0 * error.reaction);
        for (const auto &on_meshes : forces)
            fmt::print(" {:.2f} %", 100.0 * core::observed_error(on_meshes) / on_meshes.back());
        fmt::print("\n");
        std::fflush(stdout);
    }
    for (std::size_t i = 0; i < depths.size(); ++i) {
        // The load case has ten depths, which changes friction: the force by 0.8 % at most.
        EXPECT_NEAR(forces[i].front(), reference[i], 0.01 * reference[i]);
        EXPECT_LT(core::observed_error(forces[i]), 0.05 * forces[i].back());
    }
}

TEST(TouchedLiver, SpringsBearABallThatIsSmallBesideTheirEdges) {
    struct Expected {
        const char *model;
        std::array<double, depths.size()> error; ///< of the force, 0.03 more or less
    };
    auto problem = large_touch();
    problem.load_case.path = {depths.begin(), depths.end()};
    for (const auto &[name, error] :
         {Expected{"lloyd", {0.49, 0.21, -0.04}}, Expected{"nodal_neo_hookean", {-0.05, -0.08, -0.04}},
          Expected{"nodal_neo_hookean_f", {-0.05, -0.08, -0.04}}}) {
        const auto models = models::all_models();
        const auto model = std::ranges::find(models, name, &core::Model::name);
        ASSERT_NE(model, models.end());
        const auto solution = model->solve(problem);
        ASSERT_EQ(solution.status, core::SolutionStatus::ok) << solution.message;
        ASSERT_EQ(solution.path.size(), depths.size());
        for (std::size_t i = 0; i < depths.size(); ++i) {
            const double force = solution.path[i].reaction.back().norm(), found = force / reference[i] - 1.0;
            fmt::print("{} {:.0f} mm: {:.4f} N ({:+.1f} %)\n", name,
                       1e3 * depths[i] * problem.load_case.touching->press.norm(), force, 100.0 * found);
            EXPECT_NEAR(found, error[i], 0.03) << name;
        }
    }
}

} // namespace
} // namespace livermark

namespace livermark::studies {
namespace {

/// A thousand needles in all.
TEST(RandomNeedles, OfAThousandAllBalanceTheirWork) {
    EXPECT_EQ(tests::drive_random_needles("beam", "x_min", 11, 334), std::vector<std::string>{});
    EXPECT_EQ(tests::drive_random_needles("liver_healthy", "posterior", 12, 333), std::vector<std::string>{});
    EXPECT_EQ(tests::drive_random_needles("liver_tumours", "posterior", 13, 333), std::vector<std::string>{});
}

TEST(RandomNeedles, InStepsInLiversBalanceTheirWork) {
    EXPECT_EQ(tests::step_random_needles("liver_healthy", "posterior", 14, 40), std::vector<std::string>{});
    EXPECT_EQ(tests::step_random_needles("liver_tumours", "posterior", 15, 40), std::vector<std::string>{});
}

} // namespace
} // namespace livermark::studies
