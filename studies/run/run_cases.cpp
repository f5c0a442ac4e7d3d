#include "studies/run/run_cases.hpp"

#include <algorithm>
#include <csignal>
#include <cstring>
#include <fmt/format.h>
#include <iterator>
#include <optional>
#include <span>
#include <stdexcept>
#include <utility>

#include "fem_reference/linear/solver_choice.hpp"
#include "results/hdf5/result_file.hpp"
#include "results/hdf5/result_files.hpp"
#include "results/provenance.hpp"
#include "studies/progress.hpp"
#include "studies/run/amplitudes.hpp"
#include "studies/run/benchmark_case.hpp"
#include "studies/run/loads.hpp"
#include "studies/run/solutions/output_folder.hpp"
#include "studies/run/work/case_groups.hpp"
#include "studies/run/work/work_items.hpp"
#include "studies/run/work/worker_messages.hpp"
#include "support/input_error.hpp"
#include "support/processes/memory.hpp"
#include "support/processes/mpi_session.hpp"

namespace livermark::studies {

namespace {

/// Several MPI ranks solve each benchmark case together.
constexpr std::span<const core::Model> none_first;

/// Of the largest body. What is solved together on the refined mesh of a liver takes 124 kB for each tetrahedron,
/// measured; no other model takes as much.
double bytes_per_worker(const RunTask &task) {
    constexpr double bytes_per_tetrahedron = 140e3;
    std::size_t most = 1;
    for (const auto &problem : task.problems)
        most = std::max(most, problem.body->mesh.tetrahedra.size());
    return bytes_per_tetrahedron * static_cast<double>(most);
}

/// Algebraic multigrid, asked for or taken for what is too large to factor, runs on one communicator of this process.
int num_workers(const RunTask &task, const RunOptions &options) {
    using enum fem_reference::SolverChoice;
    const bool is_large = std::ranges::any_of(task.problems, [](const core::Problem &problem) {
        const auto &mesh = problem.body->mesh;
        const auto num_edges = mesh.num_nodes() + mesh.num_tetrahedra() + mesh.num_boundary_triangles() / 2; // Euler
        return 3 * (mesh.num_nodes() + num_edges) > fem_reference::largest_direct_system;
    });
    if (support::mpi_num_ranks() > 1 || options.model_options.fem_solver == iterative || is_large)
        return 1;
    return options.jobs.value_or(support::workers_that_fit(bytes_per_worker(task)));
}

/// The same with models that keep what they solve for a run that goes on after this one was killed: one of the same
/// command and no other, since numbers depend a little on what is solved together. On several MPI ranks, which solve
/// together, nothing is kept.
RunTask with_cache(RunTask task, const RunOptions &options, const results::Provenance &provenance) {
    if (support::mpi_num_ranks() == 1) {
        task.solutions.keep_in(
            folder_of_solutions(options.output, fmt::format("{}\n{}\n{}", provenance.command, provenance.git_commit,
                                                            provenance.build_type)));
        if (!options.resume)
            task.solutions.clear();
    }
    task.baseline = cached(task.baseline, task.solutions);
    for (auto &model : task.models)
        model = cached(model, task.solutions);
    return task;
}

/// A problem at one of the amplitudes, and what became of it.
struct Case {
    std::size_t number; ///< of the problem in the task
    std::optional<results::Result> result{};
    bool is_kept = false; ///< whether an earlier run has left the result
    std::vector<std::string> failures{};
};

Case case_of(const LoadedProblem &load, const RunOptions &options, const results::Provenance &provenance) {
    Case one{load.number};
    if (options.resume)
        one.result = results::resumable_result(result_file_of(load.problem, options), load.problem, provenance);
    one.is_kept = one.result.has_value();
    return one;
}

/// The result files of a run, which no other process may write meanwhile.
std::vector<OutputFile> files_to_write(const RunTask &task, const RunOptions &options) {
    std::vector<OutputFile> files;
    for (const auto &problem : task.problems)
        for (const auto &amplified : at_amplitudes(problem, options.amplitudes)) {
            const auto file = result_file_of(amplified, options);
            files.emplace_back(file.parent_path().parent_path(), problem, file.filename().string());
        }
    return files;
}

/// For each model in each case that has a result already.
std::vector<std::string> kept_steps(const std::vector<Case> &cases, const Run &run) {
    std::vector<std::string> steps;
    for (std::size_t c = 0; c < cases.size(); ++c)
        for (const auto &model : run.task.models)
            if (cases[c].is_kept && model.takes_part_in(run.problems[c]))
                steps.push_back(fmt::format("{} / {}, kept", name_of(run.problems[c]), model.name));
    return steps;
}

/// @param where  the last step that the lost process told of
/// @param how    as of run_in_process_pool()
std::string sentence_on_lost(const std::string &where, const std::string &how) {
    const bool is_killed = how == strsignal(SIGKILL), is_out_of_memory = how == "out of memory";
    return fmt::format("{}: {}", where,
                       is_out_of_memory ? fmt::format("there is too little memory; {}", support::memory_remedy)
                       : is_killed      ? fmt::format("its process was killed, most likely because memory ran out; {}",
                                                      support::memory_remedy)
                                        : fmt::format("its process was lost ({}); leave this model or load case out, "
                                                           "and report it as a fault of livermark",
                                                      how));
}

} // namespace

Outcomes run_cases(const RunTask &task, const RunOptions &options, const std::string &command_line,
                   const ProgressReport &report) {
    Outcomes outcomes{std::vector<Outcome>(task.problems.size()), {}, {}};
    const auto files = files_to_write(task, options);
    Worker worker{PreparedModels(most_shared(task.problems))};
    outcomes.spent.begin(other_work);
    const auto provenance = results::current_provenance(command_line);
    Run run{.task = with_cache(task, options, provenance), .options = options, .command_line = command_line};
    const auto loads = load_all(run.task, options, worker.prepared, [&](std::size_t number, const std::string &reason) {
        outcomes.of_problem[number].failures.push_back(fmt::format("{}: {}", name_of(task.problems[number]), reason));
    });
    run.problems = problems_of(loads);
    std::vector<Case> cases;
    for (const auto &load : loads)
        cases.push_back(case_of(load, options, provenance));
    run.solves_first = support::mpi_num_ranks() == 1;
    run.plan = plan_work(run.problems, run.solves_first ? std::span<const core::Model>(run.task.models) : none_first,
                         [&](std::size_t load) { return !cases[load].is_kept; });
    outcomes.spent.stop();
    const auto kept = kept_steps(cases, run);
    Steps steps(num_steps(run) + static_cast<int>(kept.size()), report);
    std::ranges::for_each(kept, [&](const std::string &step) { steps.next(step); });
    std::vector<std::string> last_step(run.plan.items.size());
    support::run_in_process_pool(
        run.plan.group, num_workers(task, options),
        [&](int item, const support::SendMessage &send) { do_item(run, item, worker, send); },
        [&](int item, const std::string &text) {
            const WorkerMessage message(text);
            switch (message.kind) {
            case MessageKind::step:
                steps.next(message.about);
                last_step[static_cast<std::size_t>(item)] = message.about;
                break;
            case MessageKind::time:
                outcomes.spent.add(message.about, message.seconds);
                break;
            case MessageKind::result:
                cases[message.problem].result = results::read_result(message.about, results::Origin::own);
                break;
            case MessageKind::failure:
                cases[message.problem].failures.push_back(message.about);
                break;
            }
        },
        run.plan.waits_for,
        [&](int item, const std::string &how) {
            const auto &work = run.plan.items[static_cast<std::size_t>(item)];
            const auto load = work.case_groups.front().front();
            const auto &step = last_step[static_cast<std::size_t>(item)];
            const auto sentence = sentence_on_lost(step.empty() ? name_of(run.problems[load]) : step, how);
            if (work.models.empty())
                cases[load].failures.push_back(sentence);
            else // a benchmark case solves by itself what it does not find
                outcomes.notes.push_back(sentence + "; each load case was then solved by itself");
        });
    for (auto &one : cases) {
        auto &outcome = outcomes.of_problem[one.number];
        outcome.num_kept += one.is_kept ? 1 : 0;
        if (one.result)
            outcome.done.push_back(*std::move(one.result));
        std::ranges::move(one.failures, std::back_inserter(outcome.failures));
    }
    if (std::ranges::all_of(outcomes.of_problem, [](const Outcome &outcome) { return outcome.failures.empty(); }))
        run.task.solutions.clear();
    return outcomes;
}

void help_first_rank(const RunTask &task, const RunOptions &options, const std::string &command_line) {
    PreparedModels prepared;
    const auto provenance = results::current_provenance(command_line);
    const auto own = with_cache(task, options, provenance);
    const auto loads = load_all(own, options, prepared, [](std::size_t, const std::string &) {});
    const auto solve = [&](const core::Model &model, const core::Problem &problem) {
        return prepared.solve(model, problem);
    };
    for (const auto &item : plan_work(problems_of(loads), none_first, [](std::size_t) { return true; }).items)
        try {
            evaluate(loads[item.case_groups.front().front()].problem, own.models, solve, provenance);
        } catch (const std::exception &) {
            continue; // what fails here fails on rank 0 as well
        }
}

} // namespace livermark::studies
