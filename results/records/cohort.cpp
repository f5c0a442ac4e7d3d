#include "results/records/cohort.hpp"

#include <limits>

#include "core/tool/tool_stiffness.hpp"
#include "results/one_reference.hpp"

namespace livermark::results {

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

bool is_in_cohort(const Result &result) {
    return is_plain_static(result) && !leaves_regime(result) && !ends_at_rest(result) &&
           cohort_half(result.problem.body->name).has_value();
}

} // namespace

std::optional<std::string> cohort_half(const std::string &body) {
    if (body.empty() || body.back() < '0' || body.back() > '9')
        return std::nullopt;
    return (body.back() - '0') % 2 == 1 ? "training" : "unseen";
}

std::vector<CohortError> cohort_errors(std::span<const Result> results) {
    std::vector<CohortError> errors;
    for (const auto &result : results) {
        if (!is_in_cohort(result))
            continue;
        const auto &problem = result.problem;
        const double radius =
            core::radius_in_edges(core::tool_places(problem.body->mesh, problem.load_case)).value_or(nan);
        for (const auto &model : result.models)
            if (model.comparison || model.solution.status != core::SolutionStatus::ok)
                errors.push_back({.body = problem.body->name,
                                  .regime = problem.load_case.regime,
                                  .poisson_ratio = poisson_ratio(result),
                                  .load_case = problem.load_case.name,
                                  .model = model.name,
                                  .status = model.solution.status,
                                  .relative_l2 = model.comparison ? model.comparison->relative_l2 : nan,
                                  .reaction_error = model.comparison ? model.comparison->reaction_error : nan,
                                  .stiffness = model.comparison && model.comparison->tool
                                                   ? model.comparison->tool->worst_stiffness()
                                                   : nan,
                                  .reference = reference_of(result),
                                  .tool_radius_in_edges = radius});
    }
    return errors;
}

} // namespace livermark::results
