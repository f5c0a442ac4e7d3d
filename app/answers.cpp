#include "app/answers.hpp"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fmt/format.h>
#include <memory>

#include "app/amplitudes.hpp"
#include "app/batches.hpp"
#include "app/contest.hpp"
#include "app/load_scaling.hpp"
#include "app/news.hpp"
#include "core/input_error.hpp"
#include "core/side_by_side.hpp"
#include "results/result_file.hpp"

namespace livermark::app {

namespace {

/// Answers come home from workers as result files. The folder goes with the object.
class TemporaryFolder {
  public:
    TemporaryFolder() {
        std::error_code fault;
        const auto parent = std::filesystem::temp_directory_path(fault);
        auto name = (parent / "livermark-XXXXXX").string();
        if (fault || !mkdtemp(name.data()))
            throw core::InputError("no folder can be made for temporary files; set TMPDIR to one that can be written");
        path_ = name;
    }
    ~TemporaryFolder() {
        std::error_code nobody_cares;
        std::filesystem::remove_all(path_, nobody_cares);
    }
    TemporaryFolder(const TemporaryFolder &) = delete;
    TemporaryFolder &operator=(const TemporaryFolder &) = delete;

    const std::filesystem::path &path() const { return path_; }

  private:
    std::filesystem::path path_;
};

/// A problem of a group as it is loaded, and what was found for it.
struct LoadedProblem {
    std::size_t number; ///< of the problem
    core::Problem problem;
    std::vector<results::ModelResult> found{};
};

/// Leaves the problems that cannot be loaded to the contests.
std::vector<LoadedProblem> load_all(const std::vector<std::size_t> &numbers, const RunTask &task,
                                    const RunOptions &options,
                                    const std::function<bool(const core::Problem &)> &is_wanted) {
    std::vector<LoadedProblem> all;
    for (const auto number : numbers)
        try {
            for (auto &problem : loaded(task.problems[number], baseline_of(task.models), options))
                if (is_wanted(problem))
                    all.push_back({number, std::move(problem)});
        } catch (const std::exception &) {
            continue;
        }
    return all;
}

/// Adds the answers of a model, most_together at a time.
void add_answers(const core::Model &model, std::vector<LoadedProblem> &all) {
    for (std::size_t first = 0; first < all.size(); first += model.most_together) {
        const auto last = std::min(all.size(), first + model.most_together);
        std::vector<core::Problem> some;
        for (auto p = first; p < last; ++p)
            some.push_back(all[p].problem);
        auto solutions = model.solve_together(some);
        for (auto p = first; p < last; ++p) {
            auto &found = all[p].found.emplace_back();
            found.name = model.name;
            found.solution = std::move(solutions[p - first]);
        }
    }
}

} // namespace

TogetherGroups together_groups(const RunTask &task) {
    TogetherGroups groups;
    std::size_t most = 1;
    for (const auto &model : task.models)
        if (model.solve_together) {
            groups.models.push_back(model);
            most = std::max(most, model.most_together);
        }
    if (groups.models.empty())
        return groups;
    const auto batches = batches_of(task.problems);
    for (std::size_t b = 0; b < batches.problems.size(); ++b) {
        const bool has_room =
            !groups.body.empty() && groups.body.back() == batches.body[b] && groups.problems.back().size() < most;
        if (!has_room) {
            groups.problems.emplace_back();
            groups.body.push_back(batches.body[b]);
        }
        groups.problems.back().push_back(batches.problems[b].front());
    }
    return groups;
}

std::vector<core::Problem> loaded(const core::Problem &problem, const core::Model &baseline,
                                  const RunOptions &options) {
    return at_amplitudes(scaled_to_target(problem, baseline), options.amplitudes);
}

std::vector<Answer> solve_together(const TogetherGroups &groups, const RunTask &task, const RunOptions &options,
                                   int num_workers, const std::function<bool(const core::Problem &)> &is_wanted,
                                   Progress &progress, TimeSpent &spent) {
    std::vector<Answer> answers;
    if (groups.num_steps() == 0)
        return answers;
    const TemporaryFolder folder;
    core::side_by_side(
        groups.body, num_workers,
        [&](int group, const core::Tell &tell) {
            const auto &numbers = groups.problems[group];
            const auto &first = task.problems[numbers.front()];
            TimeSpent clock;
            clock.begin(other_work);
            auto all = load_all(numbers, task, options, is_wanted);
            for (const auto &model : groups.models) {
                tell(to_text(News::step, numbers.front(),
                             fmt::format("{} / {}{} / {}", first.body->name, first.load_case.name,
                                         numbers.size() > 1 ? fmt::format(" and {} others", numbers.size() - 1) : "",
                                         model.name)));
                clock.begin(model.name);
                try {
                    add_answers(model, all);
                } catch (const std::exception &) {
                    continue; // the contest will say what is wrong
                }
            }
            clock.begin(other_work);
            for (std::size_t p = 0; p < all.size(); ++p)
                try {
                    const auto file = folder.path() / fmt::format("{}_{}.h5", group, p);
                    results::write_result(file, {.provenance = {}, .problem = all[p].problem, .models = all[p].found});
                    tell(to_text(News::result, all[p].number, file.string()));
                } catch (const core::InputError &) {
                    continue; // the disk is full: the contest solves it again, and may find a place for its own file
                }
            for (const auto &[stage, seconds] : clock.stages())
                tell(to_text(News::time, numbers.front(), stage, seconds));
        },
        [&](int /*group*/, const std::string &text) {
            const Told told(text);
            if (told.news == News::step) {
                progress.next(told.about);
            } else if (told.news == News::time) {
                spent.add(told.about, told.seconds);
            } else {
                auto result = results::read_result(told.about);
                std::filesystem::remove(told.about);
                result.problem.body = task.problems[told.problem].body;
                for (auto &model : result.models)
                    answers.push_back({model.name, result.problem, std::move(model.solution)});
            }
        });
    return answers;
}

std::vector<core::Model> with_answers(std::vector<core::Model> models, std::vector<Answer> answers) {
    const auto all = std::make_shared<const std::vector<Answer>>(std::move(answers));
    for (auto &model : models)
        model.solve = [all, name = model.name, solve = std::move(model.solve)](const core::Problem &problem) {
            const auto found = std::ranges::find_if(*all, [&](const Answer &answer) {
                return answer.model == name && answer.problem.body == problem.body &&
                       core::are_statically_equal(answer.problem.load_case, problem.load_case);
            });
            if (found == all->end())
                return solve(problem);
            auto solution = found->solution;
            if (found->problem.load_case.name != problem.load_case.name)
                solution.solver += ", the answer to " + found->problem.load_case.name;
            return solution;
        };
    return models;
}

} // namespace livermark::app
