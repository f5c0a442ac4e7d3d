#include "studies/cutting/moving_cut.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <limits>
#include <utility>

#include "core/support/input_error.hpp"
#include "studies/arena/arena_problems.hpp"
#include "studies/arena/frame_loop.hpp"
#include "studies/models/motion/moving_method.hpp"

namespace livermark::studies {

namespace {

using models::Effort;

constexpr const char *all_under_blade = "all";
constexpr int most_frames_per_step = 1000;

/// Methods that can be cut, in the order of the table.
std::vector<models::MovingMethod> methods_under_blade() {
    auto methods = models::all_moving_methods();
    std::erase_if(methods, [](const models::MovingMethod &method) { return method.is_scaled; });
    return methods;
}

class MotionUnderBlade {
  public:
    MotionUnderBlade(const models::MovingMethod &method, const models::FramesUnderBlade &frames, int frames_per_step,
                     const std::vector<CutStage> &stages, const std::vector<core::Problem> &problems,
                     const std::vector<models::NodalProblem> &on_nodes)
        : method_(&method), frames_(frames), frames_per_step_(frames_per_step), stages_(&stages), problems_(&problems),
          on_nodes_(&on_nodes) {}

    results::CutMotion run(const Effort &effort, const char *setting, double budget) {
        results::CutMotion motion{.method = method_->name,
                                  .setting = setting,
                                  .budget = budget,
                                  .steps = effort.steps,
                                  .iterations = effort.iterations};
        const std::size_t num_records = stages_->size();
        motion.ready_seconds.assign(num_records, 0.0);
        TimedBody moving([&] { return method_->under_blade(on_nodes_->front(), frames_); }, effort,
                         stages_->front().body->mesh.points);
        double worst = 0.0;
        const auto move = [&](int num_frames, double before = 0.0) { // the time of a cut counts for the frame after it
            for (int f = 0; f < num_frames; ++f) {
                moving.advance();
                worst = std::max(worst, moving.frame_seconds().back() + std::exchange(before, 0.0));
            }
        };
        move(frames_to_rest);
        record(motion, moving, 0);
        for (std::size_t k = 1; k < num_records; ++k) {
            if (!(*stages_)[k].parents.empty())
                motion.ready_seconds[k] =
                    moving.time([&](models::FrameBody &body) { body.cut((*on_nodes_)[k], (*stages_)[k].parents); });
            move(frames_per_step_, motion.ready_seconds[k]);
            if (k + 1 == num_records)
                move(frames_to_rest);
            if (!record(motion, moving, k))
                break;
        }
        for (auto *row : {&motion.opening, &motion.tool_stiffness})
            row->resize(num_records, std::numeric_limits<double>::quiet_NaN());
        motion.setup_seconds = moving.setup_seconds();
        motion.frame_seconds = results::median(moving.frame_seconds());
        motion.worst_frame_seconds = worst;
        return motion;
    }

  private:
    /// @return whether the body is within bounds
    bool record(results::CutMotion &motion, TimedBody &moving, std::size_t k) const {
        if (!moving.is_within_bounds())
            return false;
        core::Solution solution;
        solution.displacement = moving.displacement();
        motion.opening.push_back(opening((*stages_)[k], solution.displacement));
        motion.tool_stiffness.push_back(stiffness_at_first_tool((*problems_)[k], solution));
        return true;
    }

    const models::MovingMethod *method_;
    models::FramesUnderBlade frames_;
    int frames_per_step_;
    const std::vector<CutStage> *stages_;
    const std::vector<core::Problem> *problems_;
    const std::vector<models::NodalProblem> *on_nodes_;
};

bool has_ended_within_bounds(const results::CutMotion &motion) {
    return motion.opening.back() == motion.opening.back(); // no NaN
}

} // namespace

std::vector<std::string> chosen_methods_under_blade(const CutMotionOptions &options) {
    const auto methods = methods_under_blade();
    std::vector<std::string> chosen;
    for (const auto &name : options.methods)
        if (name != all_under_blade)
            support::find_named(methods, name, "method");
    for (const auto &method : methods)
        if (std::ranges::any_of(options.methods, [&](const std::string &name) {
                return name == method.name || name == all_under_blade;
            }))
            chosen.push_back(method.name);
    if (chosen.empty())
        return chosen;
    if (options.budgets.empty() || !std::ranges::all_of(options.budgets, [](double budget) { return budget > 0.0; }))
        throw support::InputError("--budget is empty or has a time that is not above 0 ms; give times above 0");
    if (options.frames_per_step < 1 || options.frames_per_step > most_frames_per_step)
        throw support::InputError(
            fmt::format("--frames is {}; give 1 to {}", options.frames_per_step, most_frames_per_step));
    return chosen;
}

void check_loads_of_motion(const core::Problem &problem) {
    refuse_single_components(problem.load_case);
    for (const core::Vector3 &displacement : models::on_nodes(problem).conditions.displacement) {
        const bool is_constrained = !displacement.array().isNaN().any();
        if (is_constrained && !displacement.isZero(0.0))
            throw support::InputError(fmt::format("load case {} displaces a place, which would jump when the motion "
                                                  "begins; choose one with tractions or forces for --method",
                                                  problem.load_case.name));
    }
}

std::vector<results::CutMotion> move_under_blade(const CutMotionOptions &options, const std::vector<CutStage> &stages,
                                                 const std::vector<core::Problem> &problems,
                                                 const ProgressReport &report) {
    const models::FramesUnderBlade frames;
    auto budgets = options.budgets;
    std::ranges::sort(budgets);
    const auto names = chosen_methods_under_blade(options);
    std::vector<models::NodalProblem> on_nodes;
    for (std::size_t k = 0; k < problems.size(); ++k)
        on_nodes.push_back(k > 0 && stages[k].parents.empty() ? on_nodes.back() : models::on_nodes(problems[k]));
    std::vector<results::CutMotion> motions;
    Steps steps(static_cast<int>(names.size()), report);
    const auto all_methods = methods_under_blade();
    for (const auto &name : names) {
        steps.next(fmt::format("{} / {} moves under the blade", problems.front().body->name, name));
        const auto &method = support::find_named(all_methods, name, "method");
        MotionUnderBlade motion(method, frames, options.frames_per_step, stages, problems, on_nodes);
        const auto measured = method.under_blade(on_nodes.front(), frames);
        if (const auto least = measured->least_effort()) {
            auto run = motion.run(*least, stable_setting, 0.0);
            // What is stable at rest need not be so at a wound.
            if (!has_ended_within_bounds(run))
                run = motion.run(twice(*least), half_steps_setting, 0.0);
            const auto fits = std::ranges::lower_bound(budgets, run.frame_seconds);
            run.budget = fits == budgets.end() ? budgets.back() : *fits;
            motions.push_back(std::move(run));
            continue;
        }
        const auto frame = [&](const Effort &effort) { measured->advance({}, effort); };
        for (const double budget : budgets)
            for (const auto setting : models::all_settings)
                if (const auto fits = largest_effort(frame, setting, budget))
                    motions.push_back(motion.run(fits->effort, models::to_string(setting), budget));
    }
    return motions;
}

} // namespace livermark::studies
