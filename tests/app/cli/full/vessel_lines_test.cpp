#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>
#include <limits>
#include <string>

#include "results/hdf5/result_file.hpp"
#include "tests/livermark_command.hpp"
#include "tests/samples/small_bar.hpp"

namespace livermark {
namespace {

namespace fs = std::filesystem;

/// Energy that a model stores [J].
double energy_of(const results::Result &result, const std::string &model) {
    for (const auto &found : result.models)
        if (found.solution.status == core::SolutionStatus::ok && found.name == model)
            return found.solution.strain_energy;
    return std::numeric_limits<double>::quiet_NaN();
}

/// A small bar of 90 x 30 x 30 mm with a vessel along its middle, which is pulled.
class VesselsOfABar : public testing::Test {
  protected:
    void SetUp() override {
        folder_ = tests::folder_with_bar("vessel_lines");
        tests::write_pull(folder_);
        fs::copy_file(folder_ / "bar.toml", folder_ / "lines.toml", fs::copy_options::overwrite_existing);
        std::ofstream(folder_ / "lines.toml", std::ios::app) << "[vessels]\nfile = \"lines.swc\"\nunit = \"mm\"\n";
        std::ofstream(folder_ / "lines.swc") << "1 0 -5 15.1 15.1 4 -1\n2 0 45 15.1 15.1 4 1\n3 0 95 15.1 15.1 4 2\n";
    }
    std::string at(const std::string &name) const { return (folder_ / name).string(); }

    fs::path folder_;
};

/// The wall has 0.19 of a section of 50 of 900 mm^2, which makes the bar stiffer by about 1 + 0.0559 (0.19 E_w / E -
/// 1).
TEST_F(VesselsOfABar, MakeItStifferInEveryModel) {
    const std::string models = "fem_p1 fem_p2 lloyd nodal_neo_hookean xpbd_springs vertex_block_descent";
    for (const char *body : {"bar", "lines"}) {
        const auto run =
            tests::livermark(fmt::format("run {}.toml --load-case {} --model {} --reference-on-mesh --output {}",
                                         at(body), at("pull.toml"), models, at("out")));
        tests::expect_outcome(run, 0, {body == std::string("bar") ? "" : "10.0 % of their length is outside the body"});
    }
    const auto bare = results::read_result(folder_ / "out" / "bar" / "pull.h5");
    const auto lines = results::read_result(folder_ / "out" / "lines" / "pull.h5");
    ASSERT_TRUE(lines.problem.body->vessels);
    const double young_modulus = bare.problem.body->materials.front().young_modulus;
    const double expected = 1.0 + M_PI * 16.0 / 900.0 * (0.19 * 0.62e6 / young_modulus - 1.0);
    for (const auto *const model :
         {"fem_p1", "fem_p2", "lloyd", "nodal_neo_hookean", "xpbd_springs", "vertex_block_descent"}) {
        const double stiffer = energy_of(bare, model) / energy_of(lines, model); // under one force
        EXPECT_NEAR(stiffer / expected, 1.0, 0.25) << model;
    }
}

} // namespace
} // namespace livermark
