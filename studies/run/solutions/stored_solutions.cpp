#include "studies/run/solutions/stored_solutions.hpp"

#include <algorithm>
#include <exception>
#include <fmt/format.h>
#include <iterator>
#include <utility>

#include "studies/run/loads.hpp"

namespace livermark::studies {

namespace {

void solve_each(const core::Model &model, const std::vector<CaseGroup> &case_groups,
                const std::vector<core::Problem> &problems, PreparedModels &prepared, const SolutionStore &store,
                const std::function<void(const std::string &)> &starting) {
    for (const auto &case_group : case_groups)
        for (const auto number : case_group) {
            starting(name_of(problems[number]));
            store.leave(number, model.name, prepared.solve(model, problems[number]), problems[number]);
        }
}

/// Of those with the same static solution the first is solved.
void solve_together(const core::Model &model, const std::vector<CaseGroup> &case_groups,
                    const std::vector<core::Problem> &problems, PreparedModels &prepared, const SolutionStore &store) {
    for (std::size_t first = 0; first < case_groups.size(); first += model.most_together) {
        const auto last = std::min(case_groups.size(), first + model.most_together);
        std::vector<core::Problem> some;
        for (auto b = first; b < last; ++b)
            some.push_back(problems[case_groups[b].front()]);
        auto solutions = prepared.solve(model, some);
        for (auto b = first; b < last; ++b)
            for (const auto number : case_groups[b]) {
                auto solution = solutions[b - first];
                if (number != case_groups[b].front())
                    solution.solver += ", the solution of " + some[b - first].load_case.name;
                store.leave(number, model.name, solution, problems[number]);
            }
    }
}

} // namespace

std::vector<CaseGroup> part_of(const core::Model &model, const std::vector<CaseGroup> &case_groups,
                               const std::vector<core::Problem> &problems) {
    std::vector<CaseGroup> part;
    for (const auto &case_group : case_groups) {
        CaseGroup some; // of one static solution, which a motion may begin with
        std::ranges::copy_if(case_group, std::back_inserter(some),
                             [&](std::size_t number) { return model.takes_part_in(problems[number]); });
        if (!some.empty())
            part.push_back(std::move(some));
    }
    return part;
}

void solve_and_store(const WorkItem &item, const std::vector<core::Model> &models,
                     const std::vector<core::Problem> &problems, PreparedModels &prepared, const SolutionStore &store,
                     const std::function<void(const std::string &model, const std::string &about)> &starting) {
    for (const auto m : item.models)
        try {
            const auto &model = models[m];
            const auto case_groups = part_of(model, item.case_groups, problems);
            if (case_groups.empty())
                continue;
            const auto start = [&](const std::string &about) { starting(model.name, about); };
            if (model.most_together > 1) {
                const auto others = case_groups.size() - 1;
                start(name_of(problems[case_groups.front().front()]) +
                      (others > 0 ? fmt::format(" and {} others", others) : ""));
                solve_together(model, case_groups, problems, prepared, store);
            } else {
                solve_each(model, case_groups, problems, prepared, store, start);
            }
        } catch (const std::exception &) {
            continue; // a solver's fault, or a full disk
        }
}

} // namespace livermark::studies
