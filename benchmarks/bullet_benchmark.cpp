// Time of the same work by a method of interactive/ and by Bullet, as bullet/<work>/<body>; see README.md.
#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <optional>

#include "benchmarks/bodies.hpp"
#include "benchmarks/bullet_comparisons.hpp"
#include "benchmarks/program.hpp"
#include "core/processor_time.hpp"

namespace {

namespace benchmarks = livermark::benchmarks;

constexpr int times_in_a_row = 5;

/// The work a few times from the start; implicit steps would come to rest, where there is nothing left to do.
/// @return time of all [s]
double time_of(const benchmarks::Side &side) {
    side.reset();
    const double start = livermark::core::processor_seconds();
    for (int i = 0; i < times_in_a_row; ++i)
        side.work();
    return livermark::core::processor_seconds() - start;
}

struct Checked {
    std::string name;
    benchmarks::Sides sides;
    double difference = 0.0, checked = 0.0; ///< of what is timed, and of what has converged
    std::string fault;
};

Checked check(const std::string &name, const benchmarks::Comparison &comparison, const std::string &body) {
    static std::optional<benchmarks::MovingScene> scene;
    if (!scene || scene->scene.body->name != body)
        scene = benchmarks::make_moving_scene(benchmarks::make_body(body));
    Checked checked{.name = name, .sides = comparison.make(*scene, false), .fault = {}};
    checked.difference = benchmarks::difference(checked.sides);
    checked.checked = benchmarks::difference(comparison.make(*scene, true));
    if (!(checked.checked < comparison.tolerance))
        checked.fault =
            fmt::format("results differ by {:.1e}, more than {:.1e}", checked.checked, comparison.tolerance);
    return checked;
}

/// Both by turns, so that a machine that is slow for a while is slow for both.
void time_both(benchmark::State &state, const std::string &name, const benchmarks::Comparison &comparison,
               const std::string &body) {
    static std::optional<Checked> last; // Google Benchmark calls several times
    if (!last || last->name != name)
        last = check(name, comparison, body);
    if (!last->fault.empty()) {
        state.SkipWithError(last->fault.c_str());
        return;
    }
    double ours = 0.0, theirs = 0.0;
    for (auto _ : state) {
        const double first = time_of(last->sides.ours), second = time_of(last->sides.bullet);
        state.SetIterationTime(first + second);
        ours += first;
        theirs += second;
    }
    const double all = static_cast<double>(state.iterations()) * times_in_a_row;
    state.counters["livermark"] = ours / all;
    state.counters["bullet"] = theirs / all;
    state.counters["bullet_over_livermark"] = theirs / ours;
    state.counters["inner_iterations"] = comparison.iterations;
    state.counters["difference"] = last->difference;
    state.counters["difference_converged"] = last->checked;
}

} // namespace

int main(int argc, char **argv) {
    return benchmarks::run_program(argc, argv, [] {
        for (const auto &body : benchmarks::body_names())
            if (benchmarks::num_refinements(body) <= 1 && body != "liver_tumours") // Bullet has one material for all
                for (const auto &comparison : benchmarks::bullet_comparisons()) {
                    const auto name = fmt::format("bullet/{}/{}", comparison.name, body);
                    benchmark::RegisterBenchmark(name.c_str(), [name, comparison, body](benchmark::State &state) {
                        time_both(state, name, comparison, body);
                    })->UseManualTime();
                }
    });
}
