#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <set>

#include "core/mesh/refinement.hpp"
#include "core/support/input_error.hpp"
#include "meshes/cutting/cut.hpp"
#include "msm/elastic_body.hpp"
#include "msm/springs/springs.hpp"
#include "msm/statics/equilibrium.hpp"
#include "studies/cutting/cut_study.hpp"
#include "studies/models/model_table.hpp"
#include "studies/models/motion/moving_method.hpp"
#include "tests/bad_input.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark::studies {
namespace {

using core::Vector3;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
const core::Material tissue{1000.0, 5000.0, 0.3};

/// From the face x = 0 on at half the height, as wide as the strip and more.
BladeWay along_middle(double height, double from, double to, int num_steps) {
    const double z = 0.5 * height;
    return {{Vector3(from, -0.01, z), Vector3(from, 0.1, z), Vector3(to, 0.1, z), Vector3(to, -0.01, z)}, num_steps};
}

double strain_energy(const core::Body &body, const msm::Equilibrium &equilibrium, const msm::ElasticBody &springs) {
    auto positions = body.mesh.points;
    for (std::size_t i = 0; i < positions.size(); ++i)
        positions[i] += equilibrium.displacement[i];
    return msm::elastic_energy(springs, positions);
}

/// The strip of Rivlin and Thomas (1953, J. Polym. Sci. 10): pulled apart at its long edges and cut along its middle.
/// What is far behind the tip is unloaded, what is far before it is strained evenly, and the tip in between only goes
/// on: what a cut sets free over its area is the energy of even strain in the height. Lattice and strain are what the
/// springs have to have right for that, and nothing else.
TEST(GrowingCut, SetsFreeWhatAnEvenlyStrainedStripHasStoredInItsHeight) {
    const Vector3 size(0.12, 0.005, 0.02);
    constexpr double strain = 1e-3;
    const auto body = tests::make_body(tests::box_mesh(size, {24, 1, 4}), tissue);
    const auto stages = grow_cut(body, along_middle(size.z(), -0.01, 0.08, 9), {});
    ASSERT_EQ(stages.size(), 10U);
    const auto energy_of = [&](const CutStage &stage) {
        const auto &mesh = stage.body->mesh;
        auto load_case = tests::empty_load_case(mesh);
        tests::prescribe(load_case, mesh, "x_max", {0.0, nan, nan});
        tests::prescribe(load_case, mesh, "y_min", {nan, 0.0, nan});
        tests::prescribe(load_case, mesh, "y_max", {nan, 0.0, nan});
        tests::prescribe(load_case, mesh, "z_min", {nan, nan, 0.0});
        tests::prescribe(load_case, mesh, "z_max", {nan, nan, strain * size.z()});
        const auto springs =
            msm::coupled_springs_with_volume(*stage.body, msm::find_coupled_springs("nodal_neo_hookean"));
        const auto found = msm::find_equilibrium(springs, mesh.points,
                                                 msm::nodal_conditions({stage.body, load_case}, springs.node_mass));
        EXPECT_EQ(found.status, core::SolutionStatus::ok) << found.message;
        // Far behind the tip the halves are as far apart as the grips were moved, near it a little more.
        EXPECT_GT(opening(stage, found.displacement), 0.99 * strain * size.z());
        EXPECT_LT(opening(stage, found.displacement), 1.25 * strain * size.z());
        return strain_energy(*stage.body, found, springs);
    };
    const double nu = tissue.poisson_ratio;
    const double even = 0.5 * tissue.young_modulus / (1.0 - nu * nu) * strain * strain * size.z(); // [J/m^2]
    const auto &early = stages[6], &late = stages[8];
    EXPECT_NEAR(late.area - early.area, 0.02 * size.y(), 1e-12);
    const double rate = (energy_of(early) - energy_of(late)) / (late.area - early.area);
    EXPECT_NEAR(rate, even, 0.01 * even);
}

/// As a set of faces in space, which does not know how nodes are numbered.
std::vector<std::array<double, 3>> wound_of(const core::TetraMesh &mesh) {
    std::vector<std::array<double, 3>> middles;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (mesh.patch_names[mesh.boundary_patch[f]] == core::wound_patch) {
            const auto &[a, b, c] = mesh.boundary_triangles[f];
            const Vector3 middle = (mesh.points[a] + mesh.points[b] + mesh.points[c]) / 3.0;
            middles.push_back({middle.x(), middle.y(), middle.z()});
        }
    std::ranges::sort(middles);
    return middles;
}

TEST(GrowingCut, LeavesTheSameBodyInOneStepAndInTwenty) {
    const Vector3 size(0.08, 0.02, 0.02);
    const auto body = tests::make_body(tests::box_mesh(size, {16, 4, 4}), tissue);
    const auto at_once = grow_cut(body, along_middle(size.z(), -0.001, 0.051, 1), {});
    const auto in_steps = grow_cut(body, along_middle(size.z(), -0.001, 0.051, 20), {});
    ASSERT_EQ(at_once.size(), 2U);
    ASSERT_EQ(in_steps.size(), 21U);
    const auto &one = at_once.back().body->mesh, &other = in_steps.back().body->mesh;
    EXPECT_EQ(one.num_nodes(), other.num_nodes());
    EXPECT_EQ(one.num_tetrahedra(), other.num_tetrahedra());
    EXPECT_EQ(wound_of(one), wound_of(other));
    EXPECT_NEAR(at_once.back().area, 0.05 * size.y(), 1e-12);
    EXPECT_NEAR(in_steps.back().area, at_once.back().area, 1e-12);
    EXPECT_EQ(in_steps.back().parted.size(), at_once.back().parted.size());
    for (std::size_t k = 1; k < in_steps.size(); ++k)
        EXPECT_GE(in_steps[k].area, in_steps[k - 1].area) << k;
}

TEST(GrowingCut, MeetsTheBodyWhereItIs) {
    const Vector3 size(0.08, 0.02, 0.02);
    const auto body = tests::make_body(tests::box_mesh(size, {16, 4, 4}), tissue);
    const Vector3 shift(0.01, 0.0, 0.0);
    const auto shifted = [&](const CutStage &stage) {
        return std::vector<Vector3>(stage.body->mesh.points.size(), shift);
    };
    const auto moved = grow_cut(body, along_middle(size.z(), 0.0, 0.05, 5), shifted);
    const auto at_rest = grow_cut(body, along_middle(size.z(), -0.01, 0.04, 5), {});
    EXPECT_EQ(wound_of(moved.back().body->mesh), wound_of(at_rest.back().body->mesh));
    EXPECT_GT(at_rest.back().area, 0.0);
    for (const auto &[one, other] : moved.back().parted)
        EXPECT_EQ(moved.back().body->mesh.points[one], moved.back().body->mesh.points[other]);
}

/// Nodes of the facets at the end of the blade, and none at its mouth or on its way.
TEST(GrowingCut, EndsAtARim) {
    const Vector3 size(0.08, 0.02, 0.02);
    const auto body = tests::make_body(tests::box_mesh(size, {16, 4, 4}), tissue);
    const auto stage = grow_cut(body, along_middle(size.z(), -0.001, 0.051, 1), {}).back();
    const auto expect_rim = [&](const core::TetraMesh &mesh) {
        const auto is_rim = wound_rim_nodes(mesh);
        for (int node = 0; node < mesh.num_nodes(); ++node) {
            const auto &x = mesh.points[node];
            EXPECT_EQ(is_rim[node], std::abs(x.x() - 0.05) < 1e-9 && std::abs(x.z() - 0.01) < 1e-9) << x.transpose();
        }
        return std::ranges::count(is_rim, true);
    };
    EXPECT_EQ(expect_rim(stage.body->mesh), 5);
    const core::Problem problem{stage.body, tests::empty_load_case(stage.body->mesh)};
    const auto finer = core::refine_at_rims_and(problem, wound_rim_nodes(stage.body->mesh)).problem;
    EXPECT_EQ(expect_rim(finer.body->mesh), 9);
    for (const auto &nodes : finer.body->mesh.tetrahedra) { // at the other end nothing was cut
        const bool is_far = std::ranges::all_of(nodes, [&](int n) { return finer.body->mesh.points[n].x() < 0.035; });
        if (is_far) {
            EXPECT_TRUE(std::ranges::all_of(nodes, [&](int n) { return n < stage.body->mesh.num_nodes(); }));
        }
    }
}

TEST(GrowingCut, CanBeMadeExactlyInOneStep) {
    const Vector3 size(0.08, 0.02, 0.02);
    const auto body = tests::make_body(tests::box_mesh(size, {16, 4, 4}), tissue);
    auto way = along_middle(size.z(), -0.001, 0.051, 5);
    for (auto &corner : way.corners)
        corner.z() += 0.002; // between two layers of nodes
    const auto along_facets = grow_cut(body, way, {}).back(), exact = cut_exactly(*body, way);
    EXPECT_DOUBLE_EQ(exact.depth, along_facets.depth);
    EXPECT_GT(exact.body->mesh.num_tetrahedra(), along_facets.body->mesh.num_tetrahedra());
    const double edge = 0.005; // by which the end may be short
    EXPECT_LT(exact.area, 0.051 * size.y());
    EXPECT_GT(exact.area, (0.05 - 1.5 * edge) * size.y());
    EXPECT_FALSE(exact.parted.empty());
    const auto is_rim = wound_rim_nodes(exact.body->mesh);
    EXPECT_GT(std::ranges::count(is_rim, true), 4);
    for (const auto &[one, other] : exact.parted)
        EXPECT_EQ(exact.body->mesh.points[one], exact.body->mesh.points[other]);
    EXPECT_THROW(cut_exactly(*body, along_middle(0.2, 0.0, 0.02, 3)), meshes::CutNotOnBody);
}

TEST(GrowingCut, RefusesABladeThatMissesOnAllOfItsWay) {
    const auto body = tests::make_body(tests::box_mesh({0.02, 0.02, 0.02}, {2, 2, 2}), tissue);
    EXPECT_THROW(grow_cut(body, along_middle(0.2, 0.0, 0.02, 3), {}), meshes::CutNotOnBody);
}

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
