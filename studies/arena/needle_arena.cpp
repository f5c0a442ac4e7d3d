#include "studies/arena/arena.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <optional>
#include <utility>

#include "core/support/input_error.hpp"
#include "core/tool/needle/needle.hpp"
#include "results/one_reference.hpp"
#include "results/records/needle.hpp"
#include "results/records/result.hpp"
#include "studies/arena/arena_run.hpp"
#include "studies/models/motion/moving_method.hpp"
#include "studies/needle/needle_study.hpp"
#include "studies/study.hpp"

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
std::vector<T> at_depths(const core::Insertion &insertion, const std::vector<T> &record_values,
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
            result.push_back(record_values[j]);
            continue;
        }
        const double part = (depth - insertion.depth[j]) / (insertion.depth[j + 1] - insertion.depth[j]);
        result.push_back((1.0 - part) * record_values[j] + part * record_values[j + 1]);
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

constexpr const char *needle_obstacle =
    "the masses of its stiff parts are scaled, and impulses of a needle are those of true masses";

/// Methods that move, and why others do not.
struct ChosenMethods {
    std::vector<models::MovingMethod> methods;
    std::vector<results::LeftOut> left_out;
};

ChosenMethods chosen_methods_with_needle(const std::vector<std::string> &names) {
    ChosenMethods chosen;
    auto all = models::all_moving_methods();
    for (const auto &name : names)
        support::find_named(all, name, "method");
    for (auto &method : all) {
        const bool is_asked_for = std::ranges::find(names, method.name) != names.end();
        if (names.empty() ? method.only_when_named : !is_asked_for)
            continue;
        if (!method.is_scaled)
            chosen.methods.push_back(std::move(method));
        else if (is_asked_for)
            throw support::InputError(
                fmt::format("{} holds no needle, because {}; leave it out", method.name, needle_obstacle));
        else
            chosen.left_out.push_back({method.name, needle_obstacle});
    }
    return chosen;
}

std::vector<core::Needle> chosen_needles(const NeedleProblem &problem, const std::vector<std::string> &names) {
    if (names.empty())
        return problem.needles;
    std::vector<core::Needle> chosen;
    for (const auto &name : names)
        chosen.push_back(support::find_named(problem.needles, name, "needle of the load case"));
    return chosen;
}

/// The tip moves on by half the distance of two places at most in a step, which is a frame in implicit methods.
void refuse_too_fast(const core::Needle &needle, const models::NeedlePlan &plan) {
    constexpr double largest_part = 0.4;
    const double fastest = largest_part * core::needle_line(needle).spacing / plan.frame_interval;
    if (plan.speed > fastest)
        throw support::InputError(fmt::format("'{}' is led at {:.3g} m/s, and forces that are spread over {:.3g} m "
                                              "follow no more than {:.3g} m/s; give a lower --speed",
                                              needle.name, plan.speed, needle.spread, fastest));
}

/// Knowledge of a needle without methods.
struct ReferenceOfNeedle {
    results::NeedleStudy study; ///< with an arena
    std::vector<core::Vector3> places;
};

ReferenceOfNeedle reference_of_needle(const core::Problem &problem, const core::Needle &needle,
                                      const models::NeedlePlan &plan, const core::Model &model) {
    const auto line = core::needle_line(needle);
    const auto compliance = model.compliance(problem, line.places);
    results::NeedleStudy study{.needle = needle, .runs = {}};
    study.runs.push_back({model.name, insert(compliance.matrix, line, needle), compliance.seconds});
    study.runs.front().note_limit(results::largest_small_displacement(problem));
    const auto &insertion = study.runs.front().insertion;
    std::optional<core::Insertion> coarser;
    if (!compliance.on_coarser.empty()) {
        coarser = insert(compliance.on_coarser.back(), line, needle);
        study.reference_miss_change = (insertion.target[insertion.at_plan] - coarser->target[coarser->at_plan]).norm();
        study.reference_force_change = results::force_error(*coarser, insertion);
    }
    study.arena = empty_needle_arena(needle, plan, insertion, coarser ? &*coarser : nullptr);
    auto places = insertion.places;
    return {std::move(study), std::move(places)};
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

Found<results::NeedleFile> run_needle_arena(const ArenaOptions &options, const NeedleArenaOptions &needle_options,
                                            const std::string &command_line, const ProgressReport &report) {
    const auto [methods, left_out] = chosen_methods_with_needle(options.methods);
    const auto reference = needle_reference_model(needle_options.reference_on_mesh);
    const models::NeedlePlan plan{.speed = needle_options.speed, .rest = needle_options.rest};
    Found<results::NeedleFile> done;
    const auto problems = read_with_needles({.bodies = options.bodies,
                                             .load_case = options.load_case,
                                             .models = {},
                                             .material = options.material,
                                             .output = {}},
                                            done.notes);
    std::size_t num_needles = 0;
    for (const auto &problem : problems) {
        refuse_single_components(problem.problem.load_case);
        for (const auto &needle : chosen_needles(problem, needle_options.needles)) {
            refuse_too_fast(needle, plan);
            ++num_needles;
        }
    }
    Steps steps(static_cast<int>(num_needles * (1 + methods.size() * options.meshes.size())), report);
    for (const auto &with_needles : problems) {
        const auto &problem = with_needles.problem;
        const OutputFile output(options.output, problem, fmt::format("needle_arena.{}.h5", problem.load_case.name));
        results::NeedleFile file{.provenance = results::current_provenance(command_line),
                                 .body = problem.body->name,
                                 .load_case = problem.load_case.name,
                                 .title = problem.load_case.title,
                                 .needles = {}};
        for (const auto &needle : chosen_needles(with_needles, needle_options.needles)) {
            steps.next(fmt::format("{} / {} / {}", problem.body->name, needle.name, reference.name));
            auto [study, places] = reference_of_needle(problem, needle, plan, reference);
            study.arena->left_out = left_out;
            for (const int mesh : options.meshes) {
                const auto on_mesh = on_arena_mesh(problem, mesh);
                const NeedleScene scene{on_mesh, needle, plan, *study.arena, places};
                for (const auto &method : methods) {
                    steps.next(fmt::format("{} / {} / {} tetrahedra / {}", problem.body->name, needle.name,
                                           on_mesh.body->mesh.tetrahedra.size(), method.name));
                    std::ranges::move(run_needle_budgets(method, scene, options.budgets),
                                      std::back_inserter(study.arena->runs));
                }
            }
            file.needles.push_back(std::move(study));
        }
        results::write_needles(output.path(), file);
        done.records.push_back(std::move(file));
    }
    return done;
}

} // namespace livermark::studies
