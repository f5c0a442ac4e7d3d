#include "studies/arena/needle/needle_run.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include "core/mesh/bounding_box.hpp"
#include "core/processor_time.hpp"
#include "core/tool/needle/needle_line.hpp"
#include "results/quantile.hpp"
#include "studies/arena/arena_run.hpp"

namespace livermark::studies {

namespace {

using models::Effort;
using models::NeedledBody;

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

/// What a frame costs with the needle and without, by turns.
struct FrameCosts {
    std::vector<double> all;           ///< of every frame with it [s]
    std::vector<double> with, without; ///< of those that were compared [s]

    /// Not of the first frames, before which nothing moves.
    void compare(const NeedledBody &body, NeedledBody &alone, const Effort &effort) {
        alone.take_motion_of(body);
        alone.advance_alone(effort);
        const double start = core::processor_seconds();
        alone.advance_alone(effort);
        without.push_back(core::processor_seconds() - start);
        with.push_back(all.back());
    }
};

/// One after each frame.
class NeedleRecorder {
  public:
    NeedleRecorder(const NeedleScene &scene, results::NeedleArenaRun &run)
        : scene_(scene), run_(run), bound_(core::extent(scene.problem.body->mesh.points)),
          target_(static_cast<std::size_t>(core::needle_line(scene.needle).target)) {}

    /// @return false if the body has left all bounds
    bool record(const NeedledBody &body) {
        const auto displacement = body.displacement();
        if (!std::ranges::all_of(displacement,
                                 [&](const core::Vector3 &u) { return u.lpNorm<Eigen::Infinity>() < bound_; }))
            return false;
        auto reading = body.reading();
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
    double bound_; ///< a displacement beyond it is no motion any more [m]
    std::size_t target_;
    std::vector<core::Vector3> at_plan_;
};

results::NeedleArenaRun run_needled_method(const models::NeedledMethod &method, const NeedleScene &scene,
                                           const Effort &effort) {
    results::NeedleArenaRun run;
    run.method = method.texts.name;
    run.tetrahedra = static_cast<int>(scene.problem.body->mesh.tetrahedra.size());
    run.steps = effort.steps;
    run.iterations = effort.iterations;
    const double start = core::processor_seconds();
    const auto body = method.prepare(scene.problem, scene.needle, scene.plan);
    body->prepare_for(effort);
    run.setup_seconds = core::processor_seconds() - start;
    const auto alone = method.prepare(scene.problem, scene.needle, scene.plan);
    alone->prepare_for(effort);

    NeedleRecorder recorder(scene, run);
    FrameCosts costs;
    bool is_within = recorder.record(*body);
    const auto num_frames = static_cast<int>(scene.arena.depth.size()) - 1;
    for (int frame = 1; frame <= num_frames && is_within; ++frame) {
        const double before = core::processor_seconds();
        body->advance(scene.arena.depth[static_cast<std::size_t>(frame)], effort);
        costs.all.push_back(core::processor_seconds() - before);
        is_within = recorder.record(*body);
        if (is_within && frame % frames_per_comparison == 0)
            costs.compare(*body, *alone, effort);
    }
    recorder.finish();
    run.frame_seconds = results::median(costs.all);
    run.frame_seconds_95 = results::quantile(costs.all, 0.95);
    run.worst_frame_seconds = *std::ranges::max_element(costs.all);
    run.cost_ratio = costs.with.empty() ? not_known : results::median(costs.with) / results::median(costs.without);
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

std::vector<results::NeedleArenaRun> run_needle_budgets(const models::NeedledMethod &method, const NeedleScene &scene,
                                                        const std::vector<double> &budgets) {
    std::vector<results::NeedleArenaRun> runs;
    const auto measured = method.prepare(scene.problem, scene.needle, scene.plan);
    if (const auto least = measured->least_effort()) {
        auto run = run_needled_method(method, scene, *least);
        const char *setting = stable_setting;
        if (run.outcome == results::ArenaOutcome::diverged) { // what is pressed in is stiffer than at rest
            run = run_needled_method(method, scene, twice(*least));
            setting = half_steps_setting;
        }
        for (const double budget : budgets)
            runs.push_back(within_budget(run, setting, budget, run.frame_seconds));
        return runs;
    }
    const double depth = part_to_measure * scene.needle.depth();
    for (int frame = 1; frame <= frames_to_get_there; ++frame)
        measured->advance(depth * frame / frames_to_get_there, {});
    for (const auto setting : models::all_settings)
        for (const double budget : budgets) {
            const auto fits =
                largest_effort([&](const Effort &each) { measured->advance(depth, each); }, setting, budget);
            if (!fits)
                continue;
            auto run = run_needled_method(method, scene, fits->effort);
            run.calibration_spread = fits->spread;
            run.stops_early = fits->stops_early ? 1 : 0;
            runs.push_back(within_budget(std::move(run), models::to_string(setting), budget, fits->seconds));
        }
    return runs;
}

} // namespace livermark::studies
