#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "core/tool/touching_tool.hpp"
#include "studies/models/model_table.hpp"
#include "tests/samples/touch/touched_layer.hpp"

namespace livermark {
namespace {

using core::Vector3;

/// Least and largest error of the force of a model where the circle of contact has so many edges in its radius, over
/// the places of the ball.
struct ErrorOfForce {
    double circle_in_edges, least, largest;
};

constexpr std::array<double, 2> depths_in_layer{0.5e-3, 2e-3}; // m
constexpr std::array<int, 4> bricks_down{2, 3, 4, 6};
/// In bricks: near a node, on the middle of an edge, inside a facet.
constexpr std::array<std::array<double, 2>, 3> places_of_ball{{{0.07, 0.13}, {0.5, 0.02}, {0.3, 0.4}}};

/// One for each mesh and depth, by the size of the circle.
std::vector<ErrorOfForce> errors_of(const core::Model &model) {
    std::vector<ErrorOfForce> errors;
    for (const int down : bricks_down)
        for (std::size_t d = 0; d < depths_in_layer.size(); ++d) {
            ErrorOfForce error{.circle_in_edges = 0.0, .least = 1e9, .largest = -1e9};
            for (const auto &[x, y] : places_of_ball) {
                const double brick = tests::TouchedLayer::thickness / down;
                const auto problem = tests::TouchedLayer{.poisson_ratio = 0.45, .bricks_down = down}.problem(
                    depths_in_layer[d], {x * brick, y * brick, 0.0});
                const auto solution = model.solve(problem);
                EXPECT_EQ(solution.status, core::SolutionStatus::ok) << model.name << ": " << solution.message;
                if (solution.status != core::SolutionStatus::ok)
                    continue;
                const double found =
                    solution.reaction.back().norm() / tests::TouchedLayer::force(0.45, depths_in_layer[d]) - 1.0;
                error.least = std::min(error.least, found);
                error.largest = std::max(error.largest, found);
                const auto facet = core::touched_facets(*problem.body, problem.load_case).front();
                error.circle_in_edges = core::circle_of_contact(*problem.load_case.touching, 1.0) / facet.side;
            }
            errors.push_back(error);
        }
    std::ranges::sort(errors, {}, &ErrorOfForce::circle_in_edges);
    return errors;
}

/// Force of a ball on a layer over the radius of what it touches in edges, of every model that touches, on four meshes.
TEST(ContactCircles, FromHalfAnEdgeOnForcesAreRight) {
    constexpr double half = 0.5, percent = 100.0;
    for (const char *name : {"lloyd", "patch_nodal_volume", "nodal_springs", "nodal_neo_hookean", "nodal_neo_hookean_f",
                             "edge_neo_hookean", "fem_p1_neo_hookean", "fem_p2_neo_hookean", "fem_p2p1_neo_hookean"}) {
        const auto models = models::all_models();
        const auto model = std::ranges::find(models, std::string(name), &core::Model::name);
        ASSERT_NE(model, models.end());
        const bool has_softness_of_its_own = !std::string(name).starts_with("lloyd") &&
                                             !std::string(name).starts_with("patch") &&
                                             !std::string(name).starts_with("fem_p2");
        fmt::print("| `{}` |", name);
        for (const auto &error : errors_of(*model)) {
            fmt::print(" {:.2f}: {:+.0f} to {:+.0f} |", error.circle_in_edges, percent * error.least,
                       percent * error.largest);
            if (has_softness_of_its_own && error.circle_in_edges > half) {
                EXPECT_GT(error.least, -0.12) << name;
                EXPECT_LT(error.largest, 0.12) << name;
            }
        }
        fmt::print("\n");
        std::fflush(stdout);
    }
}

} // namespace
} // namespace livermark
