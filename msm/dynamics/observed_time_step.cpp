#include "msm/dynamics/observed_time_step.hpp"

#include <cmath>
#include <limits>
#include <random>

#include "core/mesh/bounding_box.hpp"
#include "msm/dynamics/elastic_motion.hpp"

namespace livermark::msm {

namespace {

/// Of the push, relative to the size of the mesh: far inside the linear range even when it has grown, and far above the
/// rounding of the positions.
constexpr double push = 1e-9;
constexpr double widest_bracket = 1e4;
constexpr double first_bracket = 2.0;

/// A displacement of every free component, between -scale and scale.
Eigen::VectorXd random_displacement(const NodalConditions &conditions, double scale) {
    std::mt19937 generator(2007); // its sequence is laid down in the standard, that of distributions is not
    std::vector<core::Vector3> displacement(conditions.displacement.size(), core::Vector3::Zero());
    for (std::size_t i = 0; i < displacement.size(); ++i)
        for (int c = 0; c < 3; ++c) {
            const double part = 2.0 * generator() / std::mt19937::max() - 1.0;
            if (std::isnan(conditions.displacement[i][c]))
                displacement[i][c] = scale * part;
        }
    return to_unknowns(displacement);
}

} // namespace

double observed_time_step(const Integrator &integrator, const ElasticBody &body,
                          const std::vector<core::Vector3> &positions, const NodalConditions &conditions,
                          const core::RayleighDamping &damping, double guess, const ObservationOptions &options) {
    NodalConditions unloaded = conditions;
    unloaded.force.assign(positions.size(), core::Vector3::Zero());
    auto equation = elastic_motion(body, positions, unloaded, damping, options.scaling);
    int num_accelerations = 0;
    equation.acceleration = [uncounted = equation.acceleration, &num_accelerations](
                                const Eigen::VectorXd &u, const Eigen::VectorXd &v, Eigen::VectorXd &a) {
        ++num_accelerations;
        uncounted(u, v, a);
    };
    const auto start = random_displacement(conditions, push * core::extent(positions));
    const double bound = options.growth * start.norm();

    const auto time_step = [&](int power) { return std::pow(1.0 + options.accuracy, power); };
    const auto is_stable = [&](int power) {
        const auto step = integrator.prepare(equation, time_step(power));
        State state{start, Eigen::VectorXd::Zero(start.size())};
        num_accelerations = 0;
        for (int s = 0; s < options.num_steps || num_accelerations < options.num_accelerations; ++s) {
            step(state);
            if (!(state.displacement.norm() <= bound))
                return false;
        }
        return true;
    };

    const double powers_per_factor = 1.0 / std::log1p(options.accuracy);
    const int middle = static_cast<int>(std::lround(std::log(guess) * powers_per_factor));
    const int reach = static_cast<int>(std::lround(std::log(widest_bracket) * powers_per_factor));
    const int stride = static_cast<int>(std::lround(std::log(first_bracket) * powers_per_factor));
    int good = middle - stride;
    int bad = middle + stride;
    while (!is_stable(good)) {
        bad = good;
        good -= stride;
        if (good < middle - reach)
            return 0.0;
    }
    while (is_stable(bad)) {
        good = bad;
        bad += stride;
        if (bad > middle + reach)
            return std::numeric_limits<double>::infinity();
    }
    while (bad - good > 1) {
        const int between = good + (bad - good) / 2;
        (is_stable(between) ? good : bad) = between;
    }
    return time_step(good);
}

} // namespace livermark::msm
