#include "studies/run/loads.hpp"

#include <exception>
#include <fmt/format.h>

#include "studies/run/amplitudes.hpp"
#include "studies/run/load_scaling.hpp"
#include "studies/run/work/case_groups.hpp"
#include "support/processes/memory.hpp"

namespace livermark::studies {

std::vector<LoadedProblem> load_all(const RunTask &task, const RunOptions &options, PreparedModels &prepared,
                                    const std::function<void(std::size_t, const std::string &)> &failed) {
    std::vector<LoadedProblem> loads;
    for (const auto &case_group : case_groups_of(task.problems).problems)
        for (const auto number : case_group)
            try {
                for (auto &problem : at_amplitudes(scaled_to_target(task.problems[number], task.baseline, prepared),
                                                   options.amplitudes))
                    loads.push_back({number, std::move(problem)});
            } catch (const std::exception &error) {
                failed(number, support::reason_of(error));
            }
    return loads;
}

std::vector<core::Problem> problems_of(const std::vector<LoadedProblem> &loads) {
    std::vector<core::Problem> problems;
    for (const auto &load : loads)
        problems.push_back(load.problem);
    return problems;
}

std::string name_of(const core::Problem &problem) {
    return fmt::format("{} / {}", problem.body->name, problem.load_case.name);
}

} // namespace livermark::studies
