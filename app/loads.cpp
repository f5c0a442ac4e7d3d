#include "app/loads.hpp"

#include <exception>
#include <fmt/format.h>

#include "app/amplitudes.hpp"
#include "app/batches.hpp"
#include "app/contest.hpp"
#include "app/load_scaling.hpp"

namespace livermark::app {

std::vector<LoadedProblem> load_all(const RunTask &task, const RunOptions &options,
                                    const std::function<void(std::size_t, const char *)> &failed) {
    const auto &baseline = baseline_of(task.models);
    std::vector<LoadedProblem> loads;
    for (const auto &batch : batches_of(task.problems).problems)
        for (const auto number : batch)
            try {
                for (auto &problem :
                     at_amplitudes(scaled_to_target(task.problems[number], baseline), options.amplitudes))
                    loads.push_back({number, std::move(problem)});
            } catch (const std::exception &error) {
                failed(number, error.what());
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

} // namespace livermark::app
