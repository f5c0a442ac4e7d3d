#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>
#include <vector>

#include "core/error_norms.hpp"
#include "core/tool/tool_stiffness.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

using core::ToolDrive;
using core::Vector3;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// A cube of 0.1 m, three bricks a side, held at the bottom.
struct Cube {
    core::TetraMesh mesh = tests::box_mesh({0.1, 0.1, 0.1}, {3, 3, 3});
    core::LoadCase load_case = tests::empty_load_case(mesh);

    Cube() { tests::prescribe(load_case, mesh, "z_min", Vector3::Zero()); }

    /// u = height * (0, 0, scale) and reactions of that size, with a path to it at half of it and the whole.
    core::Solution squeezed(double scale) const {
        core::Solution solution;
        for (const auto &point : mesh.points)
            solution.displacement.emplace_back(0.0, 0.0, scale * point.z());
        for (int p = 0; p < load_case.num_constraints(); ++p)
            solution.reaction.emplace_back(0.0, 0.0, scale * (static_cast<double>(p) + 1.0));
        solution.strain_energy = scale * scale;
        return solution;
    }

    core::ToolComparison compare(const core::Solution &solution, const core::Solution &reference) const {
        return core::compare(mesh, load_case, solution, reference, "reference").tool.value();
    }
};

void add_path(core::Solution &solution, const std::vector<double> &factors) {
    for (const double factor : factors) {
        auto &point = solution.path.emplace_back();
        for (const auto &displacement : solution.displacement)
            point.displacement.push_back((factor * displacement).cast<float>());
        for (const auto &reaction : solution.reaction)
            point.reaction.emplace_back(factor * reaction);
        point.strain_energy = factor * factor * solution.strain_energy;
    }
}

TEST(ToolStiffness, OfAGivenTractionIsTheInverseOfTheDisplacement) {
    Cube cube;
    tests::pull(cube.load_case, cube.mesh, "z_max", {0.0, 0.0, -50.0});
    const auto tool = cube.compare(cube.squeezed(-0.0125), cube.squeezed(-0.01));
    ASSERT_EQ(tool.places.size(), 1U);
    EXPECT_EQ(tool.places[0].name, "z_max");
    EXPECT_NEAR(tool.stiffness(), -0.2, 1e-14);
}

/// If the reference has nodes beside those of the mesh, its own work counts, and that of the model if it has one.
TEST(ToolStiffness, OfAGivenTractionComparesTheWorksOfTheModelsThemselves) {
    Cube cube;
    tests::pull(cube.load_case, cube.mesh, "z_max", {0.0, 0.0, -50.0});
    auto reference = cube.squeezed(-0.01), solution = cube.squeezed(-0.0125);
    const double force = 50.0 * 0.1 * 0.1; // of which the work is 0.1 scale times that
    reference.load_work = 1.06 * force * 0.1 * 0.01;
    EXPECT_NEAR(cube.compare(solution, reference).stiffness(), 1.06 * 0.8 - 1.0, 1e-12);
    solution.load_work = 1.02 * force * 0.1 * 0.0125;
    EXPECT_NEAR(cube.compare(solution, reference).stiffness(), 1.06 / 1.02 * 0.8 - 1.0, 1e-12);
    reference.load_work = nan;
    EXPECT_NEAR(cube.compare(solution, reference).stiffness(), -0.2, 1e-12) << "both are summed at the nodes";
}

/// A corner node of the face carries the third of its facets' force.
TEST(ToolStiffness, WeighsDisplacementsWithTheTractionAlongIt) {
    Cube cube;
    tests::pull(cube.load_case, cube.mesh, "z_max", {0.0, 0.0, -50.0});
    const auto reference = cube.squeezed(-0.01);
    auto solution = reference;
    double part = 0.0;
    int node = -1;
    for (int f = 0; f < cube.mesh.num_boundary_triangles(); ++f)
        if (cube.load_case.load_on(f) == 0) {
            if (node < 0)
                node = cube.mesh.boundary_triangles[f][0];
            for (const int corner : cube.mesh.boundary_triangles[f])
                part += corner == node ? core::area_vector(cube.mesh, f).norm() / 3.0 / 0.01 : 0.0;
        }
    solution.displacement[node] += Vector3(0.7, -0.3, -0.001); // across the traction nothing counts
    EXPECT_NEAR(cube.compare(solution, reference).stiffness(), 1.0 / (1.0 + part) - 1.0, 1e-13);
    solution = reference;
    for (std::size_t i = 0; i < solution.displacement.size(); ++i)
        if (cube.mesh.points[i].z() < 0.09)
            solution.displacement[i].setZero();
    EXPECT_NEAR(cube.compare(solution, reference).stiffness(), 0.0, 1e-15);
}

TEST(ToolStiffness, OfAControlledDepthIsTheForceAlongThatOfTheReference) {
    Cube cube;
    tests::press(cube.load_case, cube.mesh, "z_max", {0.0, 0.0, -1.0}, 0.001);
    const auto reference = cube.squeezed(-0.01);
    auto solution = cube.squeezed(-0.02); // displacements do not count
    solution.reaction = reference.reaction;
    solution.reaction[0] *= 3.0; // of what holds
    solution.reaction[1] *= 1.1;
    solution.reaction[1].x() = 5.0;
    const auto tool = cube.compare(solution, reference);
    ASSERT_EQ(tool.places.size(), 1U);
    EXPECT_EQ(tool.places[0].name, "z_max");
    EXPECT_NEAR(tool.stiffness(), 0.1, 1e-14);
}

TEST(ToolStiffness, OfAPlaceThatIsHeldAndMovedIsItsReaction) {
    Cube cube;
    tests::prescribe(cube.load_case, cube.mesh, "z_max", {nan, nan, 0.002});
    const auto tool = cube.compare(cube.squeezed(0.9), cube.squeezed(1.0));
    ASSERT_EQ(tool.places.size(), 1U);
    EXPECT_EQ(tool.places[0].name, "z_max");
    EXPECT_NEAR(tool.stiffness(), -0.1, 1e-14);
}

TEST(ToolStiffness, IsNotThereWithoutATool) {
    Cube cube;
    cube.load_case.acceleration = {0.0, 0.0, -9.81};
    EXPECT_TRUE(core::tool_places(cube.mesh, cube.load_case).empty());
    EXPECT_FALSE(core::radius_in_edges({}));
    EXPECT_FALSE(core::compare(cube.mesh, cube.load_case, cube.squeezed(1.0), cube.squeezed(1.1), "reference").tool);
}

TEST(ToolStiffness, OfALoadCaseIsThatOfThePlaceWhereItIsWorst) {
    Cube cube;
    tests::prescribe(cube.load_case, cube.mesh, "x_max", {0.001, 0.0, 0.0});
    tests::pull(cube.load_case, cube.mesh, "z_max", {0.0, 0.0, 1.0});
    const auto reference = cube.squeezed(1.0);
    auto solution = reference;
    solution.reaction[1] *= 0.7;
    for (auto &displacement : solution.displacement)
        displacement *= 0.8;
    auto tool = cube.compare(solution, reference);
    ASSERT_EQ(tool.places.size(), 2U);
    EXPECT_NEAR(tool.places[0].stiffness, 0.25, 1e-14);
    EXPECT_NEAR(tool.stiffness(), -0.3, 1e-14);
    EXPECT_EQ(tool.worst_place().name, "x_max");
    // Displacements that say nothing of forces have a stiffness where the force is given.
    solution.reaction.assign(2, Vector3::Constant(nan));
    tool = cube.compare(solution, reference);
    EXPECT_EQ(tool.worst_place().name, "z_max");
    EXPECT_NEAR(tool.stiffness(), 0.25, 1e-14);
    EXPECT_TRUE(std::isnan(tool.places[1].stiffness));
}

TEST(ToolStiffness, IsNoNumberWhereTheReferenceHasNoForceOrTheModelNoSolution) {
    Cube cube;
    tests::pull(cube.load_case, cube.mesh, "z_max", {1.0, 0.0, 0.0}); // across the displacement
    EXPECT_TRUE(std::isnan(cube.compare(cube.squeezed(1.0), cube.squeezed(1.1)).stiffness()));
    cube = Cube();
    tests::prescribe(cube.load_case, cube.mesh, "z_max", {0.0, 0.0, 0.002});
    auto reference = cube.squeezed(1.0);
    reference.reaction[1] = {0.0, 0.0, 1e-9};
    EXPECT_TRUE(std::isnan(cube.compare(cube.squeezed(1.0), reference).stiffness()));
    const auto lost = cube.compare(cube.squeezed(nan), cube.squeezed(1.0));
    EXPECT_TRUE(std::isnan(lost.stiffness()));
    EXPECT_TRUE(std::isnan(lost.worst_stiffness()));
}

TEST(ToolStiffness, GoesAlongThePathAsFarAsTheSolution) {
    Cube cube;
    tests::pull(cube.load_case, cube.mesh, "z_max", {0.0, 0.0, 1.0});
    tests::prescribe(cube.load_case, cube.mesh, "x_max", {0.001, 0.0, 0.0});
    auto reference = cube.squeezed(1.0);
    add_path(reference, {0.5, 1.0});
    auto solution = cube.squeezed(1.25);
    add_path(solution, {0.3, 1.0});
    auto tool = cube.compare(solution, reference);
    ASSERT_EQ(tool.places[0].path.size(), 2U);
    EXPECT_NEAR(tool.places[0].path[0], 0.5 / 0.375 - 1.0, 1e-6); // single precision
    EXPECT_NEAR(tool.places[0].path[1], -0.2, 1e-6);
    EXPECT_NEAR(tool.places[1].path[0], 0.375 / 0.5 - 1.0, 1e-14);
    EXPECT_NEAR(tool.places[1].path[1], 0.25, 1e-14);
    EXPECT_NEAR(tool.stiffness(), 0.25, 1e-14);
    EXPECT_NEAR(tool.along_path()[0], 1.0 / 3.0, 1e-6);
    EXPECT_NEAR(tool.worst_stiffness(), 1.0 / 3.0, 1e-6);
    solution.path.pop_back();
    EXPECT_EQ(cube.compare(solution, reference).along_path().size(), 1U);
}

TEST(ToolStiffness, HasTheErrorWithinTwoRadii) {
    Cube cube;
    tests::pull(cube.load_case, cube.mesh, "z_max", {0.0, 0.0, 1.0});
    cube.load_case.conditions.back().round = core::RoundLoad{{0.0, 0.0, 0.1}, 0.02};
    const auto reference = cube.squeezed(1.0);
    auto solution = reference;
    std::vector<double> errors;
    for (std::size_t i = 0; i < solution.displacement.size(); ++i)
        if ((cube.mesh.points[i] - Vector3(0.0, 0.0, 0.1)).norm() <= 0.04)
            solution.displacement[i] *= 1.3;
        else
            solution.displacement[i] *= -7.0;
    EXPECT_NEAR(cube.compare(solution, reference).worst_place().relative_l2, 0.3, 1e-14);
}

TEST(ToolPlace, HasTheRadiusOfARoundToolOrOfTheDiscOfItsArea) {
    Cube cube;
    tests::pull(cube.load_case, cube.mesh, "z_max", {0.0, 0.0, 1.0});
    tests::prescribe(cube.load_case, cube.mesh, "x_max", {0.0, 0.0, 0.001});
    const auto places = core::tool_places(cube.mesh, cube.load_case);
    ASSERT_EQ(places.size(), 2U);
    EXPECT_EQ(places[0].drive, ToolDrive::traction);
    EXPECT_EQ(places[0].facets.size(), 18U);
    EXPECT_LT((places[0].middle - Vector3(0.05, 0.05, 0.1)).norm(), 1e-15);
    EXPECT_NEAR(places[0].radius, 0.1 / std::sqrt(std::numbers::pi), 1e-15);
    EXPECT_NEAR(places[0].edge_length, (2.0 + std::numbers::sqrt2) / 3.0 * 0.1 / 3.0, 1e-15);
    EXPECT_EQ(places[1].drive, ToolDrive::displacement);
    EXPECT_EQ(places[1].constraint, 1);
    auto round = cube.load_case;
    round.conditions[round.condition_on[places[0].facets.front()]].round = core::RoundLoad{{0.04, 0.03, 0.1}, 0.02};
    const auto with_round = core::tool_places(cube.mesh, round);
    EXPECT_EQ(with_round[0].middle, Vector3(0.04, 0.03, 0.1));
    EXPECT_EQ(with_round[0].radius, 0.02);
    EXPECT_NEAR(core::radius_in_edges(with_round).value(), 0.02 / places[0].edge_length, 1e-14);
}

/// A ball of 12 mm at depths of 1, 3 and 10 mm.
TEST(ToolPlace, OfABallHasTheRadiusOfItsContactAlongThePath) {
    Cube cube;
    EXPECT_TRUE(core::contact_radii_in_edges(cube.mesh, cube.load_case).empty());
    cube.load_case.path = {0.1, 0.3, 1.0};
    cube.load_case.touching =
        core::TouchingTool{.shape = 0.012, .start = {0.05, 0.05, 0.112}, .press = {0.0, 0.0, -0.01}, .constraint = 0};
    auto radii = core::contact_radii_in_edges(cube.mesh, cube.load_case);
    ASSERT_EQ(radii.size(), 3U);
    const double edge = (2.0 + std::numbers::sqrt2) / 3.0 * 0.1 / 3.0;
    EXPECT_NEAR(radii[0], std::sqrt(0.012 * 0.001) / edge, 1e-12);
    EXPECT_NEAR(radii[1], std::sqrt(0.012 * 0.003) / edge, 1e-12);
    EXPECT_NEAR(radii[2], std::sqrt(0.012 * 0.010) / edge, 1e-12);
    cube.load_case.touching->slide = {0.01, 0.0, 0.0}; // the first half presses
    radii = core::contact_radii_in_edges(cube.mesh, cube.load_case);
    EXPECT_NEAR(radii[0], std::sqrt(0.012 * 0.002) / edge, 1e-12);
    EXPECT_NEAR(radii[1], std::sqrt(0.012 * 0.006) / edge, 1e-12);
    EXPECT_NEAR(radii[2], std::sqrt(0.012 * 0.010) / edge, 1e-12);
}

TEST(ObservedError, OfStiffnessAtTheToolIsExactForErrorsThatShrinkByOneFactor) {
    Cube cube;
    tests::pull(cube.load_case, cube.mesh, "z_max", {0.0, 0.0, 1.0});
    std::vector<core::Solution> levels;
    for (const double error : {0.008, 0.004, 0.002})
        levels.push_back(cube.squeezed(1.0 - error));
    EXPECT_NEAR(core::observed_error(cube.mesh, cube.load_case, levels).stiffness.value(), 0.002, 2e-5);
    EXPECT_FALSE(core::observed_error(cube.mesh, {}, levels).stiffness);
    // What extrapolation adds is uncertain by a half.
    EXPECT_NEAR(core::extrapolated(cube.mesh, cube.load_case, levels).observed_error->stiffness.value(),
                core::doubt * 0.002, 2e-5);
    // Reactions that do not change are not extrapolated, and neither is the stiffness of a place that is held.
    cube.load_case = Cube().load_case;
    tests::prescribe(cube.load_case, cube.mesh, "z_max", {0.0, 0.0, 1.0});
    for (auto &level : levels)
        level.reaction.assign(2, Vector3(0.0, 0.0, 1.0));
    EXPECT_EQ(core::extrapolated(cube.mesh, cube.load_case, levels).observed_error->stiffness.value(), 0.0);
}

} // namespace
} // namespace livermark

namespace livermark::core {
namespace {

/// A cube of 0.1 m held at the bottom, that is squeezed evenly.
struct SqueezedCube {
    TetraMesh mesh = tests::box_mesh({0.1, 0.1, 0.1}, {2, 2, 2});
    LoadCase load_case = tests::empty_load_case(mesh);
    Solution solution{};

    SqueezedCube() {
        tests::prescribe(load_case, mesh, "z_min", Vector3::Zero());
        for (const auto &point : mesh.points)
            solution.displacement.emplace_back(0.0, 0.0, -0.02 * point.z());
    }

    double stiffness() const { return stiffness_at(mesh, load_case, tool_places(mesh, load_case), 0, solution); }
};

TEST(PlaceStiffness, OfAGivenTractionIsForceOverDisplacement) {
    SqueezedCube cube;
    tests::pull(cube.load_case, cube.mesh, "z_max", {0.0, 0.0, -50.0});
    EXPECT_NEAR(cube.stiffness(), 50.0 * 0.01 / 0.002, 1e-9);
    cube.solution.load_work = 1.25 * 0.5 * 0.002; // with shape functions of the model itself
    EXPECT_NEAR(cube.stiffness(), 250.0 / 1.25, 1e-9);
}

TEST(PlaceStiffness, OfADepthIsTheReactionOverIt) {
    SqueezedCube cube;
    tests::press(cube.load_case, cube.mesh, "z_max", {0.0, 0.0, -1.0}, 0.002);
    cube.solution.reaction = {{0.0, 0.0, 0.6}, {0.0, 0.0, -0.6}};
    EXPECT_NEAR(cube.stiffness(), 300.0, 1e-9);
}

TEST(PlaceStiffness, OfAPrescribedDisplacementIsTheReactionAlongIt) {
    SqueezedCube cube;
    tests::prescribe(cube.load_case, cube.mesh, "z_max", {0.0, 0.0, -0.002});
    cube.solution.reaction = {{0.0, 0.0, 0.6}, {0.3, 0.0, -0.6}};
    EXPECT_NEAR(cube.stiffness(), 300.0, 1e-9);
}

TEST(PlaceStiffness, IsUnknownWhereATractionHasNoResultant) {
    SqueezedCube cube;
    tests::pull(cube.load_case, cube.mesh, "z_max", {0.0, 0.0, -50.0});
    auto pulls_up = false; // every other facet, all of one area
    for (std::size_t f = 0; f < cube.load_case.value.size(); ++f)
        if (cube.load_case.is_loaded(f))
            cube.load_case.value[f].z() *= (pulls_up = !pulls_up) ? -1.0 : 1.0;
    EXPECT_TRUE(std::isnan(cube.stiffness()));
}

} // namespace
} // namespace livermark::core
