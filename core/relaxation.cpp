#include "core/relaxation.hpp"

#include <cmath>

namespace livermark::core {

namespace {

/// (1 - exp(-x)) / x
double mean_fade(double x) {
    if (x <= 0.0)
        return 1.0;
    return std::isinf(x) ? 0.0 : -std::expm1(-x) / x;
}

/// The integral of (1 - exp(-x t))^2 / x over t from 0 to 1: of its series where the closed form cancels.
double change_loss(double x) {
    if (x < 0.02)
        return x * (1.0 / 3.0 - x * (1.0 / 4.0 - x * (7.0 / 60.0 - x * (1.0 / 24.0 - x * 31.0 / 2520.0))));
    return std::isinf(x) ? 0.0 : (1.0 - 2.0 * mean_fade(x) + mean_fade(2.0 * x)) / x;
}

} // namespace

std::vector<BranchStep> branch_steps(const PronySeries &relaxation, double step) {
    std::vector<BranchStep> branches;
    for (std::size_t k = 0; k < relaxation.moduli.size(); ++k) {
        const double modulus = relaxation.moduli[k];
        const double x = step > 0.0 ? step / relaxation.times[k] : 0.0;
        const double mean = mean_fade(x);
        auto &branch = branches.emplace_back();
        branch.modulus = modulus;
        branch.fade = std::exp(-x);
        branch.gain = modulus * mean;
        // h(t) = exp(-x t) h(n) + g (1 - exp(-x t)) / x (s(n+1) - s(n)), squared, times x / g
        branch.loss_of_stress = modulus > 0.0 ? -0.5 * std::expm1(-2.0 * x) / modulus : 0.0;
        branch.loss_of_both = std::isinf(x) ? 0.0 : x * mean * mean;
        branch.loss_of_change = modulus * change_loss(x);
    }
    return branches;
}

double instant_part(const PronySeries &relaxation, const std::vector<BranchStep> &branches) {
    double part = relaxation.remaining();
    for (const auto &branch : branches)
        part += branch.gain;
    return part;
}

} // namespace livermark::core
