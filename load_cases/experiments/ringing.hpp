#pragma once

#include <limits>
#include <span>
#include <vector>

#include "load_cases/experiments/experiment.hpp"

namespace livermark::experiments {

/// A damped oscillation.
struct Ringing {
    double frequency = std::numeric_limits<double>::quiet_NaN(); ///< of the damped oscillation [Hz]
    double ratio = std::numeric_limits<double>::quiet_NaN();     ///< zeta, of the decay exp(-2 pi f zeta t)
};

/// Records from one to before another.
struct Window {
    int first = 0, end = 0;
};

/// The damped oscillation that fits displacements best, in the mean square over all components of the markers:
///     u(t) = a + b t + exp(-2 pi f zeta t) (c cos 2 pi f t + d sin 2 pi f t),
/// with a, b, c and d of each component by linear least squares and one f and one zeta for all (variable projection:
/// Golub and Pereyra 1973, SIAM J. Numer. Anal. 10(2)). The line a + b t takes up a body that creeps while it rings.
/// @param markers  that count
/// @return NaN where displacements are not finite or the window has less than eight records
Ringing fit_ringing(const MarkerMotion &motion, std::span<const int> markers, const Window &window);

/// The same of all records.
Ringing fit_ringing(const MarkerMotion &motion, std::span<const int> markers);

/// Measured quantity, and its uncertainty.
struct MeasuredRinging {
    Ringing value;                      ///< mean over repeats, of all markers and records
    double frequency_uncertainty = 0.0; ///< half the range over repeats, single markers and windows [Hz]
    double ratio_uncertainty = 0.0;     ///< the same
};

/// Windows are all records, those without the first period, and the first half.
MeasuredRinging measured_ringing(std::span<const MarkerMotion> repeats, std::span<const int> markers);

/// Swings of a body from each turning point to the next, from t = 0 on: half of the change of the mean
/// displacement of the markers, along the direction in which they move most at first. Turning points are looked for
/// within a quarter of a period around multiples of half a period.
/// @param frequency  of the motion [Hz]
/// @return shape (count) [m]; NaN beyond the last record
std::vector<double> swings(const MarkerMotion &motion, std::span<const int> markers, double frequency, int count);

} // namespace livermark::experiments
