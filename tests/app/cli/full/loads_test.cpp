#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>
#include <ranges>
#include <string>
#include <utility>
#include <vector>

#include "load_cases/readers/load_case_reader.hpp"
#include "meshes/io/mesh_files.hpp"
#include "results/hdf5/result_file.hpp"
#include "results/tables/table.hpp"
#include "tests/child.hpp"
#include "tests/livermark_command.hpp"
#include "tests/result_folder.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

constexpr double target_peak = 0.0015; // m

/// A box as files, with a load case that is driven in every way: the command scales it and multiplies it.
class ScaledRun : public testing::Test {
  protected:
    void SetUp() override {
        const auto *test = testing::UnitTest::GetInstance()->current_test_info();
        folder_ = std::filesystem::path(testing::TempDir()) / "livermark_load_scaling" / test->name();
        std::filesystem::remove_all(folder_);
        std::filesystem::create_directories(folder_);
        meshes::write_msh(folder_ / "box.msh", mesh_);
        std::ofstream(folder_ / "box.toml") << "title = \"box\"\nmesh = \"box.msh\"\n[regions.solid]\n"
                                               "density = 1060.0\nyoung_modulus = 5000.0\npoisson_ratio = 0.45\n"
                                               "source = \"test\"\n";
        std::ofstream(folder_ / "all.toml")
            << "title = \"all\"\ntarget_peak_displacement = " << target_peak << "\nscale_to_target = true\n"
            << "acceleration = [0.0, 0.1, -0.2]\n"
               "[[condition]]\npatch = \"x_min\"\ndisplacement = [0.0, 0.0, 0.0]\n"
               "[[condition]]\npatch = \"y_max\"\npressure = 20.0\n"
               "[[condition]]\npatch = \"x_max\"\ndisplacement = [\"free\", \"free\", 0.0004]\n";
    }

    tests::Outcome run(const std::string &options) const {
        return tests::livermark(
            fmt::format("run --reference-on-mesh --model fem_p1 fem_p2 lloyd --body {} --load-case {} --output {} {}",
                        (folder_ / "box.toml").string(), (folder_ / "all.toml").string(), folder_.string(), options));
    }
    results::Result result(const std::string &name) const {
        return results::read_result(folder_ / "box" / (name + ".h5"));
    }
    core::LoadCase as_written() const { return load_cases::read_load_case(folder_ / "all.toml", mesh_); }
    bool exists(const std::string &name) const { return std::filesystem::exists(folder_ / "box" / (name + ".h5")); }

    const std::filesystem::path &folder() const { return folder_; }

  private:
    core::TetraMesh mesh_ = tests::box_mesh({0.1, 0.08, 0.06}, {4, 3, 3});
    std::filesystem::path folder_;
};

const std::vector<core::Vector3> &displacement_of(const results::Result &result, const std::string &model) {
    return std::ranges::find(result.models, model, &results::ModelResult::name)->solution.displacement;
}

TEST_F(ScaledRun, BaselineReachesTheTargetAndTheFactorIsKept) {
    const auto outcome = run("--tables");
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    const auto found = result("all");
    const auto lengths = [](const core::Vector3 &u) { return u.norm(); };
    const auto &load_case = found.problem.load_case;
    // The factor has six digits, so the peak is as much off as the seventh may be.
    EXPECT_EQ(fmt::format("{}", std::stod(fmt::format("{:.5e}", load_case.load_scale))),
              fmt::format("{}", load_case.load_scale));
    EXPECT_NEAR(std::ranges::max(displacement_of(found, "fem_p1") | std::views::transform(lengths)), target_peak,
                5e-6 * target_peak);
    EXPECT_GT(std::abs(load_case.load_scale - 1.0), 0.1);
    EXPECT_NE(outcome.output.find(fmt::format("box all {:.4g}", load_case.load_scale)), std::string::npos)
        << outcome.output;
    const auto expected = core::scaled(as_written(), load_case.load_scale);
    EXPECT_EQ(load_case.acceleration, expected.acceleration);
    for (std::size_t f = 0; f < expected.value.size(); ++f)
        for (int c = 0; c < 3; ++c)
            if (!std::isnan(expected.value[f][c])) {
                EXPECT_EQ(load_case.value[f][c], expected.value[f][c]);
            }
}

TEST_F(ScaledRun, AmplitudesMultiplyTheScaledLoad) {
    const auto outcome = run("--amplitude 2,0.5");
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    EXPECT_FALSE(exists("all"));
    const auto small = result("all@0.5"), large = result("all@2");
    EXPECT_NEAR(large.problem.load_case.load_scale, 4.0 * small.problem.load_case.load_scale, 1e-12);
    const auto &u = displacement_of(small, "fem_p2"), &u_large = displacement_of(large, "fem_p2");
    for (std::size_t i = 0; i < u.size(); ++i)
        EXPECT_LT((u_large[i] - 4.0 * u[i]).norm(), 1e-10 * target_peak);
    // The springs leave their linearised solution in proportion to the load, at first.
    const auto nonlinearity = [](const results::Result &result) {
        return std::ranges::find(result.models, "lloyd", &results::ModelResult::name)->solution.nonlinearity;
    };
    EXPECT_NEAR(nonlinearity(large) / nonlinearity(small), 4.0, 0.5);
    EXPECT_NE(outcome.output.find("below 5 % up to"), std::string::npos) << outcome.output;
    EXPECT_LT(outcome.output.find("x 0.5 [%]"), outcome.output.find("x 2 [%]")) << outcome.output;
}

TEST_F(ScaledRun, LoadCasesThatDoNotFitABodyAreLeftOutUnlessBothWereNamed) {
    const auto root = folder() / "root";
    for (const auto *name : {"meshes", "load_cases"})
        std::filesystem::create_directories(root / name);
    for (const auto *name : {"box.toml", "box.msh"})
        std::filesystem::copy_file(folder() / name, root / "meshes" / name);
    std::filesystem::copy_file(folder() / "all.toml", root / "load_cases" / "all.toml");
    std::ofstream(root / "load_cases" / "nowhere.toml") << "title = \"none\"\ntarget_peak_displacement = 0.001\n"
                                                           "[[condition]]\npatch = \"antenna\"\npush = 0.001\n";
    const std::string fault = "nowhere.toml:4: the body has no patch 'antenna'";
    ASSERT_EQ(setenv("LIVERMARK_ROOT", root.c_str(), 1), 0);
    const auto in_root = [&](const std::string &names) {
        return tests::livermark(
            fmt::format("run --reference-on-mesh --model lloyd --output {} {}", folder().string(), names));
    };
    const auto all = in_root(""), body = in_root("--body box"), both = in_root("--body box --load-case nowhere"),
               load_case = in_root("--load-case nowhere");
    unsetenv("LIVERMARK_ROOT");
    for (const auto &outcome : {all, body}) {
        tests::expect_outcome(outcome, 0,
                              {"livermark: left out on box: nowhere, because the body has no patch 'antenna'\n"});
    }
    EXPECT_TRUE(exists("all"));
    for (const auto &outcome : {both, load_case}) { // the latter fits no body
        tests::expect_outcome(outcome, 2, {fault});
        EXPECT_EQ(std::ranges::count(outcome.output, '\n'), 1) << outcome.output;
    }
}

namespace fs = std::filesystem;

/// A box whose sides have the names of a liver's, so that `traction` fits and many load cases do not.
class LeftOut : public tests::ResultFolder {
  protected:
    /// @param bricks  of 30 mm / bricks on each side
    /// @param below   name of the side at y = 0
    void write_box(const std::string &name, int bricks, const std::string &below = "y_min") const {
        auto mesh = tests::box_mesh({0.03, 0.03, 0.03}, {bricks, bricks, bricks});
        mesh.patch_names = {"posterior", "left_lobe_tip", below, "anterior", "inferior", "right_lobe_dome"};
        meshes::write_msh(directory_ / (name + ".msh"), mesh);
        std::ofstream(directory_ / (name + ".toml"))
            << fmt::format("title = \"box\"\nmesh = \"{}.msh\"\n[regions.solid]\ndensity = 1000.0\n"
                           "young_modulus = 5000.0\npoisson_ratio = 0.3\nsource = \"made up\"\n",
                           name);
    }

    /// held.toml: a blade holds an edge beside what is fixed, and lifts it.
    void write_held_edge() const {
        std::ofstream(directory_ / "held.toml")
            << "title = \"held\"\ntarget_peak_displacement = 0.002\n"
               "[[condition]]\npatch = \"posterior\"\ndisplacement = [0.0, 0.0, 0.0]\n"
               "[[condition]]\nname = \"blade\"\n"
               "edge = { between = [\"anterior\", \"inferior\"], width = 0.008, length = 0.060 }\n"
               "displacement = [0.0, -0.0014, 0.0014]\n";
    }

    tests::ChildEnd run(std::vector<std::string> words) const {
        words.insert(words.begin(), {LIVERMARK_BINARY, "run", "--model", "fem_p1", "--reference-on-mesh", "--static",
                                     "--output", "runs"});
        return tests::run_child(words, {.folder = directory_});
    }

    fs::path result(const std::string &body, const std::string &load_case) const {
        return directory_ / "runs" / body / (load_case + ".h5");
    }
};

bool has(const std::string &text, const std::string &part) {
    return text.find(part) != std::string::npos;
}

TEST_F(LeftOut, LoadCasesAreNamedWithTheReasonAndTheOthersRun) {
    write_box("narrow", 3);
    const auto end = run({"--body", "narrow.toml"});
    EXPECT_EQ(end.status, 0) << end.errors;
    EXPECT_TRUE(fs::exists(result("narrow", "traction")));
    EXPECT_FALSE(fs::exists(result("narrow", "grasp")));
    const std::vector<std::string> reasons{"the body has no patch 'superior'",
                                           "no facet of the body is in 'disc at (-0.028, 0.008, 0.024) m'"};
    const auto results_line = end.errors.rfind("Result files are in");
    for (const auto &reason : reasons) {
        EXPECT_FALSE(has(end.output, reason)) << "said twice";
        EXPECT_LT(end.errors.rfind(reason), results_line) << reason << " is not said at the end of: " << end.errors;
    }
    const auto with_tables = run({"--body", "narrow.toml", "--tables"});
    EXPECT_EQ(with_tables.status, 0) << with_tables.errors;
    EXPECT_TRUE(has(with_tables.output, "left out on")) << with_tables.output;
    for (const auto &reason : reasons) {
        EXPECT_TRUE(has(with_tables.output, reason)) << reason << " is missing in: " << with_tables.output;
        EXPECT_FALSE(has(with_tables.errors, reason)) << "said twice";
    }
    EXPECT_FALSE(has(with_tables.output, "large_")) << "of the other regime, which was not asked for";
}

TEST_F(LeftOut, LoadCasesAreNoneWhereThePlaceYieldsAndTheFileSaysHowMuch) {
    write_box("finer", 6);
    write_held_edge();
    const auto end = run({"--body", "finer.toml", "--load-case", "held.toml", "--tables"});
    EXPECT_EQ(end.status, 0) << end.errors;
    const auto yielded = results::read_result(result("finer", "held")).problem.load_case.yielded;
    ASSERT_EQ(yielded.size(), 1U);
    EXPECT_EQ(yielded[0].name, "blade");
    EXPECT_NEAR(yielded[0].lost_area, 1.0 / 6.0, 1e-9);
    EXPECT_TRUE(has(end.output, "area given up to other places: finer held 'blade' 17 %")) << end.output;
}

TEST_F(LeftOut, OneThatIsAskedForAloneIsRefused) {
    write_box("narrow", 3);
    write_held_edge();
    for (const auto &[load_case, fault] :
         {std::pair{"grasp", "grasp.toml:11: the body has no patch 'superior'"},
          std::pair{"held.toml",
                    "held.toml:6: 'blade' moves nodes that 'posterior' moves differently, such as the node "
                    "at (0, 0.02, 0) m, and without the facets there it keeps 67 % of its area and needs "
                    "75 %"}}) {
        const auto end = run({"--body", "narrow.toml", "--load-case", load_case});
        EXPECT_EQ(end.status, 2);
        EXPECT_TRUE(has(end.errors, fault)) << end.errors;
    }
    EXPECT_FALSE(fs::exists(directory_ / "runs"));
}

TEST_F(LeftOut, OneOfAFileOfTheUsersOwnIsRefusedBesideOthers) {
    write_box("narrow", 3);
    std::ofstream(directory_ / "own.toml")
        << "title = \"pull\"\ntarget_peak_displacement = 0.001\n[[condition]]\npatch = \"posterior\"\n"
           "displacement = [0.0, 0.0, 0.0]\n[[condition]]\npatch = \"superior\"\ntraction = [10.0, 0.0, 0.0]\n";
    const auto end = run({"--body", "narrow.toml", "--load-case", "traction", "own.toml"});
    EXPECT_EQ(end.status, 2);
    EXPECT_TRUE(has(end.errors, "own.toml:")) << end.errors;
}

TEST_F(LeftOut, NamedOnesOfSeveralBodiesRunWhereTheyFit) {
    write_box("narrow", 3);
    write_box("finer", 6, "superior");
    const auto end = run({"--body", "narrow.toml", "finer.toml", "--load-case", "grasp", "traction"});
    EXPECT_EQ(end.status, 0) << end.errors;
    EXPECT_TRUE(fs::exists(result("narrow", "traction")));
    EXPECT_TRUE(fs::exists(result("finer", "traction")));
    EXPECT_TRUE(fs::exists(result("finer", "grasp")));
    EXPECT_FALSE(fs::exists(result("narrow", "grasp")));
}

/// The healthy liver in other axes than the patient's.
class TurnedBody : public tests::ResultFolder {
  protected:
    /// @param is_named  whether the file has the names of the patches
    void write_liver(const std::string &name, const core::Vector3 &turn, bool is_named) const {
        auto mesh = meshes::read_msh(LIVERMARK_SOURCE_DIR "/meshes/liver_healthy.msh");
        const Eigen::AngleAxisd rotation(turn.norm(), turn.norm() > 0.0 ? turn.normalized() : core::Vector3::UnitX());
        for (auto &point : mesh.points)
            point = rotation * point;
        if (!is_named) {
            mesh.patch_names = {"surface"};
            std::ranges::fill(mesh.boundary_patch, 0);
        }
        meshes::write_msh(directory_ / (name + ".msh"), mesh);
        std::ofstream(directory_ / (name + ".toml"))
            << fmt::format("mesh = \"{}.msh\"\nfind_patches = true\n[regions.parenchyma]\ndensity = 1060.0\n"
                           "young_modulus = 5000.0\npoisson_ratio = 0.45\n",
                           name);
    }

    tests::ChildEnd run(std::vector<std::string> bodies) const {
        std::vector<std::string> words{LIVERMARK_BINARY, "run",      "--static", "--reference-on-mesh", "--model",
                                       "fem_p1",         "--output", "runs",     "--load-case",         "breathing",
                                       "gravity_tilt",   "traction", "--body"};
        words.insert(words.end(), bodies.begin(), bodies.end());
        return tests::run_child(words, {.folder = directory_});
    }

    /// Both columns of the table [%].
    std::pair<double, double> numbers(const std::string &body, const std::string &load_case) const {
        const auto result = results::read_result(directory_ / "runs" / body / (load_case + ".h5"));
        const auto model = std::ranges::find(result.models, "fem_p1", &results::ModelResult::name);
        return {100.0 * model->comparison->relative_l2, 100.0 * results::stiffness_at_tool(*model)};
    }
};

TEST_F(TurnedBody, HasTheTableOfTheOneInLps) {
    const core::Vector3 by_97_degrees(1.69, 0.0, 0.0);
    write_liver("named", {0.0, 0.0, 0.0}, true);
    write_liver("named_turned", by_97_degrees, true);
    write_liver("plain", {0.0, 0.0, 0.0}, false);
    write_liver("plain_turned", by_97_degrees, false);
    const auto end = run({"named.toml", "named_turned.toml", "plain.toml", "plain_turned.toml"});
    ASSERT_EQ(end.status, 0) << end.errors;
    for (const std::string body : {"named", "plain"}) {
        EXPECT_NE(end.errors.find(body + "_turned: "), std::string::npos) << end.errors;
        for (const std::string load_case : {"breathing", "gravity_tilt", "traction"}) {
            const auto [l2, tool] = numbers(body, load_case);
            const auto [turned_l2, turned_tool] = numbers(body + "_turned", load_case);
            fmt::print("{} {}: L2 {:.3f} and {:.3f} %, tool {:.3f} and {:.3f} %\n", body, load_case, l2, turned_l2,
                       tool, turned_tool);
            const double most =
                body == "named" ? 0.05 : 0.5; // percentage points, of rotations found by patches, by shape
            EXPECT_NEAR(turned_l2, l2, most) << body << " " << load_case;
            EXPECT_EQ(std::isnan(turned_tool), std::isnan(tool)) << load_case;
            if (!std::isnan(tool)) { // as without a place that is loaded
                EXPECT_NEAR(turned_tool, tool, most) << body << " " << load_case;
            }
        }
    }
    EXPECT_NE(end.errors.find("turned by 97 degrees from LPS"), std::string::npos) << end.errors;
}

} // namespace
} // namespace livermark
