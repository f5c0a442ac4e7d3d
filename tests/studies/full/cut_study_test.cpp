#include "studies/cutting/cut_study.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <utility>

#include "core/support/input_error.hpp"
#include "msm/springs/springs.hpp"
#include "results/records/cut.hpp"
#include "studies/advise/advise.hpp"
#include "studies/models/model_table.hpp"
#include "tests/bad_input.hpp"
#include "tests/samples/small_bar.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark::studies {
namespace {

using core::Vector3;

/// A double cantilever beam: two arms of the height h, length a and width B, that loads P bend apart.
struct DoubleCantilever {
    static constexpr double length = 0.12, width = 0.01, h = 0.01, load = 1e-5;
    core::Material material{1000.0, 5000.0, 0.3};

    std::shared_ptr<const core::Body> body(int bricks_per_arm) const {
        auto mesh = tests::box_mesh({length, width, 2.0 * h}, {static_cast<int>(bricks_per_arm * length / h),
                                                               bricks_per_arm, 2 * bricks_per_arm});
        mesh.patch_names.emplace_back("upper_end");
        for (int f = 0; f < mesh.num_boundary_triangles(); ++f) {
            double z = 0.0;
            for (const int node : mesh.boundary_triangles[f])
                z += mesh.points[node].z() / 3.0;
            if (mesh.boundary_patch[f] == 0 && z > h)
                mesh.boundary_patch[f] = static_cast<int>(mesh.patch_names.size()) - 1;
        }
        return tests::make_body(std::move(mesh), material);
    }

    /// G = 12 P^2 (a + chi h)^2 / (E B^2 h^3) with Williams's chi for what gives way at the root of an arm. (Hashemi,
    /// Kinloch, Williams 1990, Proc. R. Soc. Lond. A 427) Over the area cut between two lengths, its integral [J].
    double released(double from, double to) const {
        const double shear = material.shear_modulus(), gamma = 1.18 * material.young_modulus / shear;
        const double part = gamma / (1.0 + gamma);
        const double chi = std::sqrt(material.young_modulus / (11.0 * shear) * (3.0 - 2.0 * part * part));
        const auto cube = [&](double a) { return std::pow(a + chi * h, 3) / 3.0; };
        return 12.0 * load * load / (material.young_modulus * width * std::pow(h, 3)) * (cube(to) - cube(from));
    }

    /// The blade from the free end on, between the arms.
    BladeWay cut_to(double length_of_cut, int num_steps) const {
        return {{Vector3(-0.01, -0.01, h), Vector3(-0.01, 0.1, h), Vector3(length_of_cut, 0.1, h),
                 Vector3(length_of_cut, -0.01, h)},
                num_steps};
    }

    core::Problem loaded(const CutStage &stage) const {
        const auto &mesh = stage.body->mesh;
        auto load_case = tests::empty_load_case(mesh);
        tests::prescribe(load_case, mesh, "x_max", Vector3::Zero());
        const double traction = load / (width * h);
        tests::pull(load_case, mesh, "upper_end", {0.0, 0.0, traction});
        tests::pull(load_case, mesh, "x_min", {0.0, 0.0, -traction});
        return {stage.body, std::move(load_case)};
    }

    /// Energy that a model stores with the cut as long as that: as much as the loads have done beside it [J].
    double stored(const core::Model &model, const CutStage &stage) const {
        const auto solution = model.solve(loaded(stage));
        EXPECT_EQ(solution.status, core::SolutionStatus::ok) << solution.message;
        return solution.strain_energy;
    }
};

TEST(GrowingCuts, OfADoubleCantileverSetFreeWhatBeamsDo) {
    const DoubleCantilever beam;
    const auto all = models::all_models();
    const auto &model = support::find_named(all, std::string("fem_p2p1"), "model");
    constexpr double from = 0.05, to = 0.07;
    const auto way = beam.cut_to(to, 4);
    std::vector<double> errors;
    for (const int bricks_per_arm : {1, 2}) {
        const auto stages = grow_cut(beam.body(bricks_per_arm), way, {});
        ASSERT_EQ(stages.size(), 5U);
        const auto &early = stages[3], &late = stages[4];
        ASSERT_NEAR(early.area, from * beam.width, 1e-9);
        ASSERT_NEAR(late.area, to * beam.width, 1e-9);
        const double released = beam.stored(model, late) - beam.stored(model, early);
        errors.push_back(released / beam.released(from, to) - 1.0);
    }
    EXPECT_LT(std::abs(errors[1]), 0.05);
    EXPECT_LT(std::abs(errors[1]), std::abs(errors[0])) << errors[0] << " and " << errors[1];
}

CutStudyOptions options_of_cut_bar(const std::string &suite) {
    const auto folder = tests::folder_with_bar(suite, 0.01);
    tests::write_pull(folder, "pull", 2.0);
    CutStudyOptions options;
    options.body = (folder / "bar.toml").string();
    options.load_case = (folder / "pull.toml").string();
    options.output = (folder / "runs").string();
    return options;
}

/// Across the bar at half its length, from above to half its height.
void put_blade_across(CutStudyOptions &options) {
    const auto mesh = meshes::read_body(options.body).mesh;
    Vector3 low = mesh.points.front(), high = low;
    for (const auto &point : mesh.points) {
        low = low.cwiseMin(point);
        high = high.cwiseMax(point);
    }
    const double x = 0.5 * (low.x() + high.x()) + 1e-4, more = 0.01, z = 0.5 * (low.z() + high.z()) - 1e-4;
    options.blade = {x, low.y() - more,  high.z() + more,
                     x, high.y() + more, high.z() + more,
                     x, high.y() + more, z,
                     x, low.y() - more,  z};
}

TEST(GrowingCuts, SetFreeAsMuchAsTheyStoreUnderConstantLoads) {
    auto options = options_of_cut_bar("cut_study");
    put_blade_across(options);
    options.num_steps = 3;
    options.models = {"fem_p1", "nodal_springs"};
    const auto done = let_blade_in(options, "test", {});
    const auto &file = done.file;
    ASSERT_EQ(file.num_records(), 4U);
    ASSERT_EQ(file.runs.size(), 3U);
    EXPECT_EQ(file.runs[0].model, "fem_p2p1");
    EXPECT_GT(file.area.back(), 0.0);
    for (const auto &run : file.runs) {
        // What is linear stores half of what its loads do (Clapeyron), with and without the cut.
        const double stored = run.stored.back() - run.stored.front();
        EXPECT_GT(stored, 0.0) << run.model;
        EXPECT_NEAR(run.released(3), stored, (run.model == "nodal_springs" ? 0.02 : 1e-6) * stored) << run.model;
        EXPECT_EQ(run.opening.front(), 0.0) << run.model;
        EXPECT_GT(run.opening.back(), 0.0) << run.model;
        for (std::size_t k = 1; k < file.num_records(); ++k)
            EXPECT_GE(run.released(k), run.released(k - 1) * (1.0 - 1e-9)) << run.model << k;
    }
    // The free end gives way further where the bar is cut, and what pulls at it does more work: none is stiffer.
    for (const auto &run : file.runs) {
        EXPECT_LT(run.tool_stiffness.back(), run.tool_stiffness.front()) << run.model;
        EXPECT_GT(run.tool_stiffness.back(), 0.0) << run.model;
        for (std::size_t k = 0; k < file.num_records(); ++k)
            EXPECT_GE(run.solve_seconds[k], run.setup_seconds[k]) << run.model;
    }
    // Of springs alone: before, along facets, and exactly, where tetrahedra are split and steps get shorter.
    EXPECT_TRUE(file.runs[0].critical_time_step.empty());
    EXPECT_TRUE(file.runs[1].critical_time_step.empty());
    const auto &steps = file.runs[2].critical_time_step;
    ASSERT_EQ(steps.size(), 3U);
    const auto bar = meshes::read_body(options.body);
    const auto known = models::all_models();
    const auto springs = models::springs_of(support::find_named(known, std::string("nodal_springs"), "model"),
                                            std::make_shared<const core::Body>(bar));
    EXPECT_NEAR(steps[0], critical_time_step(bar, springs.value().body), 1e-9 * steps[0]);
    EXPECT_GT(steps[1], 0.2 * steps[0]);
    EXPECT_LT(steps[2], steps[0]);
    const auto read = results::read_cut_file(std::filesystem::path(options.output) / file.body / "cut.pull.h5");
    EXPECT_EQ(read.runs[2].critical_time_step, steps);
    EXPECT_EQ(read.area, file.area);
    EXPECT_EQ(read.runs[2].work, file.runs[2].work);
    EXPECT_EQ(read.cut_seconds, file.cut_seconds);
}

/// The opening of a double cantilever on coarse meshes that are finer at the rim alone, and the error that they say,
/// beside a mesh that is four times finer everywhere. What refinement at the rim leaves as it is, is not in the error,
/// so it is right to a factor of two.
TEST(GrowingCuts, KnowHowFarTheReferenceIsFromFinerMeshes) {
    const DoubleCantilever beam;
    const auto all = models::all_models();
    const auto &model = support::find_named(all, std::string("fem_p2p1"), "model");
    constexpr double to = 0.06;
    const auto way = beam.cut_to(to, 1);
    const auto levels_on = [&](int bricks_per_arm, int times) {
        const auto stage = grow_cut(beam.body(bricks_per_arm), way, {}).back();
        std::string failure;
        auto levels = solve_finer_at_wound(
            model, way, "facets", stage, beam.loaded(stage), times, [] {}, failure);
        EXPECT_EQ(failure, "");
        return levels;
    };
    results::CutFile file;
    file.levels = levels_on(1, 2);
    ASSERT_EQ(file.levels.size(), 3U);
    EXPECT_NEAR(file.levels.back().depth, to + 0.01, 1e-9);
    for (std::size_t k = 1; k < file.levels.size(); ++k)
        EXPECT_GT(file.levels[k].tetrahedra, file.levels[k - 1].tetrahedra);
    const auto fine = levels_on(4, 1).back();
    for (const auto number : {&results::CutLevel::opening, &results::CutLevel::tool_stiffness}) {
        const auto bar = file.in_the_end("facets", number);
        ASSERT_TRUE(bar);
        EXPECT_GT(bar->error, 0.0);
        EXPECT_LT(bar->error, 0.05 * bar->value);
        const double left = std::abs(bar->value - fine.*number);
        EXPECT_LT(left, 2.0 * bar->error);
        EXPECT_GT(left, 0.5 * bar->error);
        EXPECT_LT(left, 0.25 * std::abs(file.levels.front().*number - fine.*number));
    }
}

/// Under small loads nothing is nonlinear; under large ones it is. The bodies are those of the small regime.
TEST(GrowingCuts, AreJudgedInTheLargeRegimeOnTheBodiesOfTheSmallOne) {
    auto options = options_of_cut_bar("large_cut_study");
    put_blade_across(options);
    options.num_steps = 1;
    options.num_refined = 0;
    options.models = {"nodal_springs"};
    const auto opening_at = [&](double traction, std::optional<core::Regime> regime) {
        tests::write_pull(std::filesystem::path(options.load_case).parent_path(), "pull", traction);
        options.regime = regime;
        const auto done = let_blade_in(options, "test", {});
        EXPECT_EQ(done.file.regime, regime.value_or(core::Regime::small));
        EXPECT_EQ(done.file.runs.front().model, regime ? "fem_p2p1_neo_hookean" : "fem_p2p1");
        EXPECT_TRUE(done.file.levels.empty());
        return std::pair{done.file.runs.front().opening.back(), done.file.nodes};
    };
    const auto large = core::Regime::large;
    const auto [small_linear, nodes] = opening_at(0.002, std::nullopt);
    const auto [small_loads, same_nodes] = opening_at(0.002, large);
    EXPECT_EQ(nodes, same_nodes);
    EXPECT_NEAR(small_loads, small_linear, 1e-3 * small_linear);
    const double linear = opening_at(20.0, std::nullopt).first, nonlinear = opening_at(20.0, large).first;
    EXPECT_NEAR(linear, 1e4 * small_linear, 1e-6 * linear);
    EXPECT_GT(std::abs(nonlinear - linear), 0.02 * linear);
    const auto folder = std::filesystem::path(options.output) / "bar";
    EXPECT_EQ(results::read_cut_file(folder / "cut.pull.h5").regime, core::Regime::small);
    EXPECT_EQ(results::read_cut_file(folder / "cut.pull.large.h5").regime, core::Regime::large);
}

TEST(GrowingCuts, MoveAndAreRefinedInBothRegimes) {
    auto options = options_of_cut_bar("moving_cut_study");
    put_blade_across(options);
    options.num_steps = 2;
    options.models = {"nodal_springs"};
    options.motion.methods = {"nodal_springs"};
    for (const auto regime : {core::Regime::small, core::Regime::large}) {
        options.regime = regime;
        const auto file = let_blade_in(options, "test", {}).file;
        ASSERT_EQ(file.motions.size(), 1U);
        // The same springs, moving and at rest.
        EXPECT_NEAR(file.motions[0].opening.back(), file.runs[1].opening.back(), 0.01 * file.runs[1].opening.back());
        for (const char *way : {"facets", "exact"}) {
            const auto bar = file.in_the_end(way, &results::CutLevel::opening);
            ASSERT_TRUE(bar) << way;
            EXPECT_GT(bar->error, 0.0) << way;
            EXPECT_LT(bar->error, 0.2 * bar->value) << way;
        }
        EXPECT_EQ(file.levels.front().opening, file.runs.front().opening.back());
        EXPECT_EQ(file.levels.front().area, file.area.back());
    }
}

/// Springs that move come to rest where the same springs do that are cut at rest, and a capsule holds the wound
/// together beside the cut.
TEST(GrowingCuts, OpenACapsuleInMotion) {
    auto options = options_of_cut_bar("covered_cut_study");
    put_blade_across(options);
    options.num_steps = 2;
    options.num_refined = 0;
    options.models = {"nodal_springs", "lloyd"};
    options.motion.methods = {"nodal_springs", "lloyd"};
    const auto plain = let_blade_in(options, "test", {}).file;
    options.output += "_covered";
    std::ofstream(options.body, std::ios::app) << "[capsule]\nthickness = 1e-4\nyoung_modulus = 1e6\n";
    const auto file = let_blade_in(options, "test", {}).file;
    ASSERT_EQ(file.motions.size(), 2U);
    for (const auto &motion : file.motions) {
        const auto &run = *std::ranges::find(file.runs, motion.method, &results::CutRun::model);
        const auto &without = *std::ranges::find(plain.runs, motion.method, &results::CutRun::model);
        EXPECT_NEAR(motion.opening.back(), run.opening.back(), 0.01 * run.opening.back()) << motion.method;
        EXPECT_GT(run.opening.back(), 0.0) << motion.method;
        EXPECT_LT(run.opening.back(), without.opening.back()) << motion.method;
    }
}

TEST(GrowingCuts, RefuseWhatIsNoBladeAndLoadsThatChange) {
    auto options = options_of_cut_bar("bad_cut_study");
    const auto fails = [&](const std::string &what) {
        tests::expect_input_error([&] { let_blade_in(options, "test", {}); }, {what});
    };
    options.blade = {0.0, 0.0, 0.0};
    fails("give four corners");
    put_blade_across(options);
    options.num_steps = 0;
    fails("--steps is 0");
    options.num_steps = 2;
    options.toughness = -1.0;
    fails("--toughness");
    options.toughness = 164.0;
    options.num_refined = 1;
    fails("--refine is 1");
    options.num_refined = 0;
    options.models = {"no_such_model"};
    fails("no_such_model");
    options.models = {"fem_p1_neo_hookean"};
    fails("takes no part in load case pull in the small regime");
    options.models = {};
    options.motion.methods = {"tlde"};
    fails("did you mean 'tled'?");
    options.motion.methods = {};
    const auto large = std::filesystem::path(options.load_case).parent_path() / "large.toml";
    std::ofstream(large) << "title = \"large\"\nregime = \"large\"\ntarget_peak_displacement = 0.01\n[[condition]]\n"
                            "patch = \"x_min\"\ndisplacement = [0.0, 0.0, 0.0]\n[[condition]]\npatch = \"x_max\"\n"
                            "force = [0.001, 0.0, 0.0]\n";
    const auto small = std::exchange(options.load_case, large.string());
    options.regime = core::Regime::small;
    fails("leave --regime out");
    options.regime.reset();
    options.motion.methods = {"tled"};
    fails("with --regime large if deformations are large");
    options.motion.methods = {};
    options.load_case = small;
    options.models = {};
    for (auto k : {0U, 3U, 6U, 9U})
        options.blade[k] += 10.0;
    fails("parts no face");
    const auto pressed = std::filesystem::path(options.load_case).parent_path() / "press.toml";
    std::ofstream(pressed) << "title = \"press\"\n[[condition]]\npatch = \"x_min\"\ndisplacement = [0.0, 0.0, "
                              "0.0]\n[[condition]]\npatch = \"x_max\"\npress = 0.001\n";
    options.load_case = pressed.string();
    fails("loads that change");
}

} // namespace
} // namespace livermark::studies
