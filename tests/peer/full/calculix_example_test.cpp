#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <fmt/ostream.h>
#include <fstream>
#include <gtest/gtest.h>

#include "core/error_norms.hpp"
#include "fem_reference/hyperelastic/hyperelasticity.hpp"
#include "fem_reference/linear/linear_elasticity.hpp"
#include "results/hdf5/result_file.hpp"
#include "tests/fem_reference/fem_test_bodies.hpp"
#include "tests/livermark_command.hpp"
#include "tests/peer/calculix.hpp"
#include "tests/samples/bodies_with_vessels.hpp"
#include "tests/samples/calculix_neo_hooke.hpp"
#include "tests/samples/covered_bodies.hpp"

namespace livermark {
namespace {

/// The worked example of docs/studies/peers.md: a problem goes out as a file, CalculiX solves it, and its
/// displacements come back. Its C3D4 are linear tetrahedra, so they have to score as our own.
TEST(CalculixExample, ScoresAsLinearElements) {
    const auto ccx = tests::find_ccx();
    if (ccx.empty())
        GTEST_SKIP() << "there is no ccx";
    const auto folder = std::filesystem::path(LIVERMARK_PEER_RUNS) / "example";
    std::filesystem::remove_all(folder);
    const auto exported = tests::livermark(fmt::format("export liver_healthy palpation -o {}", folder.string()));
    ASSERT_EQ(exported.status, 0) << exported.output;
    const auto here = folder / "liver_healthy";
    const auto solved =
        tests::run_command(fmt::format("cd '{}' && OMP_NUM_THREADS=1 '{}' palpation", here.string(), ccx.string()));
    ASSERT_EQ(solved.status, 0) << solved.output;
    const auto problem = results::read_result(here / "palpation.problem.h5").problem;
    const auto &points = problem.body->mesh.points;
    {
        std::ifstream dat(here / "palpation.dat");
        const auto u = tests::read_dat(dat, static_cast<int>(points.size()));
        std::ofstream csv(here / "solution.csv");
        csv << "x,y,z,ux,uy,uz\n";
        for (std::size_t i = 0; i < points.size(); ++i)
            fmt::print(csv, "{},{},{},{},{},{}\n", points[i].x(), points[i].y(), points[i].z(), u[i].x(), u[i].y(),
                       u[i].z());
    }
    const auto scored =
        tests::livermark(fmt::format("score liver_healthy palpation {} --name calculix --reference-on-mesh --output {}",
                                     (here / "solution.csv").string(), folder.string()));
    ASSERT_EQ(scored.status, 0) << scored.output;
    const auto result = results::read_result(folder / "liver_healthy" / "palpation.calculix.h5");
    const auto error_of = [&](const std::string &name) {
        return std::ranges::find(result.models, name, &results::ModelResult::name)->comparison->relative_l2;
    };
    EXPECT_GT(error_of("fem_p1"), 0.05);
    EXPECT_NEAR(error_of("calculix"), error_of("fem_p1"), 1e-6);
}

/// examples/engines/calculix/calculix.py, which docs/studies/peers.md shows. Linear tetrahedra with CalculiX's own
/// energy of a change of volume find what it scores, to the seven digits that CalculiX writes.
TEST(CalculixExample, ScoresLargeDeformationsAsLinearElementsWithItsEnergy) {
    const auto ccx = tests::find_ccx();
    if (ccx.empty())
        GTEST_SKIP() << "there is no ccx";
    const auto folder = std::filesystem::path(LIVERMARK_PEER_RUNS) / "score_calculix";
    std::filesystem::remove_all(folder);
    const auto exported = tests::livermark(fmt::format("export liver_healthy large_traction -o {}", folder.string()));
    ASSERT_EQ(exported.status, 0) << exported.output;
    const auto problem = folder / "liver_healthy" / "large_traction.problem.h5", solution = folder / "solution.csv";
    const auto solved =
        tests::run_command(fmt::format("/usr/bin/python3 '{}/examples/engines/calculix/calculix.py' '{}' '{}'",
                                       LIVERMARK_SOURCE_DIR, problem.string(), solution.string()));
    ASSERT_EQ(solved.status, 0) << solved.output;
    EXPECT_NE(solved.output.find(R"({"engine": "calculix", "version": )"), std::string::npos) << solved.output;
    const auto scored =
        tests::livermark(fmt::format("score liver_healthy large_traction {} --name calculix --model fem_p1_neo_hookean "
                                     "--reference-on-mesh --markdown --output {}",
                                     solution.string(), folder.string()));
    ASSERT_EQ(scored.status, 0) << scored.output;
    EXPECT_NE(scored.output.find("| liver_healthy | large_traction | calculix | 12.36 |"), std::string::npos)
        << scored.output; // as in docs/studies/peers.md
    const auto result = results::read_result(folder / "liver_healthy" / "large_traction.calculix.h5");
    const auto &theirs = std::ranges::find(result.models, "calculix", &results::ModelResult::name)->solution;
    const auto ours = hyperelastic::solve(result.problem, tests::calculix_neo_hooke(),
                                          {.degree = 1, .rule = hyperelastic::TetrahedronRule::four_points},
                                          {.fractions = {0.5, 1.0}})
                          .solution;
    ASSERT_EQ(ours.status, core::SolutionStatus::ok) << ours.message;
    const auto comparison =
        core::compare(result.problem.body->mesh, result.problem.load_case, ours, theirs, "calculix");
    RecordProperty("relative_l2", fmt::format("{:.2e}", comparison.relative_l2));
    EXPECT_LT(comparison.relative_l2, 1e-6);
}

/// Membranes of a solver by other people are the capsule: its M3D3, thin layers of solid elements, find what ours do.
TEST(CalculixCapsule, FindsTheSameDisplacements) {
    const auto ccx = tests::find_ccx();
    if (ccx.empty())
        GTEST_SKIP() << "there is no ccx";
    const auto body = tests::covered::with_capsule(
        tests::make_body(tests::shaken_box_mesh({0.1, 0.03, 0.03}, {5, 2, 2}), {1060.0, 5000.0, 0.45}));
    auto load_case = tests::held(body->mesh);
    tests::pull(load_case, body->mesh, "x_max", {3.0, 1.0, -2.0});
    const core::Problem problem{body, load_case};
    const core::Problem bare{tests::covered::with_capsule(body, std::nullopt), load_case};
    const auto ours = fem_reference::solve_static(problem, 1), without = fem_reference::solve_static(bare, 1);
    auto theirs = ours;
    theirs.displacement = tests::solve_with_calculix(ccx, problem, 1, fmt::format("{}/capsule", LIVERMARK_PEER_RUNS));
    EXPECT_LT(core::compare(body->mesh, load_case, ours, theirs, "calculix").relative_l2, 1e-3);
    EXPECT_GT(core::compare(body->mesh, load_case, ours, without, "bare").relative_l2, 0.5);
}

/// A large load case that holds x_min and pulls at x_max.
core::LoadCase pulled_far(const core::TetraMesh &mesh, const core::Vector3 &traction) {
    auto load_case = tests::held(mesh);
    tests::pull(load_case, mesh, "x_max", traction);
    load_case.regime = core::Regime::large;
    load_case.path = {0.5, 1.0};
    return load_case;
}

core::Solution solved_far(const core::Problem &problem, int degree) {
    auto ours = hyperelastic::solve(problem, tests::calculix_neo_hooke(),
                                    {.degree = degree, .rule = hyperelastic::TetrahedronRule::four_points},
                                    {.fractions = {0.5, 1.0}})
                    .solution;
    EXPECT_EQ(ours.status, core::SolutionStatus::ok) << ours.message;
    return ours;
}

/// CalculiX finds a solution of ours, and another one is far off.
void expect_the_same(const core::Problem &problem, int degree, const core::Solution &ours, const std::string &name,
                     const core::Solution &without) {
    auto theirs = ours;
    theirs.displacement = tests::solve_with_calculix(tests::find_ccx(), problem, degree,
                                                     fmt::format("{}/{}_p{}", LIVERMARK_PEER_RUNS, name, degree));
    const auto error = core::compare(problem.body->mesh, problem.load_case, ours, theirs, "calculix").relative_l2;
    testing::Test::RecordProperty(fmt::format("{}_p{}", name, degree), fmt::format("{:.2e}", error));
    EXPECT_LT(error, 2e-6) << name << ", degree " << degree << "; CalculiX writes seven digits";
    EXPECT_GT(core::compare(problem.body->mesh, problem.load_case, ours, without, "without").relative_l2, 0.02);
}

/// Springs to the ground stand for a foundation, also where only normals are held, and on quadratic elements.
TEST(CalculixFoundation, FindsTheSameDisplacements) {
    if (tests::find_ccx().empty())
        GTEST_SKIP() << "there is no ccx";
    const auto body = tests::make_body(tests::shaken_box_mesh({0.1, 0.03, 0.03}, {5, 2, 2}), {1060.0, 5000.0, 0.45});
    auto load_case = pulled_far(body->mesh, {60.0, 10.0, -40.0}), all_held = load_case;
    core::Foundation foundation;
    for (int f = 0; f < body->mesh.num_boundary_triangles(); ++f) {
        const auto &patch = body->mesh.patch_names[body->mesh.boundary_patch[f]];
        if (patch != "y_max" && patch != "z_min")
            continue;
        foundation.facets.push_back(f);
        foundation.stiffness.push_back(patch == "y_max" ? 2e4 : 1e5);
        foundation.normal_only.push_back(patch == "z_min" ? 1 : 0);
    }
    load_case.foundation = foundation;
    all_held.foundation = foundation;
    all_held.foundation->normal_only.assign(foundation.facets.size(), 0);
    for (const int degree : {1, 2}) {
        const core::Problem problem{body, load_case};
        expect_the_same(problem, degree, solved_far(problem, degree), "foundation",
                        solved_far({body, all_held}, degree));
    }
}

/// Springs to the ground stand for fibres of vessels, which linear elements stretch evenly.
TEST(CalculixVessels, FindTheSameDisplacements) {
    if (tests::find_ccx().empty())
        GTEST_SKIP() << "there is no ccx";
    const auto bare = tests::make_body(tests::shaken_box_mesh({0.1, 0.1, 0.1}, {3, 3, 3}), {1060.0, 5000.0, 0.45});
    const auto body = tests::vessels::with_vessels(bare);
    auto small = tests::held(body->mesh);
    tests::pull(small, body->mesh, "x_max", {3.0, 1.0, -2.0});
    expect_the_same({body, small}, 1, fem_reference::solve_static({body, small}, 1), "vessels_small",
                    fem_reference::solve_static({bare, small}, 1));
    const auto large = pulled_far(body->mesh, {600.0, 200.0, -400.0});
    expect_the_same({body, large}, 1, solved_far({body, large}, 1), "vessels_large", solved_far({bare, large}, 1));
}

} // namespace
} // namespace livermark
