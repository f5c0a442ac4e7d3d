#include "studies/arena/needle_run.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/tool/needle/needle_line.hpp"
#include "results/quantile.hpp"
#include "studies/arena/frame_loop.hpp"

namespace livermark::studies {

namespace {

using models::Effort;

constexpr double not_known = std::numeric_limits<double>::quiet_NaN();
/// Every so many frames are timed without the needle as well; the first of two is not, since it fetches the body.
constexpr int frames_per_comparison = 10;
/// Times are measured with the needle this part of its way in, led there in frames of a quick hand.
constexpr double part_to_measure = 0.5;
constexpr int frames_to_get_there = 40;

/// A row of records of the static needle at the depths of a plan.
template <class T>
std::vector<T> at_depths(const core::Insertion &insertion, const std::vector<T> &of_records,
                         const models::NeedlePlan &plan, const core::Needle &needle) {
    std::vector<T> result;
    const int last = insertion.num_records() - 1, in = plan.at_plan(needle);
    const int out_from = plan.num_frames(needle) - in;
    for (int frame = 0; frame <= plan.num_frames(needle); ++frame) {
        const double depth = plan.depth_after(needle, frame);
        int j = frame <= out_from ? 0 : insertion.at_plan;
        const int end = frame <= out_from ? insertion.at_plan : last;
        const auto is_behind = [&](int record) {
            return frame <= out_from ? insertion.depth[record] <= depth : insertion.depth[record] >= depth;
        };
        while (j < end && is_behind(j + 1))
            ++j;
        if (j == end) {
            result.push_back(of_records[j]);
            continue;
        }
        const double part = (depth - insertion.depth[j]) / (insertion.depth[j + 1] - insertion.depth[j]);
        result.push_back((1.0 - part) * of_records[j] + part * of_records[j + 1]);
    }
    return result;
}

std::vector<double> depths_of(const models::NeedlePlan &plan, const core::Needle &needle) {
    std::vector<double> depth;
    for (int frame = 0; frame <= plan.num_frames(needle); ++frame)
        depth.push_back(plan.depth_after(needle, frame));
    return depth;
}

/// One after each frame.
class NeedleRecorder {
  public:
    NeedleRecorder(const NeedleScene &scene, results::NeedleArenaRun &run)
        : scene_(scene), run_(run), target_(static_cast<std::size_t>(core::needle_line(scene.needle).target)) {}

    /// @return false if the body has left all bounds
    bool record(TimedBody &moving) {
        if (!moving.is_within_bounds())
            return false;
        auto reading = moving.body().reading();
        run_.force.push_back(reading.force);
        run_.tip.push_back(reading.tip);
        run_.target.push_back(reading.places[target_]);
        if (static_cast<int>(run_.force.size()) == scene_.arena.at_plan + 1)
            at_plan_ = std::move(reading.places);
        return true;
    }

    void finish() {
        const auto count = scene_.arena.depth.size(), at_plan = static_cast<std::size_t>(scene_.arena.at_plan);
        const bool is_whole = run_.force.size() == count;
        run_.force.resize(count, not_known);
        run_.tip.resize(count, not_known);
        run_.target.resize(count, core::Vector3::Constant(not_known));
        run_.target_error = run_.path_error = not_known;
        run_.forces = {.peak = not_known, .slope = not_known, .pull = not_known};
        if (!is_whole) {
            run_.outcome = results::ArenaOutcome::diverged;
            return;
        }
        run_.target_error = (run_.target[at_plan] - scene_.arena.reference_target[at_plan]).norm();
        double difference = 0.0, size = 0.0;
        for (std::size_t k = 0; k < at_plan_.size(); ++k) {
            difference += (at_plan_[k] - scene_.reference_places[k]).squaredNorm();
            size += scene_.reference_places[k].squaredNorm();
        }
        run_.path_error = std::sqrt(difference / size);
        run_.forces = results::needle_forces(scene_.arena.depth, run_.force, scene_.arena.at_plan);
    }

  private:
    const NeedleScene &scene_;
    results::NeedleArenaRun &run_;
    std::size_t target_;
    std::vector<core::Vector3> at_plan_;
};

results::NeedleArenaRun run_with_needle(const models::MovingMethod &method, const NeedleScene &scene,
                                        const Effort &effort) {
    results::NeedleArenaRun run;
    run.method = method.name;
    run.tetrahedra = static_cast<int>(scene.problem.body->mesh.tetrahedra.size());
    run.steps = effort.steps;
    run.iterations = effort.iterations;
    const auto prepare = [&] { return method.with_needle(scene.problem, scene.needle, scene.plan); };
    TimedBody moving(prepare, effort, scene.problem.body->mesh.points),
        alone(prepare, effort, scene.problem.body->mesh.points);
    NeedleRecorder recorder(scene, run);
    std::vector<double> with, without; // the needle, by turns [s]
    bool is_within = recorder.record(moving);
    const auto num_frames = static_cast<int>(scene.arena.depth.size()) - 1;
    for (int frame = 1; frame <= num_frames && is_within; ++frame) {
        moving.advance({.depth = scene.arena.depth[static_cast<std::size_t>(frame)]});
        is_within = recorder.record(moving);
        if (!is_within || frame % frames_per_comparison != 0)
            continue;
        const auto advance_alone = [&](models::FrameBody &body) { body.advance_alone(effort); };
        alone.body().take_motion_of(moving.body());
        advance_alone(alone.body());
        without.push_back(alone.time(advance_alone));
        with.push_back(moving.frame_seconds().back());
    }
    recorder.finish();
    moving.describe_times(run);
    run.cost_ratio = with.empty() ? not_known : results::median(with) / results::median(without);
    return run;
}

} // namespace

results::NeedleArena empty_needle_arena(const core::Needle &needle, const models::NeedlePlan &plan,
                                        const core::Insertion &reference, const core::Insertion *coarser) {
    results::NeedleArena arena;
    arena.speed = plan.speed;
    arena.rest = plan.rest;
    arena.mass_damping = plan.mass_damping;
    arena.frame_interval = plan.frame_interval;
    arena.at_plan = plan.at_plan(needle);
    arena.depth = depths_of(plan, needle);
    arena.reference_force = at_depths(reference, reference.force, plan, needle);
    arena.reference_target = at_depths(reference, reference.target, plan, needle);
    arena.reference_forces = results::needle_forces(arena.depth, arena.reference_force, arena.at_plan);
    if (coarser) {
        const auto before =
            results::needle_forces(arena.depth, at_depths(*coarser, coarser->force, plan, needle), arena.at_plan);
        arena.reference_changes = {.peak = std::abs(arena.reference_forces.peak - before.peak),
                                   .slope = std::abs(arena.reference_forces.slope - before.slope),
                                   .pull = std::abs(arena.reference_forces.pull - before.pull)};
    }
    return arena;
}

std::vector<results::NeedleArenaRun> run_needle_budgets(const models::MovingMethod &method, const NeedleScene &scene,
                                                        const std::vector<double> &budgets) {
    const auto measured = method.with_needle(scene.problem, scene.needle, scene.plan);
    const double depth = part_to_measure * scene.needle.depth();
    if (!measured->least_effort())
        for (int frame = 1; frame <= frames_to_get_there; ++frame)
            measured->advance({.depth = depth * frame / frames_to_get_there}, {});
    return runs_within_budgets(
        *measured, [&](const Effort &each) { measured->advance({.depth = depth}, each); }, budgets, false,
        [&](const Effort &effort) { return run_with_needle(method, scene, effort); });
}

} // namespace livermark::studies
