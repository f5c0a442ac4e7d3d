// A hand that asks a soft body for its force a thousand times in a second: how long it waits.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <numbers>
#include <string>
#include <vector>

#include "core/processor_time.hpp"
#include "live/scene.hpp"
#include "live/springs.hpp"
#include "load_cases/readers/load_case_reader.hpp"
#include "meshes/io/body_reader.hpp"
#include "support/input_error.hpp"
#include "support/root_folder.hpp"

namespace livermark {
namespace {

struct Options {
    std::vector<std::string> bodies{"liver_healthy", "liver_tumours"};
    std::vector<std::string> springs{"patch", "nodal_springs", "nodal_neo_hookean"};
    std::vector<int> threads{1, 2};
    double poisson_ratio = 0.45, depth = 0.01, seconds = 2.0;
};

double real_time() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// The smallest that this part of them does not exceed.
double percentile(std::vector<double> values, double part) {
    const auto rank = static_cast<std::ptrdiff_t>(std::ceil(part * static_cast<double>(values.size()))) - 1;
    std::ranges::nth_element(values, values.begin() + rank);
    return values[static_cast<std::size_t>(rank)];
}

/// A load case that constrains a liver at its back.
std::vector<bool> constrained_facets(const core::Body &body) {
    const auto load_case = load_cases::read_load_case(support::root_folder() / "load_cases/palpation.toml", body.mesh);
    std::vector<bool> constrained;
    for (int f = 0; f < load_case.num_facets(); ++f)
        constrained.push_back(load_case.is_constrained(f) && load_case.value[f].isZero(0.0));
    return constrained;
}

/// A finger of 10 mm at the front of the body, that goes in as deep as it should and out again once in a second.
live::Tool finger(const core::Vector3 &front, double depth, double time) {
    const double way = 0.5 * depth * (1.0 - std::cos(2.0 * std::numbers::pi * time));
    constexpr double radius = 0.01;
    return {.kind = live::ToolKind::probe, .target = front + core::Vector3(0.0, way - radius, 0.0), .radius = radius};
}

struct Times {
    std::vector<double> real, processor; ///< of each step with its force [s]
    std::vector<double> without_tool;    ///< of a step of a body that nobody touches [s], of the processor
    double frame = 0.0;                  ///< what a picture takes beside the steps [s], of the processor
    double strongest = 0.0;              ///< force on the finger [N]
    double evaluations = 0.0;            ///< of the forces, for each step
    double time_step = 0.0;
};

Times time_hand(live::Scene &scene, const live::Chosen &chosen, const core::Vector3 &front, const Options &options) {
    Times times;
    times.time_step = chosen.time_step;
    for (int step = 0; step < 100; ++step) {
        const double start = core::processor_seconds();
        scene.feel({}, 1);
        times.without_tool.push_back(core::processor_seconds() - start);
    }
    const auto num_steps = std::max(1, static_cast<int>(options.seconds / chosen.time_step));
    const long before = scene.num_evaluations();
    for (int step = 0; step < num_steps; ++step) {
        const auto tool = finger(front, options.depth, step * chosen.time_step);
        const double real = real_time(), processor = core::processor_seconds();
        const auto force = scene.feel(tool, 1);
        times.real.push_back(real_time() - real);
        times.processor.push_back(core::processor_seconds() - processor);
        times.strongest = std::max(times.strongest, force.norm());
    }
    times.evaluations = static_cast<double>(scene.num_evaluations() - before) / num_steps;
    const double start = core::processor_seconds();
    const auto frame = scene.move(finger(front, options.depth, options.seconds), 0);
    times.frame = core::processor_seconds() - start;
    if (frame.restarts > 0)
        throw support::InputError("the motion has left all bounds; press less deep");
    return times;
}

void print_histogram(const std::vector<double> &seconds) {
    constexpr double first = 50e-6;
    constexpr int num_bins = 12; // each sqrt 2 wider than the one before
    std::array<std::size_t, num_bins + 1> count{};
    for (const double s : seconds)
        ++count[static_cast<std::size_t>(std::clamp(std::ceil(2.0 * std::log2(s / first)), 0.0, double(num_bins)))];
    for (int bin = 0; bin <= num_bins; ++bin)
        if (const double part = static_cast<double>(count[bin]) / static_cast<double>(seconds.size()); count[bin] > 0)
            fmt::print("    {} {:6.0f} us {:6.2f} % {}\n", bin == num_bins ? "longer, up to" : "           up to",
                       1e6 * (bin == num_bins ? *std::ranges::max_element(seconds) : first * std::pow(2.0, bin / 2.0)),
                       100.0 * part, std::string(static_cast<std::size_t>(std::ceil(50.0 * part)), '#'));
}

void print(const std::string &body, const std::string &springs, int threads, const Times &times) {
    double real = 0.0, processor = 0.0;
    for (std::size_t i = 0; i < times.real.size(); ++i) {
        real += times.real[i];
        processor += times.processor[i];
    }
    const double motion = times.time_step * static_cast<double>(times.real.size());
    fmt::print(
        "{}, {}, {} thread{}: step {:.3f} ms, {:.0f} steps/s of motion, {:.2f} evaluations each; up to {:.2f} N\n",
        body, springs, threads, threads == 1 ? "" : "s", 1e3 * times.time_step, 1.0 / times.time_step,
        times.evaluations, times.strongest);
    fmt::print("  one step without tool {:.0f} us, with it {:.0f} us, and a picture {:.0f} us (processor, medians)\n",
               1e6 * percentile(times.without_tool, 0.5), 1e6 * percentile(times.processor, 0.5), 1e6 * times.frame);
    for (const auto &[name, list, sum] :
         {std::tuple("real time", &times.real, real), std::tuple("processor", &times.processor, processor)})
        fmt::print("  one step and force, {}: 50 % {:.0f} us, 95 % {:.0f} us, 99 % {:.0f} us; pace {:.2f}\n", name,
                   1e6 * percentile(*list, 0.5), 1e6 * percentile(*list, 0.95), 1e6 * percentile(*list, 0.99),
                   motion / sum);
    print_histogram(times.real);
}

void run(const Options &options) {
    fmt::print("Times are those of this machine and of what else runs on it. Pace is motion over time.\n");
    for (const auto &name : options.bodies) {
        const auto body = meshes::read_body(support::root_folder() / "meshes" / (name + ".toml"));
        const auto constrained = constrained_facets(body);
        const auto surface = live::touchable_surface(body.mesh, constrained);
        const auto &x = body.mesh.points;
        const int front = *std::ranges::min_element(surface.nodes, {}, [&](int node) { return x[node].y(); });
        for (const auto &springs : options.springs)
            for (const int threads : options.threads) {
                live::Scene scene(body, constrained, threads);
                const auto chosen =
                    scene.choose({.springs = springs, .young_modulus = 5e3, .poisson_ratio = options.poisson_ratio});
                print(name, springs, threads, time_hand(scene, chosen, x[front], options));
            }
    }
}

int start(int argc, char **argv) {
    Options options;
    CLI::App app("How long a hand waits for one step and the force of a liver that it presses");
    app.add_option("--body", options.bodies, "Names of bodies that ship")->capture_default_str();
    app.add_option("--springs", options.springs, "Springs of the live page")
        ->capture_default_str()
        ->check(CLI::IsMember(live::spring_names()));
    app.add_option("--threads", options.threads, "Numbers of threads")->capture_default_str()->check(CLI::Range(1, 64));
    app.add_option("--poisson", options.poisson_ratio, "Poisson's ratio everywhere")
        ->capture_default_str()
        ->check(CLI::Range(0.0, 0.49));
    app.add_option("--depth", options.depth, "How deep the finger goes [m]")
        ->capture_default_str()
        ->check(CLI::Range(0.0, 0.05));
    app.add_option("--seconds", options.seconds, "Of motion")->capture_default_str()->check(CLI::Range(0.001, 1000.0));
    CLI11_PARSE(app, argc, argv);
    try {
        run(options);
        return 0;
    } catch (const support::InputError &fault) {
        fmt::print(stderr, "hand_benchmark: {}\n", fault.what());
        return 2;
    }
}

} // namespace
} // namespace livermark

int main(int argc, char **argv) {
    return livermark::start(argc, argv);
}
