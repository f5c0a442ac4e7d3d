#include "results/records/cohort.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "core/tool/tool_stiffness.hpp"
#include "results/one_reference.hpp"
#include "results/quantile.hpp"
#include "support/random_numbers.hpp"

namespace livermark::results {

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// Regime, reference, half, Poisson's ratio and model.
using Group = std::tuple<core::Regime, std::string, std::string, double, std::string>;
/// Regime, Poisson's ratio and reference: what stands in one table at one ratio.
using Judge = std::tuple<core::Regime, double, std::string>;
/// By load case: relative L2 error, NaN where a model has not come to an end, and stiffness at the tool.
struct ErrorsOfBody {
    std::map<std::string, double> relative_l2, stiffness;
};
using ErrorsOfBodies = std::map<std::string, ErrorsOfBody>; // by body

bool is_in_cohort(const Result &result) {
    return is_plain_static(result) && !leaves_regime(result) && !ends_at_rest(result) &&
           cohort_half(result.problem.body->name).has_value();
}

/// Of absolute values, where there is one; NaN of none.
double mean_size(const std::map<std::string, double> &values) {
    double sum = 0.0;
    int count = 0;
    for (const auto &[load_case, value] : values)
        if (!std::isnan(value)) {
            sum += std::abs(value);
            ++count;
        }
    return sum / count;
}

/// Means over load cases, of the bodies that have them all.
std::vector<BodyMean> means_of(const ErrorsOfBodies &bodies, std::size_t num_load_cases) {
    std::vector<BodyMean> means;
    for (const auto &[body, errors] : bodies) {
        double sum = 0.0;
        for (const auto &[load_case, error] : errors.relative_l2)
            sum += error;
        if (errors.relative_l2.size() == num_load_cases && std::isfinite(sum))
            means.push_back({body, sum / static_cast<double>(num_load_cases), mean_size(errors.stiffness)});
    }
    return means;
}

CohortStatistics statistics_of(const Group &group, const ErrorsOfBodies &bodies, std::size_t num_load_cases) {
    CohortStatistics statistics{.regime = std::get<0>(group),
                                .reference = std::get<1>(group),
                                .half = std::get<2>(group),
                                .poisson_ratio = std::get<3>(group),
                                .model = std::get<4>(group),
                                .means = means_of(bodies, num_load_cases),
                                .median = nan,
                                .median_interval = {nan, nan},
                                .percentile_95 = nan,
                                .percentile_95_interval = {nan, nan},
                                .worst = nan,
                                .stiffness_median = nan,
                                .stiffness_median_interval = {nan, nan},
                                .stiffness_worst = nan};
    statistics.left_out = static_cast<int>(bodies.size() - statistics.means.size());
    if (statistics.means.empty())
        return statistics;
    std::vector<double> values;
    for (const auto &mean : statistics.means)
        values.push_back(mean.error);
    statistics.median = quantile(values, 0.5);
    statistics.percentile_95 = quantile(values, 0.95);
    statistics.worst = *std::ranges::max_element(values);
    if (values.size() >= fewest_bodies_of_interval) {
        statistics.median_interval = bootstrap_interval(values, 0.5);
        statistics.percentile_95_interval = bootstrap_interval(values, 0.95);
    }
    values.clear();
    for (const auto &mean : statistics.means)
        if (!std::isnan(mean.stiffness))
            values.push_back(mean.stiffness);
    if (!values.empty()) {
        statistics.stiffness_median = quantile(values, 0.5);
        statistics.stiffness_worst = *std::ranges::max_element(values);
        if (values.size() >= fewest_bodies_of_interval)
            statistics.stiffness_median_interval = bootstrap_interval(values, 0.5);
    }
    return statistics;
}

} // namespace

Interval bootstrap_interval(const std::vector<double> &values, double part) {
    constexpr int num_samples = 2000;
    constexpr std::uint64_t seed = 1979;
    support::RandomNumbers random(seed);
    std::vector<double> quantiles, sample(values.size());
    for (int s = 0; s < num_samples; ++s) {
        for (auto &value : sample)
            value = values[random.below(static_cast<int>(values.size()))];
        quantiles.push_back(quantile(sample, part));
    }
    return {quantile(quantiles, 0.025), quantile(quantiles, 0.975)};
}

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

std::vector<CohortStatistics> cohort_statistics(std::span<const CohortError> errors) {
    std::map<Judge, std::string> first_reference; // by regime and ratio, the last empty
    for (const auto &error : errors)
        if (!error.reference.empty())
            first_reference.emplace(Judge{error.regime, error.poisson_ratio, {}}, error.reference);
    std::map<Group, ErrorsOfBodies> groups;
    std::map<Judge, std::set<std::string>> load_cases;
    for (const auto &error : errors) {
        const auto half = cohort_half(error.body);
        if (!half)
            continue;
        const auto reference =
            error.reference.empty() ? first_reference[{error.regime, error.poisson_ratio, {}}] : error.reference;
        load_cases[{error.regime, error.poisson_ratio, reference}].insert(error.load_case);
        auto &of_body = groups[{error.regime, reference, *half, error.poisson_ratio, error.model}][error.body];
        of_body.relative_l2[error.load_case] = error.status == core::SolutionStatus::ok ? error.relative_l2 : nan;
        of_body.stiffness[error.load_case] = error.stiffness;
    }
    std::vector<CohortStatistics> statistics;
    for (const auto &[group, bodies] : groups)
        statistics.push_back(statistics_of(
            group, bodies, load_cases[{std::get<0>(group), std::get<3>(group), std::get<1>(group)}].size()));
    return statistics;
}

} // namespace livermark::results
