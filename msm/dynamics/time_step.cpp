#include "msm/dynamics/time_step.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace livermark::msm {

namespace {

/// Growth that is put down to rounding.
constexpr double rounding = 1e-12;
constexpr int num_frequencies = 48;
/// Steps are tried from this part of the shortest time scale on. Without damping the growth of an integrator that is
/// never stable would at much smaller steps be lost in rounding; those that are stable are so up to 2 and more. What
/// does not bear it with damping, as explicit Euler where that is weak, begins much lower.
constexpr double usual_first_try = 0.3;
constexpr double smallest_damped_try = 1e-5;
constexpr double largest_try = 1e3;
/// From one try to the next; finer than any gap in what the integrators can bear.
constexpr double ratio = 1.02;
constexpr int num_bisections = 40;

/// Takes (omega u, v) from one time to the next.
Eigen::Matrix2d propagator(const Integrator &integrator, double omega, double damping_ratio, double time_step) {
    EquationOfMotion equation;
    equation.mass = Eigen::VectorXd::Ones(1);
    equation.acceleration = [=](const Eigen::VectorXd &u, const Eigen::VectorXd &v, Eigen::VectorXd &a) {
        a = -omega * omega * u - 2.0 * damping_ratio * omega * v;
    };
    equation.effective_mass = [=](const Eigen::VectorXd &, double d, double k) {
        Eigen::SparseMatrix<double> matrix(1, 1);
        matrix.insert(0, 0) = 1.0 + d * 2.0 * damping_ratio * omega + k * omega * omega;
        return matrix;
    };
    const auto step = integrator.prepare(equation, time_step);
    Eigen::Matrix2d matrix;
    for (int column = 0; column < 2; ++column) {
        State state{Eigen::VectorXd::Zero(1), Eigen::VectorXd::Zero(1)};
        (column == 0 ? state.displacement[0] : state.velocity[0]) = column == 0 ? 1.0 / omega : 1.0;
        step(state);
        matrix.col(column) << omega * state.displacement[0], state.velocity[0];
    }
    return matrix;
}

double spectral_radius(const Eigen::Matrix2d &matrix) {
    const double half_trace = 0.5 * matrix.trace();
    const double discriminant = half_trace * half_trace - matrix.determinant();
    return discriminant < 0.0 ? std::sqrt(matrix.determinant()) : std::abs(half_trace) + std::sqrt(discriminant);
}

} // namespace

bool is_stable(const Integrator &integrator, double omega, double damping_ratio, double time_step) {
    const auto matrix = propagator(integrator, omega, damping_ratio, time_step);
    // Jury's conditions on z^2 - trace z + det. The eigenvalues themselves lose half the digits where the two meet,
    // which a critically damped oscillation makes them do at every small step.
    const double determinant = matrix.determinant();
    return determinant <= 1.0 + rounding && std::abs(matrix.trace()) <= 1.0 + determinant + rounding;
}

double largest_amplification(const Integrator &integrator, const core::RayleighDamping &damping, double lowest,
                             double highest, double time_step) {
    double largest = 0.0;
    for (int f = 0; f < num_frequencies; ++f) {
        const double omega = highest * std::pow(lowest / highest, f / (num_frequencies - 1.0));
        largest = std::max(largest, spectral_radius(propagator(integrator, omega, damping.ratio(omega), time_step)));
    }
    return largest;
}

double critical_time_step(const Integrator &integrator, const core::RayleighDamping &damping, double lowest,
                          double highest) {
    std::vector<double> frequencies;
    for (int f = 0; f < num_frequencies; ++f)
        frequencies.push_back(highest * std::pow(lowest / highest, f / (num_frequencies - 1.0)));
    const auto all_are_stable = [&](double time_step) {
        return std::ranges::all_of(
            frequencies, [&](double omega) { return is_stable(integrator, omega, damping.ratio(omega), time_step); });
    };
    double largest_rate = 0.0; // of what oscillates or, beyond critical damping, comes to rest
    for (const double omega : frequencies) {
        const double ratio = std::max(damping.ratio(omega), 1.0);
        largest_rate = std::max(largest_rate, omega * (ratio + std::sqrt(ratio * ratio - 1.0)));
    }
    const bool is_damped = damping.alpha > 0.0 || damping.beta > 0.0;
    double good = usual_first_try / largest_rate;
    if (is_damped && !all_are_stable(good))
        good = smallest_damped_try / highest;
    if (!all_are_stable(good))
        return 0.0;
    double bad = good * ratio;
    while (all_are_stable(bad)) {
        good = bad;
        bad *= ratio;
        if (bad * highest > largest_try)
            return std::numeric_limits<double>::infinity();
    }
    for (int i = 0; i < num_bisections; ++i) {
        const double middle = 0.5 * (good + bad);
        (all_are_stable(middle) ? good : bad) = middle;
    }
    return good;
}

} // namespace livermark::msm
