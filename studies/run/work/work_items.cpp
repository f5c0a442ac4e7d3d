#include "studies/run/work/work_items.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <iterator>
#include <utility>

#include "results/hdf5/result_file.hpp"
#include "results/provenance.hpp"
#include "studies/run/benchmark_case.hpp"
#include "studies/run/loads.hpp"
#include "studies/run/solutions/output_folder.hpp"
#include "studies/run/work/time_spent.hpp"
#include "studies/run/work/worker_messages.hpp"
#include "support/input_error.hpp"
#include "support/processes/memory.hpp"
#include "support/processes/mpi_session.hpp"

namespace livermark::studies {

namespace {

void write_or_say(const std::filesystem::path &file, const results::Result &result, const RunOptions &options) {
    try {
        results::write_result(file, result);
    } catch (const support::InputError &error) {
        throw support::InputError(
            fmt::format("{}, and go on with {}", error.what(), options.resume ? "the same command" : "--resume"));
    }
}

/// What is reported before a model is at the first of some case groups.
std::string step_text(const Run &run, const core::Model &model, std::span<const CaseGroup> case_groups) {
    std::string where;
    for (const auto &case_group : case_groups)
        if (where = run.task.solutions.where(model, run.problems[case_group.front()]); where.empty())
            break;
    const auto num_others = case_groups.size() - 1;
    return fmt::format("{}{} / {}{}", name_of(run.problems[case_groups.front().front()]),
                       num_others > 0 ? fmt::format(" and {} other{}", num_others, num_others > 1 ? "s" : "") : "",
                       model.name, where.empty() ? "" : ", " + where);
}

void send_times(TimeSpent &spent, std::size_t load, const support::SendMessage &send) {
    for (const auto &[stage, seconds] : spent.stages())
        send(to_text(MessageKind::time, load, stage, seconds));
}

/// The problems that a model takes part in, those that it solves once together.
std::vector<CaseGroup> part_of(const core::Model &model, const std::vector<CaseGroup> &case_groups,
                               const std::vector<core::Problem> &problems) {
    std::vector<CaseGroup> part;
    for (const auto &case_group : case_groups) {
        CaseGroup some; // of one static solution, which a motion may begin with
        std::ranges::copy_if(case_group, std::back_inserter(some),
                             [&](std::size_t number) { return model.takes_part_in(problems[number]); });
        if (model.most_together == 1)
            for (const auto number : some)
                part.push_back({number});
        else if (!some.empty())
            part.push_back(std::move(some));
    }
    return part;
}

/// Of those with the same static solution the first is solved.
void solve_together(const Run &run, const core::Model &model, std::span<const CaseGroup> case_groups,
                    PreparedModels &prepared) {
    std::vector<core::Problem> firsts;
    for (const auto &case_group : case_groups)
        firsts.push_back(run.problems[case_group.front()]);
    auto solutions = prepared.solve(model, firsts);
    for (std::size_t b = 0; b < case_groups.size(); ++b) {
        solutions[b].solver += ", the solution of " + firsts[b].load_case.name;
        for (const auto number : std::span(case_groups[b]).subspan(1))
            run.task.solutions.keep(model, run.problems[number], solutions[b]);
    }
}

void solve_item(const Run &run, const WorkItem &item, PreparedModels &prepared, const support::SendMessage &send) {
    const auto load = item.case_groups.front().front();
    TimeSpent spent;
    for (const auto m : item.models)
        try {
            const auto &model = run.task.models[m];
            const auto part = part_of(model, item.case_groups, run.problems);
            for (std::size_t first = 0; first < part.size(); first += model.most_together) {
                const auto some = std::span(part).subspan(first, std::min(model.most_together, part.size() - first));
                send(to_text(MessageKind::step, load, step_text(run, model, some)));
                spent.begin(model.name);
                solve_together(run, model, some, prepared);
            }
        } catch (const std::exception &) {
            continue; // a solver's fault, or a full disk
        }
    send_times(spent, load, send);
}

/// Evaluates the benchmark case of one problem and writes the result.
void evaluate_item(const Run &run, std::size_t load, PreparedModels &prepared, const support::SendMessage &send) {
    const auto &problem = run.problems[load];
    TimeSpent spent;
    spent.begin(other_work);
    try {
        const auto file = result_file_of(problem, run.options);
        const auto solve = [&](const core::Model &model, const core::Problem &to_solve) {
            if (!run.solves_first || run.task.solutions.where(model, to_solve).empty()) {
                send(to_text(MessageKind::step, load, fmt::format("{} / {}", name_of(to_solve), model.name)));
                spent.begin(model.name);
            }
            return prepared.solve(model, to_solve);
        };
        const auto result = evaluate(problem, run.task.models, solve, results::current_provenance(run.command_line));
        spent.begin(other_work);
        write_or_say(file, result, run.options);
        run.task.solutions.forget(run.task.models, problem);
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

} // namespace

std::filesystem::path result_file_of(const core::Problem &problem, const RunOptions &options) {
    return output_folder(options, problem) / problem.body->name / (problem.load_case.name + ".h5");
}

void do_item(const Run &run, int item, Worker &worker, const support::SendMessage &send) {
    const auto &work = run.plan.items[item];
    if (run.solves_first && run.plan.group[item] != worker.at_group)
        worker.prepared.clear(); // what comes is by other models, or compares
    worker.at_group = run.plan.group[item];
    if (work.models.empty())
        evaluate_item(run, work.case_groups.front().front(), worker.prepared, send);
    else
        solve_item(run, work, worker.prepared, send);
}

int num_steps(const Run &run) {
    std::size_t num = 0;
    for (const auto &item : run.plan.items) {
        for (const auto m : item.models) {
            const auto &model = run.task.models[m];
            num +=
                (part_of(model, item.case_groups, run.problems).size() + model.most_together - 1) / model.most_together;
        }
        if (item.models.empty() && !run.solves_first)
            num += std::ranges::count_if(run.task.models, [&](const core::Model &model) {
                return model.takes_part_in(run.problems[item.case_groups.front().front()]);
            });
    }
    return static_cast<int>(num);
}

} // namespace livermark::studies
