#include "results/tables/studies/needle_table.hpp"

#include <cmath>
#include <fmt/format.h>
#include <map>
#include <string>
#include <vector>

#include "core/units.hpp"

namespace livermark::results {

namespace {

using core::millimetres, core::percent;

constexpr double needle_millijoules = 1e3;
/// Of the work of the hand: what balances, balances to 2 %.
constexpr double most_energy_error = 0.05;

std::string mark_of(double value, int decimals) {
    return std::isnan(value) ? "-" : fixed(value, decimals);
}

} // namespace

Layout needle_table(const NeedleFile &file) {
    Layout table{{{"needle"},
                  {"model"},
                  {"target moved [mm]", true},
                  {"off by [mm]", true},
                  {"short of it [mm]", true},
                  {"force there [N]", true},
                  {"largest [N]", true},
                  {"punctured at [mm]", true},
                  {"pull out [N]", true},
                  {"force off by [%]", true}},
                 {}};
    for (const auto &study : file.needles) {
        const auto &reference = study.runs.front();
        for (const auto &run : study.runs) {
            const bool judges = &run == &reference;
            const auto off = [&](double value, int decimals) { return judges ? "-" : mark_of(value, decimals); };
            table.rows.push_back(
                {study.needle.name, judges ? run.model + " (reference)" : run.model,
                 mark_of(millimetres * run.miss().norm(), 2),
                 off(millimetres * (run.miss() - reference.miss()).norm(), 2),
                 mark_of(millimetres * run.short_of_target(study.needle), 2), mark_of(run.force_at_plan(), 3),
                 fixed(run.largest_force(study.needle), 3), mark_of(millimetres * run.insertion.puncture_depth, 1),
                 mark_of(run.largest_pull(), 3), off(percent * force_error(run.insertion, reference.insertion), 1)});
        }
    }
    return table;
}

std::string limit_note(const NeedleStudy &study) {
    std::map<double, std::vector<std::string>> models; // by depth
    for (const auto &run : study.runs)
        if (!std::isnan(run.left_regime_at))
            models[run.left_regime_at].push_back(run.model);
    if (models.empty())
        return "";
    std::vector<std::string> depths;
    for (const auto &[depth, names] : models)
        depths.push_back(fmt::format("{:.1f} mm ({})", millimetres * depth, fmt::join(names, ", ")));
    return fmt::format(
        "{}: small regime left at {}: from there on tissue moves further than small deformations go, and "
        "the numbers say nothing of it; use --regime large\n",
        printable(study.needle.name), fmt::join(depths, ", "));
}

std::string needle_note(const NeedleFile &file) {
    std::string note;
    for (const auto &study : file.needles) {
        note += limit_note(study);
        for (const auto &run : study.runs) {
            if (run.energy_error() > most_energy_error)
                note +=
                    fmt::format("{}: energies of {} miss {:.0f} % of the work of the hand, as where springs fold; do "
                                "not rely on it here\n",
                                printable(study.needle.name), run.model, percent * run.energy_error());
            if (!std::isnan(run.insertion.stopped_at))
                note += fmt::format("{}: {} finds no equilibrium with the tip at a depth of {:.1f} mm, on the way {}; "
                                    "take a smaller force of the puncture or a finer mesh\n",
                                    printable(study.needle.name), run.model, millimetres * run.insertion.stopped_at,
                                    std::isnan(run.force_at_plan()) ? "in" : "out");
        }
        if (std::isnan(study.reference_miss_change)) {
            note += fmt::format("{}: {} is on the mesh itself, and how far it is from finer ones is not known\n",
                                printable(study.needle.name), study.runs.front().model);
            continue;
        }
        note += fmt::format("{}: the last refinement of {} near the needle moved the target by {:.3f} mm and changed "
                            "the force by {:.2f} %\n",
                            printable(study.needle.name), study.runs.front().model,
                            millimetres * study.reference_miss_change, percent * study.reference_force_change);
    }
    return note;
}

Layout measured_needle_table(const MeasuredNeedle &measured) {
    Layout table{{{"depth [mm]", true}, {"measured [N]", true}, {"lowest", true}, {"highest", true}}, {}};
    for (const auto &run : measured.runs)
        table.columns.push_back({run.model, true});
    for (std::size_t b = 0; b < measured.from.size(); ++b) {
        table.rows.push_back(
            {fmt::format("{:.0f} to {:.0f}", millimetres * measured.from[b], millimetres * measured.to[b]),
             fixed(measured.mean[b], 2), fixed(measured.lowest[b], 2), fixed(measured.highest[b], 2)});
        for (const auto &run : measured.runs)
            table.rows.back().push_back(mark_of(run.force[b], 2));
    }
    return table;
}

Layout fitted_needle_table(const MeasuredNeedle &measured) {
    Layout table{{{"model"},
                  {"stiffness, fitted", true},
                  {"friction, fitted [N/m]", true},
                  {"off before the puncture [N]", true},
                  {"off behind it [N]", true},
                  {"work [mJ]", true}},
                 {}};
    for (const auto &run : measured.runs)
        table.rows.push_back({run.model, fmt::format("x {:.2f}", run.stiffness), fixed(run.friction, 1),
                              fixed(run.error_before, 2), fixed(run.error, 2),
                              fixed(needle_millijoules * run.work, 1)});
    table.rows.push_back({"measured", "", "", "", "", fixed(needle_millijoules * measured.work, 1)});
    return table;
}

} // namespace livermark::results
