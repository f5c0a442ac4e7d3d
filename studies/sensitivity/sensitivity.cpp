#include "studies/sensitivity/sensitivity.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <iterator>
#include <limits>
#include <optional>
#include <sstream>
#include <toml++/toml.h>
#include <utility>

#include "core/stopwatch.hpp"
#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "core/support/processes/child_process.hpp"
#include "core/support/toml_input.hpp"
#include "results/hdf5/references.hpp"
#include "results/hdf5/result_file.hpp"
#include "results/one_reference.hpp"
#include "results/records/result.hpp"
#include "studies/models/model_table.hpp"
#include "studies/run/run.hpp"
#include "studies/study.hpp"

namespace livermark::studies {

namespace {

constexpr const char *ranges_that_ship = "results/parameter_ranges.toml";
constexpr const char *law_of_reference = "fem_p2p1_neo_hookean", *other_law = "fem_p2p1_ogden";
/// Few enough that little is lost where somebody ends the program, and writing takes no time beside solving.
constexpr std::size_t samples_between_files = 16;

/// A load case that is sampled: S samples of P parameters with O outputs.
struct SampledCase {
    core::Problem nominal;
    std::vector<Output> outputs;
    OutputFile output;
    std::vector<std::string> parameters{};     ///< (P)
    std::vector<std::vector<double>> points{}; ///< (S, P) SI
    std::vector<std::vector<double>> values{}; ///< (S, O) SI, of the samples that are solved
    std::string state{};                       ///< that Python goes on with

    std::string name() const { return fmt::format("{} / {}", nominal.body->name, nominal.load_case.name); }
};

std::string asked_of_python(const std::string &part, const toml::table &question) {
    std::ostringstream text;
    text << question;
    return support::run_python("studies.sensitivity", {part}, text.str(), "a sensitivity study",
                               "python3-openturns python3-numpy python3-h5py");
}

toml::table answer_of_python(const std::string &part, const toml::table &question) {
    return support::parse_toml(asked_of_python(part, question), "livermark.studies.sensitivity");
}

template <class Values> toml::array toml_array(const Values &values) {
    toml::array array;
    for (const auto &value : values)
        array.push_back(value);
    return array;
}

toml::array joined_rows(const std::vector<std::vector<double>> &rows) {
    toml::array array;
    for (const auto &row : rows)
        for (const double value : row)
            array.push_back(value);
    return array;
}

std::vector<std::vector<double>> rows_of(const toml::table &answer, const char *key, std::size_t num_columns) {
    std::vector<std::vector<double>> rows;
    for (const auto &value : *answer[key].as_array()) {
        if (rows.empty() || rows.back().size() == num_columns)
            rows.emplace_back();
        rows.back().push_back(value.value<double>().value());
    }
    return rows;
}

void add_notes(const toml::table &answer, std::vector<std::string> &notes) {
    for (const auto &note : *answer["notes"].as_array())
        notes.push_back(note.value<std::string>().value());
}

SampledCase sampled_case(const core::Problem &nominal, const SensitivityOptions &options) {
    if (nominal.load_case.regime != core::Regime::small || nominal.load_case.release)
        throw support::InputError(fmt::format(
            "load case {} {}; patients are sampled at rest in the small regime, so name another one such as "
            "palpation",
            nominal.load_case.name, nominal.load_case.release ? "moves in time" : "is of the large regime"));
    if (nominal.load_case.foundation)
        throw support::InputError(fmt::format("load case {} has an elastic foundation, and what bears sampled patients "
                                              "is itself sampled; name another one such as palpation",
                                              nominal.load_case.name));
    return {.nominal = nominal,
            .outputs = outputs_of(nominal),
            .output = {options.output, nominal, fmt::format("sensitivity.{}.h5", nominal.load_case.name)}};
}

toml::table question_on(const SampledCase &sampled, const std::string &model) {
    const auto &[body, load_case] = sampled.nominal;
    toml::array outputs;
    for (const auto output : sampled.outputs)
        outputs.push_back(name_of(output));
    return toml::table{{"body", body->name},
                       {"load_case", load_case.name},
                       {"title", load_case.title},
                       {"fingerprint", results::fingerprint(sampled.nominal, model)},
                       {"file", sampled.output.path().string()},
                       {"outputs", std::move(outputs)},
                       {"has_tumour", !tumour_regions(*body).empty()},
                       {"has_map", !body->modulus_factor.empty()},
                       {"has_acceleration", !load_case.acceleration.isZero(0.0)},
                       {"is_held", !held_facets(load_case).empty()},
                       {"has_movable_tool", has_movable_tool(load_case)}};
}

toml::table provenance_of(const std::string &command_line) {
    const auto provenance = results::current_provenance(command_line);
    return toml::table{{"software_version", provenance.software_version},
                       {"git_commit", provenance.git_commit},
                       {"created", provenance.created},
                       {"command", provenance.command},
                       {"cpu", provenance.cpu},
                       {"compiler", provenance.compiler},
                       {"build_type", provenance.build_type},
                       {"threads", provenance.threads}};
}

/// Draws the points of all load cases, and takes the values that their files have.
void plan_samples(std::vector<SampledCase> &cases, const SensitivityOptions &options, const std::string &command_line,
                  std::vector<std::string> &notes) {
    toml::array questions;
    for (const auto &sampled : cases)
        questions.push_back(question_on(sampled, options.model));
    const auto ranges = options.ranges.empty() ? (support::root_folder() / ranges_that_ship).string() : options.ranges;
    const auto plan = answer_of_python("plan", toml::table{{"ranges", ranges},
                                                           {"samples", options.num_samples},
                                                           {"model", options.model},
                                                           {"provenance", provenance_of(command_line)},
                                                           {"case", std::move(questions)}});
    add_notes(plan, notes);
    for (std::size_t c = 0; c < cases.size(); ++c) {
        const auto &answer = *plan["case"][c].as_table();
        auto &sampled = cases[c];
        sampled.parameters = support::required_strings(answer, "parameters");
        sampled.points = rows_of(answer, "points", sampled.parameters.size());
        sampled.values = rows_of(answer, "values", sampled.outputs.size());
        sampled.state = support::required_string(answer, "state");
    }
}

/// The time that is left, from the time of the samples so far.
std::string time_left(core::Clock::time_point start, std::size_t done, std::size_t to_do) {
    if (done == 0)
        return "";
    const double seconds = core::seconds_since(start) / static_cast<double>(done) * static_cast<double>(to_do);
    constexpr double minute = 60.0;
    return seconds < minute ? fmt::format(", about {:.0f} s left", seconds)
                            : fmt::format(", about {:.0f} min left", seconds / minute);
}

void solve_samples(SampledCase &sampled, const core::Model &model, Steps &steps, std::vector<std::string> &notes) {
    const auto first = sampled.values.size(), num_samples = sampled.points.size();
    for (std::size_t s = 0; s < first; ++s)
        steps.next(fmt::format("{} / sample {} of {}, kept", sampled.name(), s + 1, num_samples));
    const auto start = core::Clock::now();
    for (auto s = first; s < num_samples; ++s) {
        steps.next(fmt::format("{} / sample {} of {}{}", sampled.name(), s + 1, num_samples,
                               time_left(start, s - first, num_samples - s)));
        const auto problem = problem_of(patient_of(sampled.parameters, sampled.points[s]), sampled.nominal);
        if (model.check)
            model.check(problem);
        const auto solution = model.solve(problem);
        sampled.values.push_back(values_of(sampled.outputs, sampled.nominal, problem, solution).values);
        if (s == first && !std::isnan(solution.nonlinearity) && problem.body->mesh.region_names.back() == "support")
            notes.push_back(fmt::format("{}: {} is not linear, so its soft support is as stiff as it should be only as "
                                        "long as it moves by much less than it is thick; fem_p2p1 is linear",
                                        sampled.name(), model.name));
        if ((s + 1) % samples_between_files == 0 || s + 1 == num_samples)
            asked_of_python("keep", toml::table{{"state", sampled.state}, {"values", joined_rows(sampled.values)}});
    }
}

const results::ModelResult &reference_in(const results::Result &result) {
    const auto solved = std::ranges::find_if(result.models, [&](const results::ModelResult &model) {
        return !model.comparison && model.solution.status == core::SolutionStatus::ok;
    });
    if (solved == result.models.end())
        throw support::InputError(
            fmt::format("{} / {}: no reference finds a solution, so nothing can be compared; give "
                        "another load case",
                        result.problem.body->name, result.problem.load_case.name));
    return *solved;
}

toml::table outputs_on(const std::string &name, const core::Problem &problem, const std::vector<Output> &outputs,
                       const core::Solution &solution) {
    const auto found = values_of(outputs, problem, problem, solution);
    return toml::table{{"name", name}, {"values", toml_array(found.values)}, {"tumour", toml_array(found.tumour)}};
}

/// The large load case of the same name; nothing where there is none, or no room for it.
std::optional<core::Problem> large_problem(const std::string &body_name, const core::Problem &nominal) {
    const auto large = "large_" + nominal.load_case.name;
    const auto all = find_toml_files({}, load_cases_folder, "load case");
    if (std::ranges::none_of(all, [&](const auto &file) { return file.stem() == large; }))
        return std::nullopt;
    try {
        return read_scaled_problems({body_name}, large, {}).problems.front();
    } catch (const support::InputError &) { // it does not fit this body
        return std::nullopt;
    }
}

/// Outputs with the law of the reference and with another one, at the whole load.
toml::array outputs_with_laws(const core::Problem &large, const std::vector<Output> &outputs, Steps &steps) {
    auto models = models::all_models();
    std::erase_if(models,
                  [](const core::Model &model) { return model.name != law_of_reference && model.name != other_law; });
    PreparedModels prepared{SolutionCache::shipped()};
    toml::array answers;
    for (const auto *name : {law_of_reference, other_law}) {
        steps.next(fmt::format("{} / {} / {}", large.body->name, large.load_case.name, name));
        answers.push_back(
            outputs_on(name, large, outputs, prepared.solve(support::find_named(models, name, "model"), large)));
    }
    return answers;
}

int num_budget_steps(const SensitivityOptions &options) {
    const int num_references = options.reference_on_mesh ? 1 : 2, num_laws = options.without_law ? 0 : 2;
    return static_cast<int>(options.compared.size()) + num_references + num_laws;
}

/// Outputs of the patient of the files by several models and laws, and the error bars of the reference.
toml::table budget_of(const SampledCase &sampled, const SensitivityOptions &options, Steps &steps) {
    const auto &nominal = sampled.nominal;
    const auto result =
        evaluate(nominal, choose_models(options.compared, {}, !options.reference_on_mesh),
                 [&](const core::Model &model, const core::Problem &problem) {
                     steps.next(fmt::format("{} / {} / {}", problem.body->name, problem.load_case.name, model.name));
                     return model.solve(problem);
                 },
                 {});
    const auto &reference = reference_in(result);
    const auto &bar = result.reference_uncertainty;
    constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
    toml::array models;
    for (const auto &name : options.compared)
        models.push_back(outputs_on(name, nominal, sampled.outputs,
                                    support::find_named(result.models, name, "model that takes part here").solution));
    const auto large = options.without_law ? std::nullopt : large_problem(options.body, nominal);
    return toml::table{{"reference", reference.name},
                       {"relative_l2", bar ? bar->relative_l2 : unknown},
                       {"stiffness", bar ? bar->stiffness.value_or(unknown) : unknown},
                       {"nominal", outputs_on(reference.name, nominal, sampled.outputs, reference.solution)},
                       {"models", std::move(models)},
                       {"law", large ? outputs_with_laws(*large, sampled.outputs, steps) : toml::array{}}};
}

} // namespace

SensitivityResults study_sensitivity(const SensitivityOptions &options, const std::string &command_line,
                                     const ProgressReport &report) {
    SensitivityResults done;
    const auto known = models::all_models();
    const auto &model = support::find_named(known, options.model, "model");
    for (const auto &name : options.compared)
        support::find_named(known, name, "model");
    std::vector<SampledCase> cases;
    for (const auto &load_case : options.load_cases) {
        const auto set = read_scaled_problems({options.body}, load_case, {});
        for (const auto &note : set.notes)
            if (std::ranges::find(done.notes, note) == done.notes.end())
                done.notes.push_back(note);
        cases.push_back(sampled_case(set.problems.front(), options));
    }
    plan_samples(cases, options, command_line, done.notes);
    Steps steps(static_cast<int>(cases.size()) * (options.num_samples + num_budget_steps(options)), report);
    for (auto &sampled : cases) {
        solve_samples(sampled, model, steps, done.notes);
        const auto budget = budget_of(sampled, options, steps);
        add_notes(answer_of_python("finish", toml::table{{"state", sampled.state},
                                                         {"values", joined_rows(sampled.values)},
                                                         {"budget", budget}}),
                  done.notes);
        done.folder = sampled.output.path().parent_path().string();
        done.files.push_back(sampled.output.path().string());
    }
    return done;
}

std::string shown_sensitivities(const std::vector<std::string> &files, const std::string &format) {
    return asked_of_python("show", toml::table{{"files", toml_array(files)}, {"format", format}});
}

} // namespace livermark::studies
