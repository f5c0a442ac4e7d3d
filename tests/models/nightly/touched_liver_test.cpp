#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <memory>
#include <span>

#include "core/mesh/local_refinement.hpp"
#include "fem_reference/hyperelastic/hyperelasticity.hpp"
#include "load_cases/readers/load_case_reader.hpp"
#include "meshes/io/body_reader.hpp"
#include "models/model_table.hpp"

namespace livermark {
namespace {

constexpr std::array depths{0.1, 0.3, 1.0}; ///< of the press

hyperelastic::PathSolution quadratic_elements(const core::Problem &problem) {
    return hyperelastic::solve(problem, hyperelastic::material_law("neo_hookean"), {.degree = 2},
                               {.fractions = {depths.begin(), depths.end()}});
}

/// Of the nodes of the coarser mesh, which come first: L2 norms over nodes.
double displacement_error(const hyperelastic::DeformedBody &coarse, const hyperelastic::DeformedBody &fine) {
    double squares = 0.0, all = 0.0;
    for (std::size_t i = 0; i < coarse.displacement.size(); ++i) {
        squares += (coarse.displacement[i] - fine.displacement[i]).squaredNorm();
        all += fine.displacement[i].squaredNorm();
    }
    return std::sqrt(squares / all);
}

core::Problem large_touch() {
    const std::filesystem::path root = LIVERMARK_SOURCE_DIR;
    const auto body = std::make_shared<const core::Body>(meshes::read_body(root / "meshes" / "liver_healthy.toml"));
    return {body, load_cases::read_load_case(root / "load_cases" / "touching" / "large_touch.toml", body->mesh)};
}

/// Forces on the mesh of a liver and on one whose tetrahedra near the ball are cut, and displacements.
TEST(TouchedLiver, QuadraticElementsOnTwoMeshesAgree) {
    const auto problem = large_touch();
    const auto &ball = *problem.load_case.touching;
    const core::InteriorPlace place{ball.first_point(), std::sqrt(ball.radius * ball.press.norm())};
    const auto finer = core::refine_near_places(problem, std::span(&place, 1), 1.5).problem;
    const auto coarse = quadratic_elements(problem), fine = quadratic_elements(finer);
    ASSERT_EQ(coarse.points.size(), depths.size());
    ASSERT_EQ(fine.points.size(), depths.size());
    fmt::print("large_touch: {} and {} tetrahedra\n", problem.body->mesh.num_tetrahedra(),
               finer.body->mesh.num_tetrahedra());
    for (std::size_t i = 0; i < depths.size(); ++i) {
        const double here = coarse.points[i].reaction.back().norm(), there = fine.points[i].reaction.back().norm();
        const double displacement = displacement_error(coarse.points[i], fine.points[i]);
        fmt::print("{:.0f} mm: force {:.4f} and {:.4f} N ({:+.1f} %), displacement {:.2f} %\n",
                   1e3 * depths[i] * ball.press.norm(), here, there, 100.0 * (here / there - 1.0),
                   100.0 * displacement);
        EXPECT_LT(std::abs(here / there - 1.0), 0.1);
        EXPECT_LT(displacement, 0.1);
    }
}

/// Beside fem_p2p1_neo_hookean on the same mesh, see docs/studies/contact.md.
TEST(TouchedLiver, SpringsBearABallThatIsSmallBesideTheirEdges) {
    constexpr std::array reference{0.0309, 0.1440, 0.7820}; // N
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
