#include <chrono>
#include <fstream>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "core/mesh/plausible_liver.hpp"
#include "tests/child.hpp"
#include "tests/samples/small_bar.hpp"

namespace livermark {
namespace {

/// Elements with displacements alone, mixed ones, and springs with and without a volume term: all end at the largest
/// ratio that is let in, in linear elasticity and beyond.
TEST(NearlyIncompressible, BodiesEndAtTheLargestRatio) {
    const auto folder = tests::folder_with_bar("nearly_incompressible", 0.015);
    for (const auto &[regime, models] :
         {std::pair{"small",
                    std::vector<std::string>{"fem_p1", "fem_p2", "fem_p2p1", "lloyd", "patch_nodal_volume",
                                             "van_gelder_tetrahedral_volume", "nodal_springs", "nodal_neo_hookean"}},
          {"large", {"fem_p1_neo_hookean", "fem_p2_neo_hookean", "fem_p2p1_neo_hookean", "nodal_neo_hookean"}}}) {
        SCOPED_TRACE(regime);
        std::ofstream(folder / "pull.toml")
            << "title = \"pull\"\ntarget_peak_displacement = 0.001\nregime = \"" << regime
            << "\"\n[[condition]]\npatch = \"x_min\"\ndisplacement = [0.0, 0.0, 0.0]\n[[condition]]\n"
               "patch = \"x_max\"\ntraction = [10.0, 0.0, 0.0]\n";
        std::vector<std::string> words{LIVERMARK_BINARY, "run",
                                       "--body",         (folder / "bar.toml").string(),
                                       "--load-case",    (folder / "pull.toml").string()};
        for (const auto &word :
             {std::string("--static"), std::string("--reference-on-mesh"), std::string("--jobs"), std::string("1"),
              std::string("--output"), (folder / "runs").string(), std::string("--poisson"),
              std::to_string(core::largest_poisson_ratio), std::string("--model")})
            words.push_back(word);
        words.insert(words.end(), models.begin(), models.end());
        const auto start = std::chrono::steady_clock::now();
        const auto end = tests::run_child(
            words, {.killed_when = [=] { return std::chrono::steady_clock::now() - start > std::chrono::minutes(3); }});
        EXPECT_EQ(end.signal, 0) << end.output << end.errors;
        EXPECT_NE(end.output.find("nodal_neo_hookean"), std::string::npos) << end.output << end.errors;
    }
}

} // namespace
} // namespace livermark
