#include "experiments/motion_table.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "experiments/marker_table.hpp"
#include "support/input_error.hpp"

namespace livermark::experiments {

namespace {

using core::Vector3;

constexpr std::size_t fewest_rows = 16;
constexpr double rounding_of_intervals = 0.01; ///< of an interval, that a time may be off

/// The column of each marker's x.
std::vector<std::size_t> columns_of(const CsvRow &header, std::span<const Marker> markers) {
    const auto refuse = [&](const std::string &fault) {
        throw support::InputError(fmt::format("{}: {}; the first line is time, and <marker>_x, <marker>_y, <marker>_z "
                                              "of each marker",
                                              header.place, fault));
    };
    if (header.cells.front() != "time" || header.cells.size() != 1 + 3 * markers.size())
        refuse(fmt::format("there are {} columns of {} markers over time", header.cells.size(), markers.size()));
    std::vector<std::size_t> columns;
    for (const auto &marker : markers) {
        const auto at = std::ranges::find(header.cells, marker.name + "_x");
        const auto column = static_cast<std::size_t>(at - header.cells.begin());
        if (column + 2 >= header.cells.size() || header.cells[column + 1] != marker.name + "_y" ||
            header.cells[column + 2] != marker.name + "_z")
            refuse(fmt::format("marker '{}' has no columns", marker.name));
        columns.push_back(column);
    }
    return columns;
}

} // namespace

MarkerMotion read_motion(const std::filesystem::path &file, std::span<const Marker> markers, double metres_per_unit) {
    const auto rows = read_csv(file);
    if (rows.size() < 1 + fewest_rows)
        throw support::InputError(
            fmt::format("{}: a motion has at least {} records, and here are {}; record for longer", file.string(),
                        fewest_rows, rows.empty() ? 0 : rows.size() - 1));
    const auto columns = columns_of(rows.front(), markers);
    MarkerMotion motion{0.0, static_cast<int>(markers.size()), {}};
    double start = 0.0;
    for (std::size_t r = 1; r < rows.size(); ++r) {
        const auto &row = rows[r];
        if (row.cells.size() != rows.front().cells.size())
            throw support::InputError(fmt::format("{}: the line has {} cells and the first line {}; correct it",
                                                  row.place, row.cells.size(), rows.front().cells.size()));
        const double time = number_in(row, 0);
        const auto steps = static_cast<double>(r - 1);
        if (r == 1)
            start = time;
        else if (r == 2)
            motion.interval = time - start;
        if (r >= 2 && !(motion.interval > 0.0 && std::abs(time - start - steps * motion.interval) <
                                                     rounding_of_intervals * motion.interval * steps))
            throw support::InputError(fmt::format("{}: times are not evenly spaced; interpolate the records to equal "
                                                  "intervals",
                                                  row.place));
        for (std::size_t k = 0; k < markers.size(); ++k)
            motion.displacement.emplace_back(metres_per_unit * Vector3(number_in(row, columns[k]),
                                                                       number_in(row, columns[k] + 1),
                                                                       number_in(row, columns[k] + 2)) -
                                             markers[k].position);
    }
    const auto last = static_cast<double>(rows.size() - 2);
    motion.interval = (number_in(rows.back(), 0) - start) / last; // of many, so that rounding of one does not count
    return motion;
}

} // namespace livermark::experiments
