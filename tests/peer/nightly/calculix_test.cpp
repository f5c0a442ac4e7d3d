#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <tuple>

#include "core/error_norms.hpp"
#include "fem_reference/hyperelastic/hyperelasticity.hpp"
#include "fem_reference/linear/linear_elasticity.hpp"
#include "load_cases/readers/load_case_reader.hpp"
#include "meshes/io/body_reader.hpp"
#include "tests/peer/calculix.hpp"
#include "tests/samples/calculix_neo_hooke.hpp"

namespace livermark {

namespace {

const std::filesystem::path root = LIVERMARK_SOURCE_DIR;

/// Parameter: body and degree of the elements.
class Calculix : public testing::TestWithParam<std::tuple<std::string, int>> {};

} // namespace

TEST_P(Calculix, FindsTheSameDisplacements) {
    const auto ccx = tests::find_ccx();
    if (ccx.empty())
        GTEST_SKIP() << "ccx is not installed (Debian: calculix-ccx)";
    const auto &[name, degree] = GetParam();
    const auto body = std::make_shared<const core::Body>(meshes::read_body(root / "meshes" / (name + ".toml")));
    fem_reference::StaticSolver solver(body, degree);
    for (const std::string load_case : {"gravity_tilt", "palpation", "traction", "indentation"}) {
        if (load_case == "indentation" && degree == 2)
            continue; // its equation of many terms makes CalculiX slow
        SCOPED_TRACE(load_case);
        const core::Problem problem{
            body, load_cases::read_load_case(root / "load_cases" / (load_case + ".toml"), body->mesh)};
        const auto ours = solver.solve(problem.load_case);
        ASSERT_EQ(ours.status, core::SolutionStatus::ok) << ours.message;
        core::Solution theirs;
        theirs.displacement = tests::solve_with_calculix(
            ccx, problem, degree, fmt::format("{}/{}_p{}_{}", LIVERMARK_PEER_RUNS, name, degree, load_case));
        theirs.reaction = ours.reaction; // not compared
        const auto comparison = core::compare(body->mesh, problem.load_case, ours, theirs, "calculix");
        RecordProperty(load_case, fmt::format("{:.2e}", comparison.relative_l2));
        EXPECT_LT(comparison.relative_l2, 1e-6); // seven digits are all that CalculiX writes
        EXPECT_LT(comparison.max_error_relative, 1e-6);
    }
}

INSTANTIATE_TEST_SUITE_P(Livers, Calculix,
                         testing::Combine(testing::Values("liver_healthy", "liver_tumours"), testing::Values(1, 2)),
                         [](const auto &info) {
                             return fmt::format("{}_p{}", std::get<0>(info.param), std::get<1>(info.param));
                         });

namespace {

const std::filesystem::path source_folder = LIVERMARK_SOURCE_DIR;

/// Parameter: body and load case.
class CalculixHyperelastic : public testing::TestWithParam<std::tuple<std::string, std::string>> {};

/// With the energy of CalculiX and the four points of its C3D10. Its increments are others: the path does not matter.
core::Solution solve_with_its_energy(const core::Problem &problem) {
    return hyperelastic::solve(problem, tests::calculix_neo_hooke(),
                               {.degree = 2, .rule = hyperelastic::TetrahedronRule::four_points},
                               {.fractions = {0.5, 1.0}})
        .solution;
}

} // namespace

/// A solver by other people, with elements of its own, comes to the same large displacements: to seven digits, which is
/// all that it writes.
TEST_P(CalculixHyperelastic, FindsTheSameLargeDisplacements) {
    const auto ccx = tests::find_ccx();
    if (ccx.empty())
        GTEST_SKIP() << "ccx is not installed (Debian: calculix-ccx)";
    const auto &[name, load_case] = GetParam();
    const auto stem = std::filesystem::path(load_case).filename().string();
    const auto body =
        std::make_shared<const core::Body>(meshes::read_body(source_folder / "meshes" / (name + ".toml")));
    const core::Problem problem{body, load_cases::read_load_case(source_folder / (load_case + ".toml"), body->mesh)};
    const auto ours = solve_with_its_energy(problem);
    ASSERT_EQ(ours.status, core::SolutionStatus::ok) << ours.message;
    core::Solution theirs;
    theirs.displacement =
        tests::solve_with_calculix(ccx, problem, 2, fmt::format("{}/{}_{}", LIVERMARK_PEER_RUNS, name, stem));
    theirs.reaction = ours.reaction; // not compared
    const auto comparison = core::compare(body->mesh, problem.load_case, ours, theirs, "calculix");
    const auto found = fmt::format("relative L2 {:.2e}, largest error {:.2e}, linear elasticity is off by {:.2e}",
                                   comparison.relative_l2, comparison.max_error_relative, ours.nonlinearity);
    RecordProperty("found", found);
    fmt::print("{}, {}: {}\n", name, stem, found);
    EXPECT_GT(ours.nonlinearity, 0.03);
    EXPECT_LT(comparison.relative_l2, 1e-6);
    EXPECT_LT(comparison.max_error_relative, 1e-5);
}

// One of each, because CalculiX takes more than a minute for one.
INSTANTIATE_TEST_SUITE_P(Livers, CalculixHyperelastic,
                         testing::Values(std::tuple("liver_healthy", "tests/validation/held_palpation"),
                                         std::tuple("liver_tumours", "load_cases/large_traction")),
                         [](const auto &info) {
                             return fmt::format("{}_{}", std::get<0>(info.param),
                                                std::filesystem::path(std::get<1>(info.param)).filename().string());
                         });

} // namespace livermark
