#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <fmt/ostream.h>
#include <fstream>
#include <gtest/gtest.h>

#include "results/hdf5/result_file.hpp"
#include "tests/livermark_command.hpp"
#include "tests/samples/small_bar.hpp"

namespace livermark {
namespace {

namespace fs = std::filesystem;

/// A small bar under its weight and a traction, as a body and a load case of a user.
class Exchange : public testing::Test {
  protected:
    void SetUp() override {
        folder_ = tests::folder_with_bar("exchange");
        std::ofstream(folder_ / "pull.toml")
            << "title = \"pull\"\ntarget_peak_displacement = 0.001\nacceleration = [0.0, 0.0, -0.5]\n[[condition]]\n"
               "patch = \"x_min\"\ndisplacement = [0.0, 0.0, 0.0]\n[[condition]]\npatch = \"x_max\"\n"
               "traction = [10.0, 0.0, 0.0]\n";
    }

    std::string at(const std::string &name) const { return (folder_ / name).string(); }
    std::string problem() const { return at("bar.toml") + " " + at("pull.toml"); }

    void write_csv(const results::Result &result, const std::string &model) const {
        const auto found = std::ranges::find(result.models, model, &results::ModelResult::name);
        std::ofstream out(folder_ / "solution.csv");
        out << "x,y,z,ux,uy,uz\n";
        for (std::size_t i = 0; i < result.problem.body->mesh.points.size(); ++i) {
            const auto &x = result.problem.body->mesh.points[i];
            const auto &u = found->solution.displacement[i];
            fmt::print(out, "{},{},{},{},{},{}\n", x.x(), x.y(), x.z(), u.x(), u.y(), u.z());
        }
    }

    fs::path folder_;
};

const results::ModelResult &find(const results::Result &result, const std::string &name) {
    return *std::ranges::find(result.models, name, &results::ModelResult::name);
}

/// Displacements of our own springs come back with the same error as in a run.
TEST_F(Exchange, ASolutionIsScoredAsOurOwnModelsAre) {
    const auto ran = tests::livermark(fmt::format("run --body {} --load-case {} --model lloyd --output {}",
                                                  at("bar.toml"), at("pull.toml"), at("runs")));
    ASSERT_EQ(ran.status, 0) << ran.output;
    const auto run = results::read_result(folder_ / "runs" / "bar" / "pull.h5");
    write_csv(run, "lloyd");
    const auto outcome = tests::livermark(
        fmt::format("score {} {} --name outside --output {}", problem(), at("solution.csv"), at("scores")));
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    const auto scored = results::read_result(folder_ / "scores" / "bar" / "pull.outside.h5");
    const auto &ours = *find(run, "lloyd").comparison;
    const auto &theirs = *find(scored, "outside").comparison;
    EXPECT_EQ(theirs.reference, ours.reference);
    EXPECT_EQ(theirs.relative_l2, ours.relative_l2);
    EXPECT_EQ(theirs.max_error, ours.max_error);
    EXPECT_TRUE(std::isnan(theirs.reaction_error));
    EXPECT_NE(outcome.output.find("outside"), std::string::npos);
    EXPECT_NE(outcome.output.find("fem_p1"), std::string::npos);
}

TEST_F(Exchange, AProblemIsWrittenInThreeFormats) {
    const auto outcome = tests::livermark(fmt::format("export {} -o {}", problem(), at("out")));
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    const auto folder = folder_ / "out" / "bar";
    const auto problem_file = results::read_result(folder / "pull.problem.h5");
    EXPECT_TRUE(problem_file.models.empty());
    const auto &mesh = problem_file.problem.body->mesh;
    // What VTK's reader in meshio sees: the forces add up to the traction times the area and the weight.
    const auto sums = tests::run_command(fmt::format(
        "/usr/bin/python3 -c \"import meshio; m = meshio.read('{}'); f = m.point_data['nodal_force'].sum(0); "
        "print('nodes', len(m.points), 'held', m.point_data['is_prescribed'].all(1).sum(), 'force %.6e %.6e' % (f[0], "
        "f[2]))\"",
        (folder / "pull.vtu").string()));
    ASSERT_EQ(sums.status, 0) << sums.output;
    EXPECT_NE(sums.output.find(fmt::format("nodes {} ", mesh.points.size())), std::string::npos) << sums.output;
    const auto constrained = std::ranges::count_if(mesh.points, [](const auto &x) { return x.x() < 1e-9; });
    EXPECT_NE(sums.output.find(fmt::format("held {} ", constrained)), std::string::npos) << sums.output;
    EXPECT_NE(sums.output.find(fmt::format("force {:.6e} {:.6e}", 10.0 * 9e-4, -0.5 * 1000.0 * 8.1e-5)),
              std::string::npos)
        << sums.output;
    EXPECT_TRUE(fs::exists(folder / "pull.inp"));
}

TEST_F(Exchange, WhatCannotBeScoredIsRefused) {
    std::ofstream(folder_ / "solution.csv") << "x,y,z,ux,uy,uz\n1,2,3,0,0,0\n";
    for (const auto &[arguments, part] : {
             std::pair{fmt::format("score {} {}", problem(), at("solution.csv")), "belongs to another mesh"},
             {fmt::format("score {} {}", problem(), at("no.csv")), "check the path"},
             {fmt::format("score {} {} --name fem_p1", problem(), at("solution.csv")), "choose another --name"},
             {fmt::format("score {} {} --name a/b", problem(), at("solution.csv")), "letters, digits"},
             {fmt::format("score {}", problem()), "solution"},
             {fmt::format("export {} palpatoin", at("bar.toml")), "did you mean 'palpation'?"},
             {fmt::format("export {} palpation", at("bar.toml")), "no patch"},
         }) {
        const auto outcome = tests::livermark(arguments);
        EXPECT_EQ(outcome.status, 2) << arguments << "\n" << outcome.output;
        EXPECT_NE(outcome.output.find(part), std::string::npos) << outcome.output;
    }
    EXPECT_FALSE(fs::exists(folder_ / "results"));
}

} // namespace
} // namespace livermark
