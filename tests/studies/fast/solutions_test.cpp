#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <gtest/gtest.h>
#include <memory>
#include <stdexcept>
#include <string>
#include <unistd.h>
#include <vector>

#include "core/support/input_error.hpp"
#include "results/hdf5/references.hpp"
#include "results/hdf5/result_file.hpp"
#include "studies/run/run.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark::studies {
namespace {

namespace fs = std::filesystem;

core::Problem pulled(double traction) {
    auto body = tests::make_body(tests::box_mesh({0.1, 0.05, 0.05}, {2, 1, 1}), {1060.0, 5e3, 0.3});
    auto load_case = tests::empty_load_case(body->mesh);
    load_case.name = "pull";
    tests::prescribe(load_case, body->mesh, "x_min", core::Vector3::Zero());
    tests::pull(load_case, body->mesh, "x_max", {traction, 0.0, 0.0});
    return {std::move(body), std::move(load_case)};
}

/// All nodes moved by a third of the traction, which has no few digits.
core::Solution moved(const core::Problem &problem) {
    double traction = 0.0;
    for (const auto &value : problem.load_case.value)
        traction = std::max(traction, value.x());
    core::Solution solution;
    solution.displacement.assign(problem.body->mesh.points.size(), {traction / 3.0, 0.0, 0.0});
    solution.reaction.assign(problem.load_case.num_constraints(), {-traction, 0.0, 0.0});
    solution.strain_energy = traction / 7.0;
    return solution;
}

/// A folder of a run, which is not there at first.
class SolutionsOfARun : public testing::Test {
  protected:
    void SetUp() override { fs::remove_all(output); }
    void TearDown() override { fs::remove_all(output); }

    SolutionCache cache() const {
        SolutionCache cache;
        cache.keep_in(output, "settings");
        return cache;
    }

    /// A model that counts what it prepares and solves.
    core::Model counting() {
        core::Model model;
        model.name = "counting";
        model.prepare = [this](const std::shared_ptr<const core::Body> &body, const core::LoadCase *common) {
            ++num_prepared;
            return core::solves_each([this](const core::Problem &problem) {
                ++num_solved;
                return moved(problem);
            })(body, common);
        };
        return model;
    }

    fs::path output = fs::path(testing::TempDir()) / ("livermark_solutions_" + std::to_string(getpid()) +
                                                      testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::path folder = output / ".solutions";
    int num_prepared = 0, num_solved = 0;
};

TEST_F(SolutionsOfARun, AreFoundAgainToTheLastBit) {
    const auto problem = pulled(10.0);
    const auto model = counting();
    EXPECT_FALSE(cache().find(model, problem));
    EXPECT_EQ(cache().where(model, problem), "");
    cache().keep(model, problem, moved(problem));
    EXPECT_EQ(cache().where(model, problem), "kept");
    const auto found = cache().find(model, problem);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->displacement, moved(problem).displacement);
    EXPECT_EQ(found->strain_energy, moved(problem).strain_energy);
}

TEST_F(SolutionsOfARun, AreThoseOfOneModelAndProblem) {
    const auto problem = pulled(10.0);
    const auto model = counting();
    cache().keep(model, problem, moved(problem));
    const auto is_known = [&](const std::function<void(core::Body &, core::LoadCase &)> &change) {
        auto body = *problem.body;
        auto load_case = problem.load_case;
        change(body, load_case);
        return cache()
            .find(model, {std::make_shared<const core::Body>(std::move(body)), std::move(load_case)})
            .has_value();
    };
    EXPECT_TRUE(is_known([](auto &, auto &) {}));
    EXPECT_FALSE(is_known([](auto &body, auto &) { body.mesh.points[3].x() += 1e-15; }));
    EXPECT_FALSE(is_known([](auto &body, auto &) { body.materials[0].poisson_ratio = 0.31; }));
    EXPECT_FALSE(is_known([](auto &, auto &load_case) { load_case = core::scaled(load_case, 1.5); }));
    EXPECT_FALSE(is_known([](auto &, auto &load_case) { load_case.acceleration.z() = 1.0; }));
    EXPECT_FALSE(is_known([](auto &, auto &load_case) { load_case.definition = "another"; }));
    EXPECT_FALSE(is_known([](auto &, auto &load_case) { load_case.name = "another"; }));
    EXPECT_FALSE(
        is_known([](auto &, auto &load_case) { load_case.conditions.back().kind = core::ConditionKind::pressure; }));
    EXPECT_FALSE(is_known([](auto &, auto &load_case) { load_case.touching = core::TouchingTool{.shape = 0.01}; }));
    EXPECT_FALSE(is_known([](auto &, auto &load_case) { load_case.path = {0.5, 1.0}; }));
    EXPECT_FALSE(is_known([](auto &, auto &load_case) { load_case.release.emplace().num_steps = 3; }));
    EXPECT_FALSE(is_known([](auto &, auto &load_case) {
        load_case.slow_history = core::SlowHistory{.relaxation = {}, .times = {0.0, 1.0}, .factors = {0.0, 1.0}};
    }));
    auto other = model;
    other.name = "other";
    EXPECT_FALSE(cache().find(other, problem));
    SolutionCache otherwise;
    otherwise.keep_in(output, "other settings");
    EXPECT_FALSE(otherwise.find(model, problem));
}

TEST_F(SolutionsOfARun, ThatAreDamagedAreNone) {
    const auto problem = pulled(10.0);
    const auto model = counting();
    const auto damage = [&](const std::function<void(const fs::path &)> &change) {
        cache().keep(model, problem, moved(problem));
        EXPECT_TRUE(cache().find(model, problem));
        for (const auto &entry : fs::recursive_directory_iterator(folder))
            if (entry.is_regular_file())
                change(entry.path());
        EXPECT_FALSE(cache().find(model, problem));
    };
    damage([](const fs::path &file) { std::ofstream(file) << "no solution"; });
    damage([](const fs::path &file) { fs::resize_file(file, 0); });
    damage([](const fs::path &file) { fs::resize_file(file, fs::file_size(file) / 2); });
    damage([](const fs::path &file) { fs::rename(file, file.string() + ".1.partial"); });
}

TEST_F(SolutionsOfARun, GoWhenAResultHasThem) {
    const auto problem = pulled(10.0), other = pulled(11.0);
    const std::array models{counting()};
    cache().keep(models[0], problem, moved(problem));
    cache().keep(models[0], other, moved(other));
    cache().forget(models, problem);
    EXPECT_FALSE(cache().find(models[0], problem));
    EXPECT_TRUE(cache().find(models[0], other));
    cache().clear();
    EXPECT_FALSE(fs::exists(folder));
}

TEST_F(SolutionsOfARun, AreSolvedOnce) {
    const auto problem = pulled(10.0), other = pulled(11.0);
    const auto model = counting();
    PreparedModels prepared(cache());
    const auto first = prepared.solve(model, problem);
    EXPECT_EQ(num_solved, 1);
    EXPECT_EQ(prepared.solve(model, problem).displacement, first.displacement);
    EXPECT_EQ(num_solved, 1);
    EXPECT_EQ(num_prepared, 1) << "what is known needs nothing that a model keeps";
    const auto both = prepared.solve(model, std::array{core::Problem{problem.body, other.load_case}, problem});
    EXPECT_EQ(num_solved, 2) << "the other one alone";
    EXPECT_EQ(both[0].displacement, moved(other).displacement);
    EXPECT_EQ(both[1].displacement, first.displacement);
}

/// The last digits of a solution depend on its company.
TEST_F(SolutionsOfARun, AreSolvedTogetherAgainWhereOneIsMissing) {
    const auto problem = pulled(10.0), other = pulled(11.0);
    auto together = counting();
    together.most_together = 2;
    const std::array problems{problem, core::Problem{problem.body, other.load_case}};
    const auto solve_both = [&] { return PreparedModels(cache()).solve(together, problems); };
    solve_both();
    EXPECT_EQ(num_solved, 2);
    solve_both();
    EXPECT_EQ(num_solved, 2);
    cache().forget(std::array{together}, other);
    const auto both = solve_both();
    EXPECT_EQ(num_solved, 4);
    EXPECT_EQ(both[0].displacement, moved(problem).displacement);
    EXPECT_TRUE(cache().find(together, other));
}

/// A stored reference was solved alone, and stays so.
TEST_F(SolutionsOfARun, AreNotSolvedAgainBesideAStoredReference) {
    const auto problem = pulled(10.0), other = pulled(11.0);
    auto together = counting();
    together.most_together = 2;
    together.at_rest = core::Role::refined_reference;
    const auto references = output / "references";
    const auto file = results::reference_path(references, problem, together.name);
    fs::create_directories(file.parent_path());
    auto stored = moved(problem);
    stored.strain_energy *= 2.0;
    results::write_reference(file, stored, problem, together.name, {});
    SolutionCache with_references(references);
    with_references.keep_in(output, "settings");
    EXPECT_EQ(with_references.where(together, problem), "stored");
    const std::array problems{problem, core::Problem{problem.body, other.load_case}};
    for (int again = 0; again < 2; ++again) {
        const auto both = PreparedModels(with_references).solve(together, problems);
        EXPECT_EQ(num_solved, 1);
        EXPECT_EQ(both[0].strain_energy, stored.strain_energy);
        EXPECT_EQ(both[1].displacement, moved(other).displacement);
    }
}

TEST_F(SolutionsOfARun, AreThereWithoutAPlaceForThem) {
    fs::create_directories(output.parent_path());
    std::ofstream(output) << "a file where the folder should be";
    const auto problem = pulled(10.0);
    EXPECT_EQ(PreparedModels(cache()).solve(counting(), problem).displacement, moved(problem).displacement);
    EXPECT_THROW(cache().keep(counting(), problem, moved(problem)), std::exception);
}

TEST(SolutionCache, KeepsNothingWithoutAFolder) {
    const auto problem = pulled(10.0);
    core::Model model;
    model.name = "any";
    const SolutionCache cache;
    cache.keep(model, problem, moved(problem));
    EXPECT_FALSE(cache.find(model, problem));
    EXPECT_EQ(cache.where(model, problem), "");
}

} // namespace
} // namespace livermark::studies

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

/// References on finer meshes are stored in both regimes, with the work of the loads and the error bar, and of small
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

/// Probes of a motion are stored, and the model that judges motion is stored where something moves.
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
