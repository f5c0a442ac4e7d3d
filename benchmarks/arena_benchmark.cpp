// What a frame of each method of the arena costs, on one core and on two at once, beside what it computes and moves;
// see README.md.
#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <sstream>
#include <string>
#include <utility>

#include "benchmarks/limits/limits.hpp"
#include "benchmarks/program.hpp"
#include "benchmarks/work/counts.hpp"
#include "benchmarks/work/pressed_body.hpp"
#include "models/motion/moving_method.hpp"
#include "support/processes/child_process.hpp"

namespace {

namespace benchmarks = livermark::benchmarks;
namespace core = livermark::core;
namespace models = livermark::models;

/// One of each thread, so that bodies share the memory of the machine and nothing else. Made once, however often the
/// benchmark asks, in the order in which threads come.
benchmarks::PressedBody &pressed_body(const models::MovingMethod &moving_method, const std::string &body, int thread) {
    static std::mutex one_at_a_time;
    static std::map<std::string, std::shared_ptr<const core::Problem>> problems;
    static std::map<int, std::unique_ptr<benchmarks::PressedBody>> of_threads; // of one method at a time
    static std::string method;
    const std::scoped_lock lock(one_at_a_time);
    if (const auto name = moving_method.name + "/" + body; name != method) {
        of_threads.clear();
        method = name;
    }
    auto &pressed = of_threads[thread];
    if (!pressed) {
        auto &problem = problems[body];
        if (!problem)
            problem = std::make_shared<const core::Problem>(benchmarks::pressed_problem(body));
        pressed = std::make_unique<benchmarks::PressedBody>(moving_method, problem);
    }
    return *pressed;
}

/// Of one step, by the work_counter, once for each method; nothing where it was not built or fails.
std::optional<benchmarks::Work> counted_work(const std::string &method, const std::string &body) {
    static std::mutex one_at_a_time;
    static std::map<std::string, std::optional<benchmarks::Work>> known;
    const std::scoped_lock lock(one_at_a_time);
    const auto [found, is_new] = known.try_emplace(method + "/" + body);
#ifdef LIVERMARK_WORK_COUNTER
    if (is_new) {
        const auto outcome = livermark::support::run_program({LIVERMARK_WORK_COUNTER, method, body});
        benchmarks::Work work;
        if (outcome.status == 0 && outcome.lines.size() == 1 &&
            std::istringstream(outcome.lines.front()) >> work.operations >> work.bytes)
            found->second = work;
    }
#endif
    return found->second;
}

void time_frames(benchmark::State &state, const models::MovingMethod &moving_method, const std::string &body) {
    auto &pressed = pressed_body(moving_method, body, state.thread_index());
    for (auto _ : state)
        pressed.advance();
    if (pressed.has_left_all_bounds()) {
        state.SkipWithError("the body has left all bounds");
        return;
    }
    using benchmark::Counter;
    const auto tetrahedra = static_cast<double>(pressed.problem().body->mesh.tetrahedra.size());
    const double stored = pressed.body().cost(pressed.effort()).bytes_per_element;
    const int steps = pressed.steps_in_frame();
    const auto of_thread = [](double value, int flags = 0) {
        return Counter(value, static_cast<Counter::Flags>(Counter::kAvgThreads | flags));
    };
    state.counters["tetrahedra"] = of_thread(tetrahedra);
    state.counters["steps"] = of_thread(steps);
    state.counters["stored"] = of_thread(stored);
    state.counters["time_per_tetrahedron"] =
        of_thread(steps * tetrahedra, Counter::kIsIterationInvariantRate | Counter::kInvert);
    const auto work = counted_work(moving_method.name, body);
    if (!work)
        return;
    const auto operations = static_cast<double>(work->operations), bytes = static_cast<double>(work->bytes);
    const double bandwidth = benchmarks::read_bandwidth(static_cast<std::size_t>(stored * tetrahedra));
    state.counters["flop"] = of_thread(operations / tetrahedra);
    state.counters["bytes"] = of_thread(bytes / tetrahedra);
    state.counters["of_arithmetic"] =
        of_thread(steps * operations / benchmarks::arithmetic_throughput(), Counter::kIsIterationInvariantRate);
    state.counters["of_bandwidth"] = of_thread(steps * bytes / bandwidth, Counter::kIsIterationInvariantRate);
}

void register_all() {
    for (const std::string body : {"liver_healthy", "liver_refined_once"})
        for (const auto &moving_method : models::all_moving_methods())
            for (const int threads : {1, 2})
                benchmark::RegisterBenchmark(
                    fmt::format("frame/{}/{}", moving_method.name, body).c_str(),
                    [moving_method, body](benchmark::State &state) { time_frames(state, moving_method, body); })
                    ->Threads(threads)
                    ->Unit(benchmark::kMillisecond);
}

} // namespace

int main(int argc, char **argv) {
    return benchmarks::run_program(argc, argv, register_all);
}
