#include "app/hold_all.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <optional>
#include <stdexcept>

#include "app/answers.hpp"
#include "app/batches.hpp"
#include "app/contest.hpp"
#include "app/loads.hpp"
#include "app/news.hpp"
#include "app/output.hpp"
#include "app/progress.hpp"
#include "app/work_plan.hpp"
#include "core/input_error.hpp"
#include "core/side_by_side.hpp"
#include "fem_reference/mpi_session.hpp"
#include "fem_reference/solver_choice.hpp"
#include "results/kept_result.hpp"
#include "results/provenance.hpp"
#include "results/result_file.hpp"

namespace livermark::app {

namespace {

void keep(const std::filesystem::path &file, const results::Result &result) {
    try {
        results::write_result(file, result);
    } catch (const core::InputError &error) {
        throw core::InputError(fmt::format("{}, and go on with --resume", error.what()));
    }
}

std::filesystem::path file_of(const core::Problem &problem, const RunOptions &options) {
    return make_output_folder(output_folder(options, problem), problem) / (problem.load_case.name + ".h5");
}

bool is_kept(const core::Problem &problem, const RunOptions &options, const results::Provenance &provenance) {
    return options.resume && results::kept_result(file_of(problem, options), problem, provenance);
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
    if (fem_reference::mpi_num_ranks() > 1 || options.model_options.fem_solver == iterative || is_large)
        return 1;
    return options.jobs.value_or(core::workers_that_fit(bytes_per_worker(task)));
}

/// What all workers know.
struct Run {
    const RunTask &task;
    const RunOptions &options;
    const std::string &command_line;
    std::vector<LoadedProblem> loads;
    std::vector<core::Problem> problems; ///< of the loads
    std::vector<bool> is_kept;           ///< whether there is a result of each already
    bool is_model_by_model = false;
    WorkPlan plan{};
    std::optional<AnswerFolder> folder{}; ///< if there are answers
};

void tell_times(TimeSpent &spent, std::size_t load, const core::Tell &tell) {
    for (const auto &[stage, seconds] : spent.stages())
        tell(to_text(News::time, load, stage, seconds));
}

/// Holds the contest of one problem and keeps the result, or what is there.
/// @throws core::InputError on one rank, if the result cannot be kept
void hold_one(const Run &run, std::size_t load, const core::Tell &tell) {
    const auto &problem = run.problems[load];
    TimeSpent spent;
    spent.begin(other_work);
    const auto step = [&](const std::string &what) {
        tell(to_text(News::step, load, fmt::format("{} / {}", name_of(problem), what)));
    };
    try {
        const auto file = file_of(problem, run.options);
        if (run.is_kept[load]) {
            for (const auto &model : run.task.models)
                step(model.name + ", kept");
        } else {
            const auto models =
                with_answers(run.task.models, load, run.folder ? &*run.folder : nullptr, [&](const std::string &model) {
                    step(model);
                    spent.begin(model);
                });
            auto result = hold_contest(problem, models, run.task.bands, results::current_provenance(run.command_line),
                                       [](const auto &) {});
            spent.begin(other_work);
            keep(file, result);
        }
        tell(to_text(News::result, load, file.string()));
    } catch (const core::InputError &error) {
        // All else was checked before: results have no place any more. Other ranks would wait for this one.
        if (fem_reference::mpi_num_ranks() == 1)
            throw;
        tell(to_text(News::failure, load, fmt::format("{}: {}", name_of(problem), error.what())));
    } catch (const std::exception &error) {
        tell(to_text(News::failure, load, fmt::format("{}: {}", name_of(problem), error.what())));
    }
    tell_times(spent, load, tell);
}

void answer_some(const Run &run, const WorkItem &item, const core::Tell &tell) {
    const auto load = item.batches.front().front();
    TimeSpent spent;
    answer(item, run.task.models, run.problems, *run.folder, [&](const std::string &model, const std::string &about) {
        tell(to_text(News::step, load, fmt::format("{} / {}", about, model)));
        spent.begin(model);
    });
    tell_times(spent, load, tell);
}

/// @param at_group  of the item before, of the same worker
void do_item(const Run &run, int item, int &at_group, const core::Tell &tell) {
    const auto &work = run.plan.items[item];
    if (work.models.empty())
        return hold_one(run, work.batches.front().front(), tell);
    if (run.is_model_by_model && run.plan.group[item] != at_group)
        for (const auto &model : run.task.models)
            if (model.forget)
                model.forget();
    at_group = run.plan.group[item];
    answer_some(run, work, tell);
}

/// How many steps all of it is told in.
int num_steps(const Run &run) {
    std::size_t num = 0;
    for (const auto &item : run.plan.items) {
        if (item.models.empty()) {
            const bool is_kept = run.is_kept[item.batches.front().front()];
            for (const auto &model : run.task.models)
                num += is_kept || !(run.is_model_by_model || model.solve_together) ? 1 : 0;
        } else if (run.task.models[item.models.front()].solve_together) {
            num += item.models.size();
        } else {
            for (const auto &batch : item.batches)
                num += batch.size();
        }
    }
    return static_cast<int>(num);
}

} // namespace

Outcomes hold_all(const RunTask &task, const RunOptions &options, const std::string &command_line) {
    Outcomes outcomes{std::vector<Outcome>(task.problems.size()), {}};
    for (const auto &problem : most_shared(task.problems))
        for (const auto &model : task.models)
            if (model.begin_with)
                model.begin_with(problem);
    outcomes.spent.begin(other_work);
    Run run{.task = task, .options = options, .command_line = command_line, .loads = {}, .problems = {}, .is_kept = {}};
    run.loads = load_all(task, options, [&](std::size_t number, const char *reason) {
        outcomes.of_problem[number].failures.push_back(fmt::format("{}: {}", name_of(task.problems[number]), reason));
    });
    run.problems = problems_of(run.loads);
    const auto provenance = results::current_provenance(command_line);
    for (const auto &problem : run.problems)
        run.is_kept.push_back(is_kept(problem, options, provenance));
    const int workers = num_workers(task, options);
    run.is_model_by_model = workers > 1;
    run.plan = plan_work(run.problems, task.models, run.is_model_by_model,
                         [&](std::size_t load) { return !run.is_kept[load]; });
    if (std::ranges::any_of(run.plan.items, [](const WorkItem &item) { return !item.models.empty(); }))
        run.folder.emplace();
    outcomes.spent.stop();
    Progress progress(num_steps(run));
    std::vector<Outcome> of_load(run.loads.size()); // they end in any order
    int at_group = -1;                              // each worker has its own
    core::side_by_side(
        run.plan.group, workers, [&](int item, const core::Tell &tell) { do_item(run, item, at_group, tell); },
        [&](int /*item*/, const std::string &text) {
            const Told told(text);
            auto &outcome = of_load[told.problem];
            switch (told.news) {
            case News::step:
                progress.next(told.about);
                break;
            case News::time:
                outcomes.spent.add(told.about, told.seconds);
                break;
            case News::result:
                outcome.done.push_back(results::read_result(told.about));
                break;
            case News::failure:
                outcome.failures.push_back(told.about);
                break;
            }
        },
        run.plan.waits_for);
    for (std::size_t load = 0; load < of_load.size(); ++load) {
        auto &outcome = outcomes.of_problem[run.loads[load].number];
        std::ranges::move(of_load[load].done, std::back_inserter(outcome.done));
        std::ranges::move(of_load[load].failures, std::back_inserter(outcome.failures));
    }
    return outcomes;
}

void help_first_rank(const RunTask &task, const RunOptions &options, const std::string &command_line) {
    const auto loads = load_all(task, options, [](std::size_t, const char *) {});
    for (const auto &item : plan_work(problems_of(loads), task.models, false, [](std::size_t) { return true; }).items)
        try {
            hold_contest(loads[item.batches.front().front()].problem, task.models, task.bands,
                         results::current_provenance(command_line), [](const auto &) {});
        } catch (const std::exception &) {
            continue; // what fails here fails on rank 0 as well
        }
}

} // namespace livermark::app
