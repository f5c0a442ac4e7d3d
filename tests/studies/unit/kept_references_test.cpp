#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <gtest/gtest.h>

#include "results/hdf5/reference_file.hpp"
#include "studies/run/kept_references.hpp"
#include "support/input_error.hpp"
#include "tests/test_meshes.hpp"

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

class KeptReferences : public testing::Test {
  protected:
    void SetUp() override { fs::create_directories(folder); }
    void TearDown() override { fs::remove_all(folder); }

    core::Solution solve_with_kept(const core::Problem &problem) const {
        auto models = studies::models_to_keep();
        std::erase_if(models, [](const core::Model &model) { return model.name != name; });
        studies::use_kept_references(models, folder);
        return models.front().solve(problem);
    }

    fs::path folder = fs::path(testing::TempDir()) / "livermark_kept_references" /
                      testing::UnitTest::GetInstance()->current_test_info()->name(); // several run at a time
    core::Problem problem = pulled();
};

TEST_F(KeptReferences, AreReadWhereTheyFitAndSaySo) {
    const auto models = studies::models_to_keep();
    ASSERT_EQ(models.size(), 2U);
    const auto solved = solve_with_kept(problem);
    EXPECT_EQ(solved.solver.find("kept since"), std::string::npos);
    const auto kept = studies::solve_and_keep(models.front(), problem, folder, false, "test");
    EXPECT_EQ(kept.status, core::SolutionStatus::ok);
    EXPECT_EQ(studies::count_kept({problem}, name, folder), 1);
    const auto read = solve_with_kept(problem);
    EXPECT_TRUE(read.solver.starts_with("kept since 20")) << read.solver;
    EXPECT_EQ(read.displacement, solved.displacement);
    EXPECT_EQ(read.reaction, solved.reaction);
    ASSERT_EQ(read.path.size(), 2U);
    EXPECT_EQ(read.path.front().displacement, solved.path.front().displacement);
}

TEST_F(KeptReferences, AreNotTakenForAnotherProblem) {
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

TEST_F(KeptReferences, AreComparedWhenTheyAreChecked) {
    const auto model = studies::models_to_keep().front();
    EXPECT_TRUE(std::isnan(studies::solve_and_keep(model, problem, folder, true, "test").difference));
    EXPECT_EQ(studies::count_kept({problem}, name, folder), 0);
    auto wrong = model.solve(problem);
    wrong.displacement.back() *= 1.5;
    const auto file = results::reference_path(folder, problem, name);
    fs::create_directories(file.parent_path());
    results::write_reference(file, wrong, problem, name, {});
    EXPECT_GT(studies::solve_and_keep(model, problem, folder, true, "test").difference, 1e-3);
    studies::solve_and_keep(model, problem, folder, false, "test");
    EXPECT_LT(studies::solve_and_keep(model, problem, folder, true, "test").difference, 1e-9);
}

TEST_F(KeptReferences, ThatAreDamagedAreRefused) {
    const auto file = results::reference_path(folder, problem, name);
    fs::create_directories(file.parent_path());
    std::ofstream(file) << "no HDF5";
    EXPECT_THROW(solve_with_kept(problem), support::InputError);
}

} // namespace
} // namespace livermark
