#include "studies/run/run.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <iterator>
#include <memory>
#include <utility>

#include "core/support/input_error.hpp"
#include "core/support/processes/mpi_session.hpp"
#include "results/records/springs.hpp"
#include "studies/files.hpp"
#include "studies/run/benchmark_case.hpp"

namespace livermark::studies {

namespace {

/// The model of RunOptions::calibration.
constexpr auto *calibrated_springs = "calibrated_nodal_volume";

void refuse_on_several_ranks(const RunOptions &options) {
    if (support::mpi_num_ranks() == 1)
        return;
    using enum fem_reference::SolverChoice;
    for (const auto &[is_asked_for, option] : {std::pair{options.resume, "--resume"},
                                               {options.model_options.fem_solver == direct, "--fem-solver direct"},
                                               {options.jobs.value_or(1) > 1, "--jobs"}})
        if (is_asked_for)
            throw support::InputError(
                fmt::format("{} works on one rank only; leave it out or start without mpirun", option));
}

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

/// Springs that are swept, and those of a calibration, run beside the models asked for by name.
std::vector<std::string> wanted_models(const RunOptions &options) {
    auto wanted = options.models;
    if (!wanted.empty() && !options.calibration.empty())
        wanted.emplace_back(calibrated_springs);
    if (!wanted.empty())
        for (const auto &[constant, values] : options.model_options.sweeps)
            for (const double value : values)
                wanted.push_back(models::swept_name(constant, value));
    return wanted;
}

ProblemSet read_all_problems(const RunOptions &options) {
    if (options.poisson_ratios.empty())
        return read_problems(options.bodies, options.load_cases, {options.young_modulus, {}}, options.may_leave_out);
    ProblemSet all;
    for (const double poisson_ratio : options.poisson_ratios) {
        auto some = read_problems(options.bodies, options.load_cases, {options.young_modulus, poisson_ratio},
                                  options.may_leave_out);
        std::ranges::move(some.problems, std::back_inserter(all.problems));
        all.notes = std::move(some.notes); // they are the same for every Poisson's ratio
        all.left_out = std::move(some.left_out);
    }
    return all;
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
    auto read = read_all_problems(options);
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

/// A sentence for each load case in which time passes in the material, on the models that do not know of it.
/// @throws support::InputError on several ranks, which follow none
std::vector<std::string> without_part_in_slow_histories(const Run &run) {
    std::vector<std::string> sentences;
    for (const auto &problem : run.problems) {
        if (!problem.load_case.slow_history)
            continue;
        if (support::mpi_num_ranks() > 1)
            throw support::InputError(fmt::format("load case {} has a history of tissue that relaxes, which is solved "
                                                  "on one rank only; start without mpirun",
                                                  problem.load_case.name));
        std::vector<std::string> names;
        for (const auto &model : run.models)
            if (!model.follows.has<core::SlowHistory>() && !model.only_moving &&
                model.only.value_or(problem.load_case.regime) == problem.load_case.regime)
                names.push_back(model.name);
        auto sentence = fmt::format("{}: these models have no material that relaxes, and are left out: {}",
                                    problem.load_case.name, fmt::join(names, ", "));
        if (!names.empty() && std::ranges::find(sentences, sentence) == sentences.end())
            sentences.push_back(std::move(sentence));
    }
    return sentences;
}

} // namespace

std::filesystem::path Run::result_file(const core::Problem &problem) const {
    auto folder = std::filesystem::path(options.output);
    if (!options.poisson_ratios.empty())
        folder /= fmt::format("poisson_{:g}", problem.body->materials.front().poisson_ratio);
    return folder / problem.body->name / (problem.load_case.name + ".h5");
}

Run read_run(const RunOptions &options) {
    refuse_on_several_ranks(options);
    Run run{options, choose_models(wanted_models(options), model_options(options), !options.reference_on_mesh),
            baseline_of(models::all_models(options.model_options))};
    auto read = wanted_problems(options);
    run.problems = std::move(read.problems);
    run.notes = std::move(read.notes);
    run.left_out = std::move(read.left_out);
    std::ranges::move(yielded_places(run.problems), std::back_inserter(run.notes));
    std::ranges::move(without_part_in_slow_histories(run), std::back_inserter(run.notes));
    if (!options.solve_reference) {
        run.solutions = SolutionCache(stored_references_folder());
        leave_out_unsolved_motions(run.models, stored_references_folder());
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
