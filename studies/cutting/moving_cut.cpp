#include "studies/cutting/moving_cut.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <limits>
#include <memory>
#include <utility>

#include "core/mesh/bounding_box.hpp"
#include "core/processor_time.hpp"
#include "models/cut_motion/body_under_blade.hpp"
#include "results/quantile.hpp"
#include "studies/arena/arena_run.hpp"
#include "studies/arena/whole_nodes.hpp"
#include "support/input_error.hpp"
#include "support/known_names.hpp"

namespace livermark::studies {

namespace {

using models::Effort;

constexpr const char *all_under_blade = "all";
/// A motion beyond this many times the size of the body has diverged.
constexpr double bound_under_blade = 1.0;
constexpr int most_frames_per_step = 1000;

class MotionUnderBlade {
  public:
    MotionUnderBlade(const models::MethodUnderBlade &method, const models::FramesUnderBlade &frames,
                     int frames_per_step, const std::vector<CutStage> &stages,
                     const std::vector<core::Problem> &problems, const std::vector<models::ProblemOnNodes> &on_nodes)
        : method_(&method), frames_(frames), frames_per_step_(frames_per_step), stages_(&stages), problems_(&problems),
          on_nodes_(&on_nodes), bound_(bound_under_blade * core::extent(stages.front().body->mesh.points)) {}

    results::CutMotion run(const Effort &effort, const char *setting, double budget) {
        results::CutMotion motion{.method = method_->name,
                                  .setting = setting,
                                  .budget = budget,
                                  .steps = effort.steps,
                                  .iterations = effort.iterations};
        const std::size_t num_records = stages_->size();
        motion.ready_seconds.assign(num_records, 0.0);
        double start = core::processor_seconds();
        const auto body = method_->prepare(on_nodes_->front(), frames_);
        body->prepare_for(effort);
        motion.setup_seconds = core::processor_seconds() - start;
        frame_seconds_.clear();
        worst_ = 0.0;
        move(*body, effort, frames_to_rest, 0.0);
        record(motion, *body, 0);
        for (std::size_t k = 1; k < num_records; ++k) {
            if (!(*stages_)[k].parents.empty()) {
                start = core::processor_seconds();
                body->cut((*on_nodes_)[k], (*stages_)[k].parents);
                motion.ready_seconds[k] = core::processor_seconds() - start;
            }
            move(*body, effort, frames_per_step_, motion.ready_seconds[k]);
            if (k + 1 == num_records)
                move(*body, effort, frames_to_rest, 0.0);
            if (!record(motion, *body, k))
                break;
        }
        for (auto *row : {&motion.opening, &motion.tool_stiffness})
            row->resize(num_records, std::numeric_limits<double>::quiet_NaN());
        motion.frame_seconds = results::median(frame_seconds_);
        motion.worst_frame_seconds = worst_;
        return motion;
    }

  private:
    /// @param before  the time of the cut that the first frame comes after [s]
    void move(models::BodyUnderBlade &body, const Effort &effort, int num_frames, double before) {
        for (int f = 0; f < num_frames; ++f) {
            const double start = core::processor_seconds();
            body.advance(0.0, effort);
            frame_seconds_.push_back(core::processor_seconds() - start);
            worst_ = std::max(worst_, frame_seconds_.back() + std::exchange(before, 0.0));
        }
    }

    /// @return whether the body is within bounds
    bool record(results::CutMotion &motion, const models::BodyUnderBlade &body, std::size_t k) const {
        core::Solution solution;
        solution.displacement = body.displacement();
        if (!std::ranges::all_of(solution.displacement, [&](const core::Vector3 &u) {
                return u.lpNorm<Eigen::Infinity>() < bound_; // NaN is not
            }))
            return false;
        motion.opening.push_back(opening((*stages_)[k], solution.displacement));
        motion.tool_stiffness.push_back(stiffness_at_first_tool((*problems_)[k], solution));
        return true;
    }

    const models::MethodUnderBlade *method_;
    models::FramesUnderBlade frames_;
    int frames_per_step_;
    const std::vector<CutStage> *stages_;
    const std::vector<core::Problem> *problems_;
    const std::vector<models::ProblemOnNodes> *on_nodes_;
    double bound_;
    std::vector<double> frame_seconds_;
    double worst_ = 0.0;
};

bool has_ended_within_bounds(const results::CutMotion &motion) {
    return motion.opening.back() == motion.opening.back(); // no NaN
}

} // namespace

std::vector<std::string> chosen_methods_under_blade(const CutMotionOptions &options) {
    const auto methods = models::methods_under_blade();
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
    std::vector<models::ProblemOnNodes> on_nodes;
    for (std::size_t k = 0; k < problems.size(); ++k)
        on_nodes.push_back(k > 0 && stages[k].parents.empty() ? on_nodes.back() : models::on_nodes(problems[k]));
    std::vector<results::CutMotion> motions;
    Steps steps(static_cast<int>(names.size()), report);
    const auto all_methods = models::methods_under_blade();
    for (const auto &name : names) {
        steps.next(fmt::format("{} / {} moves under the blade", problems.front().body->name, name));
        const auto &method = support::find_named(all_methods, name, "method");
        MotionUnderBlade motion(method, frames, options.frames_per_step, stages, problems, on_nodes);
        const auto measured = method.prepare(on_nodes.front(), frames);
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
        const auto frame = [&](const Effort &effort) { measured->advance(0.0, effort); };
        for (const double budget : budgets)
            for (const auto setting : models::all_settings)
                if (const auto fits = largest_effort(frame, setting, budget))
                    motions.push_back(motion.run(fits->effort, models::to_string(setting), budget));
    }
    return motions;
}

} // namespace livermark::studies
