#include "results/tables/studies/history_table.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <vector>

namespace livermark::results {

namespace {

/// The steps of the case that has the fewest: a body has one more, in 0.8 of its own longest stable step.
std::vector<double> common_steps(std::span<const Histories> all) {
    const HistoryCase *shortest = nullptr;
    for (const auto &histories : all)
        for (const auto &entry : histories.cases)
            if (!shortest || entry.steps.size() < shortest->steps.size())
                shortest = &entry;
    std::vector<double> steps;
    if (shortest)
        for (const auto &history : shortest->steps)
            steps.push_back(history.time_step);
    return steps;
}

} // namespace

std::string verdict(const StepHistory &history, double critical_time_step) {
    if (!std::isnan(history.diverged_at))
        return fmt::format("diverged at {:.3g} s", history.diverged_at);
    return fmt::format("{}, ends at {:.3g} m", history.time_step > critical_time_step ? "grows" : "stable",
                       history.displacement.back());
}

Layout history_table(std::span<const Histories> all) {
    Layout layout{.columns = {{"model"}, {"longest stable step [s]", true}}, .rows = {}};
    for (const double time_step : common_steps(all))
        layout.columns.push_back({fmt::format("h = {:g} s", time_step)});
    layout.columns.push_back({"0.8 of the longest"});
    for (const auto &histories : all)
        for (const auto &entry : histories.cases) {
            auto &row =
                layout.rows.emplace_back(std::vector{entry.title, fmt::format("{:.4g}", entry.critical_time_step)});
            for (const auto &history : entry.steps)
                row.push_back(verdict(history, entry.critical_time_step));
            row.resize(layout.columns.size(), "-");
        }
    return layout;
}

} // namespace livermark::results
