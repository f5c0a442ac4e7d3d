#include <algorithm>
#include <array>
#include <cstddef>
#include <filesystem>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <memory>

#include "load_cases/readers/load_case_reader.hpp"
#include "meshes/io/body_reader.hpp"
#include "models/model_table.hpp"

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

/// The reference on meshes that are refined below the ball, and what these say of its error.
TEST(TouchedLiver, TheReferenceKnowsItsError) {
    auto problem = large_touch();
    problem.load_case.path = {depths.begin(), depths.end()};
    const auto models = models::all_models();
    const auto model = std::ranges::find(models, "fem_p2p1_neo_hookean_refined", &core::Model::name);
    ASSERT_NE(model, models.end());
    const auto solution = model->solve(problem);
    ASSERT_EQ(solution.status, core::SolutionStatus::ok) << solution.message;
    ASSERT_TRUE(solution.observed_error);
    const auto &error = *solution.observed_error;
    fmt::print("order {:.2f}, displacement {:.2f} %, reactions {:.2f} %, observed at {:.2f} of the load\n", error.order,
               100.0 * error.relative_l2, 100.0 * error.reaction, error.load_fraction);
    EXPECT_LT(error.relative_l2, 0.05);
    EXPECT_LT(error.reaction, 0.05);
    ASSERT_EQ(solution.path.size(), depths.size());
    for (std::size_t i = 0; i < depths.size(); ++i) {
        const double force = solution.path[i].reaction.back().norm();
        fmt::print("{:.0f} mm: {:.4f} N, on the mesh itself {:+.1f} %\n",
                   1e3 * depths[i] * problem.load_case.touching->press.norm(), force,
                   100.0 * (reference[i] / force - 1.0));
    }
    EXPECT_NEAR(reference.back() / solution.path.back().reaction.back().norm(), 1.0, 0.05 + error.reaction);
}

TEST(TouchedLiver, SpringsBearABallThatIsSmallBesideTheirEdges) {
    struct Expected {
        const char *model;
        std::array<double, depths.size()> error; ///< of the force, 0.03 more or less
    };
    auto problem = large_touch();
    problem.load_case.path = {depths.begin(), depths.end()};
    for (const auto &[name, error] :
         {Expected{"lloyd", {0.49, 0.21, -0.04}}, Expected{"nodal_neo_hookean", {0.13, -0.07, -0.10}},
          Expected{"nodal_neo_hookean_f", {0.13, -0.07, -0.10}}}) {
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
