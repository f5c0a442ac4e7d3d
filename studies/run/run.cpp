#include "studies/run/run.hpp"

#include <algorithm>
#include <charconv>
#include <fmt/format.h>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <stdexcept>
#include <utility>

#include "core/mesh/plausible_liver.hpp"
#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "core/support/processes/mpi_session.hpp"
#include "core/support/toml_input.hpp"
#include "load_cases/places/selector.hpp"
#include "load_cases/readers/load_case_reader.hpp"
#include "meshes/cutting/cut_reader.hpp"
#include "results/records/springs.hpp"
#include "studies/models/model_table.hpp"
#include "studies/study.hpp"

namespace livermark::studies {

namespace {

/// Files of load cases: those that ship where none was asked for; those in which time passes in the material only by
/// their names.
std::vector<std::filesystem::path> load_case_files_of(std::vector<std::string> wanted) {
    const auto slow_folder = support::root_folder() / slow_load_cases_folder;
    const auto slow =
        std::filesystem::exists(slow_folder) ? support::list_toml(slow_folder) : std::vector<std::string>{};
    for (auto &name : wanted)
        if (std::ranges::find(slow, name) != slow.end())
            name = (slow_folder / fmt::format("{}.toml", name)).string();
    return find_toml_files(wanted, load_cases_folder, "load case");
}

/// The body that a load case is put on: cut, where it says so.
/// @throws load_cases::NotOnBody if a cut does not fit the body
std::shared_ptr<const core::Body> body_for(const std::filesystem::path &load_case_file,
                                           const std::shared_ptr<const core::Body> &body,
                                           std::vector<std::string> &notes) {
    const auto cuts = meshes::cuts_of_file(load_case_file);
    if (cuts.empty())
        return body;
    try {
        const auto num_known = body->assumptions.size();
        auto cut = std::make_shared<const core::Body>(meshes::cut(*body, cuts));
        for (auto note = num_known; note < cut->assumptions.size(); ++note)
            notes.push_back(
                fmt::format("{}: {}: {}", body->name, load_case_file.stem().string(), cut->assumptions[note]));
        return cut;
    } catch (const meshes::CutNotOnBody &error) {
        throw load_cases::NotOnBody(error.place(), error.reason(), error.remedy());
    }
}

/// Load cases that are read where several fit a body.
enum class Choice { all, first };

/// Leaves the first load case that fits a body, and says why it is none before it.
/// @param first_left_out  of this body, in set.left_out
void keep_first(ProblemSet &set, std::size_t first_left_out) {
    if (first_left_out == set.left_out.size())
        return;
    const auto &before = set.left_out[first_left_out];
    set.notes.push_back(fmt::format("{}: constrained as in {}, because {} does not fit: {}", before.body,
                                    set.problems.back().load_case.name, before.load_case, before.reason));
    set.left_out.resize(first_left_out, before);
}

ProblemSet read_all(const std::vector<std::string> &bodies, const std::vector<std::string> &load_cases,
                    const meshes::MaterialOverride &material, bool may_leave_out, Choice choice = Choice::all) {
    ProblemSet set;
    std::optional<std::string> fault;
    std::map<std::string, std::filesystem::path> file_of_name;
    const auto load_case_files = load_case_files_of(load_cases);
    for (const auto &body_file : find_toml_files(bodies, bodies_folder, "body")) {
        const auto body = std::make_shared<const core::Body>(meshes::read_body(body_file, material));
        const auto [named, is_new] = file_of_name.emplace(body->name, body_file);
        if (!is_new)
            throw support::InputError(
                fmt::format("{} and {} have the same name, and their results would be in one place; rename one",
                            named->second.string(), body_file.string()));
        for (const auto &assumption : body->assumptions)
            set.notes.push_back(fmt::format("{}: {}", body->name, assumption));
        const auto first_left_out = set.left_out.size();
        for (const auto &load_case_file : load_case_files) {
            try {
                const auto cut = body_for(load_case_file, body, set.notes);
                set.problems.push_back({cut, load_cases::read_load_case(load_case_file, *cut)});
                for (const auto &doubt : core::doubts_about_loads(set.problems.back().load_case, cut->mesh))
                    set.notes.push_back(fmt::format("{}: {}", body->name, doubt));
                if (choice == Choice::first) {
                    keep_first(set, first_left_out);
                    break;
                }
            } catch (const load_cases::NotOnBody &error) {
                const auto folder = load_case_file.parent_path();
                const bool ships = folder == support::root_folder() / load_cases_folder ||
                                   folder == support::root_folder() / slow_load_cases_folder;
                if (!may_leave_out && !bodies.empty() && !ships)
                    throw;
                set.left_out.push_back({body->name, load_case_file.stem().string(), error.reason(),
                                        load_cases::load_case_kind(load_case_file)});
                fault = fault.value_or(error.what());
            }
        }
    }
    if (set.problems.empty())
        throw support::InputError(fault.value());
    return set;
}

void scale_and_note(ProblemSet &set) {
    for (auto &problem : set.problems)
        problem = scaled_to_target(std::move(problem));
    std::ranges::move(yielded_places(set.problems), std::back_inserter(set.notes));
    std::ranges::move(sentences(set.left_out), std::back_inserter(set.notes));
}

std::vector<std::string> usual_constraints_first() {
    std::vector<std::string> names{usual_constraints};
    for (const auto &file : find_toml_files({}, load_cases_folder, "load case"))
        if (const auto name = file.stem().string(); name != usual_constraints)
            names.push_back(name);
    return names;
}

} // namespace

std::vector<std::string> yielded_places(std::span<const core::Problem> problems) {
    std::vector<std::string> lines;
    for (const auto &problem : problems)
        for (const auto &place : problem.load_case.yielded) {
            auto line = fmt::format("{}: {}: '{}' gives up {:.0f} % of its area to the places above it",
                                    problem.body->name, problem.load_case.name, place.name, 100.0 * place.lost_area);
            if (std::ranges::find(lines, line) == lines.end()) // the same for every Poisson's ratio
                lines.push_back(std::move(line));
        }
    return lines;
}

std::vector<LeftOut> grouped(const std::vector<LeftOut> &left_out) {
    std::vector<LeftOut> groups;
    for (const auto &entry : left_out) {
        const auto same = std::ranges::find_if(
            groups, [&](const LeftOut &group) { return group.body == entry.body && group.reason == entry.reason; });
        if (same == groups.end())
            groups.push_back(entry);
        else
            same->load_case += ", " + entry.load_case;
    }
    return groups;
}

std::vector<std::string> sentences(const std::vector<LeftOut> &left_out) {
    std::vector<std::string> lines;
    for (const auto &group : grouped(left_out))
        lines.push_back(fmt::format("left out on {}: {}, because {}", group.body, group.load_case, group.reason));
    return lines;
}

ProblemSet read_problems(const std::vector<std::string> &bodies, const std::vector<std::string> &load_cases,
                         const meshes::MaterialOverride &material, bool may_leave_out) {
    for (const auto &file : load_case_files_of(load_cases)) {
        const auto kind = load_cases::load_case_kind(file);
        if (!kind.is_for(load_cases::run_command))
            throw support::InputError(fmt::format("load case {} {}; give it to 'livermark {} --load-case'",
                                                  file.stem().string(), kind.what, kind.commands.front()));
    }
    return read_all(bodies, load_cases, material, may_leave_out);
}

ProblemSet read_moving_problems(const std::vector<std::string> &bodies, const std::string &load_case,
                                const meshes::MaterialOverride &material) {
    if (const auto kind = load_cases::load_case_kind(load_case); !kind.is_for("arena"))
        throw support::InputError(fmt::format("load case {} has no [tool] that moves; give it to 'livermark {} "
                                              "--load-case', or choose one with a [tool]",
                                              std::filesystem::path(load_case).stem().string(), kind.commands.front()));
    return read_all(bodies, {load_case}, material, false);
}

ProblemSet read_needle_problems(const std::vector<std::string> &bodies, const std::string &load_case,
                                const meshes::MaterialOverride &material) {
    if (const auto kind = load_cases::load_case_kind(load_case); !kind.is_for("needle"))
        throw support::InputError(fmt::format("load case {} has no [[needle]]; give it to 'livermark {} --load-case', "
                                              "or choose one with a [[needle]]",
                                              std::filesystem::path(load_case).stem().string(), kind.commands.front()));
    auto set = read_all(bodies, {load_case}, material, true);
    std::ranges::move(sentences(set.left_out), std::back_inserter(set.notes));
    return set;
}

ProblemSet read_scaled_problems(const std::vector<std::string> &bodies, const std::string &load_case,
                                const meshes::MaterialOverride &material) {
    auto set = read_problems(bodies, {load_case}, material);
    scale_and_note(set);
    return set;
}

ProblemSet read_constrained_problems(const std::vector<std::string> &bodies, const std::string &load_case,
                                     const meshes::MaterialOverride &material) {
    if (!load_case.empty() || bodies.empty())
        return read_scaled_problems(bodies, load_case.empty() ? usual_constraints : load_case, material);
    auto set = read_all(bodies, usual_constraints_first(), material, true, Choice::first);
    scale_and_note(set);
    return set;
}

core::Problem scaled_to_target(core::Problem problem, const core::Model &baseline, PreparedModels &prepared) {
    auto &load_case = problem.load_case;
    if (!load_case.scale_to_target)
        return problem;
    load_case.scale_to_target = false;
    auto at_rest = problem;
    at_rest.load_case = core::without_time(std::move(at_rest.load_case)); // only the static solution is wanted
    const auto solution = prepared.solve(baseline, at_rest);
    double peak = 0.0;
    for (const auto &displacement : solution.displacement)
        peak = std::max(peak, displacement.norm());
    if (solution.status != core::SolutionStatus::ok || !(peak > 0.0))
        throw std::runtime_error(fmt::format("cannot be scaled to its target: {} ends with status {} and a peak "
                                             "displacement of {} m",
                                             baseline.name, core::to_string(solution.status), peak));
    // Six digits, so that machines whose arithmetic differs in the last digits of the baseline have the same load, and
    // find references that another one has stored.
    double factor = load_case.target_peak_displacement / peak;
    const auto digits = fmt::format("{:.5e}", factor);
    std::from_chars(digits.data(), digits.data() + digits.size(), factor);
    load_case = core::scaled(std::move(load_case), factor);
    return problem;
}

core::Problem scaled_to_target(core::Problem problem) {
    if (!problem.load_case.scale_to_target)
        return problem;
    if (support::mpi_num_ranks() > 1)
        throw support::InputError(fmt::format("load case {} is scaled to its target, which this command cannot do on "
                                              "several ranks; start without mpirun",
                                              problem.load_case.name));
    PreparedModels prepared;
    return scaled_to_target(std::move(problem), baseline_of(models::all_models()), prepared);
}

std::vector<core::Problem> at_amplitudes(const core::Problem &problem, std::span<const double> amplitudes) {
    if (amplitudes.empty())
        return {problem};
    std::vector<core::Problem> problems;
    for (const double amplitude : amplitudes) {
        problems.push_back({problem.body, core::scaled(problem.load_case, amplitude)});
        problems.back().load_case.name += fmt::format("@{:g}", amplitude);
    }
    return problems;
}

namespace {

using core::Role;

/// The model of RunOptions::calibration.
constexpr auto *calibrated_springs = "calibrated_nodal_volume";

/// Choices about models, with the springs of a calibration.
models::ModelOptions model_options(const RunOptions &options) {
    auto chosen = options.model_options;
    if (options.calibration.empty() && std::ranges::find(options.models, calibrated_springs) != options.models.end())
        throw support::InputError(
            fmt::format("model {} takes its springs from a file; name it with --calibration, or make "
                        "one with `python3 -m livermark.calibration`",
                        calibrated_springs));
    if (!options.calibration.empty())
        chosen.calibration =
            std::make_shared<const core::CalibratedSprings>(results::read_calibration(options.calibration).springs);
    return chosen;
}

/// @throws support::InputError if a load case that was asked for by name is not of the regime that was asked for
void refuse_other_regime(const RunOptions &options, core::Regime regime, const std::string &load_case) {
    const auto &asked_for = options.regimes;
    if (options.load_cases.empty() || !options.has_asked_for_regime ||
        std::ranges::find(asked_for, regime) != asked_for.end())
        return;
    const auto *const wanted = core::to_string(asked_for.front());
    throw support::InputError(
        fmt::format("--regime {}: load case {} is of the {} regime{}; write regime = \"{}\" into its "
                    "file, or leave --regime out",
                    wanted, load_case, core::to_string(regime),
                    regime == core::Regime::small ? ", as is each that names none" : "", wanted));
}

/// The problems that were asked for, and those of them that fit no body.
/// @throws support::InputError if none fits
ProblemSet wanted_problems(const RunOptions &options) {
    std::vector<meshes::MaterialOverride> materials;
    for (const double poisson_ratio : options.poisson_ratios)
        materials.push_back({options.young_modulus, poisson_ratio});
    if (materials.empty())
        materials.push_back({options.young_modulus, {}});
    ProblemSet read;
    for (const auto &material : materials) {
        auto some = read_problems(options.bodies, options.load_cases, material, options.may_leave_out);
        std::ranges::move(some.problems, std::back_inserter(read.problems));
        read.notes = std::move(some.notes); // they are the same for every Poisson's ratio
        read.left_out = std::move(some.left_out);
    }
    for (const auto &problem : read.problems)
        refuse_other_regime(options, problem.load_case.regime, problem.load_case.name);
    for (const auto &left_out : read.left_out)
        refuse_other_regime(options, left_out.kind.regime, left_out.load_case);
    const auto is_left_aside = [&](core::Regime regime, bool depends_on_time) {
        return (options.only_static && depends_on_time) ||
               (options.load_cases.empty() && std::ranges::find(options.regimes, regime) == options.regimes.end());
    };
    std::erase_if(read.problems, [&](const core::Problem &problem) {
        return is_left_aside(problem.load_case.regime, problem.load_case.in_time());
    });
    std::erase_if(read.left_out, [&](const LeftOut &left_out) {
        return is_left_aside(left_out.kind.regime, left_out.kind.depends_on_time);
    });
    if (read.problems.empty() && !read.left_out.empty())
        throw support::InputError(
            fmt::format("{}; give another body, or another load case", sentences(read.left_out).front()));
    return read;
}

/// Clause on a model that does not follow an event.
const char *lack_of(const core::TouchingTool &) {
    return "know no ball that touches";
}
const char *lack_of(const core::SlowHistory &) {
    return "have no material that relaxes";
}
const char *lack_of(const core::Foundation &) {
    return "know no elastic foundation";
}

/// A sentence for each load case and event that models do not follow, on these models, and for each model that was
/// asked for in vain.
/// @throws support::InputError on several ranks where time passes in the material, which is followed on one
std::vector<std::string> without_part(const Run &run) {
    std::vector<std::string> sentences;
    std::set<std::string> explained;
    for (const auto &problem : run.problems) {
        const auto &load_case = problem.load_case;
        if (load_case.slow_history && support::mpi_num_ranks() > 1)
            throw support::InputError(fmt::format("load case {} has a history of tissue that relaxes, which is solved "
                                                  "on one rank only; start without mpirun",
                                                  load_case.name));
        const auto name_those_without = [&]<class Kind>(const std::optional<Kind> &event) {
            std::vector<std::string> names;
            for (const auto &model : run.models)
                if (event && !model.follows.has<Kind>() && !model.only_moving &&
                    model.only.value_or(load_case.regime) == load_case.regime)
                    names.push_back(model.name);
            if (names.empty())
                return;
            explained.insert(names.begin(), names.end());
            auto sentence = fmt::format("{}: these models {}, and are left out: {}", load_case.name, lack_of(*event),
                                        fmt::join(names, ", "));
            if (std::ranges::find(sentences, sentence) == sentences.end())
                sentences.push_back(std::move(sentence));
        };
        name_those_without(load_case.touching);
        name_those_without(load_case.slow_history);
        name_those_without(load_case.foundation);
    }
    for (const auto &model : run.models)
        if (std::ranges::find(run.options.models, model.name) != run.options.models.end() &&
            !explained.contains(model.name) && std::ranges::none_of(run.problems, [&](const core::Problem &problem) {
                return model.takes_part_in(problem);
            }))
            sentences.push_back(fmt::format(
                "{} takes part in none of these load cases: another regime, something that it does not follow, or no "
                "constants of its law",
                model.name));
    return sentences;
}

} // namespace

std::vector<core::Model> choose_models(const std::vector<std::string> &wanted, const models::ModelOptions &options,
                                       bool with_uncertainty) {
    auto models = models::all_models(options);
    for (const auto &name : wanted)
        support::find_named(models, name, "model");
    std::erase_if(models, [&](const core::Model &model) {
        if (std::ranges::find(wanted, model.name) != wanted.end())
            return false;
        if (model.only_when_named)
            return true;
        if (model.at_rest == Role::refined_reference || model.in_motion == Role::refined_reference)
            return !with_uncertainty;
        return !wanted.empty() && model.at_rest != Role::reference && model.in_motion != Role::reference;
    });
    for (auto &model : models)
        if (model.in_motion == Role::reference && !wanted.empty() &&
            std::ranges::find(wanted, model.name) == wanted.end())
            model.only_moving = true;
    return models;
}

const core::Model &baseline_of(const std::vector<core::Model> &models) {
    return *std::ranges::find(models, Role::baseline, &core::Model::at_rest);
}

bool may_fail(const std::string &model, core::Regime regime) {
    if (regime != core::Regime::large)
        return false;
    const auto known = models::all_models();
    const auto found = std::ranges::find(known, model, &core::Model::name);
    return found == known.end() || (found->at_rest != Role::reference && found->at_rest != Role::substitute_reference);
}

std::filesystem::path Run::result_file(const core::Problem &problem) const {
    auto folder = std::filesystem::path(options.output);
    if (!options.poisson_ratios.empty())
        folder /= fmt::format("poisson_{:g}", problem.body->materials.front().poisson_ratio);
    return folder / problem.body->name / (problem.load_case.name + ".h5");
}

Run read_run(const RunOptions &options) {
    using enum fem_reference::SolverChoice;
    for (const auto &[is_asked_for, option] : {std::pair{options.resume, "--resume"},
                                               {options.model_options.fem_solver == direct, "--fem-solver direct"},
                                               {options.jobs.value_or(1) > 1, "--jobs"}})
        if (is_asked_for && support::mpi_num_ranks() > 1)
            throw support::InputError(
                fmt::format("{} works on one rank only; leave it out or start without mpirun", option));
    // Springs that are swept, and those of a calibration, run beside the models asked for by name.
    auto wanted = options.models;
    if (!wanted.empty() && !options.calibration.empty())
        wanted.emplace_back(calibrated_springs);
    if (!wanted.empty())
        for (const auto &[constant, values] : options.model_options.sweeps)
            for (const double value : values)
                wanted.push_back(models::swept_name(constant, value));
    Run run{options, choose_models(wanted, model_options(options), !options.reference_on_mesh),
            baseline_of(models::all_models(options.model_options))};
    auto read = wanted_problems(options);
    run.problems = std::move(read.problems);
    run.notes = std::move(read.notes);
    run.left_out = std::move(read.left_out);
    std::ranges::move(yielded_places(run.problems), std::back_inserter(run.notes));
    std::ranges::move(without_part(run), std::back_inserter(run.notes));
    if (!options.solve_reference) {
        run.solutions = SolutionCache::shipped();
        leave_out_unsolved_motions(run.models);
    }
    if (support::mpi_rank() == 0)
        for (const auto &problem : run.problems)
            for (const auto &model : run.models)
                if (model.check)
                    model.check(problem);
    return run;
}

// A fault of one rank, say a file that only one machine has, is a fault of all: none may go on alone.
Run prepare(const RunOptions &options) {
    std::optional<Run> run;
    std::string fault;
    try {
        run = read_run(options);
        if (support::mpi_rank() == 0)
            for (const auto &problem : run->problems)
                const OutputFolder can_be_made(run->result_file(problem).parent_path());
    } catch (const support::InputError &error) {
        fault = error.what();
    }
    fault = support::first_text_of_ranks(fault);
    if (!fault.empty())
        throw support::InputError(fault);
    return std::move(*run);
}

} // namespace livermark::studies
