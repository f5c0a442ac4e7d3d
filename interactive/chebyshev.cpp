#include "interactive/chebyshev.hpp"

#include <algorithm>
#include <cmath>

namespace livermark::interactive {

double chebyshev_weight(int iteration, double last_weight, double rho) {
    if (iteration == 1)
        return 1.0;
    return iteration == 2 ? 2.0 / (2.0 - rho * rho) : 4.0 / (4.0 - rho * rho * last_weight);
}

double chebyshev_rho(int num_iterations) {
    constexpr double largest = 0.95, most_left = 0.1;
    return std::min(largest, 1.0 / std::cosh(std::acosh(1.0 / most_left) / num_iterations));
}

} // namespace livermark::interactive
