// What a frame of each method of the arena costs, on one core and on two at once, beside what it reads; see README.md.
#include <algorithm>
#include <benchmark/benchmark.h>
#include <cmath>
#include <fmt/format.h>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "benchmarks/bodies.hpp"
#include "benchmarks/limits/limits.hpp"
#include "benchmarks/program.hpp"
#include "core/mesh/bounding_box.hpp"
#include "load_cases/readers/load_case_reader.hpp"
#include "models/tool_motion/moving_method.hpp"
#include "support/root_folder.hpp"

namespace {

namespace benchmarks = livermark::benchmarks;
namespace core = livermark::core;
namespace models = livermark::models;

/// Of methods that have a choice: about what their users take.
constexpr models::Effort usual_effort{.steps = 1, .iterations = 10};
constexpr int num_warm_up_frames = 3;
constexpr double way_in = 0.5; ///< of the press, where the tool is

/// One of each thread, so that bodies share the memory of the machine and nothing else.
struct MovingScene {
    std::shared_ptr<const core::Problem> problem;
    std::unique_ptr<models::MovingBody> body;
    models::Effort effort;

    void advance() { body->advance(way_in * problem->load_case.tool->press_until, effort); }
};

core::Problem pressed(const std::string &body_name) {
    const auto body = benchmarks::make_body(body_name);
    return {body,
            livermark::load_cases::read_load_case(
                livermark::support::root_folder() / "load_cases" / "moving" / "press_and_slide.toml", body->mesh)};
}

/// Made once, however often the benchmark asks, in the order in which threads come.
MovingScene &scene_of(const models::MovingMethod &moving_method, const std::string &body, int thread) {
    static std::mutex one_at_a_time;
    static std::map<std::string, std::shared_ptr<const core::Problem>> problems;
    static std::map<std::pair<std::string, int>, MovingScene> scenes; // of one method at a time
    static std::string method;
    const std::scoped_lock lock(one_at_a_time);
    if (const auto name = moving_method.name + "/" + body; name != method) {
        scenes.clear();
        method = name;
    }
    auto &scene = scenes[{method, thread}];
    if (!scene.body) {
        auto &problem = problems[body];
        if (!problem)
            problem = std::make_shared<const core::Problem>(pressed(body));
        scene.problem = problem;
        scene.body = moving_method.prepare(*problem);
        scene.effort = scene.body->least_effort().value_or(usual_effort);
        scene.body->prepare_for(scene.effort);
        // Step by step, as in the arena: a tool that jumps throws springs out of all bounds.
        const auto &tool = *scene.problem->load_case.tool;
        for (double time = tool.frame_interval; time < way_in * tool.press_until; time += tool.frame_interval)
            scene.body->advance(time, scene.effort);
        for (int f = 0; f < num_warm_up_frames; ++f)
            scene.advance();
    }
    return scene;
}

bool has_left(const MovingScene &scene) {
    const double bound = core::extent(scene.problem->body->mesh.points);
    return !std::ranges::all_of(scene.body->displacement(),
                                [&](const core::Vector3 &u) { return u.lpNorm<Eigen::Infinity>() < bound; });
}

void time_frames(benchmark::State &state, const models::MovingMethod &moving_method, const std::string &body) {
    auto &scene = scene_of(moving_method, body, state.thread_index());
    for (auto _ : state)
        scene.advance();
    if (has_left(scene)) {
        state.SkipWithError("the body has left all bounds");
        return;
    }
    using benchmark::Counter;
    const auto tetrahedra = static_cast<double>(scene.problem->body->mesh.tetrahedra.size());
    const auto [passes, bytes_of_element] = scene.body->cost(scene.effort);
    const double bytes = bytes_of_element * tetrahedra;
    const auto of_thread = [](double value, int flags = 0) {
        return Counter(value, static_cast<Counter::Flags>(Counter::kAvgThreads | flags));
    };
    state.counters["tetrahedra"] = of_thread(tetrahedra);
    state.counters["passes"] = of_thread(passes);
    state.counters["bytes_per_tetrahedron"] = of_thread(bytes_of_element);
    state.counters["time_per_tetrahedron"] =
        of_thread(passes * tetrahedra, Counter::kIsIterationInvariantRate | Counter::kInvert);
    state.counters["of_limit"] = of_thread(passes * bytes / benchmarks::read_bandwidth(static_cast<std::size_t>(bytes)),
                                           Counter::kIsIterationInvariantRate);
}

void register_all() {
    for (const std::string body : {"liver_healthy", "liver_refined_once"})
        for (const auto &moving_method : models::all_moving_methods())
            for (const int threads : {1, 2})
                benchmark::RegisterBenchmark(
                    fmt::format("frame/{}/{}", moving_method.name, body).c_str(),
                    [moving_method, body](benchmark::State &state) { time_frames(state, moving_method, body); })
                    ->Threads(threads)
                    ->UseRealTime()
                    ->Unit(benchmark::kMillisecond);
}

} // namespace

int main(int argc, char **argv) {
    return benchmarks::run_program(argc, argv, register_all);
}
