#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "studies/experiments/experiments.hpp"

namespace livermark::studies {

namespace {

/// The least value of a function of one minimum in an interval, to a width.
struct Least {
    double at, value;
};
Least golden_section(double low, double high, double width, const std::function<double(double)> &function) {
    const double part = 2.0 - std::numbers::phi;
    double a = low + part * (high - low), b = high - part * (high - low);
    double value_a = function(a), value_b = function(b);
    while (high - low > width) {
        if (value_a <= value_b) {
            high = b;
            b = a;
            value_b = value_a;
            a = low + part * (high - low);
            value_a = function(a);
        } else {
            low = a;
            a = b;
            value_a = value_b;
            b = high - part * (high - low);
            value_b = function(b);
        }
    }
    return value_a <= value_b ? Least{a, value_a} : Least{b, value_b};
}

constexpr double hundredth = 0.01; ///< of a constant, as a difference of logarithms
constexpr double largest_change = 4.0;
constexpr double least_gain = 1e-4; ///< of the error, below which a constant has no effect
constexpr double least_ratio = 0.25, largest_ratio = 0.4999;

} // namespace

results::FittedMaterial fit_material(const std::string &model, const core::Material &given, bool modulus_matters,
                                     const std::function<double(const core::Material &)> &error) {
    results::FittedMaterial fit{.model = model, .error = error(given)};
    const auto take = [&](const Least &least, double constant, double &value, double &error_then) {
        if (least.value < (1.0 - least_gain) * fit.error) {
            value = constant;
            error_then = least.value;
        }
    };
    if (modulus_matters) {
        const double range = std::log(largest_change);
        const auto least = golden_section(-range, range, hundredth, [&](double change) {
            auto material = given;
            material.young_modulus *= std::exp(change);
            return error(material);
        });
        take(least, given.young_modulus * std::exp(least.at), fit.young_modulus, fit.error_of_modulus);
    }
    const auto ratio_at = [](double logarithm) { return 0.5 - std::exp(logarithm); };
    const auto least = golden_section(std::log(0.5 - largest_ratio), std::log(0.5 - least_ratio), 4.0 * hundredth,
                                      [&](double logarithm) {
                                          auto material = given;
                                          material.poisson_ratio = ratio_at(logarithm);
                                          return error(material);
                                      });
    take(least, ratio_at(least.at), fit.poisson_ratio, fit.error_of_ratio);
    return fit;
}

} // namespace livermark::studies
