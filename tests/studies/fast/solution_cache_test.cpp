#include "studies/run/solutions.hpp"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <functional>
#include <gtest/gtest.h>
#include <memory>
#include <string>
#include <unistd.h>
#include <vector>

#include "results/hdf5/references.hpp"
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
        cache.keep_in(folder);
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
    fs::path folder = folder_of_solutions(output, "settings");
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
    EXPECT_NE(folder_of_solutions(output, "settings"), folder_of_solutions(output, "other settings"));
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
    EXPECT_FALSE(fs::exists(folder.parent_path()));
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

/// What is stored was solved alone, and stays so.
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
    with_references.keep_in(folder);
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
