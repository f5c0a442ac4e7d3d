#include "results/records/growing_cut.hpp"

#include <limits>

#include "core/observed_error.hpp"

namespace livermark::results {

std::vector<double> CutFile::ready_seconds(const CutRun &run) const {
    std::vector<double> seconds;
    for (std::size_t k = 1; k < num_records(); ++k)
        if (run.solve_seconds[k] > 0.0)
            seconds.push_back(cut_seconds[k] + run.setup_seconds[k]);
    return seconds;
}

std::vector<double> CutFile::equilibrium_seconds(const CutRun &run) const {
    std::vector<double> seconds;
    for (std::size_t k = 1; k < num_records(); ++k)
        if (run.solve_seconds[k] > 0.0)
            seconds.push_back(run.solve_seconds[k] - run.setup_seconds[k]);
    return seconds;
}

double CutFile::release_rate(const CutRun &run, std::size_t record) const {
    if (record == 0 || !(area[record] > area[record - 1]))
        return std::numeric_limits<double>::quiet_NaN();
    return (run.released(record) - run.released(record - 1)) / (area[record] - area[record - 1]);
}

std::optional<ErrorBar> CutFile::in_the_end(const std::string &way, double CutLevel::*number) const {
    constexpr std::size_t enough_levels = 3; // to observe an order
    std::vector<double> values;
    for (const auto &level : levels)
        if (level.way == way)
            values.push_back(level.*number);
    if (values.size() < enough_levels)
        return std::nullopt;
    return ErrorBar{values.back(), core::observed_error(values)};
}

CutJudge CutFile::judge_in_the_end() const {
    const auto opening = in_the_end("facets", &CutLevel::opening);
    const auto tool = in_the_end("facets", &CutLevel::tool_stiffness);
    if (opening && tool)
        return {*opening, *tool, true};
    return {{runs.front().opening.back()}, {runs.front().tool_stiffness.back()}, false};
}

} // namespace livermark::results
