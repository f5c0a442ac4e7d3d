#include "msm/kernels/relaxation/relaxation_clock.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace livermark::msm {

namespace {

/// 1 - exp(-time / tau)
double faded_part(double time, double tau) {
    return std::isinf(tau) ? 0.0 : -std::expm1(-time / tau);
}

double largest_move(const core::PronySeries &series, double time) {
    double move = 0.0;
    for (std::size_t b = 0; b < series.moduli.size(); ++b)
        move += series.moduli[b] * faded_part(time, series.times[b]);
    return move;
}

} // namespace

int steps_between_turns(const core::PronySeries &series, double largest_error, double time_step) {
    constexpr int most = 1 << 20;
    const auto is_too_many = [&](int m) { return largest_move(series, m * time_step) > largest_error; };
    int enough = 1, too_many = most + 1;
    while (too_many - enough > 1) {
        const int middle = enough + (too_many - enough) / 2;
        (is_too_many(middle) ? too_many : enough) = middle;
    }
    return enough;
}

RelaxationClock::RelaxationClock(core::PronySeries series, double largest_error, double time_step, bool is_staggered)
    : series_(std::move(series)), largest_error_(largest_error), is_staggered_(is_staggered) {
    set_time_step(time_step);
}

void RelaxationClock::set_time_step(double time_step) {
    time_step_ = time_step;
    num_steps_ = steps_between_turns(series_, largest_error_, time_step);
    steps_left_ = 0;
}

std::vector<double> RelaxationClock::shares_after(double time) const {
    std::vector<double> shares;
    for (const double tau : series_.times)
        shares.push_back(faded_part(std::max(time, 0.0), tau));
    return shares;
}

RelaxationShares RelaxationClock::turn() {
    steps_left_ = num_steps_;
    if (moves_in_every_step()) {
        RelaxationShares shares{.share = shares_after(time_step_), .gain = {}, .takes_former = true};
        for (const auto &branch : core::branch_steps(series_, time_step_)) {
            shares.gain.push_back(branch.gain);
            shares.at_once += branch.modulus - branch.gain;
        }
        return shares;
    }
    // From the middle of the steps before to the middle of the next ones.
    const double half = 0.5 * num_steps_ * time_step_, time = std::max(half - ahead_, 0.0);
    ahead_ += time;
    return {.share = shares_after(time), .gain = series_.moduli, .back = is_staggered_ ? 0.5 * time_step_ : 0.0};
}

RelaxationShares RelaxationClock::stay(double time) {
    steps_left_ = 0;
    ahead_ = 0.0;
    RelaxationShares shares{.share = shares_after(time), .gain = series_.moduli};
    if (moves_in_every_step())
        std::ranges::transform(core::branch_steps(series_, time_step_), shares.gain.begin(), &core::BranchStep::gain);
    return shares;
}

void RelaxationClock::count(int steps) {
    steps_left_ -= steps;
    if (!moves_in_every_step())
        ahead_ -= steps * time_step_;
}

} // namespace livermark::msm
