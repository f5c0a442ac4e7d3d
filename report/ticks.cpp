#include "report/ticks.hpp"

#include <array>
#include <cmath>
#include <fmt/format.h>

namespace livermark::report {

namespace {

constexpr std::array steps{1.0, 2.0, 5.0};
/// A tick that rounding has put beside the end of its range is at the end.
constexpr double slack = 1e-9;

} // namespace

double rounded_up(double value) {
    for (int exponent = static_cast<int>(std::floor(std::log10(value)));; ++exponent)
        for (const double step : steps)
            if (const double candidate = step * std::pow(10.0, exponent); candidate >= value * (1.0 - slack))
                return candidate;
}

std::vector<double> linear_ticks(double low, double high, int wanted) {
    const double step = rounded_up((high - low) / wanted);
    std::vector<double> ticks;
    for (double n = std::ceil(low / step - slack); n * step <= high + slack * (high - low); n += 1.0)
        ticks.push_back(n * step + 0.0); // no negative zero
    return ticks;
}

std::vector<double> logarithmic_ticks(double low, double high) {
    const double decades = std::log10(high / low);
    std::vector<double> ticks;
    const int stride = decades > 8.0 ? 2 : 1;
    for (int exponent = static_cast<int>(std::floor(std::log10(low))); std::pow(10.0, exponent) <= high; ++exponent)
        for (const double step : steps) {
            const double tick = step * std::pow(10.0, exponent);
            const bool is_wanted = step == 1.0 ? exponent % stride == 0 : decades < 2.5;
            if (is_wanted && tick >= low * (1.0 - slack) && tick <= high * (1.0 + slack))
                ticks.push_back(tick);
        }
    return ticks;
}

std::string tick_label(double value) {
    const double size = std::abs(value);
    return size != 0.0 && (size < 1e-3 || size >= 1e5) ? fmt::format("{:.0e}", value) : fmt::format("{:.6g}", value);
}

} // namespace livermark::report
