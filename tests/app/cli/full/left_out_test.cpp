#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>

#include "meshes/io/mesh_files.hpp"
#include "results/hdf5/result_file.hpp"
#include "tests/child.hpp"
#include "tests/result_folder.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

namespace fs = std::filesystem;

/// A box whose sides have the names of a liver's, so that `traction` fits and many load cases do not.
class LeftOut : public tests::ResultFolder {
  protected:
    /// @param bricks  of 30 mm / bricks on each side
    void write_box(const std::string &name, int bricks) const {
        auto mesh = tests::box_mesh({0.03, 0.03, 0.03}, {bricks, bricks, bricks});
        mesh.patch_names = {"posterior", "left_lobe_tip", "y_min", "anterior", "inferior", "right_lobe_dome"};
        meshes::write_msh(directory_ / (name + ".msh"), mesh);
        std::ofstream(directory_ / (name + ".toml"))
            << fmt::format("title = \"box\"\nmesh = \"{}.msh\"\n[regions.solid]\ndensity = 1000.0\n"
                           "young_modulus = 5000.0\npoisson_ratio = 0.3\nsource = \"made up\"\n",
                           name);
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
    EXPECT_FALSE(fs::exists(result("narrow", "retraction")));
    const std::string no_room = "'retractor' moves nodes that 'posterior' moves differently";
    const std::string no_patch = "the body has no patch 'superior'";
    const std::vector<std::string> reasons{no_room, no_patch, "it keeps 67 % of its area and needs 75 %"};
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
    const auto end = run({"--body", "finer.toml", "--load-case", "retraction", "--tables"});
    EXPECT_EQ(end.status, 0) << end.errors;
    const auto yielded = results::read_result(result("finer", "retraction")).problem.load_case.yielded;
    ASSERT_EQ(yielded.size(), 1U);
    EXPECT_EQ(yielded[0].name, "retractor");
    EXPECT_NEAR(yielded[0].lost_area, 1.0 / 6.0, 1e-9);
    EXPECT_TRUE(has(end.output, "area given up to other places: finer retraction 'retractor' 17 %")) << end.output;
}

TEST_F(LeftOut, OneThatIsAskedForAloneIsRefused) {
    write_box("narrow", 3);
    const auto end = run({"--body", "narrow.toml", "--load-case", "retraction"});
    EXPECT_EQ(end.status, 2);
    EXPECT_TRUE(has(end.errors, "retraction.toml:")) << end.errors;
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
    write_box("finer", 6);
    const auto end = run({"--body", "narrow.toml", "finer.toml", "--load-case", "retraction", "traction"});
    EXPECT_EQ(end.status, 0) << end.errors;
    EXPECT_TRUE(fs::exists(result("narrow", "traction")));
    EXPECT_TRUE(fs::exists(result("finer", "traction")));
    EXPECT_TRUE(fs::exists(result("finer", "retraction")));
    EXPECT_FALSE(fs::exists(result("narrow", "retraction")));
}

} // namespace
} // namespace livermark
