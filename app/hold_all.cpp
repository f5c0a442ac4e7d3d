#include "app/hold_all.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <functional>
#include <numeric>
#include <sstream>
#include <stdexcept>

#include "app/amplitudes.hpp"
#include "app/contest.hpp"
#include "app/load_scaling.hpp"
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

/// Every choice of models has the baseline.
const core::Model &baseline_of(const std::vector<core::Model> &models) {
    return *std::ranges::find(models, models::baseline_model, &core::Model::name);
}

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
        for (const auto &loaded : at_amplitudes(scaled_to_target(as_read, baseline), options.amplitudes))
            guarded(loaded, hold);
    });
}

void keep(const std::filesystem::path &file, const results::Result &result) {
    try {
        results::write_result(file, result);
    } catch (const core::InputError &error) {
        throw core::InputError(fmt::format("{}, and go on with --resume", error.what()));
    }
}

std::string name_of(const core::Problem &problem) {
    return fmt::format("{} / {}", problem.body->name, problem.load_case.name);
}

/// Problems of one body with the same static answer, which models keep: one after the other by one worker, so that what
/// is kept does not depend on how many there are.
struct Batches {
    std::vector<std::vector<std::size_t>> problems;
    std::vector<int> body; ///< of each batch
};

Batches batches_of(const std::vector<core::Problem> &problems) {
    Batches batches;
    std::vector<const core::Body *> bodies;
    for (std::size_t p = 0; p < problems.size(); ++p) {
        const auto &problem = problems[p];
        const auto same = std::ranges::find_if(batches.problems, [&](const auto &batch) {
            const auto &first = problems[batch.front()];
            return first.body == problem.body && core::are_statically_equal(first.load_case, problem.load_case);
        });
        if (same != batches.problems.end()) {
            same->push_back(p);
            continue;
        }
        const auto number = std::ranges::find(bodies, problem.body.get()) - bodies.begin();
        if (number == std::ssize(bodies))
            bodies.push_back(problem.body.get());
        batches.problems.push_back({p});
        batches.body.push_back(static_cast<int>(number));
    }
    return batches;
}

/// Those that hold the same components of a body one after the other: models keep the last factor. What comes first
/// otherwise stays first.
Batches by_what_they_hold(const Batches &batches, const std::vector<core::Problem> &problems) {
    const auto &all = batches.problems;
    const auto first_alike = [&](std::size_t batch) {
        const auto &problem = problems[all[batch].front()];
        return std::ranges::find_if(all, [&](const auto &candidate) {
            const auto &other = problems[candidate.front()];
            return other.body == problem.body && core::hold_the_same(other.load_case, problem.load_case);
        });
    };
    std::vector<std::size_t> order(all.size());
    std::iota(order.begin(), order.end(), 0);
    std::ranges::stable_sort(order, {}, first_alike);
    Batches ordered;
    for (const auto batch : order) {
        ordered.problems.push_back(all[batch]);
        ordered.body.push_back(batches.body[batch]);
    }
    return ordered;
}

/// Of the largest body; what the finite elements keep of a liver, measured, with and without its refined mesh.
double bytes_per_worker(const RunTask &task, bool with_uncertainty) {
    const double bytes_per_tetrahedron = with_uncertainty ? 250e3 : 60e3;
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
    return options.jobs.value_or(core::workers_that_fit(bytes_per_worker(task, !options.no_uncertainty)));
}

/// What a worker tells of the load cases that it is at: a letter, the number of the problem, and what it is about.
enum class News : char { step = 's', time = 't', result = 'r', failure = 'f' };

std::string to_text(News news, std::size_t problem, const std::string &about, double seconds = 0.0) {
    return fmt::format("{} {} {} {}", static_cast<char>(news), problem, seconds, about);
}

/// What came home.
struct Told {
    explicit Told(const std::string &text) {
        std::istringstream words(text);
        char letter = 0;
        words >> letter >> problem >> seconds;
        words.ignore();
        std::getline(words, about, '\0');
        news = static_cast<News>(letter);
    }

    News news;
    std::size_t problem = 0;
    double seconds = 0.0;
    std::string about;
};

/// Holds the contests of one problem, at all amplitudes.
void hold_one(const RunTask &task, const RunOptions &options, const std::string &command_line, std::size_t number,
              const core::Tell &tell) {
    TimeSpent spent;
    const auto *const other_work = "loads, comparisons, files";
    spent.begin(other_work);
    const auto step = [&](const core::Problem &problem, const std::string &what) {
        tell(to_text(News::step, number, fmt::format("{} / {}", name_of(problem), what)));
    };
    const auto hold = [&](const core::Problem &problem) {
        const auto file =
            make_output_folder(output_folder(options, problem), problem) / (problem.load_case.name + ".h5");
        const auto provenance = results::current_provenance(command_line);
        if (options.resume && results::kept_result(file, problem, provenance)) {
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

Outcomes hold_all(const RunTask &task, const RunOptions &options, const std::string &command_line) {
    Outcomes outcomes{std::vector<Outcome>(task.problems.size()), {}};
    const auto num_contests = task.problems.size() * std::max<std::size_t>(1, options.amplitudes.size());
    Progress progress(static_cast<int>(num_contests * task.models.size()));
    const auto batches = by_what_they_hold(batches_of(task.problems), task.problems);
    core::side_by_side(
        batches.body, num_workers(task, options),
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
