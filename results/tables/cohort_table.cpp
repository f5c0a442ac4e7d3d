#include "results/tables/cohort_table.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fmt/format.h>
#include <map>
#include <set>
#include <tuple>

#include "core/units.hpp"
#include "results/quantile.hpp"
#include "support/random_numbers.hpp"

namespace livermark::results {

namespace {

using core::percent;

/// Half, Poisson's ratio and model.
using Group = std::tuple<std::string, double, std::string>;
/// Relative L2 error by body and load case; NaN where a model has not come to an end.
using ErrorsOfBodies = std::map<std::string, std::map<std::string, double>>;

bool is_in_cohort(const Result &result) {
    const auto &load_case = result.problem.load_case;
    return !load_case.release && load_case.name.find('@') == std::string::npos &&
           cohort_half(result.problem.body->name).has_value();
}

std::string with_interval(const std::vector<double> &values, double part) {
    const auto interval = bootstrap_interval(values, part);
    return fmt::format("{} ({} to {})", fixed(percent * quantile(values, part), 2), fixed(percent * interval.low, 2),
                       fixed(percent * interval.high, 2));
}

/// Means over load cases, of the bodies that have them all.
std::vector<double> means_of(const ErrorsOfBodies &bodies, std::size_t num_load_cases) {
    std::vector<double> means;
    for (const auto &[body, errors] : bodies) {
        double sum = 0.0;
        for (const auto &[load_case, error] : errors)
            sum += error;
        if (errors.size() == num_load_cases && std::isfinite(sum))
            means.push_back(sum / static_cast<double>(num_load_cases));
    }
    return means;
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

Layout cohort_table(std::span<const Result> results) {
    std::map<Group, ErrorsOfBodies> groups;
    std::map<double, std::set<std::string>> load_cases; // by Poisson's ratio
    for (const auto &result : results) {
        if (!is_in_cohort(result))
            continue;
        const auto &body = result.problem.body->name;
        const double ratio = poisson_ratio(result);
        load_cases[ratio].insert(result.problem.load_case.name);
        for (const auto &model : result.models) {
            const bool is_ok = model.solution.status == core::SolutionStatus::ok;
            if (model.comparison || !is_ok)
                groups[{*cohort_half(body), ratio, model.name}][body][result.problem.load_case.name] =
                    is_ok ? model.comparison->relative_l2 : std::nan("");
        }
    }
    Layout layout{{{"half"}, {"nu", true}, {"model"}}, {}};
    for (const auto *const title : {"bodies", "left out", "median [%]", "95th percentile [%]", "worst [%]"})
        layout.columns.push_back({title, true});
    for (const auto &[group, bodies] : groups) {
        const auto &[half, ratio, model] = group;
        const auto means = means_of(bodies, load_cases[ratio].size());
        auto &row = layout.rows.emplace_back(std::vector{half, fmt::format("{:g}", ratio), model,
                                                         fmt::format("{}", means.size()),
                                                         fmt::format("{}", bodies.size() - means.size())});
        if (means.empty()) {
            row.insert(row.end(), 3, "-");
            continue;
        }
        row.push_back(with_interval(means, 0.5));
        row.push_back(with_interval(means, 0.95));
        row.push_back(fixed(percent * *std::ranges::max_element(means), 2));
    }
    return layout;
}

} // namespace livermark::results
