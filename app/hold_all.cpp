#include "app/hold_all.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <functional>
#include <stdexcept>

#include "app/answers.hpp"
#include "app/batches.hpp"
#include "app/contest.hpp"
#include "app/news.hpp"
#include "app/output.hpp"
#include "app/progress.hpp"
#include "core/input_error.hpp"
#include "core/side_by_side.hpp"
#include "fem_reference/mpi_session.hpp"
#include "fem_reference/solver_choice.hpp"
#include "results/kept_result.hpp"
#include "results/provenance.hpp"
#include "results/result_file.hpp"

namespace livermark::app {

namespace {

using Contest = std::function<void(const core::Problem &)>;

/// Holds one contest for each amplitude of a problem, in the same order on all ranks: what is collective in it would
/// wait for ever otherwise, so a failure of one keeps nobody from the next.
/// @throws core::InputError on one rank, if a result cannot be kept
void for_each_amplitude(const core::Problem &problem, const core::Model &baseline, const RunOptions &options,
                        const Contest &hold, const std::function<void(const core::Problem &, const char *)> &failed) {
    const auto guarded = [&](const core::Problem &at_work, const Contest &action) {
        try {
            action(at_work);
        } catch (const core::InputError &error) {
            // All else was checked before: results have no place any more. Other ranks would wait for this one.
            if (fem_reference::mpi_num_ranks() == 1)
                throw;
            failed(at_work, error.what());
        } catch (const std::exception &error) {
            failed(at_work, error.what());
        }
    };
    guarded(problem, [&](const core::Problem &as_read) {
        for (const auto &at_amplitude : loaded(as_read, baseline, options))
            guarded(at_amplitude, hold);
    });
}

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

std::string name_of(const core::Problem &problem) {
    return fmt::format("{} / {}", problem.body->name, problem.load_case.name);
}

/// Of the largest body. What models keep of a liver is 149 kB for each tetrahedron, measured; what is solved together
/// on the refined mesh takes as much, but before.
double bytes_per_worker(const RunTask &task) {
    constexpr double bytes_per_tetrahedron = 160e3;
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

/// Holds the contests of one problem, at all amplitudes.
void hold_one(const RunTask &task, const RunOptions &options, const std::string &command_line, std::size_t number,
              const core::Tell &tell) {
    TimeSpent spent;
    spent.begin(other_work);
    const auto step = [&](const core::Problem &problem, const std::string &what) {
        tell(to_text(News::step, number, fmt::format("{} / {}", name_of(problem), what)));
    };
    const auto hold = [&](const core::Problem &problem) {
        const auto file = file_of(problem, options);
        const auto provenance = results::current_provenance(command_line);
        if (is_kept(problem, options, provenance)) {
            for (const auto &model : task.models)
                step(problem, model.name + ", kept");
        } else {
            const auto result = hold_contest(problem, task.models, task.bands, provenance, [&](const auto &model) {
                step(problem, model);
                spent.begin(model);
            });
            spent.begin(other_work);
            keep(file, result);
        }
        tell(to_text(News::result, number, file.string()));
    };
    for_each_amplitude(task.problems[number], baseline_of(task.models), options, hold,
                       [&](const core::Problem &problem, const char *reason) {
                           spent.begin(other_work);
                           tell(to_text(News::failure, number, fmt::format("{}: {}", name_of(problem), reason)));
                       });
    for (const auto &[stage, seconds] : spent.stages())
        tell(to_text(News::time, number, stage, seconds));
}

} // namespace

Outcomes hold_all(RunTask task, const RunOptions &options, const std::string &command_line) {
    Outcomes outcomes{std::vector<Outcome>(task.problems.size()), {}};
    for (const auto &problem : most_shared(task.problems))
        for (const auto &model : task.models)
            if (model.begin_with)
                model.begin_with(problem);
    const auto num_contests = task.problems.size() * std::max<std::size_t>(1, options.amplitudes.size());
    const auto groups = together_groups(task);
    Progress progress(static_cast<int>(num_contests * task.models.size()) + groups.num_steps());
    const int workers = num_workers(task, options);
    const auto provenance = results::current_provenance(command_line);
    auto answers = solve_together(
        groups, task, options, workers,
        [&](const core::Problem &problem) { return !is_kept(problem, options, provenance); }, progress, outcomes.spent);
    task.models = with_answers(std::move(task.models), std::move(answers));
    const auto batches = batches_of(task.problems);
    core::side_by_side(
        batches.body, workers,
        [&](int batch, const core::Tell &tell) {
            for (const auto number : batches.problems[batch])
                hold_one(task, options, command_line, number, tell);
        },
        [&](int /*batch*/, const std::string &text) {
            const Told told(text);
            auto &outcome = outcomes.of_problem[told.problem];
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
        });
    return outcomes;
}

void help_first_rank(const RunTask &task, const RunOptions &options, const std::string &command_line) {
    for (const auto &problem : task.problems)
        for_each_amplitude(
            problem, baseline_of(task.models), options,
            [&](const core::Problem &loaded) {
                hold_contest(loaded, task.models, task.bands, results::current_provenance(command_line),
                             [](const auto &) {});
            },
            [](const auto &, const char *) {});
}

} // namespace livermark::app
