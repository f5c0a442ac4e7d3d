// Explicit steps of springs that relax, beside elastic ones, in turn in one run.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <string>
#include <vector>

#include "benchmarks/bodies.hpp"
#include "benchmarks/kernels/oracle.hpp"
#include "benchmarks/scene.hpp"
#include "core/processor_time.hpp"
#include "msm/dynamics/highest_frequency.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/kernels/fast_steps.hpp"
#include "msm/springs/coupled_springs.hpp"
#include "msm/springs/springs_with_volume.hpp"
#include "msm/viscoelastic/held_steps.hpp"
#include "support/input_error.hpp"

namespace livermark {
namespace {

using benchmarks::Scene;

struct Options {
    std::string body = "liver_healthy";
    std::vector<std::string> springs{"lloyd",
                                     "lloyd_nodal_volume",
                                     "nodal_springs",
                                     "nodal_neo_hookean",
                                     "nodal_neo_hookean_f",
                                     "edge_neo_hookean",
                                     "edge_neo_hookean_f"};
    std::vector<double> moduli{0.3, 0.3}, times{1.86, 51.3}; ///< of load_cases/relaxation/liver_perfused.toml
    double error = msm::FastStepOptions{}.relaxation_error;
    int blocks = 60;
};

msm::ElasticBody springs_named(const std::string &name, const Scene &scene) {
    const auto &body = *scene.problem.body;
    if (name == "lloyd")
        return scene.springs;
    if (name == "lloyd_nodal_volume")
        return msm::springs_with_volume(body, msm::springs_beside_volume(body, msm::all_spring_laws().front()),
                                        msm::find_volume_term("nodal_volume"))
            .body;
    return msm::coupled_springs_with_volume(body, msm::find_coupled_springs(name));
}

msm::State start_of(const Scene &scene) {
    const Eigen::VectorXd rest = msm::to_unknowns(scene.problem.body->mesh.points);
    return {msm::to_unknowns(scene.start) - rest, Eigen::VectorXd::Zero(rest.size())};
}

double median_time(std::vector<double> values) {
    std::ranges::nth_element(values, values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2));
    return values[values.size() / 2];
}

/// Springs, and the step that they take.
struct Moved {
    const Scene &scene;
    msm::ElasticBody springs;
    double time_step;

    msm::FastSteps steps(const core::PronySeries &relaxation, double error) const {
        auto steps =
            msm::FastSteps::prepare(springs, scene.problem.body->mesh.points, scene.conditions, {}, "symplectic_euler",
                                    time_step, {.relaxation = relaxation, .relaxation_error = error});
        if (!steps)
            throw support::InputError("the fast kernels do not know how such springs relax; name others by --springs");
        steps->set_state(start_of(scene));
        return *steps;
    }
};

/// Refuses to time what differs from the slow steps by more than single precision does: positions are rounded to 2^-24
/// of half the size of the body, against springs that are stretched by 1 % or less.
void check(const Moved &moved, const core::PronySeries &relaxation) {
    constexpr int num_checked_steps = 3;
    constexpr double tolerance = 5e-4;
    const auto &rest = moved.scene.problem.body->mesh.points;
    auto state = start_of(moved.scene);
    auto steps = moved.steps(relaxation, msm::FastStepOptions{}.relaxation_error);
    msm::HeldSteps oracle(moved.springs, relaxation, rest, moved.scene.conditions, {},
                          msm::find_integrator("symplectic_euler"), moved.time_step, steps.steps_between_relaxations());
    oracle.take(state, num_checked_steps);
    steps.take(num_checked_steps);
    const benchmarks::Run run{
        .step = [] {},
        .positions = [&] { return msm::to_field(msm::to_unknowns(rest) + steps.state().displacement); },
        .bytes = 0};
    const auto fault = benchmarks::differs_from(msm::to_field(msm::to_unknowns(rest) + state.displacement), moved.scene,
                                                run, tolerance);
    if (!fault.empty())
        throw support::InputError(fmt::format("{}; build it anew, or report this", fault));
}

void time_steps(const std::string &name, const Scene &scene, const Options &options) {
    const core::PronySeries series{"", options.moduli, options.times};
    auto springs = springs_named(name, scene);
    const double highest =
        msm::largest_angular_frequency(springs, scene.problem.body->mesh.points, scene.conditions, {}, 1e-3);
    const Moved moved{scene, std::move(springs), msm::default_safety_factor * 2.0 / highest};
    check(moved, series);
    auto elastic = moved.steps({}, 0.0), held = moved.steps(series, options.error), each = moved.steps(series, 0.0);
    const int in_block = std::max(held.steps_between_relaxations(), 20);
    const auto time = [&](msm::FastSteps &steps) {
        const double start = core::processor_seconds();
        steps.take(in_block);
        return (core::processor_seconds() - start) / in_block;
    };
    std::vector<double> of_elastic, of_held, of_each, ratio, ratio_of_each;
    double difference = 0.0;
    for (int block = -1; block < options.blocks; ++block) {
        const double first = time(elastic), second = time(held), third = time(each);
        if (block < 0)
            continue; // what is touched for the first time is slow
        of_elastic.push_back(first);
        of_held.push_back(second);
        of_each.push_back(third);
        ratio.push_back(second / first);
        ratio_of_each.push_back(third / first);
        const auto u = held.state().displacement, expected = each.state().displacement;
        difference = std::max(difference, (u - expected).norm() / start_of(scene).displacement.norm());
    }
    constexpr double to_us = 1e6;
    fmt::print("| `{}` | {:.1f} | {} | {:.1f} | {:.1f} | {:.1f} | {:.2f} | {:.2f} | {:.1e} |\n", name,
               to_us * moved.time_step, held.steps_between_relaxations(), to_us * median_time(of_elastic),
               to_us * median_time(of_held), to_us * median_time(of_each), median_time(ratio),
               median_time(ratio_of_each), difference);
}

int run(const Options &options) {
    if (options.moduli.size() != options.times.size())
        throw support::InputError("--moduli and --times have different lengths; give one time for each modulus");
    const auto scene = benchmarks::make_scene(benchmarks::make_body(options.body));
    fmt::print(
        "{}: {} tetrahedra, one thread, single precision, medians of {} blocks in turn\n\n"
        "| springs | step [us] | branches move once in so many | elastic [us] | relaxing [us] | relaxing in each "
        "step [us] | ratio | ratio in each step | differ by |\n"
        "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n",
        options.body, scene.problem.body->mesh.num_tetrahedra(), options.blocks);
    for (const auto &name : options.springs)
        time_steps(name, scene, options);
    return 0;
}

} // namespace
} // namespace livermark

int main(int argc, char **argv) {
    CLI::App app("Steps of springs that relax, beside elastic ones");
    livermark::Options options;
    app.add_option("--body", options.body, "As in benchmarks/bodies.hpp")->capture_default_str();
    app.add_option("--springs", options.springs, "lloyd, lloyd_nodal_volume, or coupled springs by name")
        ->capture_default_str();
    app.add_option("--moduli", options.moduli, "Of the Prony series")->capture_default_str();
    app.add_option("--times", options.times, "Of the Prony series [s]")->capture_default_str();
    app.add_option("--error", options.error, "Of a stress that fades, as a part of the largest")->capture_default_str();
    app.add_option("--blocks", options.blocks, "Of steps")->capture_default_str()->check(CLI::Range(1, 100000));
    CLI11_PARSE(app, argc, argv);
    try {
        return livermark::run(options);
    } catch (const livermark::support::InputError &error) {
        fmt::print(stderr, "{}\n", error.what());
        return 2;
    }
}
