#include "results/tables/studies/cut_table.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <iterator>
#include <limits>

#include "core/units.hpp"

namespace livermark::results {

namespace {

constexpr double square_centimetres = 1e4, millijoules = 1e3;

double difference_in_percent(double value, double reference) {
    return core::percent * (value / reference - 1.0);
}

double middle_of(std::vector<double> values) {
    if (values.empty())
        return std::numeric_limits<double>::quiet_NaN();
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

double longest_of(const std::vector<double> &values) {
    return values.empty() ? std::numeric_limits<double>::quiet_NaN() : *std::ranges::max_element(values);
}

} // namespace

Layout cut_table(const CutFile &file) {
    Layout table{{{"blade at [mm]", true},
                  {"cut [cm^2]", true},
                  {"opening [mm]", true},
                  {"stored [mJ]", true},
                  {"released [mJ]", true},
                  {"over area [J/m^2]", true},
                  {"left to the blade [mJ]", true},
                  {"tool [N/m]", true},
                  {"time of the cut [ms]", true}},
                 {}};
    const auto &run = file.runs.front();
    double by_blade = 0.0;
    for (std::size_t k = 0; k < file.num_records(); ++k) {
        if (k > 0)
            by_blade += std::max(0.0, file.tearing(k) - file.tearing(k - 1) - run.released(k) + run.released(k - 1));
        table.rows.push_back({fixed(core::millimetres * file.depth[k], 1), fixed(square_centimetres * file.area[k], 2),
                              fixed(core::millimetres * run.opening[k], 3), fixed(millijoules * run.stored[k], 3),
                              fixed(millijoules * run.released(k), 3), fixed(file.release_rate(run, k), 3),
                              fixed(millijoules * by_blade, 2), fixed(run.tool_stiffness[k], 2),
                              fixed(core::milliseconds * file.cut_seconds[k], 0)});
    }
    return table;
}

Layout cut_models_table(const CutFile &file) {
    Layout table{{{"model"},
                  {"opening [mm]", true},
                  {"off by [%]", true},
                  {"released [mJ]", true},
                  {"off by [%]", true},
                  {"over area [J/m^2]", true},
                  {"tool [N/m]", true},
                  {"off by [%]", true},
                  {"cut to ready [ms]", true},
                  {"longest [ms]", true},
                  {"equilibrium [ms]", true}},
                 {}};
    const auto last = file.num_records() - 1;
    const auto &judge = file.runs.front();
    for (const auto &run : file.runs) {
        const bool judges = &run == &judge;
        const auto off = [&](double value, double reference) {
            return judges ? "-" : fixed(difference_in_percent(value, reference), 1);
        };
        const auto ready = file.ready_seconds(run);
        table.rows.push_back(
            {judges ? run.model + " (reference)" : run.model, fixed(core::millimetres * run.opening[last], 3),
             off(run.opening[last], judge.opening[last]), fixed(millijoules * run.released(last), 3),
             off(run.released(last), judge.released(last)), fixed(run.released(last) / file.area[last], 3),
             fixed(run.tool_stiffness[last], 2), off(run.tool_stiffness[last], judge.tool_stiffness[last]),
             fixed(core::milliseconds * middle_of(ready), 0), fixed(core::milliseconds * longest_of(ready), 0),
             fixed(core::milliseconds * middle_of(file.equilibrium_seconds(run)), 0)});
    }
    return table;
}

Layout cut_motions_table(const CutFile &file) {
    Layout table{{{"method"},
                  {"budget [ms]", true},
                  {"steps x iterations", true},
                  {"opening [mm]", true},
                  {"off by [%]", true},
                  {"tool [N/m]", true},
                  {"off by [%]", true},
                  {"cut to next step [ms]", true},
                  {"longest [ms]", true},
                  {"frame [ms]", true},
                  {"worst frame [ms]", true}},
                 {}};
    const auto last = file.num_records() - 1;
    const auto &judge = file.runs.front();
    const auto miss = [&](const CutMotion &motion) { return std::abs(motion.opening[last] - judge.opening[last]); };
    std::vector<const CutMotion *> shown;
    for (const auto &motion : file.motions) {
        const auto same = std::ranges::find_if(shown, [&](const CutMotion *other) {
            return other->method == motion.method && other->budget == motion.budget;
        });
        if (same == shown.end())
            shown.push_back(&motion);
        else if (!(miss(motion) >= miss(**same))) // NaN is no better
            *same = std::isnan(miss(motion)) ? *same : &motion;
    }
    const auto in_ms = [](double seconds) { return fixed(core::milliseconds * seconds, 2); };
    for (const auto *motion : shown) {
        std::vector<double> ready;
        std::ranges::copy_if(motion->ready_seconds, std::back_inserter(ready), [](double s) { return s > 0.0; });
        const bool is_lost = std::isnan(motion->opening[last]);
        const auto budget = in_ms(motion->budget);
        const bool is_late = motion->frame_seconds > motion->budget;
        table.rows.push_back({motion->method,
                              is_late ? fmt::format("{}, needs {}", budget, in_ms(motion->frame_seconds)) : budget,
                              fmt::format("{} x {}", motion->steps, motion->iterations),
                              is_lost ? "diverged" : fixed(core::millimetres * motion->opening[last], 3),
                              fixed(difference_in_percent(motion->opening[last], judge.opening[last]), 1),
                              fixed(motion->tool_stiffness[last], 2),
                              fixed(difference_in_percent(motion->tool_stiffness[last], judge.tool_stiffness[last]), 1),
                              in_ms(middle_of(ready)), in_ms(longest_of(ready)), in_ms(motion->frame_seconds),
                              in_ms(motion->worst_frame_seconds)});
    }
    return table;
}

std::string cut_note(const CutFile &file) {
    const auto &judge = file.runs.front();
    double largest = 0.0;
    std::size_t above = 0, cutting = 0;
    for (std::size_t k = 1; k < file.num_records(); ++k)
        if (const double rate = file.release_rate(judge, k); !std::isnan(rate)) {
            largest = std::max(largest, rate);
            above += rate > file.toughness ? 1 : 0;
            ++cutting;
        }
    return fmt::format(
        "Tearing takes {:g} J/m^2; {} of {} steps that cut something release more over their area, the most {:.3g} "
        "J/m^2. If a step releases more, the cut grows by itself; otherwise the blade does the rest of the work.\n",
        file.toughness, above, cutting, largest);
}

} // namespace livermark::results
