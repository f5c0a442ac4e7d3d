#include "results/tables/stability_table.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <iterator>

#include "core/units.hpp"

namespace livermark::results {

namespace {

using core::milliseconds;
using core::percent;

/// Predicted, observed and difference.
std::array<std::string, 3> cells(const StepLimit &limit) {
    if (!limit.has_number())
        return {limit.predicted > 0.0 ? "any" : "none", "-", "-"};
    const auto in_milliseconds = fmt::format("{:.4f}", milliseconds * limit.predicted);
    if (std::isnan(limit.observed))
        return {in_milliseconds, "not observed", "-"};
    return {in_milliseconds, fmt::format("{:.4f}", milliseconds * limit.observed),
            fmt::format("{:+.2f}", percent * limit.difference())};
}

} // namespace

Layout stability_table(const Stability &stability) {
    Layout layout{.columns = {{"integrator"},
                              {"undamped, predicted [ms]", true},
                              {"observed [ms]", true},
                              {"difference [%]", true},
                              {"damped, predicted [ms]", true},
                              {"observed [ms]", true},
                              {"difference [%]", true}},
                  .rows = {}};
    for (const auto &limits : stability.limits) {
        auto &row = layout.rows.emplace_back(std::vector{limits.integrator});
        for (const auto *limit : {&limits.undamped, &limits.damped})
            std::ranges::copy(cells(*limit), std::back_inserter(row));
    }
    return layout;
}

} // namespace livermark::results
