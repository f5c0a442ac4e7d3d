#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <gtest/gtest.h>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/support/input_error.hpp"
#include "results/hdf5/references.hpp"
#include "results/hdf5/result_file.hpp"
#include "results/problem_key.hpp"
#include "studies/run/solutions.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

namespace fs = std::filesystem;
constexpr auto *name = "fem_p2p1_neo_hookean";

core::Problem pulled() {
    auto body = tests::make_body(tests::box_mesh({0.1, 0.05, 0.05}, {3, 2, 2}), {1060.0, 5e3, 0.45});
    auto load_case = tests::empty_load_case(body->mesh);
    load_case.name = "pull";
    load_case.regime = core::Regime::large;
    load_case.path = {0.5, 1.0};
    tests::prescribe(load_case, body->mesh, "x_min", core::Vector3::Zero());
    tests::prescribe(load_case, body->mesh, "x_max", {0.02, 0.0, 0.0});
    return {body, std::move(load_case)};
}

/// The same, let go.
core::Problem let_go() {
    auto problem = pulled();
    auto &load_case = problem.load_case;
    load_case = tests::empty_load_case(problem.body->mesh);
    load_case.name = "let_go";
    load_case.regime = core::Regime::large;
    load_case.path = {0.5, 1.0};
    tests::prescribe(load_case, problem.body->mesh, "x_min", core::Vector3::Zero());
    tests::pull(load_case, problem.body->mesh, "x_max", {0.0, 0.0, 50.0});
    load_case.release = core::Release{5, 0.01, {1.0, 1e-3}, {{"tip", problem.body->mesh.num_nodes() - 1}}};
    return problem;
}

core::Model model_to_store(const std::string &wanted) {
    for (auto &model : studies::models_to_keep())
        if (model.name == wanted)
            return model;
    throw std::logic_error(wanted + " is not stored");
}

class StoredReferences : public testing::Test {
  protected:
    void SetUp() override { fs::create_directories(folder); }
    void TearDown() override { fs::remove_all(folder); }

    core::Solution solve_with_kept(const core::Problem &problem, const std::string &model = name) const {
        return studies::PreparedModels(studies::SolutionCache(folder)).solve(model_to_store(model), problem);
    }

    fs::path folder = fs::path(testing::TempDir()) / "livermark_stored_references" /
                      testing::UnitTest::GetInstance()->current_test_info()->name(); // several run at a time
    core::Problem problem = pulled();
};

TEST_F(StoredReferences, AreReadWhereTheyFitAndSaySo) {
    const auto solved = solve_with_kept(problem);
    EXPECT_EQ(solved.solver.find("stored since"), std::string::npos);
    const auto stored = studies::solve_and_store(model_to_store(name), problem, folder, false, "test");
    EXPECT_EQ(stored.status, core::SolutionStatus::ok);
    EXPECT_EQ(studies::SolutionCache(folder).where(model_to_store(name), problem), "stored");
    const auto read = solve_with_kept(problem);
    EXPECT_TRUE(read.solver.starts_with("stored since 20")) << read.solver;
    EXPECT_EQ(read.displacement, solved.displacement);
    EXPECT_EQ(read.reaction, solved.reaction);
    ASSERT_EQ(read.path.size(), 2U);
    EXPECT_EQ(read.path.front().displacement, solved.path.front().displacement);
}

/// Those on finer meshes are stored in both regimes, with the work of the loads and the error bar, and of small
/// deformations no other.
TEST_F(StoredReferences, AreThoseOfFinerMeshes) {
    auto small = pulled();
    auto &load_case = small.load_case;
    load_case = tests::empty_load_case(small.body->mesh);
    load_case.name = "drag";
    tests::prescribe(load_case, small.body->mesh, "x_min", core::Vector3::Zero());
    tests::pull(load_case, small.body->mesh, "x_max", {10.0, 0.0, 0.0});
    const auto model = model_to_store("fem_p2p1_refined");
    ASSERT_TRUE(studies::is_stored(model, small));
    EXPECT_FALSE(studies::is_stored(model_to_store(name), small));
    EXPECT_TRUE(
        std::ranges::none_of(studies::models_to_keep(), [](const core::Model &one) { return one.name == "fem_p2p1"; }));
    const auto solved = solve_with_kept(small, model.name);
    studies::solve_and_store(model, small, folder, false, "test");
    const auto read = solve_with_kept(small, model.name);
    EXPECT_TRUE(read.solver.starts_with("stored since 20")) << read.solver;
    EXPECT_EQ(read.displacement, solved.displacement);
    EXPECT_EQ(read.strain_energy, solved.strain_energy);
    EXPECT_EQ(read.reaction, solved.reaction);
    EXPECT_GT(read.load_work, 0.0);
    EXPECT_EQ(read.load_work, solved.load_work);
    ASSERT_TRUE(read.observed_error);
    EXPECT_EQ(read.observed_error, solved.observed_error);
}

/// Of a motion the probes are stored, and the model that judges motion is stored where something moves.
TEST_F(StoredReferences, HoldTheMotionOfTheProbes) {
    const auto model = model_to_store("fem_p2_neo_hookean");
    const auto moving = let_go();
    EXPECT_FALSE(studies::is_stored(model, problem));
    ASSERT_TRUE(studies::is_stored(model, moving));
    const auto solved = solve_with_kept(moving, model.name);
    ASSERT_TRUE(solved.history);
    EXPECT_EQ(solved.history->frames.size(), 6 * moving.body->mesh.points.size());
    studies::solve_and_store(model, moving, folder, false, "test");
    const auto read = solve_with_kept(moving, model.name);
    EXPECT_TRUE(read.solver.starts_with("stored since 20")) << read.solver;
    ASSERT_TRUE(read.history);
    EXPECT_EQ(read.history->time, solved.history->time);
    EXPECT_EQ(read.history->displacement, solved.history->displacement);
    EXPECT_EQ(read.history->strain_energy, solved.history->strain_energy);
    EXPECT_TRUE(read.history->frames.empty());
    EXPECT_EQ(studies::solve_and_store(model, moving, folder, true, "test").motion_difference, 0.0);

    auto longer = moving;
    longer.load_case.release->num_steps = 6;
    EXPECT_NE(results::fingerprint(longer, model.name), results::fingerprint(moving, model.name));
    longer = moving;
    longer.load_case.release->damping.beta *= 2.0;
    EXPECT_NE(results::fingerprint(longer, model.name), results::fingerprint(moving, model.name));
}

TEST_F(StoredReferences, AreNotTakenForAnotherProblem) {
    const auto before = results::fingerprint(problem, name);
    const auto changed = [&](const std::function<void(core::Body &, core::LoadCase &)> &change) {
        auto body = *problem.body;
        auto load_case = problem.load_case;
        change(body, load_case);
        return results::fingerprint({std::make_shared<const core::Body>(std::move(body)), std::move(load_case)}, name);
    };
    EXPECT_EQ(changed([](auto &, auto &) {}), before);
    EXPECT_EQ(changed([](auto &body, auto &) { body.mesh.points[3].x() += 1e-18; }), before); // rounding
    EXPECT_NE(changed([](auto &body, auto &) { body.mesh.points[3].x() += 1e-6; }), before);
    EXPECT_NE(changed([](auto &body, auto &) { body.materials[0].poisson_ratio = 0.46; }), before);
    EXPECT_NE(changed([](auto &, auto &load_case) { load_case.path = {0.4, 1.0}; }), before);
    EXPECT_NE(changed([](auto &, auto &load_case) { load_case = core::scaled(load_case, 1.1); }), before);
    EXPECT_NE(changed([](auto &, auto &load_case) { load_case.acceleration.z() = 1.0; }), before);
    EXPECT_NE(results::fingerprint(problem, "another_model"), before);
}

TEST_F(StoredReferences, AreComparedWhenTheyAreChecked) {
    const auto model = model_to_store(name);
    EXPECT_TRUE(std::isnan(studies::solve_and_store(model, problem, folder, true, "test").difference));
    EXPECT_EQ(studies::SolutionCache(folder).where(model, problem), "");
    auto wrong = model.solve(problem);
    wrong.displacement.back() *= 1.5;
    const auto file = results::reference_path(folder, problem, name);
    fs::create_directories(file.parent_path());
    results::write_reference(file, wrong, problem, name, {});
    EXPECT_GT(studies::solve_and_store(model, problem, folder, true, "test").difference, 1e-3);
    studies::solve_and_store(model, problem, folder, false, "test");
    EXPECT_LT(studies::solve_and_store(model, problem, folder, true, "test").difference, 1e-9);
}

/// Problems in result files are those of the stored references, also where a round tool presses.
TEST_F(StoredReferences, FitProblemsOfResultFiles) {
    auto &load_case = problem.load_case;
    load_case = tests::empty_load_case(problem.body->mesh);
    load_case.name = "press";
    load_case.regime = core::Regime::large;
    load_case.path = {0.1, 0.3, 1.0};
    tests::prescribe(load_case, problem.body->mesh, "x_min", core::Vector3::Zero());
    tests::pull(load_case, problem.body->mesh, "x_max", {-1.0 / 3.0, 0.0, 0.0});
    load_case.conditions.back().kind = core::ConditionKind::press;
    load_case.conditions.back().round = core::RoundLoad{{0.1, 0.025, 0.02}, 0.03};
    load_case.press_depth = 0.007;
    core::Solution solution;
    solution.displacement.assign(problem.body->mesh.points.size(), core::Vector3::Zero());
    solution.reaction.assign(2, core::Vector3::Zero());
    results::write_result(folder / "press.h5", {{}, problem, {{name, {}, {}, solution, {}}}});
    const auto read = results::read_result(folder / "press.h5", results::Origin::own);
    EXPECT_EQ(results::fingerprint(read.problem, name), results::fingerprint(problem, name));
}

TEST_F(StoredReferences, ThatAreDamagedAreRefused) {
    const auto file = results::reference_path(folder, problem, name);
    fs::create_directories(file.parent_path());
    std::ofstream(file) << "no HDF5";
    EXPECT_THROW(solve_with_kept(problem), support::InputError);
}

} // namespace
} // namespace livermark
