#include "studies/arena/arena_run.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/mesh/bounding_box.hpp"
#include "core/mesh/deformation.hpp"
#include "core/mesh/triangle.hpp"
#include "core/processor_time.hpp"
#include "core/tool/ball_contact.hpp"
#include "core/tool/tool_motion.hpp"
#include "results/quantile.hpp"

namespace livermark::studies {

namespace {

using core::processor_seconds;
using models::Effort;
using models::MovingBody;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
/// A motion beyond this many times the size of the body has diverged.
constexpr double bound = 1.0;
/// Of the radius of a ball: where its centre is nearer to the surface, it has gone through.
constexpr double gone_through = 0.5;
/// More iterations are no answer to anything.
constexpr int most_effort = 20000;
constexpr int frames_to_measure = 3;
constexpr int most_rounds = 10;
constexpr double steady_spread = 0.02;

struct FrameTime {
    double seconds;
    double spread; ///< of the last two rounds, as a part
};

/// The shortest of a few frames is a round, and rounds are repeated until two agree. The shorter one counts, since
/// other programs only make frames longer.
FrameTime time_of_frame(const std::function<void(const Effort &)> &frame, const Effort &effort) {
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

/// What a field adds to what a run was at worst.
void judge(results::ArenaRun &run, const core::Deformation &shape, double reference_volume_change) {
    const double difference = std::abs(shape.volume_change - reference_volume_change);
    run.volume_error = std::isnan(difference) ? nan : std::max(run.volume_error, difference);
    run.smallest_jacobian = std::min(run.smallest_jacobian, shape.smallest_jacobian);
    run.num_inverted = std::max(run.num_inverted, shape.num_inverted);
}

/// (F) of a motion of the nodes of a mesh.
std::vector<core::Deformation> shapes(const core::TetraMesh &mesh, const core::ToolHistory &history) {
    std::vector<core::Deformation> result;
    const std::size_t num_nodes = mesh.points.size();
    for (std::size_t first = 0; first < history.displacement.size(); first += num_nodes) {
        std::vector<core::Vector3> displacement;
        for (std::size_t i = first; i < first + num_nodes; ++i)
            displacement.emplace_back(history.displacement[i].cast<double>());
        result.push_back(core::deformation(mesh, displacement));
    }
    return result;
}

/// Keeps the nodes of the reference of what a method does.
class Recorder {
  public:
    Recorder(const ArenaScene &scene, results::ArenaRun &run)
        : scene_(&scene), run_(&run), bound_(bound * core::extent(scene.mesh_of_reference->points)) {}

    /// @return false if the body has left all bounds, or a ball has gone through its surface; everything from there on
    /// is NaN
    bool record(int frame, const MovingBody &body) {
        history_.force.push_back(body.tool_force());
        const auto displacement = body.displacement();
        const bool is_within =
            std::ranges::all_of(displacement,
                                [&](const core::Vector3 &u) { return u.lpNorm<Eigen::Infinity>() < bound_; }) &&
            stays_outside(frame, displacement);
        if (!core::ToolHistory::has_field(frame) || !is_within)
            return is_within;
        for (std::size_t i = 0; i < scene_->mesh_of_reference->points.size(); ++i)
            history_.displacement.push_back(displacement[i].cast<float>());
        const auto field = static_cast<std::size_t>(frame / core::ToolHistory::frames_per_field);
        judge(*run_, core::deformation(scene_->problem.body->mesh, displacement),
              scene_->reference ? scene_->reference_volume_change[field] : nan);
        return true;
    }

    /// @return nothing to compare where the body was lost
    core::ToolHistory finish() {
        history_.time = core::record_times(scene_->problem.load_case.tool.value());
        const auto num_records = history_.time.size();
        history_.force.resize(num_records, core::Vector3::Constant(nan));
        history_.displacement.resize(core::ToolHistory::num_fields(static_cast<int>(num_records)) *
                                         scene_->mesh_of_reference->points.size(),
                                     Eigen::Vector3f::Constant(NAN));
        return std::move(history_);
    }

  private:
    /// Of a ball that touches: how deep the surface is inside it, also between the points of contact.
    bool stays_outside(int frame, const std::vector<core::Vector3> &displacement) {
        const auto &load_case = scene_->problem.load_case;
        if (!load_case.touching || frame > core::last_record_held(*load_case.tool))
            return true;
        const auto &ball = *load_case.touching;
        const auto centre = core::ball_centre(ball, *load_case.tool, load_case.tool->time_of(frame));
        const auto &mesh = scene_->problem.body->mesh;
        double distance = std::numeric_limits<double>::infinity();
        for (int f = 0; f < mesh.num_boundary_triangles(); ++f) {
            if (!load_case.may_touch(f))
                continue;
            auto corners = core::corners_of(mesh, f);
            for (std::size_t k = 0; k < 3; ++k)
                corners[k] += displacement[mesh.boundary_triangles[f][k]];
            distance = std::min(distance, (core::nearest_of_triangle(corners, centre) - centre).norm());
        }
        run_->deepest = std::max(run_->deepest, ball.radius - distance);
        return distance > gone_through * ball.radius;
    }

    const ArenaScene *scene_;
    results::ArenaRun *run_;
    double bound_;
    core::ToolHistory history_;
};

core::ToolErrors errors_without_reference(const core::ToolMotion &motion) {
    return {.contact = nan,
            .after = nan,
            .force = nan,
            .over_time = std::vector<double>(core::ToolHistory::num_fields(motion.num_records()), nan)};
}

/// Along which a tool presses; zero where it does not.
core::Vector3 press_of(const core::LoadCase &load_case) {
    if (load_case.touching)
        return load_case.touching->press;
    core::Vector3 press = core::Vector3::Zero();
    for (int f = 0; f < load_case.num_facets(); ++f)
        if (load_case.constraint_on(f) == load_case.tool->constraint && load_case.value[f].norm() > press.norm())
            press = load_case.value[f];
    return press;
}

/// What the tool felt, in a few numbers.
void find_forces(results::ArenaRun &run, const core::Problem &problem) {
    const auto &motion = problem.load_case.tool.value();
    const core::Vector3 inwards = press_of(problem.load_case).normalized();
    const core::Vector3 across = (motion.slide - motion.slide.dot(inwards) * inwards).normalized();
    core::Vector3 sum = core::Vector3::Zero();
    int num_sliding = 0;
    for (int record = 0; record < motion.num_records(); ++record) {
        const double time = motion.time_of(record);
        const auto &force = run.force[record];
        if (time > motion.slide_from && time < motion.slide_until) {
            sum += force;
            ++num_sliding;
        }
    }
    run.pressed_force = pressed_force(motion, run.force);
    run.slid_force = num_sliding > 0 ? -sum.dot(inwards) / num_sliding : nan;
    const double along = sum.dot(inwards);
    constexpr double smallest_part = 1e-6; // of the force: a ratio to less is one of rounding
    run.slid_ratio = std::abs(along) > smallest_part * sum.norm() ? sum.dot(across) / along : nan;
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

double pressed_force(const core::ToolMotion &motion, const std::vector<core::Vector3> &force) {
    double size = 0.0;
    for (int record = 0; record < motion.num_records() && motion.time_of(record) <= motion.slide_from; ++record)
        size = force[record].norm();
    return size;
}

std::vector<double> volume_changes(const core::TetraMesh &mesh, const core::ToolHistory &history) {
    std::vector<double> changes;
    for (const auto &shape : shapes(mesh, history))
        changes.push_back(shape.volume_change);
    return changes;
}

void judge_shape(results::ArenaRun &run, const core::TetraMesh &mesh, const core::ToolHistory &history,
                 const core::ToolHistory &reference) {
    run.smallest_jacobian = std::numeric_limits<double>::infinity();
    const auto expected = volume_changes(mesh, reference);
    const auto found = shapes(mesh, history);
    for (std::size_t f = 0; f < found.size(); ++f)
        judge(run, found[f], expected[f]);
}

std::function<void(const Effort &)> frames_on_the_way_in(MovingBody &body, const core::ToolMotion &motion) {
    return [&body, &motion, next = 0](const Effort &effort) mutable {
        body.advance(0.5 * motion.press_until + next++ % frames_to_measure * motion.frame_interval, effort);
    };
}

namespace {

/// Where a step has to be solved several times if it is long, the time is no straight line over the number of steps,
/// and a guess on that line may be ten times too many.
MeasuredEffort until_it_fits(const std::function<void(const Effort &)> &frame, models::Setting setting, double budget,
                             MeasuredEffort guess, int number) {
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

std::optional<MeasuredEffort> largest_effort(const std::function<void(const Effort &)> &frame, models::Setting setting,
                                             double budget) {
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

results::ArenaRun run_method(const models::MovingMethod &method, const ArenaScene &scene, const Effort &effort) {
    const auto &motion = scene.problem.load_case.tool.value();
    results::ArenaRun run;
    run.method = method.name;
    run.tetrahedra = static_cast<int>(scene.problem.body->mesh.tetrahedra.size());
    run.steps = effort.steps;
    run.iterations = effort.iterations;
    run.smallest_jacobian = std::numeric_limits<double>::infinity();
    double start = processor_seconds();
    const auto body = method.prepare(scene.problem);
    body->prepare_for(effort);
    run.setup_seconds = processor_seconds() - start;
    const auto cost = body->cost(effort);
    run.element_passes = cost.element_passes;
    run.bytes_per_element = cost.bytes_per_element;

    Recorder recorder(scene, run);
    recorder.record(0, *body);
    std::vector<double> seconds;
    bool is_within = true;
    for (int frame = 1; frame <= motion.num_frames && is_within; ++frame) {
        if (frame == core::last_record_held(motion) + 1) {
            start = processor_seconds();
            body->let_go();
            run.release_seconds = processor_seconds() - start;
        }
        start = processor_seconds();
        body->advance(motion.time_of(frame - 1), effort);
        seconds.push_back(processor_seconds() - start);
        is_within = recorder.record(frame, *body);
    }
    run.frame_seconds = results::median(seconds);
    run.frame_seconds_95 = results::quantile(seconds, 0.95);
    run.worst_frame_seconds = *std::ranges::max_element(seconds);
    const auto history = recorder.finish();
    run.errors = scene.reference ? core::compare(*scene.mesh_of_reference, motion, history, *scene.reference)
                                 : errors_without_reference(motion);
    run.force = history.force;
    find_forces(run, scene.problem);
    if (!is_within)
        run.outcome = results::ArenaOutcome::diverged;
    return run;
}

} // namespace livermark::studies
