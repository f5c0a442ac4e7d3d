// Started by mpirun: whether the error bar of the reference of small deformations contains what meshes find that are
// refined uniformly, twice.
#include <algorithm>
#include <fmt/format.h>
#include <memory>
#include <string>
#include <vector>

#include "benchmarks/on_ranks.hpp"
#include "core/error_norms.hpp"
#include "core/mesh/local_refinement.hpp"
#include "core/observed_error.hpp"
#include "fem_reference/distributed/distributed_solver.hpp"
#include "load_cases/readers/load_case_reader.hpp"
#include "meshes/io/body_reader.hpp"
#include "models/model_table.hpp"
#include "support/input_error.hpp"
#include "support/processes/mpi_session.hpp"
#include "support/root_folder.hpp"

namespace livermark {
namespace {

struct Options {
    std::string body = "meshes/liver_healthy.toml", load_case = "palpation";
    int num_refinements = 2, num_rims = 0;
};

constexpr double percent = 100.0;

void print(const std::string &line) {
    if (support::mpi_rank() == 0)
        fmt::print("{}\n", line);
}

core::Solution solve_reference(const core::Problem &problem) {
    const auto models = models::all_models();
    return std::ranges::find(models, core::Role::refined_reference, &core::Model::at_rest)->solve(problem);
}

/// @return at the nodes of the mesh, which come first
core::Solution solve_uniform(const core::Problem &at_rims, int num_refinements, std::size_t num_nodes) {
    auto solution = fem_reference::solve_distributed(
        at_rims, {.formulation = fem_reference::Formulation::mixed, .num_refinements = num_refinements});
    solution.displacement.resize(num_nodes);
    return solution;
}

/// A reaction or energy as it is off [%].
std::string off(double error) {
    return fmt::format("{:.2f}", percent * std::abs(error));
}

void print_row(const core::Problem &problem, const core::Solution &reference, const core::Solution &other,
               const std::string &name) {
    const auto difference = core::compare(problem.body->mesh, problem.load_case, reference, other, name);
    const auto bar = other.observed_error ? fmt::format("{} of order {:.2f}", off(other.observed_error->relative_l2),
                                                        other.observed_error->order)
                                          : "-";
    print(fmt::format("| {} | {} | {} | {} | {} | {} |", name, other.degrees_of_freedom, off(difference.relative_l2),
                      off(difference.reaction_error), off(difference.energy_error), bar));
}

void run(const Options &options) {
    const auto root = support::root_folder();
    const auto body = std::make_shared<const core::Body>(meshes::read_body(root / options.body));
    const auto &mesh = body->mesh;
    core::Problem problem{body, load_cases::read_load_case(root / "load_cases" / (options.load_case + ".toml"), mesh)};
    if (problem.load_case.regime != core::Regime::small)
        throw support::InputError(options.load_case + " is not of the small regime; name one that is");
    problem.load_case.release.reset();
    const auto reference = solve_reference(problem);
    const auto &bar = reference.observed_error.value();
    print(fmt::format("{}, {}: the reference has {} unknowns, a bar of {} %, and of {} % in reactions and {} % in the "
                      "energy",
                      body->name, options.load_case, reference.degrees_of_freedom, off(bar.relative_l2),
                      off(bar.reaction), off(bar.energy)));
    print("| mesh | unknowns | displacement of the reference off [%] | reactions [%] | energy [%] | own bar [%] |");
    print("| --- | ---: | ---: | ---: | ---: | ---: |");
    const auto at_rims = core::refine_at_rims(problem, options.num_rims);
    std::vector<core::Solution> levels;
    for (int level = 0; level <= options.num_refinements; ++level) {
        levels.push_back(solve_uniform(at_rims, level, mesh.points.size()));
        if (levels.back().status != core::SolutionStatus::ok)
            return print(levels.back().message);
        print_row(problem, reference, levels.back(), fmt::format("refined {} times", level));
    }
    if (levels.size() < 3)
        return;
    const auto limit = core::extrapolated(mesh, problem.load_case, levels);
    print_row(problem, reference, limit, "limit of these");
    const double difference = core::compare(mesh, problem.load_case, reference, limit, "limit").relative_l2;
    const double allowed = bar.relative_l2 + limit.observed_error->relative_l2;
    print(fmt::format("{} % from the limit, the two bars are {} % together: {}", off(difference), off(allowed),
                      difference <= allowed ? "contained" : "not contained"));
}

int start(int argc, char **argv) {
    Options options;
    CLI::App app("Whether the error bar of fem_p2p1_refined contains the limit of meshes that are refined uniformly: "
                 "mpirun -n N uniform_benchmark");
    app.add_option("--body", options.body, "A .toml, relative to the source tree")->capture_default_str();
    app.add_option("--load-case", options.load_case, "Name of a small one that ships")->capture_default_str();
    app.add_option("--refine", options.num_refinements, "How often each tetrahedron is cut into eight")
        ->capture_default_str()
        ->check(CLI::Range(0, 3));
    app.add_option("--rims", options.num_rims, "How often the rims of places are refined before that")
        ->capture_default_str()
        ->check(CLI::Range(0, 3));
    return benchmarks::on_ranks("uniform_benchmark", app, argc, argv, [&options] { run(options); });
}

} // namespace
} // namespace livermark

int main(int argc, char **argv) {
    return livermark::start(argc, argv);
}
