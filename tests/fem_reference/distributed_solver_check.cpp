// Started by mpirun from CTest: the distributed solver against the serial one, on every rank.
// With an argument, rank 0 compares its solutions with those that an earlier run wrote to that file, or writes them.
#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <stdexcept>

#include "core/mesh/refinement.hpp"
#include "core/mesh/tetra_mesh.hpp"
#include "core/support/processes/mpi_session.hpp"
#include "fem_reference/hyperelastic/hyperelasticity.hpp"
#include "fem_reference/linear/linear_elasticity.hpp"
#include "tests/fem_reference/fem_test_bodies.hpp"

namespace livermark {
namespace {

using core::Vector3;
constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double agreement = 1e-8;

/// A rod of two materials, constrained at one end, with a side that is moved along its normal only and meets the
/// constrained end at an edge, and an end of which one component is prescribed: pulled on a side, and hanging.
core::Problem rod(double poisson_ratio, const std::array<int, 3> &bricks = {5, 4, 3}) {
    auto problem = tests::shaken_rod(poisson_ratio, bricks);
    tests::prescribe(problem.load_case, problem.body->mesh, "x_max", {0.002, -0.001, nan});
    tests::pull(problem.load_case, problem.body->mesh, "z_max", {20.0, -10.0, 5.0});
    for (const auto &point : problem.body->mesh.points)
        problem.load_case.node_factor.push_back(1.0 + 5.0 * point.y());
    for (const auto &point : problem.body->mesh.points)
        problem.load_case.node_shift.emplace_back(0.002 * point.z(), -0.001 * point.y(), 0.0);
    return problem;
}

/// The same rod, held at one end and pressed from the side.
core::Problem pressed_rod(double poisson_ratio, double depth) {
    auto problem = tests::shaken_rod(poisson_ratio, {4, 3, 2});
    problem.load_case = tests::empty_load_case(problem.body->mesh);
    tests::prescribe(problem.load_case, problem.body->mesh, "x_min", Vector3::Zero());
    tests::press(problem.load_case, problem.body->mesh, "z_max", {0.5, 0.0, -1.0}, depth);
    return problem;
}

/// Counts and reports what does not hold.
struct Report {
    int num_faults = 0;

    void expect(bool holds, const std::string &what) {
        if (holds)
            return;
        ++num_faults;
        fmt::print(stderr, "rank {} of {}: {}\n", support::mpi_rank(), support::mpi_num_ranks(), what);
    }
    void agree(const core::Solution &a, const core::Solution &b, const std::string &name) {
        expect(a.status == core::SolutionStatus::ok, name + ": " + a.message);
        const double u = tests::relative_difference(a.displacement, b.displacement);
        const double reaction = tests::relative_difference(a.reaction, b.reaction);
        const double energy = std::abs(a.strain_energy - b.strain_energy) / b.strain_energy;
        expect(u < agreement, fmt::format("{}: displacements differ by {}", name, u));
        expect(reaction < agreement, fmt::format("{}: reactions differ by {}", name, reaction));
        expect(energy < agreement, fmt::format("{}: energies differ by {}", name, energy));
        expect(a.degrees_of_freedom == b.degrees_of_freedom, name + ": other number of unknowns");
        if (support::mpi_rank() == 0)
            fmt::print("{}: {}; u {:.1e}, reactions {:.1e}, energy {:.1e}\n", name, a.solver, u, reaction, energy);
    }
};

std::vector<double> numbers(const std::vector<core::Solution> &solutions) {
    std::vector<double> out;
    for (const auto &solution : solutions) {
        for (const auto &vectors : {solution.displacement, solution.reaction})
            for (const auto &vector : vectors)
                out.insert(out.end(), vector.begin(), vector.end());
        out.push_back(solution.strain_energy);
    }
    return out;
}

/// A run on one rank writes what a run on more ranks has to find.
void compare_with_one_rank(const std::vector<core::Solution> &solutions, const std::filesystem::path &file,
                           Report &report) {
    if (support::mpi_num_ranks() == 1) {
        std::ofstream out(file);
        for (const double number : numbers(solutions))
            out << fmt::format("{:.17g}\n", number);
        return;
    }
    std::ifstream in(file);
    std::vector<double> before;
    for (double number = 0.0; in >> number;)
        before.push_back(number);
    const auto now = numbers(solutions);
    report.expect(now.size() == before.size(), "one rank found another number of values");
    std::size_t first = 0;
    for (const auto &solution : solutions) { // each field by its largest entry
        const auto size_of_fields = {3 * solution.displacement.size(), 3 * solution.reaction.size(), std::size_t{1}};
        for (const auto size : size_of_fields) {
            double largest = 0.0, difference = 0.0;
            for (std::size_t k = first; k < std::min({first + size, now.size(), before.size()}); ++k) {
                largest = std::max(largest, std::abs(before[k]));
                difference = std::max(difference, std::abs(now[k] - before[k]));
            }
            report.expect(difference < agreement * largest,
                          fmt::format("one rank and several differ by {} of {}", difference, largest));
            first += size;
        }
    }
}

void expect_refusals(Report &report) {
    const auto refuses = [&](const core::Problem &problem, int degree, const std::string &what) {
        try {
            fem_reference::solve_distributed(problem, {.degree = degree});
            report.expect(false, what + " was accepted");
        } catch (const std::invalid_argument &) {
        }
    };
    const auto good = rod(0.3);
    refuses(good, 3, "degree 3");
    auto other_mesh = good;
    other_mesh.load_case.condition_on.pop_back();
    refuses(other_mesh, 1, "a load case of another mesh");
    auto body = *good.body;
    body.mesh.boundary_triangles[1] = body.mesh.boundary_triangles[0];
    refuses({std::make_shared<const core::Body>(body), good.load_case}, 1, "a boundary triangle given twice");

    const auto early = fem_reference::solve_distributed(good, {.degree = 2, .max_iterations = 3});
    report.expect(early.status == core::SolutionStatus::not_converged, "three iterations were enough");
    report.expect(early.message.find("after 3 iterations") != std::string::npos, early.message);
    report.expect(early.strain_energy > 0.0, "the last iterate is not given");

    auto loose = good;
    loose.load_case = tests::empty_load_case(good.body->mesh);
    tests::prescribe(loose.load_case, good.body->mesh, "x_min", {0.0, 0.0, nan}); // may slide along z
    loose.load_case.acceleration = {0.0, 0.0, 1.0};
    const auto found = fem_reference::solve_distributed(loose, {.degree = 2});
    report.expect(found.status == core::SolutionStatus::not_converged, "a body free to move was solved");
    report.expect(found.message.find("free to move") != std::string::npos, "no reason given: " + found.message);
    report.expect(std::isnan(found.strain_energy), "a body free to move has an energy");
}

/// By a seventh, with a pressure that follows the surface on a side.
core::Solution compressed(double poisson_ratio, Report &report) {
    auto problem = rod(poisson_ratio, {4, 3, 2});
    const auto &mesh = problem.body->mesh;
    const auto box = core::bounding_box(mesh.points);
    tests::prescribe(problem.load_case, mesh, "x_max", {-box.sizes().x() / 7.0, 0.0, nan});
    std::vector<double> pressure(mesh.boundary_triangles.size(), 0.0);
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (mesh.patch_names[mesh.boundary_patch[f]] == "y_max")
            pressure[f] = 200.0;
    const auto &law = hyperelastic::material_law("neo_hookean");
    const hyperelastic::LoadPath path{.fractions = {0.5, 1.0}, .tolerance = 1e-11};
    auto found = hyperelastic::solve_distributed(problem, law, path, pressure);
    const auto expected = hyperelastic::solve(
        problem, law, {.degree = 2, .formulation = fem_reference::Formulation::mixed}, path, pressure);
    report.expect(found.steps.size() == expected.steps.size(), "another number of load steps");
    report.agree(found.solution, expected.solution, fmt::format("neo-Hookean at {}", poisson_ratio));
    return found.solution;
}

void check_presses(Report &report) {
    const auto linear = pressed_rod(0.45, 0.001);
    for (const auto formulation : {fem_reference::Formulation::displacement, fem_reference::Formulation::mixed})
        report.agree(fem_reference::solve_distributed(linear, {.formulation = formulation}),
                     fem_reference::solve_static(linear, 2, fem_reference::SolverChoice::direct, formulation),
                     "pressed");
    const auto large = pressed_rod(0.45, 0.01);
    const auto &law = hyperelastic::material_law("neo_hookean");
    const hyperelastic::LoadPath path{.fractions = {0.5, 1.0}, .tolerance = 1e-11};
    const auto expected =
        hyperelastic::solve(large, law, {.degree = 2, .formulation = fem_reference::Formulation::mixed}, path);
    report.agree(hyperelastic::solve_distributed(large, law, path).solution, expected.solution, "neo-Hookean, pressed");
}

/// Standing on two sides, on one of them along the normal alone.
void check_foundations(Report &report) {
    auto problem = rod(0.45, {4, 3, 2});
    auto &foundation = problem.load_case.foundation.emplace();
    const auto &mesh = problem.body->mesh;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        for (const auto *patch : {"y_max", "z_min"})
            if (mesh.patch_names[mesh.boundary_patch[f]] == patch) {
                foundation.facets.push_back(f);
                foundation.stiffness.push_back(3e5);
                foundation.normal_only.push_back(std::string(patch) == "y_max" ? 1 : 0);
            }
    for (const auto formulation : {fem_reference::Formulation::displacement, fem_reference::Formulation::mixed})
        for (const int num_refinements : {0, 1}) {
            auto expected = fem_reference::solve_static(num_refinements == 0 ? problem : core::refine(problem), 2,
                                                        fem_reference::SolverChoice::direct, formulation);
            expected.displacement.resize(mesh.points.size());
            report.agree(fem_reference::solve_distributed(
                             problem, {.formulation = formulation, .num_refinements = num_refinements}),
                         expected, "on a foundation");
        }
}

int check(const std::filesystem::path &file) {
    Report report;
    std::vector<core::Solution> solutions;
    for (const double poisson_ratio : {0.25, 0.45})
        for (const int degree : {1, 2}) {
            // large enough for two levels of multigrid
            const auto problem = degree == 1 ? rod(poisson_ratio, {12, 9, 8}) : rod(poisson_ratio);
            solutions.push_back(fem_reference::solve_distributed(problem, {.degree = degree}));
            report.agree(solutions.back(),
                         fem_reference::solve_static(problem, degree, fem_reference::SolverChoice::direct),
                         fmt::format("P{} at {}", degree, poisson_ratio));
        }
    for (const double poisson_ratio : {0.25, 0.45, 0.499})
        for (const int num_refinements : {0, 1}) {
            const auto problem = rod(poisson_ratio, {4, 3, 2});
            solutions.push_back(fem_reference::solve_distributed(
                problem, {.formulation = fem_reference::Formulation::mixed, .num_refinements = num_refinements}));
            auto expected =
                fem_reference::solve_static(num_refinements == 0 ? problem : core::refine(problem), 2,
                                            fem_reference::SolverChoice::direct, fem_reference::Formulation::mixed);
            expected.displacement.resize(problem.body->mesh.points.size()); // the nodes of the mesh come first
            report.agree(solutions.back(), expected,
                         fmt::format("mixed at {}, refined {} times", poisson_ratio, num_refinements));
        }
    for (const double poisson_ratio : {0.25, 0.49}) {
        solutions.push_back(compressed(poisson_ratio, report));
    }
    check_presses(report);
    check_foundations(report);
    if (support::mpi_rank() == 0)
        compare_with_one_rank(solutions, file, report);
    expect_refusals(report);
    return report.num_faults == 0 ? 0 : 1;
}

} // namespace
} // namespace livermark

int main(int argc, char **argv) {
    if (argc != 2) {
        fmt::print(stderr, "usage: mpirun -n N {} FILE, first with N = 1\n", argv[0]);
        return 2;
    }
    const livermark::support::MpiSession session;
    return livermark::check(argv[1]);
}
