#include "load_cases/experiments/ringing.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace livermark::experiments {

namespace {

using core::Vector3;

constexpr int fewest_records = 8;
constexpr double tau = 2.0 * std::numbers::pi;

/// Remainder of some columns when the best oscillation of a frequency and a damping ratio is taken off.
double left_over(const Eigen::MatrixXd &columns, double interval, double frequency, double ratio) {
    const auto count = columns.rows();
    Eigen::MatrixXd basis(count, 4);
    for (Eigen::Index j = 0; j < count; ++j) {
        const double phase = tau * frequency * interval * static_cast<double>(j), decay = std::exp(-ratio * phase);
        basis.row(j) << 1.0, static_cast<double>(j) / static_cast<double>(count), decay * std::cos(phase),
            decay * std::sin(phase);
    }
    const Eigen::HouseholderQR<Eigen::MatrixXd> factor(basis);
    const Eigen::MatrixXd rotated = factor.householderQ().transpose() * columns;
    return rotated.bottomRows(count - 4).squaredNorm();
}

double range_of(const std::vector<double> &values) {
    const auto [least, most] = std::ranges::minmax_element(values);
    return *most - *least;
}

/// The mean displacement of some markers in a record.
Vector3 mean_displacement(const MarkerMotion &motion, std::span<const int> markers, int record) {
    Vector3 sum = Vector3::Zero();
    for (const int marker : markers)
        sum += motion.at(record, marker);
    return sum / static_cast<double>(markers.size());
}

} // namespace

Ringing fit_ringing(const MarkerMotion &motion, std::span<const int> markers, const Window &window) {
    const int count = window.end - window.first;
    if (count < fewest_records)
        return {};
    Eigen::MatrixXd columns(count, 3 * static_cast<Eigen::Index>(markers.size()));
    for (int j = 0; j < count; ++j)
        for (std::size_t k = 0; k < markers.size(); ++k)
            columns.block<1, 3>(j, 3 * static_cast<Eigen::Index>(k)) =
                motion.at(window.first + j, markers[k]).transpose();
    if (!columns.allFinite())
        return {};
    const double duration = count * motion.interval;
    Ringing best{1.5 / duration, 0.05};
    double least = left_over(columns, motion.interval, best.frequency, best.ratio);
    const auto take_if_better = [&](double frequency, double ratio) {
        const double left = left_over(columns, motion.interval, frequency, ratio);
        if (!(left < least))
            return false;
        best = {frequency, ratio};
        least = left;
        return true;
    };
    // Slower motion than one and a half periods is not told from creep, faster than four records a period not from
    // noise.
    for (double frequency = 1.5 / duration; frequency < 0.25 / motion.interval; frequency += 0.25 / duration)
        for (const double ratio : {0.02, 0.1, 0.3})
            take_if_better(frequency, ratio);
    double step = 0.1;
    while (step > 1e-6) { // compass search
        const double frequency = best.frequency, ratio = best.ratio;
        const bool is_better = take_if_better(frequency * (1.0 + 0.3 * step), ratio) ||
                               take_if_better(frequency * (1.0 - 0.3 * step), ratio) ||
                               take_if_better(frequency, ratio + step) || take_if_better(frequency, ratio - step);
        if (!is_better)
            step *= 0.5;
    }
    return best;
}

Ringing fit_ringing(const MarkerMotion &motion, std::span<const int> markers) {
    return fit_ringing(motion, markers, {0, motion.num_records()});
}

MeasuredRinging measured_ringing(std::span<const MarkerMotion> repeats, std::span<const int> markers) {
    MeasuredRinging measured{.value = {0.0, 0.0}};
    std::vector<double> frequencies, ratios;
    for (const auto &repeat : repeats) {
        const auto whole = fit_ringing(repeat, markers);
        measured.value.frequency += whole.frequency / static_cast<double>(repeats.size());
        measured.value.ratio += whole.ratio / static_cast<double>(repeats.size());
        const int count = repeat.num_records();
        const int period = std::isfinite(whole.frequency)
                               ? static_cast<int>(std::lround(1.0 / (whole.frequency * repeat.interval)))
                               : 0;
        for (const Window window :
             {Window{0, count}, Window{std::min(period, count / 2), count}, Window{0, count / 2}}) {
            const auto add = [&](std::span<const int> some) {
                const auto fitted = fit_ringing(repeat, some, window);
                frequencies.push_back(fitted.frequency);
                ratios.push_back(fitted.ratio);
            };
            add(markers);
            for (std::size_t k = 0; k < markers.size(); ++k)
                add(markers.subspan(k, 1));
        }
    }
    measured.frequency_uncertainty = 0.5 * range_of(frequencies);
    measured.ratio_uncertainty = 0.5 * range_of(ratios);
    return measured;
}

std::vector<double> swings(const MarkerMotion &motion, std::span<const int> markers, double frequency, int count) {
    std::vector<double> found(count, std::numeric_limits<double>::quiet_NaN());
    const double half_period = 0.5 / (frequency * motion.interval);
    const int opposite = static_cast<int>(std::lround(half_period));
    if (!std::isfinite(half_period) || opposite < 1 || opposite >= motion.num_records())
        return found;
    const Vector3 start = mean_displacement(motion, markers, 0);
    const Vector3 way = (mean_displacement(motion, markers, opposite) - start).normalized();
    double before = 0.0, direction = 1.0;
    for (int n = 1; n <= count; ++n) {
        const int first = static_cast<int>(std::ceil((n - 0.5) * half_period)),
                  last = static_cast<int>((n + 0.5) * half_period);
        if (last + 1 >= motion.num_records() || first < 1)
            break;
        const auto along = [&](int record) {
            return direction * (mean_displacement(motion, markers, record) - start).dot(way);
        };
        int turn = first;
        for (int record = first; record <= last; ++record)
            if (along(record) > along(turn))
                turn = record;
        const double a = along(turn - 1), b = along(turn), c = along(turn + 1), curvature = a - 2.0 * b + c;
        // The vertex of the parabola through three records.
        const double at_turn = direction * (curvature < 0.0 ? b - (a - c) * (a - c) / (8.0 * curvature) : b);
        found[n - 1] = 0.5 * std::abs(at_turn - before);
        before = at_turn;
        direction = -direction;
    }
    return found;
}

} // namespace livermark::experiments
