#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <memory>
#include <numbers>

#include "app/catalogue.hpp"
#include "app/commands.hpp"
#include "app/msm_choice.hpp"
#include "app/output.hpp"
#include "app/problems.hpp"
#include "app/progress.hpp"
#include "app/usage.hpp"
#include "core/input_error.hpp"
#include "core/root_folder.hpp"
#include "meshes/body_reader.hpp"
#include "msm/highest_frequency.hpp"
#include "msm/observed_time_step.hpp"
#include "msm/spectrum.hpp"
#include "msm/spring_network.hpp"
#include "msm/time_step.hpp"
#include "results/provenance.hpp"
#include "results/stability_file.hpp"
#include "results/stability_table.hpp"
#include "results/table_layout.hpp"

namespace livermark::app {

namespace {

constexpr double percent = 100.0;
constexpr double milliseconds = 1000.0;
/// By how much prediction and observation may differ.
constexpr double largest_difference = 0.02;

/// A run that is this much above the limit has to be found out...
constexpr double found_out = 0.01;
/// ...by the growth of a mode that had no more than this part in the push, and in no more steps than this.
constexpr double part_of_push = 1e-3;
constexpr double most_steps = 30000.0;

struct StabilityOptions {
    std::vector<std::string> bodies;
    std::string law = "lloyd";
    std::string load_case = "traction";
    std::vector<std::string> integrators;
    meshes::MaterialOverride material;
    double damping_ratio = 0.05;                          // as load_cases/release.toml
    std::array<double, 2> damping_frequencies{1.7, 10.0}; // [Hz]
    std::string output;
    bool markdown = false;
    bool no_observed = false;
};

/// The same ratio at two frequencies.
core::RayleighDamping rayleigh_damping(double ratio, const std::array<double, 2> &frequencies) {
    const double first = 2.0 * std::numbers::pi * frequencies[0];
    const double second = 2.0 * std::numbers::pi * frequencies[1];
    return {.alpha = 2.0 * ratio * first * second / (first + second), .beta = 2.0 * ratio / (first + second)};
}

/// Time that a longitudinal wave in a bar takes along a mean edge of the springs, in the material of the first region.
double element_time_step(const core::Body &body, const core::SpringNetwork &springs) {
    double sum = 0.0;
    for (const double length : springs.rest_length)
        sum += length;
    const auto &material = body.materials.front();
    return sum / static_cast<double>(springs.rest_length.size()) * std::sqrt(material.density / material.young_modulus);
}

results::Stability examine(const core::Problem &problem, const msm::SpringLaw &law,
                           const std::vector<msm::Integrator> &integrators, const StabilityOptions &options,
                           Progress &progress) {
    const auto &positions = problem.body->mesh.points;
    const auto springs = msm::spring_network(*problem.body, law);
    const auto conditions = msm::nodal_conditions(problem, springs.node_mass);
    results::Stability stability{.provenance = {},
                                 .body = problem.body->name,
                                 .spring_law = law.name,
                                 .load_case = problem.load_case.name,
                                 .damping = rayleigh_damping(options.damping_ratio, options.damping_frequencies),
                                 .limits = {}};
    progress.next(fmt::format("{} / frequencies", problem.body->name));
    stability.lowest_frequency = msm::lowest_modes(springs, positions, conditions, 1).angular_frequency.front();
    stability.largest_frequency = msm::largest_angular_frequency(springs, positions, conditions);
    stability.largest_frequency_bound = msm::gershgorin_angular_frequency(springs, positions, conditions);
    stability.element_time_step = element_time_step(*problem.body, springs);

    const auto observe = [&](const msm::Integrator &integrator, const core::RayleighDamping &damping,
                             double predicted) {
        msm::ObservationOptions run;
        const double growth = msm::largest_amplification(integrator, damping, stability.lowest_frequency,
                                                         stability.largest_frequency, (1.0 + found_out) * predicted);
        const double num_steps = std::log(run.growth / part_of_push) / std::log(growth);
        if (!(num_steps < most_steps))
            return std::numeric_limits<double>::quiet_NaN();
        run.num_steps = static_cast<int>(num_steps);
        return msm::observed_time_step(integrator, springs, positions, conditions, damping, predicted, run);
    };
    const auto find_limit = [&](const msm::Integrator &integrator, const core::RayleighDamping &damping) {
        results::StepLimit limit;
        limit.predicted =
            msm::critical_time_step(integrator, damping, stability.lowest_frequency, stability.largest_frequency);
        if (limit.has_number() && !options.no_observed)
            limit.observed = observe(integrator, damping, limit.predicted);
        return limit;
    };
    for (const auto &integrator : integrators) {
        progress.next(fmt::format("{} / {}", problem.body->name, integrator.name));
        stability.limits.push_back(
            {integrator.name, find_limit(integrator, {}), find_limit(integrator, stability.damping)});
    }
    return stability;
}

void print(const results::Stability &stability, const StabilityOptions &options) {
    const char *end = options.markdown ? "\n\n" : "\n";
    fmt::print("{}, springs of {}, held as in {}{}", stability.body, stability.spring_law, stability.load_case, end);
    fmt::print("angular frequencies {:.2f} to {:.2f} rad/s (not above {:.2f} rad/s, says Gershgorin's bound){}",
               stability.lowest_frequency, stability.largest_frequency, stability.largest_frequency_bound, end);
    fmt::print("mean edge over speed of sound, of the first region: {:.3f} ms{}",
               milliseconds * stability.element_time_step, end);
    fmt::print("damping: alpha = {:.4f} 1/s, beta = {:.4e} s, which is {:.3f} of critical at the largest frequency{}\n",
               stability.damping.alpha, stability.damping.beta, stability.damping.ratio(stability.largest_frequency),
               options.markdown ? "\n" : "");
    const auto layout = results::stability_table(stability);
    fmt::print("{}\n", options.markdown ? results::to_markdown(layout) : results::to_text(layout));
}

/// What the words in the tables mean.
void print_legend(const std::vector<results::Stability> &all, bool looked) {
    const auto any_limit = [&](auto &&is_so) {
        return std::ranges::any_of(all, [&](const auto &stability) {
            return std::ranges::any_of(
                stability.limits, [&](const auto &limits) { return is_so(limits.undamped) || is_so(limits.damped); });
        });
    };
    if (any_limit([](const auto &limit) { return limit.predicted == 0.0; }))
        fmt::print("none: no limit to find, every step makes oscillations grow, and the smaller the slower\n");
    if (any_limit([](const auto &limit) { return !limit.has_number() && limit.predicted > 0.0; }))
        fmt::print("any: stable at every step\n");
    if (looked && any_limit([](const auto &limit) { return limit.has_number() && std::isnan(limit.observed); }))
        fmt::print("not observed: just above the limit motions grow too slowly for a run to show it\n");
}

bool is_as_predicted(const results::Stability &stability) {
    const auto holds = [](const results::StepLimit &limit) {
        return std::isnan(limit.observed) || std::abs(limit.difference()) <= largest_difference;
    };
    return std::ranges::all_of(stability.limits, [&](const results::IntegratorLimits &limits) {
        return holds(limits.undamped) && holds(limits.damped);
    });
}

int find_stability(const StabilityOptions &options, const std::string &command_line) {
    const auto law = find_spring_law(options.law);
    const auto integrators = find_integrators(options.integrators);
    const auto problems = read_scaled_problems(options.bodies, options.load_case, options.material);
    std::vector<results::Stability> done;
    {
        Progress progress(static_cast<int>(problems.size() * (1 + integrators.size())));
        for (const auto &problem : problems) {
            const auto folder = make_output_folder(options.output, problem);
            done.push_back(examine(problem, law, integrators, options, progress));
            done.back().provenance = results::current_provenance(command_line);
            results::write_stability(folder / fmt::format("stability.{}.h5", law.name), done.back());
        }
    }
    for (const auto &stability : done)
        print(stability, options);
    print_legend(done, !options.no_observed);
    fmt::print(stderr, "Result files are in {}\n", options.output);
    if (std::ranges::all_of(done, is_as_predicted))
        return 0;
    fmt::print(stderr, "livermark: failed: an observed step differs from the predicted one by more than {:g} %\n",
               percent * largest_difference);
    return 1;
}

} // namespace

Command add_stability(CLI::App &parent, const std::string &command_line) {
    auto *command = parent.add_subcommand(
        "stability", "Find the longest time step that the springs of a body can bear: predicted from their largest "
                     "frequency, and observed in runs");
    auto options = std::make_shared<StabilityOptions>();
    options->output = (core::root_folder() / "results" / "runs").string();
    command->add_option("body", options->bodies,
                        "Names as in 'livermark list bodies', or paths of body .toml files; all that ship if none is "
                        "named");
    command->add_option("--law", options->law, "A name as in 'livermark list spring-laws'")->capture_default_str();
    command->add_option("--load-case", options->load_case, "Where the body is held: as this load case says")
        ->capture_default_str();
    command->add_option("--integrator", options->integrators,
                        "Names as in 'livermark list integrators'; all if none is named");
    command->add_option("--damping-ratio", options->damping_ratio, "Of critical, at two frequencies")
        ->check(number_not_below_zero())
        ->capture_default_str();
    command->add_option("--damping-frequencies", options->damping_frequencies, "These two [Hz]")
        ->check(positive_number())
        ->capture_default_str();
    command->add_option("--young", options->material.young_modulus,
                        "Young's modulus of the first region [Pa]; the others keep their ratio to it");
    command->add_option("--poisson", options->material.poisson_ratio, "Poisson's ratio of every region");
    command->add_option("--output", options->output, "Folder for <body>/stability.<law>.h5")->capture_default_str();
    command->add_flag("--markdown", options->markdown, "Print the tables in Markdown");
    command->add_flag("--no-observed", options->no_observed, "Only predict, which takes no time");
    return [options, command_line] { return find_stability(*options, command_line); };
}

} // namespace livermark::app
