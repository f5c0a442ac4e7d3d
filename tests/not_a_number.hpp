#pragma once

#include <limits>

namespace livermark::tests {

inline constexpr double nan = std::numeric_limits<double>::quiet_NaN();

} // namespace livermark::tests
