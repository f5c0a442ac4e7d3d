#pragma once

#include <vector>

namespace livermark::results {

/// The middle one, or the mean of the two in the middle.
/// @param values  at least one
double median(std::vector<double> values);

/// Linear interpolation between the sorted values (type 7 of Hyndman, Fan 1996, The American Statistician 50(4)).
/// @param values  at least one
/// @param part    from 0 to 1; 0.5 is the median
double quantile(std::vector<double> values, double part);

} // namespace livermark::results
