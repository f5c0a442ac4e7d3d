#include <algorithm>
#include <cmath>
#include <filesystem>
#include <gtest/gtest.h>
#include <map>
#include <memory>
#include <numbers>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/error_norms.hpp"
#include "core/mesh/refinement.hpp"
#include "core/support/input_error.hpp"
#include "core/tool/tool_stiffness.hpp"
#include "msm/spring_law.hpp"
#include "studies/models/model_table.hpp"
#include "studies/models/refined_solution.hpp"
#include "tests/samples/even_foundation.hpp"
#include "tests/samples/test_meshes.hpp"
#include "tests/samples/touched_block.hpp"

namespace livermark {
namespace {

TEST(ModelTable, HasEveryFileOfItsFolderUnderItsName) {
    std::set<std::string> files;
    for (const auto &file : std::filesystem::directory_iterator(LIVERMARK_SOURCE_DIR "/studies/models/families"))
        files.insert(file.path().stem().string());
    std::set<std::string> names;
    for (const auto &family : models::all_families()) {
        names.insert(family.name);
        EXPECT_FALSE(family.models({}).empty()) << family.name;
    }
    EXPECT_EQ(names, files);
}

TEST(ModelTable, NamesEveryModelOnceAndSaysWhereItComesFrom) {
    std::set<std::string> names;
    for (const auto &model : models::all_models()) {
        EXPECT_TRUE(names.insert(model.name).second) << model.name << " is there twice";
        EXPECT_FALSE(model.summary.empty()) << model.name;
        EXPECT_FALSE(model.source.empty()) << model.name;
    }
}

TEST(ModelTable, HasTheReferenceTheBaselineAndEverySpringLaw) {
    std::set<std::string> names;
    for (const auto &model : models::all_models())
        names.insert(model.name);
    for (const auto regime : {core::Regime::small, core::Regime::large})
        for (const auto &[on_mesh, refined] : {models::static_reference(regime), models::moving_reference(regime)}) {
            EXPECT_TRUE(names.contains(on_mesh));
            EXPECT_TRUE(names.contains(refined));
        }
    EXPECT_TRUE(names.contains(models::baseline_name()));
    for (const auto &law : msm::all_spring_laws())
        EXPECT_TRUE(names.contains(law.name)) << law.name;
}

/// A material with the constants of every law.
const core::Material tissue_of_all_laws{1060.0, 5e3, 0.25, {{"mooney_rivlin", {0.1}}, {"yeoh", {0.05, 0.02}}}};

/// A constrained block under an acceleration small enough to be linear: every model says where it is in the problem's
/// shapes.
TEST(EveryModel, SolvesInTheShapesOfTheProblem) {
    const auto body = tests::make_body(tests::box_mesh({0.1, 0.05, 0.05}, {4, 2, 2}), tissue_of_all_laws);
    auto load_case = tests::empty_load_case(body->mesh);
    tests::prescribe(load_case, body->mesh, "x_min", core::Vector3::Zero());
    load_case.acceleration = {0.0, 0.0, -0.01};
    const core::Problem problem{body, load_case};
    for (const auto &model : models::all_models()) {
        const auto solution = model.solve(problem);
        EXPECT_EQ(solution.status, core::SolutionStatus::ok) << model.name << ": " << solution.message;
        EXPECT_EQ(solution.displacement.size(), body->mesh.points.size()) << model.name;
        EXPECT_EQ(solution.reaction.size(), 1U) << model.name;
        EXPECT_GT(solution.strain_energy, 0.0) << model.name;
        EXPECT_GT(solution.degrees_of_freedom, 0) << model.name;
        const double weight = 1060.0 * 0.1 * 0.05 * 0.05 * 0.01;
        EXPECT_NEAR(solution.reaction[0].z(), weight, 1e-9 * weight) << model.name;
    }
}

/// One after the other, as if each were alone; and where springs bear a block, all models move a third as far or less.
TEST(EveryModel, ThatFollowsFoundationsStandsOnThatOfEachLoadCase) {
    const auto body = tests::make_body(tests::box_mesh({0.1, 0.05, 0.05}, {4, 2, 2}), tissue_of_all_laws);
    auto alone = tests::empty_load_case(body->mesh);
    tests::prescribe(alone, body->mesh, "x_min", core::Vector3::Zero());
    alone.acceleration = {0.0, 0.0, -0.01};
    std::vector<int> below;
    for (int f = 0; f < body->mesh.num_boundary_triangles(); ++f)
        if (body->mesh.patch_names[body->mesh.boundary_patch[f]] == "z_min")
            below.push_back(f);
    auto soft = alone, stiff = alone;
    soft.foundation = tests::even_foundation(below, 2e4, true);
    stiff.foundation = tests::even_foundation(below, 1e6, false);
    const std::vector<core::LoadCase> load_cases{alone, soft, stiff, alone};
    const auto peak = [](const core::Solution &solution) {
        double largest = 0.0;
        for (const auto &u : solution.displacement)
            largest = std::max(largest, u.norm());
        return largest;
    };
    std::set<std::string> names;
    std::map<std::string, double> stored; // by the body on the soft springs, which are no part of it
    for (const auto &model : models::all_models()) {
        if (!model.takes_part_in({body, soft}))
            continue;
        names.insert(model.name);
        const auto solutions = model.prepare(body, nullptr)->solve(load_cases);
        ASSERT_EQ(solutions.size(), load_cases.size()) << model.name;
        for (std::size_t c = 0; c < load_cases.size(); ++c) {
            ASSERT_EQ(solutions[c].status, core::SolutionStatus::ok) << model.name << ": " << solutions[c].message;
            const auto expected = c + 1 == load_cases.size() ? solutions[0] : model.solve({body, load_cases[c]});
            ASSERT_EQ(expected.status, core::SolutionStatus::ok) << model.name << ": " << expected.message;
            for (std::size_t i = 0; i < expected.displacement.size(); ++i)
                EXPECT_LT((solutions[c].displacement[i] - expected.displacement[i]).norm(), 1e-4 * peak(expected))
                    << model.name << ", load case " << c;
        }
        stored[model.name] = solutions[1].strain_energy;
        EXPECT_LT(peak(solutions[1]), 0.33 * peak(solutions[0])) << model.name;
        EXPECT_LT(peak(solutions[2]), 0.33 * peak(solutions[1])) << model.name;
        if (model.modes) {
            EXPECT_GT(model.modes({body, stiff}, 1).angular_frequency.front(),
                      1.5 * model.modes({body, alone}, 1).angular_frequency.front())
                << model.name;
        }
    }
    for (const auto *name : {"fem_p1", "fem_p2", "fem_p2p1", "fem_p2p1_refined", "nodal_springs", "lloyd",
                             "tled_quadratic", "xpbd_springs", "nodal_neo_hookean"})
        EXPECT_TRUE(names.contains(name)) << name;
    for (const auto *name : {"tled_quadratic", "fem_p2p1"})
        EXPECT_NEAR(stored[name] / stored["fem_p2"], 1.0, 0.2) << name;
}

/// The whole field of every second record: it begins with the static solution, and its probes are the probes.
TEST(EveryModel, ThatMovesKeepsFramesOfItsMotion) {
    const auto body = tests::make_body(tests::box_mesh({0.1, 0.05, 0.05}, {4, 1, 1}), tissue_of_all_laws);
    auto load_case = tests::empty_load_case(body->mesh);
    tests::prescribe(load_case, body->mesh, "x_min", core::Vector3::Zero());
    tests::pull(load_case, body->mesh, "x_max", {0.0, 0.0, 0.5});
    const int num_nodes = body->mesh.num_nodes();
    const core::Release release{52, 0.002, {1.0, 1e-4}, {{"tip", num_nodes - 1}, {"middle", num_nodes / 2}}};
    load_case.release = release;
    int num_moving = 0;
    for (const auto &model : models::all_models()) {
        const auto solution = model.solve({body, load_case});
        ASSERT_EQ(solution.status, core::SolutionStatus::ok) << model.name << ": " << solution.message;
        if (!solution.history)
            continue;
        ++num_moving;
        if (model.only_moving) { // what tells how good others are keeps the probes
            EXPECT_TRUE(solution.history->frames.empty()) << model.name;
            continue;
        }
        const auto &history = *solution.history;
        ASSERT_EQ(history.frames.size(), 27U * body->mesh.points.size()) << model.name;
        for (int i = 0; i < num_nodes; ++i)
            EXPECT_EQ(history.frames[i], solution.displacement[i].cast<float>()) << model.name;
        for (int frame = 0; frame < release.num_frames(); ++frame)
            for (int q = 0; q < 2; ++q)
                EXPECT_EQ(history.frames[frame * num_nodes + release.probes[q].node],
                          history.displacement[2 * frame * 2 + q].cast<float>())
                    << model.name << ", frame " << frame;
    }
    EXPECT_GE(num_moving, 3);
}

/// A body that is let go begins where the model itself is at rest under the whole load: its reactions balance the load
/// there, and springs and hyperelastic elements are not in proportion to it. Linear models are, all of the time.
TEST(EveryModel, IsLetGoFromItsOwnLargeEquilibrium) {
    const auto body = tests::make_body(tests::box_mesh({0.1, 0.03, 0.03}, {6, 2, 2}), tissue_of_all_laws);
    const int tip = body->mesh.num_nodes() - 1;
    const auto pulled = [&](double traction) {
        auto load_case = tests::empty_load_case(body->mesh);
        load_case.regime = core::Regime::large;
        load_case.path = {0.25, 0.5, 0.75, 1.0};
        tests::prescribe(load_case, body->mesh, "x_min", core::Vector3::Zero());
        tests::pull(load_case, body->mesh, "x_max", {0.0, 0.0, traction});
        load_case.release = core::Release{10, 0.005, {1.0, 1e-3}, {{"tip", tip}}};
        return core::Problem{body, load_case};
    };
    int num_linear = 0, num_others = 0;
    for (const auto &model : models::all_models()) {
        const auto half = model.solve(pulled(10.0)), whole = model.solve(pulled(20.0));
        ASSERT_EQ(whole.status, core::SolutionStatus::ok) << model.name << ": " << whole.message;
        if (!whole.history)
            continue;
        const double load = 20.0 * 0.03 * 0.03;
        EXPECT_NEAR(whole.reaction[0].z(), -load, 1e-6 * load) << model.name;
        const auto &from_half = half.history->displacement, &from_whole = whole.history->displacement;
        EXPECT_EQ(from_whole[0], whole.displacement[tip]) << model.name;
        EXPECT_EQ(whole.history->kinetic_energy[0], 0.0) << model.name;
        EXPECT_LT(from_whole[3].z(), from_whole[0].z()) << model.name;
        double out_of_proportion = 0.0;
        for (std::size_t k = 0; k < from_whole.size(); ++k)
            out_of_proportion = std::max(out_of_proportion, (from_whole[k] - 2.0 * from_half[k]).norm());
        out_of_proportion /= from_whole[0].norm();
        const bool is_linear = std::isnan(whole.nonlinearity);
        (is_linear ? num_linear : num_others) += 1;
        if (is_linear) {
            EXPECT_LT(out_of_proportion, 1e-9) << model.name;
        } else {
            EXPECT_GT(out_of_proportion, 1e-3) << model.name;
            EXPECT_EQ(whole.path.size(), model.only_moving ? 0U : 4U) << model.name;
        }
    }
    EXPECT_GE(num_linear, 2);
    EXPECT_GE(num_others, 5);
}

TEST(EveryModel, FollowsARigidTranslationOfAllThatIsPrescribed) {
    const auto body = tests::make_body(tests::box_mesh({0.1, 0.05, 0.05}, {4, 2, 2}), tissue_of_all_laws);
    auto load_case = tests::empty_load_case(body->mesh);
    const core::Vector3 shift(0.001, -0.002, 0.003);
    tests::prescribe(load_case, body->mesh, "x_min", shift);
    for (const auto &model : models::all_models()) {
        const auto solution = model.solve({body, load_case});
        ASSERT_EQ(solution.displacement.size(), body->mesh.points.size()) << model.name;
        for (const auto &displacement : solution.displacement)
            EXPECT_LT((displacement - shift).norm(), 1e-9 * shift.norm()) << model.name;
    }
}

} // namespace
} // namespace livermark

namespace livermark::models {
namespace {

constexpr double young = 5000.0, poisson = 0.45;

/// Mean over a ball of the displacement along a force of one newton that is spread over another ball, both with the
/// weight of a place, in a body without end [m/N]. Kelvin's field u = c (3 - 4 nu + cos^2) / d of a point force is
/// biharmonic, so the mean over a ball is u + <r^2> / 6 of its Laplacian c (2 - 6 cos^2) / d^3, and <r^2> is a third of
/// the radius squared. (A. E. H. Love, A Treatise on the Mathematical Theory of Elasticity, 1927, article 130)
/// @param cosine  of the angle between the force and the way to the other ball
double kelvin(double distance, double cosine, double radius) {
    const double shear = young / (2.0 * (1.0 + poisson));
    const double c = 1.0 / (16.0 * std::numbers::pi * shear * (1.0 - poisson));
    const double square = cosine * cosine;
    return c * ((3.0 - 4.0 * poisson + square) / distance +
                radius * radius / 9.0 * (2.0 - 6.0 * square) / std::pow(distance, 3));
}

/// The hold of the block at its sides takes away nearly the same everywhere near the force, and little of differences.
TEST(Compliance, InALargeBlockIsThatOfKelvin) {
    constexpr double radius = 0.01, side = 0.4;
    const auto body = tests::make_body(tests::box_mesh({side, side, side}, {16, 16, 16}), {1000.0, young, poisson});
    core::Problem problem{body, tests::empty_load_case(body->mesh)};
    for (const auto *patch : {"x_min", "x_max", "y_min", "y_max", "z_min", "z_max"})
        tests::prescribe(problem.load_case, body->mesh, patch, core::Vector3::Zero());
    const core::Vector3 middle(0.205, 0.195, 0.2);
    std::vector<core::InteriorPlace> places{{middle, radius}};
    for (const double distance : {0.03, 0.04, 0.06})
        for (const auto &way : {core::Vector3::UnitX(), core::Vector3::UnitY()})
            places.push_back({middle + distance * way, radius});
    const auto models = all_models();
    const auto found =
        support::find_named(models, std::string("fem_p2p1_refined"), "model").compliance(problem, places).matrix;
    const auto along = [&](int place) { return found(3 * place, 0); }; // for a force along x
    const double ahead = along(1) - along(5), beside = along(2) - along(6);
    EXPECT_NEAR(ahead, kelvin(0.03, 1.0, radius) - kelvin(0.06, 1.0, radius), 0.02 * ahead);
    EXPECT_NEAR(beside, kelvin(0.03, 0.0, radius) - kelvin(0.06, 0.0, radius), 0.02 * beside);
    EXPECT_NEAR(along(3) - along(5), kelvin(0.04, 1.0, radius) - kelvin(0.06, 1.0, radius), 0.02 * ahead);
}

} // namespace
} // namespace livermark::models

namespace livermark {
namespace {

using core::Vector3;

/// A rod that is held at one end, and bent by its other end.
core::Problem bent_rod(double poisson) {
    const auto mesh = tests::box_mesh({0.06, 0.03, 0.03}, {2, 1, 1});
    auto load_case = tests::empty_load_case(mesh);
    load_case.regime = core::Regime::large;
    tests::prescribe(load_case, mesh, "x_min", Vector3::Zero());
    tests::press(load_case, mesh, "x_max", {0.0, 0.0, -1.0}, 0.01);
    load_case.slow_history = {.relaxation = {.name = "two", .moduli = {0.3, 0.3}, .times = {0.4, 7.0}},
                              .times = {0.0, 0.5, 1.0, 2.0, 8.0, 30.0},
                              .factors = {0.0, 0.5, 1.0, 1.0, 1.0, 1.0}};
    return {tests::make_body(mesh, {1060.0, 5000.0, poisson}), load_case};
}

core::Solution solve_with(const std::string &name, const core::Problem &problem) {
    const auto models = models::all_models();
    return std::ranges::find(models, name, &core::Model::name)->solve(problem);
}

double force_at(const core::Solution &solution, std::size_t record) {
    return solution.path[record].reaction.back().norm();
}

TEST(LimitsOfAHistory, AreWhereItBeginsAndEnds) {
    const auto problem = bent_rod(0.45);
    auto endless = problem;
    endless.load_case.slow_history->times.back() = 1e9;
    const auto after_all = solve_with("fem_p2p1_neo_hookean", endless);
    const auto relaxed = solve_with("fem_p2p1_neo_hookean", models::relaxed_limit(problem));
    ASSERT_EQ(relaxed.status, core::SolutionStatus::ok) << relaxed.message;
    EXPECT_NEAR(relaxed.reaction.back().norm(), after_all.reaction.back().norm(),
                1e-5 * relaxed.reaction.back().norm());
    EXPECT_LT(relaxed.reaction.back().norm(), 0.6 * force_at(after_all, 2));
}

/// The bar is that of the mesh: a finer one is within it, and not by much more than it has to be.
TEST(LimitsOfAHistory, BoundWhatAFinerMeshMakesOfIt) {
    const auto problem = bent_rod(0.45);
    const auto solution = solve_with("fem_p2p1_neo_hookean_refined", problem);
    ASSERT_EQ(solution.status, core::SolutionStatus::ok) << solution.message;
    ASSERT_TRUE(solution.observed_error) << solution.solver;
    const auto &bar = *solution.observed_error;
    const auto finer = core::refine_at_rims(core::refine_at_rims(problem).problem).problem;
    auto expected = solve_with("fem_p2p1_neo_hookean", finer);
    expected.displacement.resize(problem.body->mesh.points.size());
    for (auto &point : expected.path)
        point.displacement.resize(problem.body->mesh.points.size());
    const auto comparison = core::compare(problem.body->mesh, problem.load_case, solution, expected, "on a finer mesh");
    EXPECT_LT(comparison.relative_l2, bar.relative_l2);
    EXPECT_GT(comparison.relative_l2, 0.1 * bar.relative_l2);
    ASSERT_TRUE(bar.stiffness);
    for (std::size_t record = 2; record < expected.path.size(); ++record)
        EXPECT_LT(std::abs(force_at(solution, record) / force_at(expected, record) - 1.0), *bar.stiffness) << record;
}

/// A rod that is held at one end, along a path of large loads.
core::Problem held_rod() {
    core::Problem rod{tests::make_body(tests::box_mesh({0.06, 0.03, 0.03}, {2, 1, 1}), {1060.0, 5000.0, 0.45}), {}};
    rod.load_case = tests::empty_load_case(rod.body->mesh);
    rod.load_case.regime = core::Regime::large;
    rod.load_case.path = {0.5, 1.0};
    tests::prescribe(rod.load_case, rod.body->mesh, "x_min", Vector3::Zero());
    return rod;
}

/// One of each kind of load that there is.
std::vector<std::pair<std::string, core::Problem>> kinds_of_large_loads() {
    std::vector<std::pair<std::string, core::Problem>> kinds;
    const auto add = [&](const std::string &name, const auto &load) {
        auto rod = held_rod();
        load(rod.load_case, rod.body->mesh);
        kinds.emplace_back(name, rod);
    };
    using core::LoadCase, core::TetraMesh;
    add("force", [](LoadCase &on, const TetraMesh &mesh) { tests::pull(on, mesh, "x_max", {0.0, 0.0, 60.0}); });
    add("way", [](LoadCase &on, const TetraMesh &mesh) { tests::prescribe(on, mesh, "x_max", {5e-3, 0.0, 5e-3}); });
    add("depth", [](LoadCase &on, const TetraMesh &mesh) { tests::press(on, mesh, "x_max", {0.0, 0.0, -1.0}, 5e-3); });
    add("gas", [](LoadCase &on, const TetraMesh &mesh) {
        std::vector<int> top;
        for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
            if (mesh.patch_names[static_cast<std::size_t>(mesh.boundary_patch[f])] == "z_max")
                top.push_back(f);
        on.put({"gas", core::ConditionKind::pressure}, top, {0.0, 0.0, -100.0});
    });
    add("gravity", [](LoadCase &on, const TetraMesh & /*mesh*/) { on.acceleration = {0.0, 0.0, -2.0}; });
    tests::TouchedBlock block;
    block.path = {0.5, 1.0};
    kinds.emplace_back("ball", tests::touched_block(block));
    return kinds;
}

/// Every number that models are compared in has a bar, and the stiffness at the tool wherever there is a tool.
TEST(BarsOfLargeLoads, AreThereForEachKindOfLoad) {
    std::set<std::string> without_tool;
    for (const auto &[kind, problem] : kinds_of_large_loads()) {
        SCOPED_TRACE(kind);
        const auto solution = solve_with("fem_p2p1_neo_hookean_refined", problem);
        ASSERT_EQ(solution.status, core::SolutionStatus::ok) << solution.message;
        ASSERT_TRUE(solution.observed_error) << solution.solver;
        const auto &bar = *solution.observed_error;
        EXPECT_EQ(bar.load_fraction, 1.0);
        EXPECT_GT(bar.relative_l2, 0.0);
        EXPECT_GT(bar.energy, 0.0);
        EXPECT_GE(bar.reaction, 0.0); // rounding where equilibrium gives the reaction
        const bool has_tool = !core::tool_places(problem.body->mesh, problem.load_case).empty();
        EXPECT_EQ(bar.stiffness.has_value(), has_tool);
        if (!has_tool)
            without_tool.insert(kind);
        else
            EXPECT_GT(bar.stiffness.value_or(0.0), 0.0);
    }
    EXPECT_EQ(without_tool, std::set<std::string>{"gravity"});
}

} // namespace
} // namespace livermark
