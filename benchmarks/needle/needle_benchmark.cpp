// A needle in explicit steps of springs: cost of a step with it and without.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <string>
#include <vector>

#include "core/processor_time.hpp"
#include "live/material.hpp"
#include "live/parameters.hpp"
#include "live/springs.hpp"
#include "load_cases/readers/load_case_reader.hpp"
#include "load_cases/readers/needle_reader.hpp"
#include "meshes/io/body_reader.hpp"
#include "msm/needle/moving_needle.hpp"
#include "msm/nodal_conditions.hpp"
#include "support/input_error.hpp"
#include "support/root_folder.hpp"

namespace livermark {
namespace {

struct Options {
    std::string body = "liver_tumours", load_case = "biopsy";
    std::vector<std::string> springs{"lloyd", "patch", "nodal_neo_hookean", "edge_neo_hookean"};
    bool keeps_volume = true, in_single_precision = true;
    double mass_damping = 10.0;
    int blocks = 60;
};

constexpr int steps_in_block = 20;
constexpr double seconds_to_us = 1e6;

double median_of(std::vector<double> values) {
    std::ranges::nth_element(values, values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2));
    return values[values.size() / 2];
}

/// A body that moves, on a problem with needles.
struct Pricked {
    core::Problem problem;
    msm::ElasticBody springs;
    msm::NodalConditions conditions;
    double time_step;
};

Pricked pricked(const core::Problem &problem, const std::string &name, const Options &options) {
    live::SpringsOfLaws kept;
    const auto &material = problem.body->materials[static_cast<std::size_t>(live::largest_region(problem.body->mesh))];
    const live::Settings settings{.springs = name,
                                  .keeps_volume = options.keeps_volume,
                                  .young_modulus = material.young_modulus,
                                  .poisson_ratio = material.poisson_ratio,
                                  .damping = {options.mass_damping, 0.0}};
    auto parts = live::mass_springs(*problem.body, settings, kept);
    auto conditions = msm::nodal_conditions(problem, parts.body.node_mass);
    const auto stepping = live::chosen_steps(*problem.body, parts, conditions, settings);
    return {problem, parts.body, std::move(conditions), stepping.unscaled.longest_time_step};
}

/// Medians over blocks of steps by turns, so that whatever else the machine does meets both alike [s].
struct StepCost {
    double without = 0.0, with = 0.0, held = 0.0;
};

StepCost step_cost(const Pricked &of, const core::Needle &needle, const Options &options) {
    const auto &mesh = of.problem.body->mesh;
    const auto prepare = [&] {
        return msm::FastSteps::prepare(of.springs, mesh.points, of.conditions, {options.mass_damping, 0.0},
                                       "symplectic_euler", of.time_step,
                                       {.precision = options.in_single_precision
                                                         ? msm::ForcePrecision::single_precision
                                                         : msm::ForcePrecision::double_precision})
            .value();
    };
    auto alone = prepare(), with = prepare();
    msm::MovingNeedle moving(needle, mesh, of.springs.node_mass, of.conditions);
    moving.begin(with);
    std::vector<double> of_alone, of_with, of_held;
    const double way = needle.depth() / (options.blocks * steps_in_block);
    const auto block = [&](std::vector<double> &times, msm::FastSteps &steps, bool has_needle, double advance) {
        const double start = core::processor_seconds();
        for (int i = 0; i < steps_in_block; ++i) {
            steps.take(1);
            if (has_needle)
                moving.act(steps, moving.depth() + advance, of.time_step);
        }
        times.push_back((core::processor_seconds() - start) / steps_in_block);
    };
    for (int i = 0; i < options.blocks; ++i) {
        block(of_alone, alone, false, 0.0);
        block(of_with, with, true, way);
    }
    for (int i = 0; i < options.blocks; ++i) {
        block(of_alone, alone, false, 0.0);
        block(of_held, with, true, 0.0);
    }
    return {median_of(of_alone), median_of(of_with), median_of(of_held)};
}

void print_costs(const core::Problem &problem, const std::vector<core::Needle> &needles, const Options &options) {
    fmt::print(
        "{}, {} precision: a step without a needle, and over it one while the needle goes in and one while it is "
        "held\n",
        problem.body->name, options.in_single_precision ? "single" : "double");
    for (const auto &name : options.springs) {
        const auto of = pricked(problem, name, options);
        for (const auto &needle : needles) {
            const auto cost = step_cost(of, needle, options);
            fmt::print("  {}, {}, step {:.2f} ms: {:.1f} us; {:.3f}, {:.3f}\n", name, needle.name, 1e3 * of.time_step,
                       seconds_to_us * cost.without, cost.with / cost.without, cost.held / cost.without);
        }
    }
}

void run(const Options &options) {
    const auto root = support::root_folder();
    const auto file = root / "load_cases/needles" / (options.load_case + ".toml");
    auto body = std::make_shared<const core::Body>(meshes::read_body(root / "meshes" / (options.body + ".toml")));
    const core::Problem problem{body, load_cases::read_load_case(file, body->mesh)};
    const auto needles = load_cases::read_needles(file, *body, problem.load_case);
    print_costs(problem, needles, options);
}

int start(int argc, char **argv) {
    Options options;
    CLI::App app("A needle in explicit steps of springs: cost of a step");
    app.add_option("--body", options.body, "Name of a body that ships")->capture_default_str();
    app.add_option("--load-case", options.load_case, "Name of a load case with needles")->capture_default_str();
    app.add_option("--springs", options.springs, "Springs of the live page")
        ->capture_default_str()
        ->check(CLI::IsMember(live::spring_names()));
    app.add_option("--mass-damping", options.mass_damping, "alpha of Rayleigh's damping [1/s]")
        ->capture_default_str()
        ->check(CLI::Range(0.0, 1000.0));
    app.add_option("--blocks", options.blocks, "Blocks of 20 steps of each kind")
        ->capture_default_str()
        ->check(CLI::Range(1, 100000));
    app.add_flag(
        "--double", [&](auto) { options.in_single_precision = false; }, "In double precision");
    CLI11_PARSE(app, argc, argv);
    try {
        run(options);
        return 0;
    } catch (const support::InputError &fault) {
        fmt::print(stderr, "needle_benchmark: {}\n", fault.what());
        return 2;
    }
}

} // namespace
} // namespace livermark

int main(int argc, char **argv) {
    return livermark::start(argc, argv);
}
