#include "results/tables/studies/cohort_table.hpp"

#include <cmath>
#include <fmt/format.h>
#include <string>
#include <vector>

#include "core/units.hpp"
#include "results/tables/tool_cells.hpp"

namespace livermark::results {

namespace {

using core::percent;

std::string with_interval(double value, const Interval &interval) {
    if (std::isnan(interval.low))
        return fixed(percent * value, 2);
    return fmt::format("{} ({} to {})", fixed(percent * value, 2), fixed(percent * interval.low, 2),
                       fixed(percent * interval.high, 2));
}

std::string tool_with_interval(const CohortStatistics &group) {
    const auto &[low, high] = group.stiffness_median_interval;
    const auto median = size_cell(group.stiffness_median);
    return std::isnan(low) ? median
                           : fmt::format("{} ({} to {})", median, fixed(percent * low, 1), fixed(percent * high, 1));
}

/// In words that do not suggest that models learn; files keep theirs.
std::string half_in_words(const std::string &half) {
    return half == "training" ? "tuning" : half == "unseen" ? "test" : half;
}

} // namespace

Layout cohort_table(std::span<const CohortStatistics> statistics) {
    Layout layout{{{"half"}, {"nu", true}, {"model"}}, {}};
    for (const auto *const title :
         {"bodies", "left out", "median [%]", "95th percentile [%]", "worst [%]", "tool [%]", "worst tool [%]"})
        layout.columns.push_back({title, true});
    for (const auto &group : statistics) {
        auto &row = layout.rows.emplace_back(
            std::vector{half_in_words(group.half), fmt::format("{:g}", group.poisson_ratio), group.model,
                        fmt::format("{}", group.means.size()), fmt::format("{}", group.left_out)});
        if (group.means.empty()) {
            row.insert(row.end(), 5, "-");
            continue;
        }
        row.push_back(with_interval(group.median, group.median_interval));
        row.push_back(with_interval(group.percentile_95, group.percentile_95_interval));
        row.push_back(fixed(percent * group.worst, 2));
        row.push_back(tool_with_interval(group));
        row.push_back(size_cell(group.stiffness_worst));
    }
    return layout;
}

} // namespace livermark::results
