#include "results/records/growing_cut.hpp"

#include <limits>

namespace livermark::results {

double CutFile::release_rate(const CutRun &run, std::size_t record) const {
    if (record == 0 || !(area[record] > area[record - 1]))
        return std::numeric_limits<double>::quiet_NaN();
    return (run.released(record) - run.released(record - 1)) / (area[record] - area[record - 1]);
}

} // namespace livermark::results
