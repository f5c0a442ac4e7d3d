#pragma once

#include <algorithm>
#include <functional>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "core/problem.hpp"
#include "core/stopwatch.hpp"
#include "core/tool/tool_motion.hpp"
#include "results/one_reference.hpp"
#include "results/records/arena.hpp"
#include "studies/models/motion/moving_method.hpp"

/// The loop over frames that arena, needle and blade have in common, and how much a method does in each of them.
namespace livermark::studies {

/// Settings of methods that take explicit steps: the least number of them, and twice that.
inline constexpr const char *stable_setting = "stable", *half_steps_setting = "half steps";

/// Work of a method in a frame, measured.
struct MeasuredEffort {
    models::Effort effort;
    double seconds = 0.0; ///< of a frame, about
    double spread = 0.0;  ///< by how much the times behind it differed, as a part of them
    /// Whether the frame ends earlier whatever the number is, because the method stops where nothing is left to do.
    bool stops_early = false;
};

/// A frame that is like others, of a method with a choice.
using MeasuredFrame = std::function<void(const models::Effort &)>;

/// The largest effort that fits into a budget, as measured on a body that is moved for it. Times are measured until two
/// rounds agree, or ten times.
/// @param budget  of one core, for a frame [s]
/// @return the least effort, and what it takes, where nothing fits; nothing where only one step of ten iterations fits:
///   in one step more of them do
std::optional<MeasuredEffort> largest_effort(const MeasuredFrame &frame, models::Setting setting, double budget);

/// The same in steps of half the length; an explicit method has one of the two numbers only.
models::Effort twice(const models::Effort &effort);

/// So many iterations of one step in a frame, or so many steps of ten iterations or of one.
models::Effort effort_of(models::Setting setting, int number);

/// Runs of a method within each budget, in all settings that it has.
/// @param measured  a body for the measurement
/// @param frame     moves it on by a frame that is like others
/// @param tells_of_diverged  whether runs of the least effort that have diverged are among them, beside those of twice
/// it
/// @param run                (effort): the run, an ArenaRun or a NeedleArenaRun
template <class RunWith>
auto runs_within_budgets(const models::FrameBody &measured, const MeasuredFrame &frame,
                         const std::vector<double> &budgets, bool tells_of_diverged, const RunWith &run) {
    std::vector<decltype(run(models::Effort{}))> runs;
    const auto add = [&](auto found, const char *setting, double budget, double seconds) {
        found.setting = setting;
        found.budget = budget;
        if (found.outcome == results::ArenaOutcome::ok && seconds > budget)
            found.outcome = results::ArenaOutcome::too_slow;
        runs.push_back(std::move(found));
    };
    if (const auto least = measured.least_effort()) {
        auto found = run(*least);
        const char *setting = stable_setting;
        const auto add_all = [&] {
            for (const double budget : budgets)
                add(found, setting, budget, found.frame_seconds);
        };
        // What is stable at rest need not be so where a tool has pressed the body together.
        if (found.outcome == results::ArenaOutcome::diverged) {
            if (tells_of_diverged)
                add_all();
            found = run(twice(*least));
            setting = half_steps_setting;
        }
        add_all();
        return runs;
    }
    for (const auto setting : models::all_settings)
        for (const double budget : budgets)
            if (const auto fits = largest_effort(frame, setting, budget)) {
                auto found = run(fits->effort);
                found.calibration_spread = fits->spread;
                found.stops_early = fits->stops_early ? 1 : 0;
                add(std::move(found), models::to_string(setting), budget, fits->seconds);
            }
    return runs;
}

/// A body that moves frame by frame with one effort, its times, and the bounds that it may leave.
class TimedBody {
  public:
    /// @param prepare  makes the body
    /// @param points   shape (N) [m], at rest: a displacement beyond the size of their box is no motion any more
    TimedBody(const std::function<std::unique_ptr<models::FrameBody>()> &prepare, const models::Effort &effort,
              const std::vector<core::Vector3> &points);

    /// Moves on by a frame.
    void advance(const models::Lead &lead = {});

    /// Displacements now, shape (N) [m].
    const std::vector<core::Vector3> &displacement();

    /// Whether all of them are within bounds.
    bool is_within_bounds();

    /// Processor time of an action on the body [s].
    template <class Action> double time(const Action &action) {
        const double start = core::processor_seconds();
        action(*body_);
        return core::processor_seconds() - start;
    }

    models::FrameBody &body() { return *body_; }
    double setup_seconds() const { return setup_seconds_; }
    const std::vector<double> &frame_seconds() const { return frame_seconds_; }

    /// Median, 95th percentile and maximum of the frames, in the members of a run with these names.
    template <class Run> void describe_times(Run &run) const {
        run.setup_seconds = setup_seconds_;
        run.frame_seconds = results::median(frame_seconds_);
        run.frame_seconds_95 = results::quantile(frame_seconds_, 0.95);
        run.worst_frame_seconds = *std::ranges::max_element(frame_seconds_);
    }

  private:
    std::unique_ptr<models::FrameBody> body_;
    models::Effort effort_;
    double bound_; ///< [m]
    double setup_seconds_ = 0.0;
    std::vector<double> frame_seconds_;
    std::optional<std::vector<core::Vector3>> displacement_; ///< nothing before it is asked for
};

/// A body on one of the meshes of an arena. Its first nodes are those of the reference.
struct ArenaScene {
    core::Problem problem;
    const core::TetraMesh *mesh_of_reference = nullptr;
    const core::ToolHistory *reference = nullptr; ///< null if there is none: errors are NaN then
    std::vector<double> reference_volume_change;  ///< (F) of the mesh of the reference; empty if there is none
};

/// The size of the force on a tool when its slide begins [N].
/// @param force  (K) at the records of the motion
double pressed_force(const core::ToolMotion &motion, const std::vector<core::Vector3> &force);

/// A method through the whole motion, judged, with all budgets and settings on one mesh. What has no choice of its
/// effort moves once, or twice where its steps have to be halved.
std::vector<results::ArenaRun> run_budgets(const models::MovingMethod &method, const ArenaScene &scene,
                                           const std::vector<double> &budgets);

/// The same with given numbers of iterations.
std::vector<results::ArenaRun> run_series(const models::MovingMethod &method, const ArenaScene &scene,
                                          const std::vector<int> &iterations);

/// (F) change of volume at each field, of the mesh whose nodes they are.
std::vector<double> volume_changes(const core::TetraMesh &mesh, const core::ToolHistory &history);

/// Volumes and inverted tetrahedra of a motion of the nodes of the reference.
void judge_shape(results::ArenaRun &run, const core::TetraMesh &mesh, const core::ToolHistory &history,
                 const core::ToolHistory &reference);

} // namespace livermark::studies
