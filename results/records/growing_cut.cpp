#include "results/records/growing_cut.hpp"

#include <limits>

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

} // namespace livermark::results
