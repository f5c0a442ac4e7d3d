#include "tests/peer/calculix.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <tuple>

#include "core/error_norms.hpp"
#include "fem_reference/linear/linear_elasticity.hpp"
#include "load_cases/readers/load_case_reader.hpp"
#include "meshes/io/body_reader.hpp"

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

} // namespace livermark
