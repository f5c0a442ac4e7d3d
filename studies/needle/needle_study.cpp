#include "studies/needle/needle_study.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <limits>
#include <utility>

#include "core/stopwatch.hpp"
#include "core/support/input_error.hpp"
#include "core/units.hpp"
#include "load_cases/experiments/needle_curves.hpp"
#include "load_cases/places/selector.hpp"
#include "load_cases/readers/load_case_reader.hpp"
#include "results/one_reference.hpp"
#include "results/records/needle.hpp"
#include "results/records/result.hpp"
#include "studies/models/model_table.hpp"
#include "studies/models/pushed_model.hpp"
#include "studies/run/run.hpp"
#include "studies/study.hpp"

namespace livermark::studies {

namespace {

std::vector<core::Model> models_that_take_needles(core::Regime regime) {
    auto able = models::all_models();
    std::erase_if(able, [&](const core::Model &model) {
        if (regime == core::Regime::small)
            return !model.compliance;
        return model.only == core::Regime::small || (!model.compliance && !models::pushed_model(model));
    });
    return able;
}

constexpr const char *kind_of_model = "model that a needle can be driven into";

/// The reference first, then those that were asked for, each once.
/// @throws support::InputError for a model that cannot tell
std::vector<core::Model> models_with_needles(const NeedleOptions &options) {
    const auto able = models_that_take_needles(options.regime);
    std::vector<core::Model> chosen{needle_reference_model(options.reference_on_mesh, options.regime)};
    const auto add = [&](const core::Model &model) {
        if (std::ranges::find(chosen, model.name, &core::Model::name) == chosen.end())
            chosen.push_back(model);
    };
    for (const auto &name : options.models)
        add(support::find_named(able, name, kind_of_model));
    if (options.models.empty())
        for (const auto &model : able)
            if (!model.only_when_named && model.role_at_rest(options.regime) != core::Role::refined_reference &&
                (!model.only || model.only == options.regime))
                add(model);
    return chosen;
}

void note_change(results::NeedleStudy &study, const results::NeedleRun &coarser) {
    study.reference_miss_change = (study.runs.front().miss() - coarser.miss()).norm();
    study.reference_force_change = results::force_error(coarser.insertion, study.runs.front().insertion);
}

/// Into a linear body.
void drive_linear(const core::Problem &problem, const core::Model &model, const core::NeedleLine &line,
                  results::NeedleStudy &study) {
    const auto compliance = model.compliance(problem, line.places);
    const auto start = core::Clock::now();
    study.runs.push_back({model.name, insert(compliance.matrix, line, study.needle), compliance.seconds});
    study.runs.back().solve_seconds = core::seconds_since(start);
    if (problem.load_case.regime == core::Regime::small)
        study.runs.back().note_limit(results::largest_small_displacement(problem));
    if (study.runs.size() == 1 && !compliance.on_coarser.empty())
        note_change(study, {model.name, insert(compliance.on_coarser.back(), line, study.needle)});
}

/// Into a body that comes to rest under the forces, on each of its meshes.
void drive_far(const core::Problem &problem, const models::PushedModel &model, const std::string &name,
               const core::NeedleLine &line, results::NeedleStudy &study, const std::function<void(int)> &begin_mesh) {
    std::vector<results::NeedleRun> mesh_runs;
    Eigen::MatrixXd compliance;
    for (int mesh = 0; mesh < model.num_meshes; ++mesh) {
        begin_mesh(mesh);
        auto start = core::Clock::now();
        const auto body = model.prepare(problem, line.places, mesh, mesh > 0 ? &compliance : nullptr);
        results::NeedleRun run{.model = name, .insertion = {}, .setup_seconds = core::seconds_since(start)};
        start = core::Clock::now();
        run.insertion = insert(*body, line, study.needle);
        run.solve_seconds = core::seconds_since(start);
        compliance = body->compliance();
        mesh_runs.push_back(std::move(run));
    }
    const bool judges = study.runs.empty();
    study.runs.push_back(mesh_runs.back());
    if (judges && mesh_runs.size() > 1)
        note_change(study, mesh_runs[mesh_runs.size() - 2]);
}

results::NeedleStudy drive(const core::Problem &problem, const core::Needle &needle,
                           const std::vector<core::Model> &models, Steps &steps) {
    const auto line = core::needle_line(needle);
    results::NeedleStudy study{.needle = needle, .runs = {}};
    for (const auto &model : models) {
        const auto what = fmt::format("{} / {} / {}", problem.body->name, needle.name, model.name);
        const auto pushed =
            problem.load_case.regime == core::Regime::large ? models::pushed_model(model) : std::nullopt;
        if (pushed) {
            drive_far(problem, *pushed, model.name, line, study, [&](int mesh) {
                steps.next(pushed->num_meshes > 1 ? fmt::format("{}, mesh {} of {}", what, mesh + 1, pushed->num_meshes)
                                                  : what);
            });
        } else {
            steps.next(what);
            drive_linear(problem, model, line, study);
        }
    }
    return study;
}

/// Meshes that a needle is driven into, of all models.
int meshes_of(const std::vector<core::Model> &models, core::Regime regime) {
    int count = 0;
    for (const auto &model : models) {
        const auto pushed = regime == core::Regime::large ? models::pushed_model(model) : std::nullopt;
        count += pushed ? pushed->num_meshes : 1;
    }
    return count;
}

constexpr double records_of_stretch = 4.0; ///< at least, of a model
constexpr double widest_spread = 0.5;      ///< radius of the places, of the way
/// Friction [N/m]: the most that is tried, and the tolerance to which it is found.
constexpr double most_friction = 500.0, friction_tolerance = 0.01;
constexpr double golden = 0.6180339887498949;

/// Force that a model meets with a friction.
results::FittedNeedle with_friction(const Eigen::MatrixXd &compliance, const core::NeedleLine &line,
                                    core::Needle needle, double friction, const results::MeasuredNeedle &measured) {
    needle.friction = friction;
    results::FittedNeedle run;
    run.friction = friction;
    run.insertion = insert(compliance, line, needle);
    const auto &insertion = run.insertion;
    double sum = 0.0, sum_before = 0.0;
    int count = 0, count_before = 0;
    for (std::size_t b = 0; b < measured.from.size(); ++b) {
        double force = 0.0;
        int records = 0;
        for (int j = 0; j <= insertion.at_plan; ++j)
            if (insertion.depth[j] >= measured.from[b] && insertion.depth[j] < measured.to[b]) {
                force += insertion.force[j];
                ++records;
            }
        run.force.push_back(records > 0 ? force / records : std::numeric_limits<double>::quiet_NaN());
        if (records == 0)
            continue;
        const double off = run.force.back() - measured.mean[b];
        run.work += run.force.back() * (measured.to[b] - measured.from[b]);
        const bool is_before = measured.to[b] <= measured.puncture_depth;
        const bool is_behind = measured.from[b] >= measured.puncture_depth;
        (is_behind ? sum : sum_before) += is_before || is_behind ? off * off : 0.0;
        count += is_behind ? 1 : 0;
        count_before += is_before ? 1 : 0;
    }
    run.pull = results::NeedleRun{.model = {}, .insertion = insertion}.largest_pull();
    run.error = std::sqrt(sum / std::max(1, count));
    run.error_before = std::sqrt(sum_before / std::max(1, count_before));
    return run;
}

/// The friction of the least error, by golden section.
results::FittedNeedle fitted(const Eigen::MatrixXd &compliance, const core::NeedleLine &line,
                             const core::Needle &needle, const results::MeasuredNeedle &measured) {
    const auto at = [&](double friction) { return with_friction(compliance, line, needle, friction, measured); };
    double low = 0.0, high = most_friction;
    auto left = at(high - golden * (high - low)), right = at(low + golden * (high - low));
    while (high - low > friction_tolerance) {
        if (left.error <= right.error) {
            high = right.friction;
            right = std::move(left);
            left = at(high - golden * (high - low));
        } else {
            low = left.friction;
            left = std::move(right);
            right = at(low + golden * (high - low));
        }
    }
    auto best = left.error <= right.error ? left : right;
    best.has_friction = best.friction < most_friction - 10.0 * friction_tolerance;
    if (!best.has_friction)
        best.friction = most_friction;
    return best;
}

/// The record by itself, before any model.
results::MeasuredNeedle without_models(const experiments::NeedleCurve &curve, const experiments::NeedlePhases &phases) {
    results::MeasuredNeedle measured;
    measured.name = curve.name;
    measured.source = curve.source;
    measured.unknown = curve.unknown;
    measured.puncture_depth = phases.puncture.depth;
    measured.touched_at = phases.touched_at;
    measured.lowest_behind = phases.lowest;
    measured.slope = phases.slope;
    measured.pull = phases.pull;
    measured.held_for = curve.held.seconds;
    measured.held_from = curve.held.first_force;
    measured.held_to = curve.held.last_force;
    return measured;
}

/// Lowers numbers of the load case that the record does not allow, and says so.
/// @throws support::InputError for a way that is too short for the tetrahedra
void fit_to_record(core::Needle &needle, const core::TetraMesh &mesh, results::MeasuredNeedle &measured) {
    if (const double most = needle.puncture_force / needle.diameter; needle.toughness > most) {
        measured.changed.push_back(fmt::format("the toughness is {:.0f} and not {:g} J/m^2, so that tearing takes no "
                                               "more than the {:.2f} N at which the surface gave way",
                                               most, needle.toughness, needle.puncture_force));
        needle.toughness = most;
    }
    if (const double most = widest_spread * needle.depth(); needle.spread > most) {
        measured.changed.push_back(fmt::format("forces are spread over {:.2g} and not {:g} mm, half of the way",
                                               core::millimetres * most, core::millimetres * needle.spread));
        needle.spread = most;
    }
    if (const double least = core::smallest_spread(needle, mesh); needle.spread < least)
        throw support::InputError("the measured needle '{}' goes {:.3g} m deep, and forces over half of that are too "
                                  "narrow for the tetrahedra along it, which take {:.3g} m; give a finer mesh",
                                  measured.name, needle.depth(), least);
}

} // namespace

core::Model needle_reference_model(bool on_mesh, core::Regime regime) {
    const auto judge = models::static_reference(regime);
    return support::find_named(models_that_take_needles(regime), on_mesh ? judge.on_mesh : judge.refined,
                               kind_of_model);
}

std::vector<NeedleProblem> read_with_needles(const NeedleOptions &options, std::vector<std::string> &notes) {
    const auto file = find_toml_files({options.load_case}, needle_load_cases_folder, "load case").front();
    auto set = read_needle_problems(options.bodies, file.string(), options.material);
    notes = std::move(set.notes);
    std::vector<NeedleProblem> problems;
    std::string fault;
    for (auto &problem : set.problems)
        try {
            auto needles = load_cases::read_needles(file, *problem.body, problem.load_case);
            problem.load_case.regime = options.regime;
            const bool is_large = options.regime == core::Regime::large;
            for (auto &needle : needles)
                needle.step = options.step.value_or(is_large ? large_needle_step : needle.step);
            problems.push_back({std::move(problem), std::move(needles)});
        } catch (const load_cases::NotOnBody &error) {
            notes.push_back(fmt::format("left out on {}: {}, because {}", problem.body->name, file.stem().string(),
                                        error.reason()));
            fault = error.what();
        }
    if (problems.empty())
        throw support::InputError(fault);
    return problems;
}

Found<results::NeedleFile> drive_needles(const NeedleOptions &options, const std::string &command_line,
                                         const ProgressReport &report) {
    const auto models = models_with_needles(options);
    Found<results::NeedleFile> done;
    const auto problems = read_with_needles(options, done.notes);
    std::size_t num_needles = 0;
    for (const auto &[problem, needles] : problems)
        num_needles += needles.size();
    Steps steps(static_cast<int>(num_needles) * meshes_of(models, options.regime), report);
    for (const auto &[problem, needles] : problems) {
        const bool is_large = options.regime == core::Regime::large;
        const OutputFile output(options.output, problem,
                                fmt::format("needle.{}{}.h5", problem.load_case.name, is_large ? ".large" : ""));
        results::NeedleFile file{.provenance = results::current_provenance(command_line),
                                 .body = problem.body->name,
                                 .load_case = problem.load_case.name,
                                 .title = problem.load_case.title + (is_large ? ", large regime" : ""),
                                 .regime = options.regime,
                                 .needles = {}};
        for (const auto &needle : needles)
            file.needles.push_back(drive(problem, needle, models, steps));
        results::write_needles(output.path(), file);
        done.records.push_back(std::move(file));
    }
    return done;
}

results::MeasuredNeedle compare_with_measured(const NeedleOptions &options, const experiments::NeedleCurve &curve,
                                              const ProgressReport &report) {
    const auto phases = experiments::phases_of(curve);
    const auto &puncture = phases.puncture;
    const auto models = models_with_needles(options);
    std::vector<std::string> notes;
    const auto problems = read_with_needles(options, notes);
    const auto &[problem, needles] = problems.front();
    auto measured = without_models(curve, phases);
    measured.needle = needles.front();
    auto &needle = measured.needle;
    const double end = *std::ranges::max_element(curve.depth);
    if (!(needle.depth() >= end))
        throw support::InputError(fmt::format("{}: the needle '{}' goes {:.3g} m deep, and the measured one {:.3g} m; "
                                              "give a load case with a needle as deep",
                                              options.load_case, needle.name, needle.depth(), end));
    needle.target = needle.entry + end * needle.direction();
    needle.diameter = curve.diameter;
    needle.puncture_force = puncture.force;
    if (!options.step)
        needle.step = std::min(needle.step, curve.stretch / records_of_stretch);
    fit_to_record(needle, problem.body->mesh, measured);
    for (const auto &bin : experiments::binned(curve, curve.stretch)) {
        measured.from.push_back(bin.from);
        measured.to.push_back(bin.to);
        measured.mean.push_back(bin.mean);
        measured.lowest.push_back(bin.lowest);
        measured.highest.push_back(bin.highest);
        measured.work += bin.mean * (bin.to - bin.from);
    }
    const auto line = core::needle_line(needle);
    Steps steps(static_cast<int>(models.size()), report);
    for (const auto &model : models) {
        steps.next(fmt::format("{} / measured needle {} / {}", problem.body->name, curve.name, model.name));
        const auto compliance = model.compliance(problem, line.places).matrix;
        // Before the puncture depth = F (C / stiffness + 1 / k), with C of the place at the entry.
        const core::Vector3 axis = needle.direction();
        const double entry_compliance = axis.dot(compliance.topLeftCorner<3, 3>() * axis);
        const double stiffness = entry_compliance / (puncture.depth / puncture.force - 1.0 / core::needle_stiffness);
        auto run = fitted(compliance / stiffness, line, needle, measured);
        run.model = model.name;
        run.stiffness = stiffness;
        measured.runs.push_back(std::move(run));
    }
    return measured;
}

} // namespace livermark::studies
