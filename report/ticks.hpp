#pragma once

#include <string>
#include <vector>

namespace livermark::report {

/// Multiples of 1, 2 or 5 times a power of ten in a range, about as many as wanted.
/// @param low   < high, both finite
std::vector<double> linear_ticks(double low, double high, int wanted);

/// Powers of ten in a range; with 2 and 5 times these where there are few.
/// @param low   > 0, < high
std::vector<double> logarithmic_ticks(double low, double high);

/// The smallest of 1, 2 and 5 times a power of ten that is not below a value.
/// @param value  > 0
double rounded_up(double value);

/// Short: 0.05, 20, 1e-6.
std::string tick_label(double value);

} // namespace livermark::report
