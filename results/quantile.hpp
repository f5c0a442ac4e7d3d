#pragma once

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <vector>

namespace livermark::results {

/// NaN of none.
inline double mean(const std::vector<double> &values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// Linear interpolation between the sorted values (type 7 of Hyndman, Fan 1996, The American Statistician 50(4)).
/// @param values  at least one
/// @param part    from 0 to 1
inline double quantile(std::vector<double> values, double part) {
    std::ranges::sort(values);
    const double place = part * static_cast<double>(values.size() - 1);
    const auto below = static_cast<std::size_t>(place);
    const auto above = std::min(below + 1, values.size() - 1);
    return values[below] + (place - static_cast<double>(below)) * (values[above] - values[below]);
}

/// The middle one, or the mean of the two in the middle.
/// @param values  at least one
inline double median(std::vector<double> values) {
    std::ranges::sort(values);
    return 0.5 * (values[(values.size() - 1) / 2] + values[values.size() / 2]);
}

} // namespace livermark::results
