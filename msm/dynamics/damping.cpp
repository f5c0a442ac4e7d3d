#include "msm/dynamics/damping.hpp"

#include <cmath>
#include <fmt/format.h>

#include "support/input_error.hpp"

namespace livermark::msm {

namespace {

void check(double ratio, double omega) {
    if (!(ratio >= 0.0) || !std::isfinite(ratio))
        throw support::InputError(fmt::format("the damping ratio is {}; it has to be zero or more", ratio));
    if (!(omega > 0.0) || !std::isfinite(omega))
        throw support::InputError(
            fmt::format("the angular frequency of a damping ratio is {} rad/s; it has to be positive", omega));
}

} // namespace

core::RayleighDamping mass_proportional_damping(double ratio, double omega) {
    check(ratio, omega);
    return {.alpha = 2.0 * ratio * omega, .beta = 0.0};
}

core::RayleighDamping stiffness_proportional_damping(double ratio, double omega) {
    check(ratio, omega);
    return {.alpha = 0.0, .beta = 2.0 * ratio / omega};
}

core::RayleighDamping two_mode_damping(double ratio_1, double omega_1, double ratio_2, double omega_2) {
    check(ratio_1, omega_1);
    check(ratio_2, omega_2);
    if (omega_1 == omega_2)
        throw support::InputError(
            fmt::format("both damping ratios are those of {} rad/s; give two frequencies that differ", omega_1));
    const double difference = (omega_2 - omega_1) * (omega_2 + omega_1);
    const core::RayleighDamping damping{.alpha = 2.0 * omega_1 * omega_2 * (ratio_1 * omega_2 - ratio_2 * omega_1) /
                                                 difference,
                                        .beta = 2.0 * (ratio_2 * omega_2 - ratio_1 * omega_1) / difference};
    if (damping.alpha < 0.0 || damping.beta < 0.0)
        throw support::InputError(fmt::format("damping ratios of {} at {} rad/s and {} at {} rad/s need a negative {}; "
                                              "bring the ratios nearer to each other than the frequencies are",
                                              ratio_1, omega_1, ratio_2, omega_2,
                                              damping.alpha < 0.0 ? "alpha" : "beta"));
    return damping;
}

} // namespace livermark::msm
