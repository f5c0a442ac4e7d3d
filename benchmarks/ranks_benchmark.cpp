// Started by mpirun: what the mixed reference costs on so many ranks.
#include <mpi.h>
#include <sys/resource.h>

#include <fmt/format.h>
#include <string>

#include "benchmarks/on_ranks.hpp"
#include "fem_reference/distributed/distributed_solver.hpp"
#include "load_cases/readers/load_case_reader.hpp"
#include "meshes/io/body_reader.hpp"
#include "support/processes/mpi_session.hpp"
#include "support/root_folder.hpp"

namespace livermark {
namespace {

struct Options {
    std::string body = "meshes/liver_healthy.toml", load_case = "gravity_tilt";
    double poisson_ratio = 0.49;
    int num_refinements = 0;
};

/// Of the largest rank [GB]
double peak_memory() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    double mine = 1e-6 * static_cast<double>(usage.ru_maxrss), largest = 0.0;
    MPI_Allreduce(&mine, &largest, 1, MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD);
    return largest;
}

void run(const Options &options) {
    const auto root = support::root_folder();
    auto body = std::make_shared<const core::Body>(
        meshes::read_body(root / options.body, {.young_modulus = {}, .poisson_ratio = options.poisson_ratio}));
    const core::Problem problem{
        body, load_cases::read_load_case(root / "load_cases" / (options.load_case + ".toml"), body->mesh)};
    const auto solution = fem_reference::solve_distributed(
        problem, {.formulation = fem_reference::Formulation::mixed, .num_refinements = options.num_refinements});
    const double memory = peak_memory();
    if (support::mpi_rank() == 0)
        fmt::print("Poisson {}, {} unknowns: {}; set-up {:.1f} s, solve {:.1f} s, {:.2f} GB on a rank at most, {}\n",
                   options.poisson_ratio, solution.degrees_of_freedom, solution.solver, solution.setup_seconds,
                   solution.solve_seconds, memory, core::to_string(solution.status));
}

int start(int argc, char **argv) {
    Options options;
    CLI::App app("Time, memory and iterations of the mixed elements on several MPI ranks: mpirun -n N ranks_benchmark");
    app.add_option("--body", options.body, "A .toml, relative to the source tree")->capture_default_str();
    app.add_option("--load-case", options.load_case, "Name of one that ships")->capture_default_str();
    app.add_option("--poisson", options.poisson_ratio, "Poisson's ratio everywhere")->capture_default_str();
    app.add_option("--refine", options.num_refinements, "How often each tetrahedron is cut into eight")
        ->capture_default_str()
        ->check(CLI::Range(0, 3));
    return benchmarks::on_ranks("ranks_benchmark", app, argc, argv, [&options] { run(options); });
}

} // namespace
} // namespace livermark

int main(int argc, char **argv) {
    return livermark::start(argc, argv);
}
