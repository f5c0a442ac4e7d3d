// Time of a picture of the live page, 1/60 s of motion, on one core: live/<springs>/<body>; see README.md.
#include <algorithm>
#include <benchmark/benchmark.h>
#include <cmath>
#include <fmt/format.h>
#include <numbers>
#include <string>
#include <vector>

#include "app/live/scene.hpp"
#include "benchmarks/harness.hpp"

namespace livermark::benchmarks {

namespace {

constexpr double picture = 1.0 / 60.0; // [s]
constexpr double finger = 0.010;       // [m]
constexpr double deepest = 0.010;      // [m]

/// Settings that the page begins with.
live::Settings usual_settings(const std::string &springs) {
    return {.springs = springs, .young_modulus = 5e3, .poisson_ratio = 0.45};
}

std::vector<bool> constrained_at(const core::TetraMesh &mesh, const std::string &patch) {
    std::vector<bool> constrained;
    for (const int number : mesh.boundary_patch)
        constrained.push_back(mesh.patch_names[number] == patch);
    return constrained;
}

/// Node that is furthest in front.
int front_of(const core::TetraMesh &mesh) {
    const auto in_front = std::ranges::min_element(mesh.points, {}, [](const core::Vector3 &x) { return x.y(); });
    return static_cast<int>(in_front - mesh.points.begin());
}

/// A finger goes in and out again once in a second of motion.
void time_picture(benchmark::State &state, const std::string &springs, const std::string &name) {
    const auto body = make_body(name);
    live::Scene scene(*body, constrained_at(body->mesh, "posterior"));
    const auto chosen = scene.choose(usual_settings(springs));
    const core::Vector3 front = body->mesh.points[front_of(body->mesh)];
    const int num_steps = static_cast<int>(std::ceil(picture / chosen.time_step));
    const double length = num_steps * chosen.time_step;
    const long evaluations = scene.num_evaluations();
    int restarts = 0;
    double time = 0.0;
    for (auto _ : state) {
        const double depth = 0.5 * deepest * (1.0 - std::cos(2.0 * std::numbers::pi * time));
        const auto frame = scene.move({.kind = live::ToolKind::probe,
                                       .target = front + core::Vector3(0.0, depth - finger, 0.0),
                                       .radius = finger},
                                      num_steps);
        restarts = frame.restarts;
        time += length;
    }
    if (restarts > 0)
        return state.SkipWithError("the motion was lost");
    const auto pictures = static_cast<double>(state.iterations());
    state.counters["pace"] = benchmark::Counter(pictures * length, benchmark::Counter::kIsRate);
    state.counters["time_step"] = chosen.time_step;
    state.counters["steps"] = num_steps;
    state.counters["forces"] = static_cast<double>(scene.num_evaluations() - evaluations) / pictures;
}

} // namespace

} // namespace livermark::benchmarks

int main(int argc, char **argv) {
    using namespace livermark;
    return benchmarks::run_program(argc, argv, [] {
        for (const std::string springs : {"patch", "nodal_neo_hookean", "nodal_neo_hookean_f", "edge_neo_hookean"})
            for (const std::string body : {"liver_healthy", "liver_tumours"})
                benchmark::RegisterBenchmark(
                    fmt::format("live/{}/{}", springs, body).c_str(),
                    [springs, body](benchmark::State &state) { benchmarks::time_picture(state, springs, body); })
                    ->Unit(benchmark::kMillisecond);
    });
}
