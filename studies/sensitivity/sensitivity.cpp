#include "studies/sensitivity/sensitivity.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <optional>
#include <utility>

#include "core/stopwatch.hpp"
#include "models/model_table.hpp"
#include "results/hdf5/files/sensitivity_file.hpp"
#include "results/hdf5/result_files.hpp"
#include "results/problem_key.hpp"
#include "results/provenance.hpp"
#include "results/quantile.hpp"
#include "studies/files.hpp"
#include "studies/run/problems.hpp"
#include "studies/sensitivity/error_budget.hpp"
#include "studies/sensitivity/ranges.hpp"
#include "studies/sensitivity/sobol.hpp"
#include "support/input_error.hpp"
#include "support/known_names.hpp"
#include "support/root_folder.hpp"

namespace livermark::studies {

namespace {

constexpr std::size_t samples_between_files = 16;

/// A load case that is sampled.
struct SampledCase {
    core::Problem nominal;
    std::vector<Output> outputs;
    OutputFile output;
    results::Sensitivity found;
    std::vector<std::vector<double>> unit_points{}; ///< (S, P) in the unit cube

    std::string name() const { return fmt::format("{} / {}", nominal.body->name, nominal.load_case.name); }
};

void refuse_other_kinds(const core::Problem &problem) {
    if (problem.load_case.regime != core::Regime::small || problem.load_case.release)
        throw support::InputError(fmt::format(
            "load case {} {}; patients are sampled at rest in the small regime, so name another one such as "
            "palpation",
            problem.load_case.name, problem.load_case.release ? "moves in time" : "is of the large regime"));
}

std::vector<std::string> groups_of(const std::vector<results::UncertainParameter> &parameters) {
    std::vector<std::string> groups;
    for (const auto &parameter : parameters)
        if (std::ranges::find(groups, parameter.group) == groups.end())
            groups.push_back(parameter.group);
    return groups;
}

SampledCase sampled_case(const core::Problem &nominal, const Ranges &ranges, const SensitivityOptions &options,
                         const std::string &command_line, std::vector<std::string> &notes) {
    refuse_other_kinds(nominal);
    auto acting = acting_on(nominal, ranges);
    std::ranges::move(acting.notes, std::back_inserter(notes));
    if (options.num_samples < least_samples(acting.parameters.size()))
        throw support::InputError(fmt::format("--samples {}: {} parameters need at least {}", options.num_samples,
                                              acting.parameters.size(), least_samples(acting.parameters.size())));
    SampledCase sampled{.nominal = nominal,
                        .outputs = outputs_of(nominal),
                        .output = {options.output, nominal, fmt::format("sensitivity.{}.h5", nominal.load_case.name)},
                        .found = {}};
    auto &found = sampled.found;
    found.provenance = results::current_provenance(command_line);
    found.body = nominal.body->name;
    found.load_case = nominal.load_case.name;
    found.title = nominal.load_case.title;
    found.model = options.model;
    found.fingerprint = results::fingerprint(nominal, options.model);
    found.groups = groups_of(acting.parameters);
    found.parameters = std::move(acting.parameters);
    return sampled;
}

void place_points(SampledCase &sampled, int num_samples) {
    auto &found = sampled.found;
    sampled.unit_points = sobol_points(static_cast<std::size_t>(num_samples), found.parameters.size());
    for (const auto &unit : sampled.unit_points) {
        auto &point = found.points.emplace_back();
        for (std::size_t p = 0; p < unit.size(); ++p)
            point.push_back(found.parameters[p].at(unit[p]));
    }
}

/// Takes the values of a file that went the same way before, as far as it came.
void take_kept_samples(SampledCase &sampled) {
    std::error_code nobody_cares;
    auto &found = sampled.found;
    if (!std::filesystem::exists(sampled.output.path(), nobody_cares) ||
        results::kind_of_file(sampled.output.path()) != results::FileKind::sensitivity)
        return;
    const auto before = results::read_sensitivity(sampled.output.path());
    if (before.fingerprint != found.fingerprint || before.parameters != found.parameters)
        return;
    for (std::size_t s = 0; s < std::min(found.points.size(), before.values.size()); ++s) {
        if (before.points[s] != found.points[s] || before.values[s].size() != sampled.outputs.size())
            return;
        found.values.push_back(before.values[s]);
    }
}

/// What is left, from what the samples so far took.
std::string time_left(core::Clock::time_point start, std::size_t done, std::size_t to_do) {
    if (done == 0)
        return "";
    const double seconds = core::seconds_since(start) / static_cast<double>(done) * static_cast<double>(to_do);
    constexpr double minute = 60.0;
    return seconds < minute ? fmt::format(", about {:.0f} s left", seconds)
                            : fmt::format(", about {:.0f} min left", seconds / minute);
}

void solve_samples(SampledCase &sampled, const core::Model &model, Steps &steps, std::vector<std::string> &notes) {
    auto &found = sampled.found;
    const auto first = found.values.size(), num_samples = found.points.size();
    for (std::size_t s = 0; s < first; ++s)
        steps.next(fmt::format("{} / sample {} of {}, kept", sampled.name(), s + 1, num_samples));
    const auto start = core::Clock::now();
    for (auto s = first; s < num_samples; ++s) {
        steps.next(fmt::format("{} / sample {} of {}{}", sampled.name(), s + 1, num_samples,
                               time_left(start, s - first, num_samples - s)));
        const auto problem = problem_of(patient_of(found.parameters, found.points[s]), sampled.nominal);
        if (model.check)
            model.check(problem);
        const auto solution = model.solve(problem);
        found.values.push_back(values_of(sampled.outputs, sampled.nominal, problem, solution).values);
        if (s == first && !std::isnan(solution.nonlinearity) && problem.body->mesh.region_names.back() == "support")
            notes.push_back(fmt::format("{}: {} is not linear, so its soft support is as stiff as it should be only as "
                                        "long as it moves by much less than it is thick; fem_p2p1 is linear",
                                        sampled.name(), model.name));
        if ((s + 1) % samples_between_files == 0)
            results::write_sensitivity(sampled.output.path(), found);
    }
}

/// Of the samples that have a solution.
void add_indices(SampledCase &sampled, std::vector<std::string> &notes) {
    auto &found = sampled.found;
    std::vector<std::vector<double>> points, values(sampled.outputs.size());
    for (std::size_t s = 0; s < found.values.size(); ++s)
        if (std::ranges::all_of(found.values[s], [](double value) { return std::isfinite(value); })) {
            points.push_back(sampled.unit_points[s]);
            for (std::size_t o = 0; o < values.size(); ++o)
                values[o].push_back(found.values[s][o]);
        }
    if (const auto lost = found.values.size() - points.size(); lost > 0)
        notes.push_back(fmt::format("{}: {} of {} samples have no solution by {} and are left out", sampled.name(),
                                    lost, found.values.size(), found.model));
    if (points.size() < static_cast<std::size_t>(least_samples(found.parameters.size())))
        throw support::InputError(fmt::format("{}: {} finds a solution to {} samples only, which are too few for "
                                              "indices; choose another model",
                                              sampled.name(), found.model, points.size()));
    std::vector<std::vector<int>> groups(found.groups.size());
    for (std::size_t p = 0; p < found.parameters.size(); ++p)
        groups[std::ranges::find(found.groups, found.parameters[p].group) - found.groups.begin()].push_back(
            static_cast<int>(p));
    const auto indices = sobol_indices(points, values, groups);
    for (std::size_t o = 0; o < values.size(); ++o) {
        results::OutputSensitivity output{.name = name_of(sampled.outputs[o]), .unit = unit_of(sampled.outputs[o])};
        const auto count = static_cast<double>(values[o].size());
        for (const double value : values[o])
            output.mean += value / count;
        for (const double value : values[o])
            output.deviation += (value - output.mean) * (value - output.mean) / (count - 1.0);
        output.deviation = std::sqrt(output.deviation);
        constexpr double tail = 0.025;
        output.lower = results::quantile(values[o], tail);
        output.upper = results::quantile(values[o], 1.0 - tail);
        output.unexplained = indices[o].unexplained;
        output.first = indices[o].first;
        output.first_lower = indices[o].first_lower;
        output.first_upper = indices[o].first_upper;
        output.total = indices[o].total;
        output.total_lower = indices[o].total_lower;
        output.total_upper = indices[o].total_upper;
        output.group_total = indices[o].group_total;
        found.outputs.push_back(std::move(output));
    }
}

void add_budget(SampledCase &sampled, const std::string &body_name, const BudgetOptions &options, Steps &steps) {
    auto of_case = budget_of(body_name, sampled.nominal, sampled.outputs, options, steps);
    sampled.found.budget = std::move(of_case.budget);
    for (std::size_t o = 0; o < sampled.found.outputs.size(); ++o)
        sampled.found.outputs[o].nominal = of_case.reference.values[o];
}

} // namespace

int least_samples(std::size_t num_parameters) {
    return 2 * (static_cast<int>(num_parameters) + 1);
}

SensitivityResults study_sensitivity(const SensitivityOptions &options, const std::string &command_line,
                                     const ProgressReport &report) {
    SensitivityResults done;
    const auto known = models::all_models();
    const auto &model = support::find_named(known, options.model, "model");
    for (const auto &name : options.compared)
        support::find_named(known, name, "model");
    const auto ranges = read_ranges(options.ranges.empty() ? support::root_folder() / ranges_that_ship
                                                           : std::filesystem::path(options.ranges));
    std::vector<SampledCase> cases;
    for (const auto &load_case : options.load_cases) {
        const auto set = read_scaled_problems({options.body}, load_case, {});
        for (const auto &note : set.notes)
            if (std::ranges::find(done.notes, note) == done.notes.end())
                done.notes.push_back(note);
        cases.push_back(sampled_case(set.problems.front(), ranges, options, command_line, done.notes));
    }
    const BudgetOptions budget{.compared = options.compared,
                               .reference_on_mesh = options.reference_on_mesh,
                               .without_law = options.without_law,
                               .displacement_noise = ranges.displacement_noise};
    Steps steps(static_cast<int>(cases.size()) * (options.num_samples + num_budget_steps(budget)), report);
    for (auto &sampled : cases) {
        place_points(sampled, options.num_samples);
        take_kept_samples(sampled);
        solve_samples(sampled, model, steps, done.notes);
        results::write_sensitivity(sampled.output.path(), sampled.found);
        add_indices(sampled, done.notes);
        add_budget(sampled, options.body, budget, steps);
        results::write_sensitivity(sampled.output.path(), sampled.found);
        done.folder = sampled.output.path().parent_path().string();
        done.of_load_case.push_back(std::move(sampled.found));
    }
    return done;
}

} // namespace livermark::studies
