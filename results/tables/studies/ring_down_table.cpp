#include "results/tables/studies/ring_down_table.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <iterator>

#include "core/units.hpp"

namespace livermark::results {

namespace {

std::string mm(double length) {
    return std::isfinite(length) ? fixed(core::millimetres * length, 2) : "-";
}

std::string with_decimals(double value, int decimals) {
    return std::isfinite(value) ? fixed(value, decimals) : "-";
}

/// In percent of what was measured, with its sign.
std::string percent_off(double value, double measured) {
    return std::isfinite(value) ? fmt::format("{:+.1f}", 100.0 * (value / measured - 1.0)) : "-";
}

std::vector<const RingDownRun *> best_first(const RingDownResult &ring_down) {
    std::vector<const RingDownRun *> runs;
    std::ranges::transform(ring_down.runs, std::back_inserter(runs), [](const auto &run) { return &run; });
    std::ranges::stable_sort(runs, {},
                             [](const RingDownRun *run) { return std::isfinite(run->error) ? run->error : HUGE_VAL; });
    return runs;
}

} // namespace

Layout ring_down_table(const ExperimentResult &result) {
    Layout layout{{{"state", false},
                   {"ring-down", false},
                   {"tetrahedra", true},
                   {"frequency [Hz]", true},
                   {"off by [%]", true},
                   {"damping ratio", true},
                   {"swings, error [mm]", true},
                   {"markers, error [mm]", true},
                   {"time [s]", true}},
                  {}};
    for (const auto &ring_down : result.ring_downs) {
        const auto add = [&](std::vector<std::string> row) {
            row.insert(row.begin(), printable(ring_down.state));
            row.resize(layout.columns.size());
            layout.rows.push_back(std::move(row));
        };
        add({"measured", "", fixed(ring_down.frequency, 2), "", fixed(ring_down.damping_ratio, 3)});
        add({"uncertainty of that", "", fixed(ring_down.frequency_uncertainty, 2),
             fixed(100.0 * ring_down.frequency_uncertainty / ring_down.frequency, 1),
             fixed(ring_down.damping_uncertainty, 3), ring_down.swing_noise > 0.0 ? mm(ring_down.swing_noise) : "-",
             ring_down.noise > 0.0 ? mm(ring_down.noise) : "-"});
        add({"rigid motion, fitted to each record", "", "", "", "", "", mm(ring_down.rigid_motion)});
        add({"no motion", "", "", "", "", "", mm(ring_down.no_motion)});
        for (const auto *run : best_first(ring_down))
            add({run->status == core::SolutionStatus::ok
                     ? run->model
                     : fmt::format("{} ({})", run->model, core::to_string(run->status)),
                 std::to_string(run->tetrahedra), with_decimals(run->frequency, 2),
                 percent_off(run->frequency, ring_down.frequency), with_decimals(run->damping_ratio, 3),
                 mm(run->swing_error), mm(run->error), fixed(run->seconds, 1)});
    }
    return layout;
}

std::string ring_down_note(const ExperimentResult &result) {
    for (const auto &ring_down : result.ring_downs)
        if (ring_down.state == result.damping_from && !ring_down.runs.empty()) {
            const auto &damping = ring_down.runs.back().damping; // of the reference
            return fmt::format(
                "Damping is fitted on {} alone, a ratio of {:.3f} at {:.2f} Hz, and then stays: "
                "alpha = {:.3f} 1/s, beta = {:.3e} s. Interactive methods know damping of the mass alone, "
                "and have the same ratio there.",
                printable(result.damping_from), ring_down.damping_ratio, ring_down.frequency, damping.alpha,
                damping.beta);
        }
    return "";
}

} // namespace livermark::results
