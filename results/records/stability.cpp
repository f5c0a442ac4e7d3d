#include "results/records/stability.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <iterator>

#include "core/units.hpp"
#include "results/hdf5/file_parts.hpp"

namespace livermark::results {

namespace {

using core::milliseconds;

template <class At> void describe_stability(At at, hdf5::Of<At, Stability> &stability) {
    at.text("body", stability.body);
    at.text("spring_law", stability.spring_law);
    if (at.has("model")) // not in files of an older version
        at.text("model", stability.model);
    at.text("load_case", stability.load_case);
    at.number("alpha", stability.damping.alpha);
    at.number("beta", stability.damping.beta);
    at.number("lowest_angular_frequency", stability.lowest_frequency);
    at.number("largest_angular_frequency", stability.largest_frequency);
    at.number("largest_angular_frequency_bound", stability.largest_frequency_bound);
    at.number("element_time_step", stability.element_time_step);
    auto limits = hdf5::columns_of(at.group("critical_time_step"), stability.limits);
    limits.texts("integrators", &IntegratorLimits::integrator);
    using Limits = IntegratorLimits;
    limits.column("undamped_predicted", hdf5::inside(&Limits::undamped, &StepLimit::predicted), "s");
    limits.column("undamped_observed", hdf5::inside(&Limits::undamped, &StepLimit::observed), "s");
    limits.column("damped_predicted", hdf5::inside(&Limits::damped, &StepLimit::predicted), "s");
    limits.column("damped_observed", hdf5::inside(&Limits::damped, &StepLimit::observed), "s");
}

/// Cells of a predicted step, an observed one and their difference.
std::array<std::string, 3> cells(const StepLimit &limit) {
    if (!limit.has_number())
        return {limit.predicted > 0.0 ? "any" : "none", "-", "-"};
    const auto in_milliseconds = fmt::format("{:.4f}", milliseconds * limit.predicted);
    if (std::isnan(limit.observed))
        return {in_milliseconds, "not observed", "-"};
    return {in_milliseconds, fmt::format("{:.4f}", milliseconds * limit.observed),
            fmt::format("{:+.2f}", core::percent * limit.difference())};
}

} // namespace

void write_stability(const std::filesystem::path &path, const Stability &stability) {
    hdf5::write_record(path, stability, [](auto root, auto &record) { describe_stability(root, record); });
}

Stability read_stability(const std::filesystem::path &path) {
    return hdf5::read_record<Stability>(path, "livermark stability",
                                        [](auto root, auto &record) { describe_stability(root, record); });
}

Layout stability_table(const Stability &stability) {
    auto layout = headed({"integrator"}, {"undamped, predicted [ms]", "observed [ms]", "difference [%]",
                                          "damped, predicted [ms]", "observed [ms]", "difference [%]"});
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
