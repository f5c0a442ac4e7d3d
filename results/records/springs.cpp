#include "results/records/springs.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>

#include "core/units.hpp"
#include "results/hdf5/record_file.hpp"

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
std::array<std::string, 3> step_cells(const StepLimit &limit) {
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
    TableOf<IntegratorLimits> table(stability.limits);
    table.text("integrator", &IntegratorLimits::integrator);
    const auto add = [&](const char *predicted, StepLimit IntegratorLimits::*limit) {
        for (std::size_t c = 0; const auto *title : {predicted, "observed [ms]", "difference [%]"}) {
            table.number(title, [=](auto &limits) { return step_cells(limits.*limit)[c]; });
            ++c;
        }
    };
    add("undamped, predicted [ms]", &IntegratorLimits::undamped);
    add("damped, predicted [ms]", &IntegratorLimits::damped);
    return table.layout();
}

std::string step_advice(const Stability &stability, double part) {
    const auto has_limit = [](auto &limits) { return limits.undamped.has_number(); };
    const auto is_usual = [&](auto &limits) { return limits.integrator == "symplectic_euler" && has_limit(limits); };
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

namespace {

/// A number of each spring, positive and finite.
template <class At>
void describe_of_springs(At at, const std::string &name, hdf5::Of<At, std::vector<double>> &values,
                         const std::string &units, std::size_t num_springs) {
    at.rows(name, values, units, num_springs);
    const auto bad = std::ranges::find_if(values, [](double value) { return !(value > 0.0 && std::isfinite(value)); });
    if (bad != values.end())
        at.check(false, name,
                 fmt::format("row {} is {}, which is not positive and finite", bad - values.begin(), *bad));
}

template <class At> void describe_calibration(At root, hdf5::Of<At, Calibration> &calibration) {
    root.check(root.has("springs"), "holds no calibration");
    root.text("body", calibration.body);
    root.text("spring_law", calibration.spring_law);
    root.text("volume_term", calibration.volume_term);
    root.text("reference", calibration.reference);
    root.text("held", calibration.constrained);
    root.integer("seed", calibration.seed);
    root.integer("iterations", calibration.iterations);
    root.number("penalty", calibration.penalty);
    auto &springs = calibration.springs;
    hdf5::describe_materials(root, springs.materials);
    const auto at = root.group("springs");
    at.rows("edges", springs.edges);
    const auto num_springs = springs.edges.size();
    describe_of_springs(at, "rest_length", springs.rest_length, "m", num_springs);
    describe_of_springs(at, "start_stiffness", calibration.start_stiffness, "N/m", num_springs);
    describe_of_springs(at, "stiffness", springs.stiffness, "N/m", num_springs);
    const auto loads = root.group("loads");
    loads.rows("held_out", calibration.held_out);
    loads.rows("error_before", calibration.error_before, "", calibration.held_out.size());
    loads.rows("error_after", calibration.error_after, "", calibration.held_out.size());
}

} // namespace

void write_calibration(const std::filesystem::path &path, const Calibration &calibration) {
    hdf5::write_record(path, calibration, [](auto root, auto &record) { describe_calibration(root, record); });
}

Calibration read_calibration(const std::filesystem::path &path) {
    auto calibration = hdf5::read_record<Calibration>(
        path, "python3 -m livermark.calibration", [](auto root, auto &record) { describe_calibration(root, record); });
    calibration.springs.origin = path.string();
    return calibration;
}

} // namespace livermark::results
