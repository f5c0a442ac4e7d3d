#include "studies/run/run.hpp"

#include <algorithm>
#include <csignal>
#include <cstring>
#include <exception>
#include <fmt/format.h>
#include <iterator>
#include <map>
#include <numeric>
#include <optional>
#include <span>
#include <utility>

#include "core/support/input_error.hpp"
#include "core/support/processes/mpi_session.hpp"
#include "core/support/processes/own_process.hpp"
#include "fem_reference/linear/elastic_system.hpp"
#include "results/hdf5/result_file.hpp"
#include "results/records/result.hpp"
#include "studies/study.hpp"

namespace livermark::studies {

namespace {

using IsWanted = std::function<bool(std::size_t)>;

std::vector<CaseGroup> wanted_of(std::span<const CaseGroup> case_groups, const IsWanted &is_wanted) {
    std::vector<CaseGroup> wanted;
    for (const auto &case_group : case_groups) {
        CaseGroup some;
        std::ranges::copy_if(case_group, std::back_inserter(some), is_wanted);
        if (!some.empty())
            wanted.push_back(std::move(some));
    }
    return wanted;
}

/// The stage of all that is not done by a model.
constexpr auto other_work = "loads, comparisons, files";

/// A problem at its target and one of the amplitudes, and what became of it.
struct Case {
    std::size_t number; ///< of the problem in the run
    core::Problem problem;
    bool is_kept = false;  ///< whether an earlier run has left the result
    std::string failure{}; ///< a sentence; empty where a result is written
};

/// For people: body and load case.
std::string name_of(const core::Problem &problem) {
    return fmt::format("{} / {}", problem.body->name, problem.load_case.name);
}

/// Cases of a run, in an order in which models can make use of what they keep: see case_groups_of(). It is the same on
/// all MPI ranks, who all have to call this.
/// @param prepared  what the baseline solves with
/// @param failures  gets a sentence for each problem that cannot be scaled to its target, by its number
std::vector<Case> load_cases_of(const Run &run, PreparedModels &prepared,
                                std::map<std::size_t, std::vector<std::string>> &failures) {
    std::vector<Case> cases;
    for (const auto &case_group : case_groups_of(run.problems))
        for (const auto number : case_group)
            try {
                for (auto &problem : at_amplitudes(scaled_to_target(run.problems[number], run.baseline, prepared),
                                                   run.options.amplitudes))
                    cases.push_back({number, std::move(problem)});
            } catch (const std::exception &error) {
                failures[number].push_back(
                    fmt::format("{}: {}", name_of(run.problems[number]), support::reason_of(error)));
            }
    return cases;
}

/// The same run, which keeps its solutions for a run that goes on after this one was killed: one of the same command
/// and no other, since numbers depend a little on what is solved together. On several MPI ranks, which solve together,
/// nothing is kept.
Run with_cache(Run run, const results::Provenance &provenance) {
    if (support::mpi_num_ranks() == 1) {
        run.solutions.keep_in(run.options.output, fmt::format("{}\n{}\n{}", provenance.command, provenance.git_commit,
                                                              provenance.build_type));
        if (!run.options.resume)
            run.solutions.clear();
    }
    return run;
}

/// The result files of a run, which no other process may write meanwhile.
std::vector<OutputFile> files_to_write(const Run &run) {
    std::vector<OutputFile> files;
    for (const auto &problem : run.problems)
        for (const auto &amplified : at_amplitudes(problem, run.options.amplitudes)) {
            const auto file = run.result_file(amplified);
            files.emplace_back(file.parent_path(), file.filename().string());
        }
    return files;
}

/// Algebraic multigrid, asked for or taken for what is too large to factor, runs on one communicator of this process.
int num_workers(const Run &run) {
    using enum fem_reference::SolverChoice;
    const bool is_large = std::ranges::any_of(run.problems, [](const core::Problem &problem) {
        const auto &mesh = problem.body->mesh;
        const auto num_edges = mesh.num_nodes() + mesh.num_tetrahedra() + mesh.num_boundary_triangles() / 2; // Euler
        return 3 * (mesh.num_nodes() + num_edges) > fem_reference::largest_direct_system;
    });
    if (support::mpi_num_ranks() > 1 || run.options.model_options.fem_solver == iterative || is_large)
        return 1;
    // Load cases that are solved together on the refined mesh of a liver take 124 kB for each tetrahedron, measured;
    // no other model takes as much.
    constexpr double bytes_per_tetrahedron = 140e3;
    std::size_t most = 1; // of the largest body
    for (const auto &problem : run.problems)
        most = std::max(most, problem.body->mesh.tetrahedra.size());
    return run.options.jobs.value_or(support::workers_that_fit(bytes_per_tetrahedron * static_cast<double>(most)));
}

/// Does items of the plan, in the main process or in a copy of it. It sends texts of two lines: the stage that the time
/// of the item goes to from here on, and the step that it begins, if any. At the end of the item there is no stage, and
/// the second line says why its case has failed, if it has.
class Worker {
  public:
    Worker(const Run &run, const std::string &command_line, PreparedModels prepared)
        : run_(run), command_line_(command_line), prepared_(std::move(prepared)) {}

    /// Lets models solve, whose solutions the cache keeps, or evaluates the benchmark case of a problem and writes its
    /// result. A model that finds no solution in the first stage has none: the benchmark case tries again, and says so.
    /// @throws support::InputError on one rank, if the result cannot be written
    void work(const std::vector<Case> &cases, const WorkItem &item, const support::SendMessage &send) {
        if (solves_first_ && item.group != at_group_)
            prepared_.clear(); // what comes is by other models, or compares
        at_group_ = item.group;
        std::string failure;
        if (item.is_evaluation())
            failure = evaluate_case(cases[item.first_problem()].problem, send);
        else
            for (const auto m : item.models)
                try {
                    solve(cases, item.case_groups, run_.models[m], send);
                } catch (const std::exception &) {
                    continue; // a solver's fault, or a full disk
                }
        send("\n" + failure);
    }

    /// The steps that work() reports.
    int num_steps(const std::vector<Case> &cases, const WorkItem &item) const {
        std::size_t num = 0;
        for (const auto m : item.models) {
            const auto most = run_.models[m].most_together;
            num += (part_of(run_.models[m], item.case_groups, cases).size() + most - 1) / most;
        }
        if (item.is_evaluation() && !solves_first_)
            num += std::ranges::count_if(run_.models, [&](const core::Model &model) {
                return model.takes_part_in(cases[item.first_problem()].problem);
            });
        return static_cast<int>(num);
    }

  private:
    /// The problems that a model takes part in, those that it solves once together.
    static std::vector<CaseGroup> part_of(const core::Model &model, const std::vector<CaseGroup> &case_groups,
                                          const std::vector<Case> &cases) {
        std::vector<CaseGroup> part;
        for (const auto &case_group : case_groups) {
            CaseGroup some; // of one static solution, which a motion may begin with
            std::ranges::copy_if(case_group, std::back_inserter(some),
                                 [&](std::size_t number) { return model.takes_part_in(cases[number].problem); });
            if (model.most_together == 1)
                for (const auto number : some)
                    part.push_back({number});
            else if (!some.empty())
                part.push_back(std::move(some));
        }
        return part;
    }

    /// Solves the first problem of each case group, as many together as the model can.
    void solve(const std::vector<Case> &cases, const std::vector<CaseGroup> &case_groups, const core::Model &model,
               const support::SendMessage &send) {
        const auto part = part_of(model, case_groups, cases);
        for (std::size_t first = 0; first < part.size(); first += model.most_together) {
            const auto some = std::span(part).subspan(first, std::min(model.most_together, part.size() - first));
            std::vector<core::Problem> firsts;
            for (const auto &case_group : some)
                firsts.push_back(cases[case_group.front()].problem);
            std::string where;
            for (const auto &problem : firsts)
                if (where = run_.solutions.where(model, problem); where.empty())
                    break;
            const auto num_others = firsts.size() - 1;
            const auto others =
                num_others > 0 ? fmt::format(" and {} other{}", num_others, num_others > 1 ? "s" : "") : "";
            send(fmt::format("{}\n{}{} / {}{}", model.name, name_of(firsts.front()), others, model.name,
                             where.empty() ? "" : ", " + where));
            auto solutions = prepared_.solve(model, firsts);
            for (std::size_t g = 0; g < some.size(); ++g) {
                solutions[g].solver += ", the solution of " + firsts[g].load_case.name;
                for (const auto number : std::span(some[g]).subspan(1))
                    run_.solutions.keep(model, cases[number].problem, solutions[g]);
            }
        }
    }

    /// @return why there is no result; empty if it is written
    std::string evaluate_case(const core::Problem &problem, const support::SendMessage &send) {
        send(std::string(other_work) + "\n");
        const auto solve = [&](const core::Model &model, const core::Problem &to_solve) {
            if (!solves_first_ || run_.solutions.where(model, to_solve).empty())
                send(fmt::format("{}\n{} / {}", model.name, name_of(to_solve), model.name));
            return prepared_.solve(model, to_solve);
        };
        try {
            const auto result = evaluate(problem, run_.models, solve, results::current_provenance(command_line_));
            send(std::string(other_work) + "\n");
            write(result);
            run_.solutions.forget(run_.models, problem);
        } catch (const support::InputError &error) {
            // All else was checked before: results have no place any more. Other ranks would wait for this one.
            if (support::mpi_num_ranks() == 1)
                throw;
            return fmt::format("{}: {}", name_of(problem), error.what());
        } catch (const std::exception &error) {
            return fmt::format("{}: {}", name_of(problem), support::reason_of(error));
        }
        return {};
    }

    void write(const results::Result &result) const {
        try {
            results::write_result(run_.result_file(result.problem), result);
        } catch (const support::InputError &error) {
            throw support::InputError(fmt::format("{}, and go on with {}", error.what(),
                                                  run_.options.resume ? "the same command" : "--resume"));
        }
    }

    const Run &run_;
    const std::string &command_line_;
    bool solves_first_ = support::mpi_num_ranks() == 1;
    PreparedModels prepared_;
    int at_group_ = -1; ///< of the item before
};

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

/// An item on its way, as its worker tells.
struct Progress {
    TimeSpent spent{};
    std::string last_step{};
};

} // namespace

std::vector<CaseGroup> case_groups_of(std::span<const core::Problem> problems) {
    std::vector<CaseGroup> all;
    for (std::size_t p = 0; p < problems.size(); ++p) {
        const auto same = std::ranges::find_if(all, [&](const CaseGroup &case_group) {
            const auto &first = problems[case_group.front()];
            return first.body == problems[p].body && core::are_statically_equal(first.load_case, problems[p].load_case);
        });
        if (same != all.end())
            same->push_back(p);
        else
            all.push_back({p});
    }
    const auto first_alike = [&](std::size_t case_group) {
        const auto &problem = problems[all[case_group].front()];
        return std::ranges::find_if(all, [&](const CaseGroup &candidate) {
            const auto &other = problems[candidate.front()];
            return other.body == problem.body && core::constrain_the_same(other.load_case, problem.load_case);
        });
    };
    std::vector<std::size_t> order(all.size());
    std::iota(order.begin(), order.end(), 0);
    std::ranges::stable_sort(order, {}, first_alike);
    std::ranges::stable_sort(order, std::ranges::greater(), [&](std::size_t case_group) {
        return problems[all[case_group].front()].body->mesh.tetrahedra.size();
    });
    std::vector<CaseGroup> ordered;
    for (const auto case_group : order)
        ordered.push_back(all[case_group]);
    return ordered;
}

std::vector<core::Problem> most_shared(std::span<const core::Problem> problems) {
    struct Candidate {
        const core::Problem *problem;
        std::ptrdiff_t num_sharing; ///< problems that constrain as much or more
    };
    std::vector<Candidate> best; // of each body
    for (const auto &problem : problems) {
        const auto is_of_body = [&](const auto &other) { return other.body == problem.body; };
        const auto constrains_as_much = [&](const auto &other) {
            return is_of_body(other) && core::constrains_all_of(other.load_case, problem.load_case);
        };
        const bool gains = std::ranges::any_of(problems, [&](const auto &other) {
            return constrains_as_much(other) && !core::constrain_the_same(other.load_case, problem.load_case);
        });
        if (!gains)
            continue;
        const Candidate candidate{&problem, std::ranges::count_if(problems, constrains_as_much)};
        const auto known = std::ranges::find_if(best, [&](const auto &other) { return is_of_body(*other.problem); });
        if (known == best.end())
            best.push_back(candidate);
        else if (candidate.num_sharing > known->num_sharing)
            *known = candidate;
    }
    std::vector<core::Problem> shared;
    for (const auto &candidate : best)
        shared.push_back(*candidate.problem);
    return shared;
}

std::vector<WorkItem> plan_work(std::span<const core::Problem> problems, std::span<const core::Model> models,
                                const std::function<bool(std::size_t)> &is_wanted) {
    std::vector<std::size_t> together, others;
    std::size_t most_together = 1;
    for (std::size_t m = 0; m < models.size(); ++m)
        if (models[m].most_together > 1) {
            together.push_back(m);
            most_together = std::max(most_together, models[m].most_together);
        } else {
            others.push_back(m);
        }
    std::vector<WorkItem> items;
    const auto next_group = [&] { return items.empty() ? 0 : items.back().group + 1; };
    // As many case groups at once as models take less time for together: the same ones whatever of them is left to do.
    const auto add_solves = [&](const std::vector<std::size_t> &solving, std::span<const CaseGroup> case_groups,
                                std::size_t most_at_once) {
        const int group = next_group();
        for (std::size_t first = 0; first < case_groups.size(); first += most_at_once) {
            const auto some = case_groups.subspan(first, std::min(most_at_once, case_groups.size() - first));
            if (auto wanted = wanted_of(some, is_wanted); !wanted.empty())
                items.push_back({solving, std::move(wanted), group});
        }
    };
    auto left = case_groups_of(problems);
    while (!left.empty()) {
        const auto body = problems[left.front().front()].body;
        const auto end_of_body = std::stable_partition(left.begin(), left.end(), [&](const CaseGroup &case_group) {
            return problems[case_group.front()].body == body;
        });
        const std::vector same_body(left.begin(), end_of_body);
        left.erase(left.begin(), end_of_body);
        if (!together.empty())
            add_solves(together, same_body, most_together);
        for (const auto model : others)
            add_solves({model}, same_body, 1);
        const int group = next_group(), num_solves = static_cast<int>(items.size());
        for (const auto &case_group : wanted_of(same_body, is_wanted))
            for (const auto problem : case_group) {
                auto &evaluation = items.emplace_back(WorkItem{{}, {{problem}}, group}); // waits for what solves it
                for (int item = 0; item < num_solves; ++item)
                    if (!items[item].is_evaluation() && std::ranges::any_of(items[item].case_groups, [&](auto &solved) {
                            return std::ranges::count(solved, problem) > 0;
                        }))
                        evaluation.waits_for.push_back(item);
            }
    }
    return items;
}

RunOutcome run_cases(const Run &task, const std::string &command_line, const ProgressReport &report) {
    RunOutcome outcome;
    const bool is_first_rank = support::mpi_rank() == 0;
    const auto files = is_first_rank ? files_to_write(task) : std::vector<OutputFile>();
    outcome.spent.begin(other_work);
    const auto provenance = results::current_provenance(command_line);
    const auto run = with_cache(task, provenance);
    PreparedModels prepared(run.solutions, is_first_rank ? most_shared(run.problems) : std::vector<core::Problem>());
    std::map<std::size_t, std::vector<std::string>> failures; // by the number of the problem
    auto cases = load_cases_of(run, prepared, failures);
    if (run.options.resume)
        for (auto &one : cases)
            one.is_kept = results::resumable_result(run.result_file(one.problem), one.problem, provenance).has_value();
    std::vector<core::Problem> problems;
    for (const auto &one : cases)
        problems.push_back(one.problem);
    // Several MPI ranks solve each case together, so that no model solves before.
    const auto items = plan_work(problems, support::mpi_num_ranks() == 1 ? run.models : std::span<const core::Model>(),
                                 [&](std::size_t number) { return !cases[number].is_kept; });
    if (!is_first_rank) {
        const auto solve = [&](const core::Model &model, const core::Problem &problem) {
            return prepared.solve(model, problem);
        };
        for (const auto &item : items)
            try {
                evaluate(cases[item.first_problem()].problem, run.models, solve, provenance);
            } catch (const std::exception &) {
                continue; // what fails here fails on rank 0 as well, which says so
            }
        return outcome;
    }
    Worker worker(run, command_line, std::move(prepared));
    outcome.spent.stop();

    std::vector<std::string> kept; // a step for each model in each case that has a result already
    for (const auto &one : cases)
        for (const auto &model : run.models)
            if (one.is_kept && model.takes_part_in(one.problem))
                kept.push_back(fmt::format("{} / {}, kept", name_of(one.problem), model.name));
    auto num_steps = static_cast<int>(kept.size());
    std::vector<int> groups;
    std::vector<std::vector<int>> waits_for;
    for (const auto &item : items) {
        num_steps += worker.num_steps(cases, item);
        groups.push_back(item.group);
        waits_for.push_back(item.waits_for);
    }
    Steps steps(num_steps, report);
    std::ranges::for_each(kept, [&](const std::string &step) { steps.next(step); });
    std::vector<Progress> progress(items.size());
    support::run_in_process_pool(
        groups, num_workers(task),
        [&](int item, const support::SendMessage &send) { worker.work(cases, items[item], send); },
        [&](int item, const std::string &text) {
            auto &[spent, last_step] = progress[item];
            const auto end_of_stage = text.find('\n');
            const auto stage = text.substr(0, end_of_stage), step = text.substr(end_of_stage + 1);
            if (stage.empty()) {
                spent.stop();
                cases[items[item].first_problem()].failure += step;
                return;
            }
            spent.begin(stage);
            if (!step.empty())
                steps.next(last_step = step);
        },
        waits_for,
        [&](int item, const std::string &how) {
            auto &[spent, last_step] = progress[item];
            spent.stop();
            auto &first = cases[items[item].first_problem()];
            const auto sentence = sentence_on_lost(last_step.empty() ? name_of(first.problem) : last_step, how);
            if (items[item].is_evaluation())
                first.failure = sentence;
            else // a benchmark case solves by itself what it does not find
                outcome.notes.push_back(sentence + "; each load case was then solved by itself");
        });

    for (auto &[spent, last_step] : progress)
        outcome.spent.add(spent);
    std::ranges::stable_sort(cases, {}, &Case::number);
    for (const auto &one : cases)
        if (one.failure.empty()) {
            outcome.done.push_back(results::read_result(run.result_file(one.problem), results::Origin::own));
            outcome.num_kept += one.is_kept ? 1 : 0;
        } else {
            failures[one.number].push_back(one.failure);
        }
    for (auto &[number, some] : failures)
        std::ranges::move(some, std::back_inserter(outcome.failures));
    if (outcome.failures.empty())
        run.solutions.clear();
    return outcome;
}

} // namespace livermark::studies
