#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>
#include <string>

#include "results/hdf5/result_file.hpp"
#include "tests/livermark_command.hpp"
#include "tests/samples/small_bar.hpp"

namespace livermark {
namespace {

namespace fs = std::filesystem;

/// A small bar of 90 x 30 x 30 mm and an image of its shear modulus.
class StiffnessOfABar : public testing::Test {
  protected:
    void SetUp() override {
        folder_ = tests::folder_with_bar("stiffness_map");
        tests::write_pull(folder_);
    }

    /// From 1 to 3 kPa along 90 mm.
    /// @param origin  centre of the first of 7 x 3 x 3 voxels in x [mm], which are 15 mm wide
    std::string image(double origin) const {
        auto path = (folder_ / "map.nrrd").string();
        std::ofstream file(path);
        file << fmt::format("NRRD0004\ntype: float\ndimension: 3\nspace: left-posterior-superior\nsizes: 7 3 3\n"
                            "space directions: (15,0,0) (0,15,0) (0,0,15)\nspace origin: ({},0,0)\nencoding: ascii\n\n",
                            origin);
        for (int row = 0; row < 9; ++row)
            for (int along = 0; along < 7; ++along)
                file << 1.0 + along / 3.0 << (along < 6 ? " " : "\n");
        return path;
    }
    tests::Outcome map(const std::string &image, const std::string &unit = "kPa") const {
        return tests::livermark(
            fmt::format("mesh stiffness {} --map {} --unit {} -o {}", at("bar.toml"), image, unit, at("mapped.toml")));
    }
    std::string at(const std::string &name) const { return (folder_ / name).string(); }

    fs::path folder_;
};

TEST_F(StiffnessOfABar, IsReadWherePartOfTheBodyHasNoValue) {
    const auto outcome = map(image(60.0)); // beyond 60 of 90 mm
    tests::expect_outcome(outcome, 2, {"it has values in", "of the body, and at least 50 % are needed"});
    EXPECT_FALSE(fs::exists(folder_ / "mapped.toml"));
    EXPECT_FALSE(fs::exists(folder_ / "mapped.moduli.txt"));
    tests::expect_outcome(map(image(0.0), "Pa"), 2, {"say with --unit whether they are in Pa or kPa"});
}

TEST_F(StiffnessOfABar, ChangesTheBodyThatIsRun) {
    const auto path = image(0.0);
    tests::expect_outcome(map(path), 0, {"Young's modulus of map.nrrd is 52", "next: livermark run --body"});
    const auto run =
        tests::livermark(fmt::format("run {} --load-case {} --model fem_p1 lloyd --reference-on-mesh --output {}",
                                     at("mapped.toml"), at("pull.toml"), at("out")));
    tests::expect_outcome(run, 0, {"Young's modulus is that of mapped.moduli.txt, 2"});
    const auto result = results::read_result(folder_ / "out" / "mapped" / "pull.h5");
    const auto &body = *result.problem.body;
    ASSERT_EQ(body.modulus_factor.size(), body.mesh.tetrahedra.size());
    // E = 2 (1 + 0.3) mu, and mu grows from 1 to 3 kPa in 90 mm.
    for (std::size_t t = 0; t < body.modulus_factor.size(); ++t) {
        double x = 0.0;
        for (const int node : body.mesh.tetrahedra[t])
            x += 0.25 * body.mesh.points[node].x();
        EXPECT_NEAR(body.young_modulus_of(t), 2.6 * (1000.0 + 2000.0 * x / 0.09), 1.0);
    }
    tests::expect_outcome(map(path), 0, {"are written"}); // again, over its own
    const auto twice = tests::livermark(
        fmt::format("mesh stiffness {} --map {} --unit kPa -o {}", at("mapped.toml"), path, at("other.toml")));
    tests::expect_outcome(twice, 2, {"has a map of stiffness already"});
}

} // namespace
} // namespace livermark
