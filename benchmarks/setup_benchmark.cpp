// Time of what is done once for a body: spring parameters, the order of nodes, time steps, factors; see README.md.
#include <algorithm>
#include <benchmark/benchmark.h>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <memory>
#include <numeric>

#include "benchmarks/bodies.hpp"
#include "benchmarks/program.hpp"
#include "benchmarks/scene.hpp"
#include "fem_reference/dof_conditions.hpp"
#include "fem_reference/dynamics/mass_matrix.hpp"
#include "fem_reference/solvers/constrained_solver.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/kernels/layout/sliced_body.hpp"
#include "msm/springs/spring_network.hpp"

namespace {

namespace benchmarks = livermark::benchmarks;
namespace core = livermark::core;
namespace fem = livermark::fem_reference;
namespace msm = livermark::msm;

using BodyPointer = std::shared_ptr<const core::Body>;

/// Bodies are asked for one after the other.
BodyPointer body_of(const std::string &name) {
    static BodyPointer body;
    if (!body || body->name != name)
        body = benchmarks::make_body(name);
    return body;
}

void count(benchmark::State &state, const char *name, std::size_t number) {
    state.counters[name] = static_cast<double>(number);
}

void time_springs(benchmark::State &state, const core::Body &body, const msm::SpringLaw &law) {
    const auto springs = msm::spring_network(body, law);
    const auto is_stiffness = [](double stiffness) { return std::isfinite(stiffness) && stiffness > 0.0; };
    if (!std::ranges::all_of(springs.stiffness, is_stiffness)) {
        state.SkipWithError("a spring has a stiffness that none can have");
        return;
    }
    for (auto _ : state)
        benchmark::DoNotOptimize(msm::spring_network(body, law));
    count(state, "springs", springs.edges.size());
}

void time_order(benchmark::State &state, const core::Body &body) {
    const auto edges = core::edge_table(body.mesh.tetrahedra).edges;
    auto order = msm::reverse_cuthill_mckee(edges, body.mesh.num_nodes());
    std::ranges::sort(order);
    std::vector<int> all(body.mesh.points.size());
    std::iota(all.begin(), all.end(), 0);
    if (order != all) {
        state.SkipWithError("not every node is there once");
        return;
    }
    for (auto _ : state)
        benchmark::DoNotOptimize(msm::reverse_cuthill_mckee(edges, body.mesh.num_nodes()));
    count(state, "nodes", all.size());
}

void time_time_step(benchmark::State &state, const BodyPointer &body) {
    const auto scene = benchmarks::make_scene(body);
    const auto &points = body->mesh.points;
    if (!(scene.largest_angular_frequency <=
          msm::gershgorin_angular_frequency(scene.springs, points, scene.conditions))) {
        state.SkipWithError("the largest frequency is above its bound");
        return;
    }
    for (auto _ : state)
        benchmark::DoNotOptimize(msm::largest_angular_frequency(scene.springs, points, scene.conditions));
    count(state, "springs", scene.springs.edges.size());
}

/// Largest |K u - f| of the free unknowns over the largest |f|, f of ones.
double residual(fem::ConstrainedSolver &solver, const fem::ElasticSystem &system,
                const std::vector<double> &prescribed) {
    const std::vector<double> load(prescribed.size(), 1.0);
    std::vector<double> u(load.size()), force(load.size());
    solver.solve_constrained(load, u);
    system.stiffness.multiply(u, force);
    double largest = 0.0;
    for (std::size_t i = 0; i < load.size(); ++i)
        if (std::isnan(prescribed[i]))
            largest = std::max(largest, std::abs(force[i] - load[i]));
    return largest;
}

void time_factor(benchmark::State &state, const core::Body &body, int degree) {
    const auto system = fem::assemble(body, degree);
    const auto stiffness = compressed_rows(system.stiffness);
    const auto prescribed = fem::dof_conditions(benchmarks::constrained(body), system).prescribed;
    {
        fem::ConstrainedSolver solver(stiffness);
        if (!solver.factorise(prescribed) || !(residual(solver, system, prescribed) < 1e-6)) {
            state.SkipWithError("the factor solves nothing");
            return;
        }
    }
    for (auto _ : state) {
        state.PauseTiming(); // its matrix is its own
        fem::ConstrainedSolver solver(stiffness);
        state.ResumeTiming();
        solver.factorise(prescribed);
    }
    count(state, "unknowns", prescribed.size());
}

void add(const std::string &what, const std::string &body, const std::function<void(benchmark::State &)> &work) {
    benchmark::RegisterBenchmark(fmt::format("setup/{}/{}", what, body).c_str(), work)->Unit(benchmark::kMillisecond);
}

/// What takes minutes or more memory than most machines have is left out.
void add_all(const std::string &body) {
    const int refinements = benchmarks::num_refinements(body);
    if (refinements <= 1)
        for (const auto &law : msm::all_spring_laws())
            add("springs/" + law.name, body,
                [&law, body](benchmark::State &state) { time_springs(state, *body_of(body), law); });
    add("order/reverse_cuthill_mckee", body, [body](benchmark::State &state) { time_order(state, *body_of(body)); });
    add("largest_frequency", body, [body](benchmark::State &state) { time_time_step(state, body_of(body)); });
    for (const int degree : {1, 2})
        if (refinements + degree <= 2)
            add(fmt::format("factor/fem_p{}", degree), body,
                [body, degree](benchmark::State &state) { time_factor(state, *body_of(body), degree); });
}

} // namespace

int main(int argc, char **argv) {
    return benchmarks::run_program(argc, argv, [] {
        for (const auto &body : benchmarks::body_names())
            add_all(body);
    });
}
