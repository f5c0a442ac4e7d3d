#include "results/tables/studies/needles/needle_arena_table.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <map>
#include <tuple>
#include <vector>

#include "core/units.hpp"
#include "results/tables/studies/needle_table.hpp"

namespace livermark::results {

namespace {

using core::millimetres, core::milliseconds, core::percent;

/// A value with what it is off by.
std::string with_error(double value, double reference, int decimals) {
    return fmt::format("{} ({})", fixed(value, decimals),
                       std::isnan(value) ? "-" : fmt::format("{:+.1f}", percent * (value / reference - 1.0)));
}

std::string or_unknown(double value, double factor, int decimals, const char *units) {
    return std::isnan(value) ? "an amount that is not known"
                             : fmt::format("{} {}", fixed(factor * value, decimals), units);
}

} // namespace

Layout needle_arena_table(const NeedleArena &arena) {
    Layout layout{{{"tetrahedra", true},
                   {"budget [ms]", true},
                   {"method"},
                   {"setting"},
                   {"steps", true},
                   {"iterations", true},
                   {"target off [mm]", true},
                   {"path [%]", true},
                   {"peak [N] (%)", true},
                   {"slope [N/m] (%)", true},
                   {"pull [N] (%)", true},
                   {"frame [ms]", true},
                   {"worst [ms]", true},
                   {"needle/none", true},
                   {"outcome"}},
                  {}};
    std::vector<const NeedleArenaRun *> runs;
    for (const auto &run : arena.runs)
        runs.push_back(&run);
    const auto last_if_unknown = [](double error) {
        return std::isfinite(error) ? error : std::numeric_limits<double>::infinity();
    };
    std::ranges::stable_sort(runs, {}, [&](const NeedleArenaRun *run) {
        return std::tuple(run->tetrahedra, run->budget, last_if_unknown(run->target_error));
    });
    const auto &reference = arena.reference_forces;
    for (const auto *run : runs)
        layout.rows.push_back(
            {fmt::format("{}", run->tetrahedra), fixed(milliseconds * run->budget, 2), run->method, run->setting,
             fmt::format("{}", run->steps), iterations_of(run->iterations, run->stops_early),
             fixed(millimetres * run->target_error, 2), fixed(percent * run->path_error, 1),
             with_error(run->forces.peak, reference.peak, 3), with_error(run->forces.slope, reference.slope, 1),
             with_error(run->forces.pull, reference.pull, 3), fixed(milliseconds * run->frame_seconds, 2),
             fixed(milliseconds * run->worst_frame_seconds, 2), fixed(run->cost_ratio, 2), to_string(run->outcome)});
    return layout;
}

std::string needle_arena_note(const NeedleStudy &study) {
    const auto &arena = *study.arena;
    const auto &reference = study.runs.front();
    const auto at_plan = static_cast<std::size_t>(arena.at_plan);
    std::string note = fmt::format(
        "{}: {:.1f} mm in at {:g} mm/s, {:g} s of rest and out; the reference is the static {}, whose target has moved "
        "by {} mm when the tip is where it was at rest (last refinement: {}), with a peak of {} N ({}), a slope of {} "
        "N/m ({}) and a pull of {} N ({})\n",
        printable(study.needle.name), millimetres * study.needle.depth(), millimetres * arena.speed, arena.rest,
        reference.model, fixed(millimetres * arena.reference_target[at_plan].norm(), 2),
        or_unknown(study.reference_miss_change, millimetres, 3, "mm"), fixed(arena.reference_forces.peak, 3),
        or_unknown(arena.reference_changes.peak, 1.0, 4, "N"), fixed(arena.reference_forces.slope, 1),
        or_unknown(arena.reference_changes.slope, 1.0, 2, "N/m"), fixed(arena.reference_forces.pull, 3),
        or_unknown(arena.reference_changes.pull, 1.0, 4, "N"));
    std::map<std::string, std::vector<std::string>> by_reason;
    for (const auto &[method, because] : arena.left_out)
        by_reason[because].push_back(method);
    for (const auto &[because, methods] : by_reason)
        note += fmt::format("left out: {}, because {}\n", fmt::join(methods, ", "), because);
    return note + limit_note(study);
}

} // namespace livermark::results
