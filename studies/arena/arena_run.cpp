#include "studies/arena/arena_run.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/mesh/places.hpp"
#include "core/mesh/tetra_mesh.hpp"
#include "core/stopwatch.hpp"
#include "core/tool/ball_contact.hpp"
#include "core/tool/tool_motion.hpp"
#include "results/one_reference.hpp"

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

/// Corrections of a guess. A step that is long may have to be solved several times: the time is no straight line then
/// over the number of steps, and a guess on that line may be ten times too many.
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

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
/// Part of the radius of a ball, or of that around the face of a plate: a surface that is deeper in it has gone
/// through.
constexpr double gone_through = 0.5;
/// Places of the tool in frames that are like others, for the measurement of a method.
constexpr int num_places_on_the_way = 3;

/// Adds to what a run was at worst.
void judge(results::ArenaRun &run, const core::Deformation &shape, double reference_volume_change) {
    const double difference = std::abs(shape.volume_change - reference_volume_change);
    run.volume_error = std::isnan(difference) ? not_a_number : std::max(run.volume_error, difference);
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
    Recorder(const ArenaScene &scene, results::ArenaRun &run) : scene_(&scene), run_(&run) {}

    /// @return false if the body has left all bounds, or a ball has gone through its surface; everything from there on
    /// is NaN
    bool record(int frame, TimedBody &moving) {
        history_.force.push_back(moving.body().tool_force());
        const auto &displacement = moving.displacement();
        const bool is_within = moving.is_within_bounds() && stays_outside(frame, displacement);
        if (!core::ToolHistory::has_field(frame) || !is_within)
            return is_within;
        for (std::size_t i = 0; i < scene_->mesh_of_reference->points.size(); ++i)
            history_.displacement.push_back(displacement[i].cast<float>());
        const auto field = static_cast<std::size_t>(frame / core::ToolHistory::frames_per_field);
        judge(*run_, core::deformation(scene_->problem.body->mesh, displacement),
              scene_->reference ? scene_->reference_volume_change[field] : not_a_number);
        return true;
    }

    /// @return nothing to compare where the body was lost
    core::ToolHistory finish() {
        history_.time = core::record_times(scene_->problem.load_case.tool.value());
        const auto num_records = history_.time.size();
        history_.force.resize(num_records, core::Vector3::Constant(not_a_number));
        history_.displacement.resize(core::ToolHistory::num_fields(static_cast<int>(num_records)) *
                                         scene_->mesh_of_reference->points.size(),
                                     Eigen::Vector3f::Constant(NAN));
        return std::move(history_);
    }

  private:
    /// Depth of the surface inside a tool that touches, also between the points of contact: at corners of facets, and
    /// where a facet is nearest to the middle.
    bool stays_outside(int frame, const std::vector<core::Vector3> &displacement) {
        const auto &load_case = scene_->problem.load_case;
        if (!load_case.touching || frame > core::last_record_held(*load_case.tool))
            return true;
        const auto &ball = *load_case.touching;
        const auto centre = core::ball_centre(ball, *load_case.tool, load_case.tool->time_of(frame));
        const auto &mesh = scene_->problem.body->mesh;
        double gap = std::numeric_limits<double>::infinity();
        const auto look_at = [&](const core::Vector3 &point) {
            gap = std::min(gap, core::gap_to(ball.shape, point - centre).size);
        };
        for (int f = 0; f < mesh.num_boundary_triangles(); ++f) {
            if (!load_case.may_touch(f))
                continue;
            auto corners = core::corners_of(mesh, f);
            for (std::size_t k = 0; k < 3; ++k)
                corners[k] += displacement[mesh.boundary_triangles[f][k]];
            look_at(core::nearest_of_triangle(corners, centre));
            if (ball.shape.is_plate())
                std::ranges::for_each(corners, look_at);
        }
        run_->deepest = std::max(run_->deepest, -gap);
        return -gap < gone_through * ball.shape.reach();
    }

    const ArenaScene *scene_;
    results::ArenaRun *run_;
    core::ToolHistory history_;
};

core::ToolErrors errors_without_reference(const core::ToolMotion &motion) {
    return {.contact = not_a_number,
            .after = not_a_number,
            .force = not_a_number,
            .over_time = std::vector<double>(core::ToolHistory::num_fields(motion.num_records()), not_a_number)};
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

/// Forces that the tool felt, in a few numbers.
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
    run.slid_force = num_sliding > 0 ? -sum.dot(inwards) / num_sliding : not_a_number;
    const double along = sum.dot(inwards);
    constexpr double smallest_part = 1e-6; // of the force: a ratio to less is one of rounding
    run.slid_ratio = std::abs(along) > smallest_part * sum.norm() ? sum.dot(across) / along : not_a_number;
}

results::ArenaRun run_method(const models::MovingMethod &method, const ArenaScene &scene, const Effort &effort) {
    const auto &motion = scene.problem.load_case.tool.value();
    results::ArenaRun run;
    run.method = method.name;
    run.tetrahedra = static_cast<int>(scene.problem.body->mesh.tetrahedra.size());
    run.steps = effort.steps;
    run.iterations = effort.iterations;
    run.smallest_jacobian = std::numeric_limits<double>::infinity();
    TimedBody moving([&] { return method.under_tool(scene.problem); }, effort, scene.problem.body->mesh.points);
    const auto cost = moving.body().cost(effort);
    run.element_passes = cost.element_passes;
    run.bytes_per_element = cost.bytes_per_element;
    Recorder recorder(scene, run);
    recorder.record(0, moving);
    bool is_within = true;
    for (int frame = 1; frame <= motion.num_frames && is_within; ++frame) {
        if (frame == core::last_record_held(motion) + 1)
            run.release_seconds = moving.time([](models::FrameBody &body) { body.let_go(); });
        moving.advance({.start = motion.time_of(frame - 1)});
        is_within = recorder.record(frame, moving);
    }
    moving.describe_times(run);
    const auto history = recorder.finish();
    run.errors = scene.reference ? core::compare(*scene.mesh_of_reference, motion, history, *scene.reference)
                                 : errors_without_reference(motion);
    run.force = history.force;
    find_forces(run, scene.problem);
    if (!is_within)
        run.outcome = results::ArenaOutcome::diverged;
    return run;
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
    const auto one_step = time_of_frame(frame, effort_of(setting, 1));
    const bool needs_two = setting == models::Setting::ten_iterations;
    if (one_step.seconds > budget)
        return needs_two ? std::nullopt
                         : std::optional(MeasuredEffort{effort_of(setting, 1), one_step.seconds, one_step.spread});
    constexpr int most_times_trial = 8; // a frame of many times the budget is nothing to measure
    const int trial = std::clamp(static_cast<int>(0.5 * budget / one_step.seconds), 2, most_effort);
    const auto trial_time = time_of_frame(frame, effort_of(setting, trial));
    const double each_step = std::max((trial_time.seconds - one_step.seconds) / (trial - 1), 1e-9);
    const int number = std::clamp(1 + static_cast<int>((budget - one_step.seconds) / each_step), 1,
                                  std::min(most_effort, most_times_trial * trial));
    if (needs_two && number == 1)
        return std::nullopt;
    return until_it_fits(frame, setting, budget,
                         {effort_of(setting, number), one_step.seconds + (number - 1) * each_step,
                          std::max(one_step.spread, trial_time.spread)},
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

std::vector<results::ArenaRun> run_budgets(const models::MovingMethod &method, const ArenaScene &scene,
                                           const std::vector<double> &budgets) {
    const auto &motion = *scene.problem.load_case.tool;
    const auto measured = method.under_tool(scene.problem);
    int next = 0; // of frames in the middle of the way in, again and again
    const auto frame = [&](const Effort &effort) {
        measured->advance({.start = 0.5 * motion.press_until + next++ % num_places_on_the_way * motion.frame_interval},
                          effort);
    };
    return runs_within_budgets(*measured, frame, budgets, true,
                               [&](const Effort &effort) { return run_method(method, scene, effort); });
}

std::vector<results::ArenaRun> run_series(const models::MovingMethod &method, const ArenaScene &scene,
                                          const std::vector<int> &iterations) {
    std::vector<results::ArenaRun> runs;
    const auto add = [&](const Effort &effort, const char *setting) {
        runs.push_back(run_method(method, scene, effort));
        runs.back().setting = setting;
    };
    if (iterations.empty())
        return runs;
    if (const auto least = method.under_tool(scene.problem)->least_effort()) {
        add(*least, stable_setting);
        add(twice(*least), half_steps_setting);
        return runs;
    }
    for (const auto setting : models::all_settings)
        for (const int number : iterations) {
            const int in_each = effort_of(setting, 1).iterations; // where steps are what is counted
            const bool is_whole = number % in_each == 0;
            if (setting == models::Setting::one_step || (is_whole && number > in_each)) // else the same again
                add(effort_of(setting, number / in_each), models::to_string(setting));
        }
    return runs;
}

} // namespace livermark::studies
