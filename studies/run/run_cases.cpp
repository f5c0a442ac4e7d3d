#include "studies/run/run_cases.hpp"

#include <algorithm>
#include <csignal>
#include <cstring>
#include <fmt/format.h>
#include <optional>
#include <stdexcept>

#include "fem_reference/linear/solver_choice.hpp"
#include "results/hdf5/result_file.hpp"
#include "results/hdf5/resumable_result.hpp"
#include "results/provenance.hpp"
#include "studies/progress.hpp"
#include "studies/run/benchmark_case.hpp"
#include "studies/run/loads.hpp"
#include "studies/run/prepared_models.hpp"
#include "studies/run/solutions/output_folder.hpp"
#include "studies/run/solutions/stored_solutions.hpp"
#include "studies/run/work/case_groups.hpp"
#include "studies/run/work/work_plan.hpp"
#include "studies/run/work/worker_messages.hpp"
#include "support/input_error.hpp"
#include "support/processes/memory.hpp"
#include "support/processes/mpi_session.hpp"
#include "support/processes/process_pool.hpp"

namespace livermark::studies {

namespace {

void keep(const std::filesystem::path &file, const results::Result &result, const RunOptions &options) {
    try {
        results::write_result(file, result);
    } catch (const support::InputError &error) {
        throw support::InputError(
            fmt::format("{}, and go on with {}", error.what(), options.resume ? "the same command" : "--resume"));
    }
}

std::filesystem::path file_of(const core::Problem &problem, const RunOptions &options) {
    return make_output_folder(output_folder(options, problem), problem) / (problem.load_case.name + ".h5");
}

bool is_resumed(const core::Problem &problem, const RunOptions &options, const results::Provenance &provenance) {
    return options.resume && results::resumable_result(file_of(problem, options), problem, provenance);
}

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

/// What all workers know.
struct Run {
    const RunTask &task;
    const RunOptions &options;
    const std::string &command_line;
    std::vector<LoadedProblem> loads;
    std::vector<core::Problem> problems; ///< of the loads
    std::vector<bool> is_resumed;        ///< whether there is a result of each already
    bool is_model_by_model = false;      ///< not on several MPI ranks, which solve each benchmark case together
    WorkPlan plan{};
    std::optional<SolutionStore> store{}; ///< if models solve before the benchmark cases
};

void send_times(TimeSpent &spent, std::size_t load, const support::SendMessage &send) {
    for (const auto &[stage, seconds] : spent.stages())
        send(to_text(MessageKind::time, load, stage, seconds));
}

/// Evaluates the benchmark case of one problem and keeps the result, or what is there.
/// @throws support::InputError on one rank, if the result cannot be kept
void run_case(const Run &run, std::size_t load, PreparedModels &prepared, const support::SendMessage &send) {
    const auto &problem = run.problems[load];
    TimeSpent spent;
    spent.begin(other_work);
    const auto step = [&](const std::string &what) {
        send(to_text(MessageKind::step, load, fmt::format("{} / {}", name_of(problem), what)));
    };
    try {
        const auto file = file_of(problem, run.options);
        if (run.is_resumed[load]) {
            for (const auto &model : run.task.models)
                if (model.takes_part_in(problem))
                    step(model.name + ", kept");
        } else {
            const auto solve = [&](const core::Model &model, const core::Problem &to_solve) {
                if (auto stored = run.store ? run.store->find(load, model.name, to_solve) : std::nullopt)
                    return *std::move(stored);
                step(model.name);
                spent.begin(model.name);
                return prepared.solve(model, to_solve);
            };
            auto result = evaluate(problem, run.task.models, solve, run.task.bands,
                                   results::current_provenance(run.command_line));
            spent.begin(other_work);
            keep(file, result, run.options);
        }
        send(to_text(MessageKind::result, load, file.string()));
    } catch (const support::InputError &error) {
        // All else was checked before: results have no place any more. Other ranks would wait for this one.
        if (support::mpi_num_ranks() == 1)
            throw;
        send(to_text(MessageKind::failure, load, fmt::format("{}: {}", name_of(problem), error.what())));
    } catch (const std::exception &error) {
        send(to_text(MessageKind::failure, load, fmt::format("{}: {}", name_of(problem), support::reason_of(error))));
    }
    send_times(spent, load, send);
}

void solve_item(const Run &run, const WorkItem &item, PreparedModels &prepared, const support::SendMessage &send) {
    const auto load = item.case_groups.front().front();
    TimeSpent spent;
    solve_and_store(item, run.task.models, run.problems, prepared, *run.store,
                    [&](const std::string &model, const std::string &about) {
                        send(to_text(MessageKind::step, load, fmt::format("{} / {}", about, model)));
                        spent.begin(model);
                    });
    send_times(spent, load, send);
}

/// What each worker has of its own.
struct Worker {
    PreparedModels prepared;
    int at_group = -1; ///< of the item before
};

void do_item(const Run &run, int item, Worker &worker, const support::SendMessage &send) {
    const auto &work = run.plan.items[item];
    if (run.is_model_by_model && run.plan.group[item] != worker.at_group)
        worker.prepared.clear(); // what comes is by other models, or compares
    worker.at_group = run.plan.group[item];
    if (work.models.empty())
        return run_case(run, work.case_groups.front().front(), worker.prepared, send);
    solve_item(run, work, worker.prepared, send);
}

/// How many steps all of it is reported in.
int num_steps(const Run &run) {
    std::size_t num = 0;
    for (const auto &item : run.plan.items) {
        if (item.models.empty()) {
            const auto load = item.case_groups.front().front();
            for (const auto &model : run.task.models)
                if (model.takes_part_in(run.problems[load]))
                    num += run.is_resumed[load] || !(run.is_model_by_model || model.most_together > 1) ? 1 : 0;
        }
        for (const auto m : item.models) {
            const auto &model = run.task.models[m];
            const auto part = part_of(model, item.case_groups, run.problems);
            if (model.most_together > 1)
                num += part.empty() ? 0 : 1;
            else
                for (const auto &case_group : part)
                    num += case_group.size();
        }
    }
    return static_cast<int>(num);
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
    Worker worker{PreparedModels(most_shared(task.problems))};
    outcomes.spent.begin(other_work);
    Run run{
        .task = task, .options = options, .command_line = command_line, .loads = {}, .problems = {}, .is_resumed = {}};
    run.loads = load_all(task, options, worker.prepared, [&](std::size_t number, const std::string &reason) {
        outcomes.of_problem[number].failures.push_back(fmt::format("{}: {}", name_of(task.problems[number]), reason));
    });
    run.problems = problems_of(run.loads);
    const auto provenance = results::current_provenance(command_line);
    for (const auto &problem : run.problems)
        run.is_resumed.push_back(is_resumed(problem, options, provenance));
    const int workers = num_workers(task, options);
    run.is_model_by_model = support::mpi_num_ranks() == 1;
    run.plan = plan_work(run.problems, task.models, run.is_model_by_model,
                         [&](std::size_t load) { return !run.is_resumed[load]; });
    if (std::ranges::any_of(run.plan.items, [](const WorkItem &item) { return !item.models.empty(); }))
        run.store.emplace();
    outcomes.spent.stop();
    Steps steps(num_steps(run), report);
    std::vector<Outcome> of_load(run.loads.size()); // they end in any order
    std::vector<std::string> last_step(run.plan.items.size());
    support::run_in_process_pool(
        run.plan.group, workers, [&](int item, const support::SendMessage &send) { do_item(run, item, worker, send); },
        [&](int item, const std::string &text) {
            const WorkerMessage message(text);
            auto &outcome = of_load[message.problem];
            switch (message.kind) {
            case MessageKind::step:
                steps.next(message.about);
                last_step[static_cast<std::size_t>(item)] = message.about;
                break;
            case MessageKind::time:
                outcomes.spent.add(message.about, message.seconds);
                break;
            case MessageKind::result:
                outcome.done.push_back(results::read_result(message.about, results::Origin::own));
                break;
            case MessageKind::failure:
                outcome.failures.push_back(message.about);
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
                of_load[load].failures.push_back(sentence);
            else // a benchmark case solves by itself what it does not find
                outcomes.notes.push_back(sentence + "; each load case was then solved by itself");
        });
    for (std::size_t load = 0; load < of_load.size(); ++load) {
        auto &outcome = outcomes.of_problem[run.loads[load].number];
        outcome.num_kept += run.is_resumed[load] ? 1 : 0;
        std::ranges::move(of_load[load].done, std::back_inserter(outcome.done));
        std::ranges::move(of_load[load].failures, std::back_inserter(outcome.failures));
    }
    return outcomes;
}

void help_first_rank(const RunTask &task, const RunOptions &options, const std::string &command_line) {
    PreparedModels prepared;
    const auto loads = load_all(task, options, prepared, [](std::size_t, const std::string &) {});
    const auto solve = [&](const core::Model &model, const core::Problem &problem) {
        return prepared.solve(model, problem);
    };
    for (const auto &item : plan_work(problems_of(loads), task.models, false, [](std::size_t) { return true; }).items)
        try {
            evaluate(loads[item.case_groups.front().front()].problem, task.models, solve, task.bands,
                     results::current_provenance(command_line));
        } catch (const std::exception &) {
            continue; // what fails here fails on rank 0 as well
        }
}

} // namespace livermark::studies
