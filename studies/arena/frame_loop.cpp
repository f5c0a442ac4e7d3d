#include "studies/arena/frame_loop.hpp"

#include <cmath>
#include <limits>

#include "core/mesh/tetra_mesh.hpp"

namespace livermark::studies {

namespace {

using core::processor_seconds;
using models::Effort;

/// Upper limit of numbers: more iterations are no answer to anything.
constexpr int most_effort = 20000;
constexpr int frames_to_measure = 3, most_rounds = 10;
constexpr double steady_spread = 0.02;

struct FrameTime {
    double seconds;
    double spread; ///< of the last two rounds, as a part
};

/// The shortest of a few frames is a round, and rounds are repeated until two agree. The shorter one counts, since
/// other programs only make frames longer.
FrameTime time_of_frame(const MeasuredFrame &frame, const Effort &effort) {
    FrameTime time{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
    for (int round = 0; round < most_rounds && time.spread > steady_spread; ++round) {
        double shortest = std::numeric_limits<double>::infinity();
        for (int f = 0; f < frames_to_measure; ++f) {
            const double start = processor_seconds();
            frame(effort);
            shortest = std::min(shortest, processor_seconds() - start);
        }
        if (round > 0)
            time.spread = std::abs(shortest - time.seconds) / std::min(shortest, time.seconds);
        time.seconds = std::min(time.seconds, shortest);
    }
    return time;
}

/// Where a step has to be solved several times if it is long, the time is no straight line over the number of steps,
/// and a guess on that line may be ten times too many.
MeasuredEffort until_it_fits(const MeasuredFrame &frame, models::Setting setting, double budget, MeasuredEffort guess,
                             int number) {
    constexpr int most_corrections = 4;
    constexpr double near = 0.1; // of the budget: times are no more exact on a busy machine
    const int least = setting == models::Setting::ten_iterations ? 2 : 1;
    for (int c = 0;; ++c) {
        const auto time = time_of_frame(frame, guess.effort);
        guess.spread = std::max(guess.spread, time.spread);
        const int better = std::clamp(static_cast<int>(number * budget / time.seconds), least, most_effort);
        // More iterations that take no more time are none: nothing is left for them to do.
        guess.stops_early = setting == models::Setting::one_step && time.seconds < (1.0 - near) * budget &&
                            (number == most_effort || (c == most_corrections && better > number));
        if (guess.stops_early)
            guess.seconds = time.seconds;
        if (std::abs(time.seconds / budget - 1.0) <= near || better == number)
            break;
        if (c == most_corrections) {
            guess.seconds = time.seconds;
            break;
        }
        guess.seconds = time.seconds * better / number;
        number = better;
        guess.effort = effort_of(setting, number);
    }
    return guess;
}

} // namespace

Effort twice(const Effort &effort) {
    return effort.iterations > 1 ? Effort{effort.steps, 2 * effort.iterations}
                                 : Effort{2 * effort.steps, effort.iterations};
}

Effort effort_of(models::Setting setting, int number) {
    if (setting == models::Setting::one_step)
        return {.steps = 1, .iterations = number};
    return {.steps = number, .iterations = setting == models::Setting::ten_iterations ? 10 : 1};
}

std::optional<MeasuredEffort> largest_effort(const MeasuredFrame &frame, models::Setting setting, double budget) {
    const auto of_one = time_of_frame(frame, effort_of(setting, 1));
    const bool needs_two = setting == models::Setting::ten_iterations;
    if (of_one.seconds > budget)
        return needs_two ? std::nullopt
                         : std::optional(MeasuredEffort{effort_of(setting, 1), of_one.seconds, of_one.spread});
    constexpr int most_times_trial = 8; // a frame of many times the budget is nothing to measure
    const int trial = std::clamp(static_cast<int>(0.5 * budget / of_one.seconds), 2, most_effort);
    const auto of_trial = time_of_frame(frame, effort_of(setting, trial));
    const double of_each = std::max((of_trial.seconds - of_one.seconds) / (trial - 1), 1e-9);
    const int number = std::clamp(1 + static_cast<int>((budget - of_one.seconds) / of_each), 1,
                                  std::min(most_effort, most_times_trial * trial));
    if (needs_two && number == 1)
        return std::nullopt;
    return until_it_fits(
        frame, setting, budget,
        {effort_of(setting, number), of_one.seconds + (number - 1) * of_each, std::max(of_one.spread, of_trial.spread)},
        number);
}

TimedBody::TimedBody(const std::function<std::unique_ptr<models::FrameBody>()> &prepare, const Effort &effort,
                     const std::vector<core::Vector3> &points)
    : effort_(effort), bound_(core::extent(points)) {
    const double start = processor_seconds();
    body_ = prepare();
    body_->prepare_for(effort_);
    setup_seconds_ = processor_seconds() - start;
}

void TimedBody::advance(const models::Lead &lead) {
    displacement_.reset();
    frame_seconds_.push_back(time([&](models::FrameBody &body) { body.advance(lead, effort_); }));
}

const std::vector<core::Vector3> &TimedBody::displacement() {
    if (!displacement_)
        displacement_ = body_->displacement();
    return *displacement_;
}

bool TimedBody::is_within_bounds() {
    return std::ranges::all_of(displacement(), [&](const core::Vector3 &u) { // NaN is not
        return u.lpNorm<Eigen::Infinity>() < bound_;
    });
}

} // namespace livermark::studies
