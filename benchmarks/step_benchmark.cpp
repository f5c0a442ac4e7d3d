// Time of one step of everything that moves a body, as step/<integrator>/<competitor>/<body>; see README.md.
#include <benchmark/benchmark.h>
#include <cmath>
#include <fmt/format.h>
#include <optional>

#include "benchmarks/bodies.hpp"
#include "benchmarks/competitor.hpp"
#include "benchmarks/kernels/kernels.hpp"
#include "benchmarks/kernels/oracle.hpp"
#include "benchmarks/limits/limits.hpp"
#include "benchmarks/program.hpp"
#include "msm/dynamics/time_step.hpp"

namespace {

using livermark::benchmarks::Competitor;
using livermark::benchmarks::Method;
using livermark::benchmarks::Run;
using livermark::benchmarks::Scene;

/// Taken where every step is stable: the interval of the load case `release` [s].
constexpr double step_of_implicit = 0.004;

/// Memory that is touched for the first time makes the first steps slow.
constexpr int num_warm_up_steps = 3;

/// A scene, and the least time that one evaluation of its spring forces can take here, per spring [s].
struct Stage {
    Scene scene;
    double limit = 0.0;
};

/// Makes nothing twice that takes seconds: Google Benchmark calls a benchmark several times to find out how long it
/// takes, and asks for all competitors of a body one after the other.
const Stage &stage_of(const std::string &body) {
    static std::optional<Stage> stage;
    if (!stage || stage->scene.problem.body->name != body) {
        stage = Stage{.scene = livermark::benchmarks::make_scene(livermark::benchmarks::make_body(body))};
        const auto &scene = stage->scene;
        const auto num_nodes = static_cast<int>(scene.start.size());
        stage->limit =
            livermark::benchmarks::spring_limit(livermark::benchmarks::neighbours(scene.springs.edges, num_nodes))
                .longest();
    }
    return *stage;
}

/// A run that has been checked.
struct Checked {
    std::string name;
    double time_step = 0.0; ///< [s]
    Run run;
    std::string fault; ///< what is wrong with its steps, empty if nothing is
};

Checked check(const std::string &name, const Method &method, const Scene &scene) {
    const double critical = method.critical_time_step(scene);
    Checked checked{.name = name, .run = {}, .fault = {}};
    checked.time_step = std::isfinite(critical) ? livermark::msm::default_safety_factor * critical : step_of_implicit;
    checked.run = method.make(scene, checked.time_step);
    checked.fault = method.check(scene, checked.time_step, checked.run);
    for (int s = 0; s < num_warm_up_steps; ++s)
        checked.run.step();
    return checked;
}

void time_steps(benchmark::State &state, const std::string &name, const Method &method, const std::string &body) {
    static std::optional<Checked> last;
    const auto &[scene, limit] = stage_of(body);
    if (!last || last->name != name) {
        last.reset(); // frees the memory of the one before first
        last = check(name, method, scene);
    }
    if (!last->fault.empty()) {
        state.SkipWithError(last->fault.c_str());
        return;
    }
    for (auto _ : state)
        last->run.step();
    // Kept: after a first repetition that fails, Google Benchmark 1.7 crashes if others do not.
    last->fault = livermark::benchmarks::has_left(scene, last->run);
    if (!last->fault.empty()) {
        state.SkipWithError(last->fault.c_str());
        return;
    }

    using benchmark::Counter;
    const auto num_springs = static_cast<double>(scene.springs.edges.size());
    const double forces = method.forces_per_step;
    state.counters["springs"] = num_springs;
    state.counters["time_per_spring"] =
        Counter(num_springs * forces, Counter::kIsIterationInvariantRate | Counter::kInvert);
    state.counters["of_limit"] = Counter(limit * num_springs * forces, Counter::kIsIterationInvariantRate);
    if (last->run.bytes > 0)
        state.counters["bytes_per_spring"] = static_cast<double>(last->run.bytes) / num_springs;
    state.counters["steps_per_second"] = Counter(1.0, Counter::kIsIterationInvariantRate);
    state.counters["time_step"] = last->time_step;
    state.counters["real_time_factor"] = Counter(last->time_step, Counter::kIsIterationInvariantRate);
}

/// One competitor on one body. Bodies are the outer loop of main(), so that each is made once.
void add(const Competitor &competitor, const std::string &body) {
    for (const auto &method : competitor.methods) {
        if (livermark::benchmarks::num_refinements(body) > method.max_refinements)
            continue;
        const auto name = fmt::format("step/{}/{}/{}", method.integrator, competitor.name, body);
        auto *added = benchmark::RegisterBenchmark(
            name.c_str(), [name, method, body](benchmark::State &state) { time_steps(state, name, method, body); });
        if (method.num_threads > 1)
            added->UseRealTime(); // the processor time of one thread says nothing
        added->Unit(benchmark::kMicrosecond);
    }
}

} // namespace

int main(int argc, char **argv) {
    return livermark::benchmarks::run_program(argc, argv, [] {
        const auto kernels = livermark::benchmarks::our_kernels();
        for (const auto &body : livermark::benchmarks::body_names()) {
            for (const auto &kernel : kernels)
                add(kernel, body);
            for (const auto &peer : livermark::benchmarks::all_peers())
                add(peer, body);
        }
    });
}
