#include "app/answers.hpp"

#include <algorithm>
#include <exception>
#include <fmt/format.h>

#include "app/loads.hpp"

namespace livermark::app {

namespace {

void answer_each(const core::Model &model, const WorkItem &item, const std::vector<core::Problem> &problems,
                 const AnswerFolder &folder, const std::function<void(const std::string &)> &starting) {
    for (const auto &batch : item.batches)
        for (const auto number : batch) {
            starting(name_of(problems[number]));
            folder.leave(number, model.name, model.solve(problems[number]), problems[number]);
        }
}

/// Of those with the same static answer the first is solved.
void answer_together(const core::Model &model, const WorkItem &item, const std::vector<core::Problem> &problems,
                     const AnswerFolder &folder) {
    for (std::size_t first = 0; first < item.batches.size(); first += model.most_together) {
        const auto last = std::min(item.batches.size(), first + model.most_together);
        std::vector<core::Problem> some;
        for (auto b = first; b < last; ++b)
            some.push_back(problems[item.batches[b].front()]);
        auto solutions = model.solve_together(some);
        for (auto b = first; b < last; ++b)
            for (const auto number : item.batches[b]) {
                auto solution = solutions[b - first];
                if (number != item.batches[b].front())
                    solution.solver += ", the answer to " + some[b - first].load_case.name;
                folder.leave(number, model.name, solution, problems[number]);
            }
    }
}

} // namespace

void answer(const WorkItem &item, const std::vector<core::Model> &models, const std::vector<core::Problem> &problems,
            const AnswerFolder &folder,
            const std::function<void(const std::string &model, const std::string &about)> &starting) {
    for (const auto m : item.models)
        try {
            const auto &model = models[m];
            const auto start = [&](const std::string &about) { starting(model.name, about); };
            if (model.solve_together) {
                const auto others = item.batches.size() - 1;
                start(name_of(problems[item.batches.front().front()]) +
                      (others > 0 ? fmt::format(" and {} others", others) : ""));
                answer_together(model, item, problems, folder);
            } else {
                answer_each(model, item, problems, folder, start);
            }
        } catch (const std::exception &) {
            continue; // a solver's fault, or a full disk
        }
}

std::vector<core::Model> with_answers(std::vector<core::Model> models, std::size_t number, const AnswerFolder *folder,
                                      const std::function<void(const std::string &)> &solving) {
    for (auto &model : models)
        model.solve = [folder, number, solving, name = model.name,
                       solve = std::move(model.solve)](const core::Problem &problem) {
            if (auto found = folder ? folder->find(number, name, problem) : std::nullopt)
                return *std::move(found);
            solving(name);
            return solve(problem);
        };
    return models;
}

} // namespace livermark::app
