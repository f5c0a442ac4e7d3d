#include "results/tables/studies/stability_table.hpp"

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

std::string step_advice(const Stability &stability, double part) {
    const auto has_limit = [](const IntegratorLimits &limits) { return limits.undamped.has_number(); };
    const auto is_usual = [&](const IntegratorLimits &limits) {
        return limits.integrator == "symplectic_euler" && has_limit(limits);
    };
    auto found = std::ranges::find_if(stability.limits, is_usual);
    if (found == stability.limits.end())
        found = std::ranges::find_if(stability.limits, has_limit);
    const auto who = fmt::format("{}, {}", stability.body, stability.springs());
    if (found == stability.limits.end())
        return who + (std::ranges::any_of(stability.limits,
                                          [](const auto &limits) { return limits.undamped.predicted > 0.0; })
                          ? ": take any step, none is unstable"
                          : ": take another integrator, these have no stable step without damping");
    const auto step = [&](const StepLimit &limit) {
        return limit.has_number() ? fmt::format("{:.3g} ms", milliseconds * part * limit.predicted)
                                  : std::string(limit.predicted > 0.0 ? "any step" : "no step");
    };
    return fmt::format("{}: take {}, {:g} of the longest stable step of {}; with this damping {}", who,
                       step(found->undamped), part, found->integrator, step(found->damped));
}

} // namespace livermark::results
