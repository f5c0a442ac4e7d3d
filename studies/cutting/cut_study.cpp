#include "studies/cutting/cut_study.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <memory>
#include <optional>
#include <utility>

#include "core/support/input_error.hpp"
#include "core/tool/tool_stiffness.hpp"
#include "load_cases/readers/load_case_reader.hpp"
#include "meshes/cutting/cut.hpp"
#include "msm/springs/springs.hpp"
#include "results/records/cut.hpp"
#include "results/records/result.hpp"
#include "studies/advise/advise.hpp"
#include "studies/models/model_table.hpp"
#include "studies/models/motion/frame_body.hpp"
#include "studies/run/run.hpp"
#include "studies/study.hpp"

namespace livermark::studies {

namespace {

constexpr std::size_t numbers_of_blade = 12;
constexpr int most_steps_of_blade = 1000;
constexpr int least_refined_for_order = 2, most_refined = 4;
constexpr double unknown_of_cut = std::numeric_limits<double>::quiet_NaN();

BladeWay way_of(const CutStudyOptions &options) {
    if (options.blade.size() != numbers_of_blade)
        throw support::InputError(
            fmt::format("--blade has {} numbers; give four corners, twelve", options.blade.size()));
    if (options.num_steps < 1 || options.num_steps > most_steps_of_blade)
        throw support::InputError(fmt::format("--steps is {}; give 1 to {}", options.num_steps, most_steps_of_blade));
    if (!(options.toughness >= 0.0) || !std::isfinite(options.toughness))
        throw support::InputError(fmt::format("--toughness is {} J/m^2; give 0 or more", options.toughness));
    if (options.num_refined != 0 &&
        (options.num_refined < least_refined_for_order || options.num_refined > most_refined))
        throw support::InputError(fmt::format("--refine is {}; give 0 for no error bar, or {} to {}",
                                              options.num_refined, least_refined_for_order, most_refined));
    BladeWay way{.corners = {}, .num_steps = options.num_steps};
    for (std::size_t k = 0; k < numbers_of_blade; ++k)
        way.corners[k / 3][static_cast<Eigen::Index>(k % 3)] = options.blade[k];
    return way;
}

void refuse_other_loads(const core::LoadCase &load_case) {
    if (!load_case.acceleration.isZero(0.0))
        throw support::InputError(fmt::format("load case {} has an acceleration, whose work not all models compute; "
                                              "choose one with tractions, forces or prescribed displacements",
                                              load_case.name));
    if (load_case.has(core::ConditionKind::pressure) || load_case.press_depth != 0.0 || !load_case.kinds().empty())
        throw support::InputError(fmt::format("load case {} has loads that change while the blade goes in; choose one "
                                              "with tractions, forces or prescribed displacements",
                                              load_case.name));
}

/// The reference on the mesh first, then those that were asked for, each once.
std::vector<core::Model> models_under_blade(const CutStudyOptions &options, const core::Problem &problem) {
    const auto regime = problem.load_case.regime;
    const auto all = models::all_models();
    std::vector<core::Model> chosen{
        support::find_named(all, models::static_reference(regime).on_mesh, "reference of the regime")};
    const auto add = [&](const core::Model &model) {
        if (std::ranges::find(chosen, model.name, &core::Model::name) == chosen.end())
            chosen.push_back(model);
    };
    for (const auto &name : options.models) {
        const auto &model = support::find_named(all, name, "model");
        if (!model.takes_part_in(problem) || model.only_moving)
            throw support::InputError(
                fmt::format("model {} takes no part in load case {} in the {} regime; leave it out, or choose the "
                            "other regime",
                            name, problem.load_case.name, core::to_string(regime)));
        add(model);
    }
    if (options.models.empty())
        for (const auto &model : all)
            if (!model.only_when_named && !model.only_moving && model.takes_part_in(problem) &&
                model.at_rest != core::Role::refined_reference)
                add(model);
    for (const auto &model : chosen)
        if (model.check)
            model.check(problem);
    return chosen;
}

/// The loads of the body before it was cut, on a body that is.
class SameLoads {
  public:
    /// @param before  with the loads as they are to be
    SameLoads(std::filesystem::path file, const core::LoadCase &before)
        : file_(std::move(file)), scale_(before.load_scale), regime_(before.regime) {}

    core::Problem on(const std::shared_ptr<const core::Body> &body) const {
        auto load_case = load_cases::read_load_case(file_, *body);
        load_case.scale_to_target = false;
        load_case.regime = regime_;
        return {body, core::scaled(std::move(load_case), scale_)};
    }

  private:
    std::filesystem::path file_;
    double scale_;
    core::Regime regime_;
};

/// Work of the given tractions [J].
double work_of_loads(const core::Problem &problem, const core::Solution &solution) {
    if (!std::isnan(solution.load_work))
        return solution.load_work;
    const auto &mesh = problem.body->mesh;
    double work = 0.0;
    for (const auto &place : core::tool_places(mesh, problem.load_case))
        if (place.drive == core::ToolDrive::traction)
            work += core::work_of(core::nodal_forces(mesh, problem.load_case, place), solution.displacement);
    return work;
}

/// One model while the blade goes on.
class ModelUnderBlade {
  public:
    explicit ModelUnderBlade(core::Model model) : model_(std::move(model)), run_{.model = model_.name} {}

    /// @param stage  another one than the last
    /// @return where the nodes are
    std::vector<core::Vector3> solve(const CutStage &stage, const SameLoads &loads, bool has_to_succeed) {
        const auto problem = loads.on(stage.body);
        auto solution = model_.solve(problem);
        run_.setup_seconds.push_back(solution.setup_seconds);
        run_.solve_seconds.push_back(solution.setup_seconds + solution.solve_seconds);
        if (solution.status != core::SolutionStatus::ok) {
            const auto sentence = fmt::format("{} finds no equilibrium with the blade {:.3g} mm deep: {}", model_.name,
                                              1e3 * stage.depth, solution.message);
            if (has_to_succeed)
                throw support::InputError(sentence + "; take smaller loads");
            notes_.push_back(sentence);
            add(unknown_of_cut, unknown_of_cut, unknown_of_cut, unknown_of_cut);
            return {};
        }
        add(solution.strain_energy, work_of_loads(problem, solution), opening(stage, solution.displacement),
            stiffness_at_first_tool(problem, solution));
        return std::move(solution.displacement);
    }

    /// A step that has parted nothing.
    void stay() {
        add(run_.stored.back(), run_.work.back(), run_.opening.back(), run_.tool_stiffness.back());
        run_.setup_seconds.push_back(0.0);
        run_.solve_seconds.push_back(0.0);
    }

    const core::Model &model() const { return model_; }
    const std::string &name() const { return model_.name; }
    const results::CutRun &run() const { return run_; }
    const std::vector<std::string> &notes() const { return notes_; }

  private:
    void add(double stored, double work, double opening, double tool_stiffness) {
        run_.stored.push_back(stored);
        run_.work.push_back(work);
        run_.opening.push_back(opening);
        run_.tool_stiffness.push_back(tool_stiffness);
    }

    core::Model model_;
    results::CutRun run_;
    std::vector<std::string> notes_;
};

/// All models on the way of the blade.
class ModelsUnderBlade {
  public:
    ModelsUnderBlade(const std::vector<core::Model> &models, std::string body, SameLoads loads, int num_stages,
                     const ProgressReport &report)
        : models_(models.begin(), models.end()), body_(std::move(body)), loads_(std::move(loads)),
          steps_(num_stages * static_cast<int>(models.size()), report) {}

    std::vector<CutStage> go(std::shared_ptr<const core::Body> body, const BladeWay &way, bool meets_moved_body) {
        auto &reference = models_.front();
        Place place;
        const auto lead = [&](const CutStage &stage) { return take(reference, stage, place, true); };
        auto stages = grow_cut(std::move(body), way, meets_moved_body ? DisplacementOf(lead) : DisplacementOf());
        if (meets_moved_body)
            lead(stages.back());
        for (std::size_t m = meets_moved_body ? 1 : 0; m < models_.size(); ++m) {
            Place model_place;
            for (const auto &stage : stages)
                take(models_[m], stage, model_place, m == 0);
        }
        return stages;
    }

    const std::vector<ModelUnderBlade> &models() const { return models_; }

  private:
    /// A body as it was solved last, and where its nodes are.
    struct Place {
        std::shared_ptr<const core::Body> body;
        std::vector<core::Vector3> displacement;
    };

    const std::vector<core::Vector3> &take(ModelUnderBlade &model, const CutStage &stage, Place &last,
                                           bool has_to_succeed) {
        steps_.next(fmt::format("{} / {} / blade {:.1f} mm deep", body_, model.name(), 1e3 * stage.depth));
        if (stage.body == last.body)
            model.stay();
        else
            last = {stage.body, model.solve(stage, loads_, has_to_succeed)};
        return last.displacement;
    }

    std::vector<ModelUnderBlade> models_;
    std::string body_;
    SameLoads loads_;
    Steps steps_;
};

/// The reference in the end on finer meshes of the body, and of the same body cut exactly where that is asked for.
/// @param notes  what could not be solved or cut is added
std::vector<results::CutLevel> refine_in_the_end(const core::Model &reference, const CutStage &last,
                                                 const CutStage *exact, const BladeWay &way, const SameLoads &loads,
                                                 int times, std::vector<std::string> &notes,
                                                 const ProgressReport &report) {
    std::vector<results::CutLevel> levels;
    Steps steps((exact ? 2 : 1) * (times + 1), report);
    const auto add = [&](const CutStage &stage, const std::string &way_of_cut) {
        std::string failure;
        const auto found = solve_finer_at_wound(
            reference, way, way_of_cut, stage, loads.on(stage.body), times,
            [&] {
                steps.next(
                    fmt::format("{} / {} on finer meshes, cut {}", stage.body->name, reference.name, way_of_cut));
            },
            failure);
        levels.insert(levels.end(), found.begin(), found.end());
        if (!failure.empty())
            notes.push_back(fmt::format("cut {}: {} finds no equilibrium on the mesh that is refined {} times: {}",
                                        way_of_cut, reference.name, found.size(), failure));
    };
    add(last, "facets");
    if (exact)
        add(*exact, "exact");
    return levels;
}

/// The exact cut of the same way; nothing where it does not fit the body, which is noted.
std::optional<CutStage> exact_cut(const core::Body &body, const BladeWay &way, std::vector<std::string> &notes) {
    try {
        return cut_exactly(body, way);
    } catch (const meshes::CutNotOnBody &error) {
        notes.push_back(error.what());
        return std::nullopt;
    }
}

/// Critical steps of springs on bodies; none of other models.
std::vector<double> critical_time_steps(const core::Model &model,
                                        const std::vector<std::shared_ptr<const core::Body>> &bodies) {
    std::vector<double> found;
    for (const auto &body : bodies)
        if (const auto springs = models::springs_of(model, body))
            found.push_back(critical_time_step(*body, springs->body));
    return found;
}

/// Models of which regime are compared.
core::Regime regime_of_comparison(const CutStudyOptions &options, const core::LoadCase &load_case) {
    const auto regime = options.regime.value_or(load_case.regime);
    if (regime == core::Regime::small && load_case.regime == core::Regime::large)
        throw support::InputError(fmt::format("load case {} is of the large regime; leave --regime out, or choose a "
                                              "load case of the small regime",
                                              load_case.name));
    return regime;
}

} // namespace

CutResults let_blade_in(const CutStudyOptions &options, const std::string &command_line, const ProgressReport &report) {
    const auto way = way_of(options);
    auto set = read_scaled_problems({options.body}, options.load_case, options.material);
    auto &before = set.problems.front();
    refuse_other_loads(before.load_case);
    const bool meets_moved_body = before.load_case.regime == core::Regime::large;
    before.load_case.regime = regime_of_comparison(options, before.load_case);
    const bool has_motions = !chosen_methods_under_blade(options.motion).empty();
    if (has_motions)
        check_loads_of_motion(before);
    if (has_motions && meets_moved_body)
        throw support::InputError(fmt::format("load case {} is of the large regime, in which the blade meets the body "
                                              "where the reference is, not where methods are; for --method choose one "
                                              "of the small regime, with --regime large if deformations are large",
                                              before.load_case.name));
    const auto file_of_loads = find_toml_files({options.load_case}, load_cases_folder, "load case").front();
    const SameLoads loads(file_of_loads, before.load_case);
    const auto chosen = models_under_blade(options, before);
    const bool is_other_regime = !meets_moved_body && before.load_case.regime == core::Regime::large;
    const OutputFile output(options.output, before,
                            fmt::format("cut.{}{}.h5", before.load_case.name, is_other_regime ? ".large" : ""));
    ModelsUnderBlade models(chosen, before.body->name, loads, way.num_steps + 1, report);
    const auto stages = models.go(before.body, way, meets_moved_body);
    CutResults done{.file = {.provenance = results::current_provenance(command_line),
                             .body = before.body->name,
                             .load_case = before.load_case.name,
                             .title = before.load_case.title,
                             .blade = way.corners,
                             .toughness = options.toughness,
                             .regime = before.load_case.regime},
                    .notes = std::move(set.notes)};
    for (const auto &stage : stages) {
        done.file.depth.push_back(stage.depth);
        done.file.area.push_back(stage.area);
        done.file.cut_seconds.push_back(stage.seconds);
        done.file.nodes.push_back(stage.body->mesh.num_nodes());
    }
    const auto exact = meets_moved_body ? std::nullopt : exact_cut(*before.body, way, done.notes);
    std::vector bodies{before.body, stages.back().body};
    if (exact)
        bodies.push_back(exact->body);
    for (const auto &model : models.models()) {
        done.file.runs.push_back(model.run());
        done.file.runs.back().critical_time_step = critical_time_steps(model.model(), bodies);
        done.notes.insert(done.notes.end(), model.notes().begin(), model.notes().end());
    }
    if (options.num_refined > 0)
        done.file.levels = refine_in_the_end(models.models().front().model(), stages.back(), exact ? &*exact : nullptr,
                                             way, loads, options.num_refined, done.notes, report);
    if (has_motions) {
        std::vector<core::Problem> problems;
        for (const auto &stage : stages)
            problems.push_back(!problems.empty() && problems.back().body == stage.body ? problems.back()
                                                                                       : loads.on(stage.body));
        done.file.frame_interval = models::FramesUnderBlade{}.interval;
        done.file.frames_per_step = options.motion.frames_per_step;
        done.file.motions = move_under_blade(options.motion, stages, problems, report);
    }
    results::write_cut(output.path(), done.file);
    return done;
}

} // namespace livermark::studies
