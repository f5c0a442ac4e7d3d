#include "studies/exchange/exchange.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <iterator>
#include <limits>
#include <sstream>
#include <string>
#include <type_traits>
#include <utility>

#include "core/mesh/tetra_mesh.hpp"
#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "core/support/processes/child_process.hpp"
#include "core/support/toml_input.hpp"
#include "core/units.hpp"
#include "meshes/io/mesh_files.hpp"
#include "msm/elastic_body.hpp"
#include "results/hdf5/references.hpp"
#include "results/hdf5/result_file.hpp"
#include "results/records/arena.hpp"
#include "results/records/result.hpp"
#include "studies/arena/arena.hpp"
#include "studies/arena/arena_run.hpp"
#include "studies/exchange/formats/export_format.hpp"
#include "studies/models/motion/frame_body.hpp"
#include "studies/run/run.hpp"
#include "studies/study.hpp"

namespace livermark::studies {

namespace {

using exchange::FurtherKind;

ExportedProblem export_tool_scene(const ExportOptions &options, const std::string &command_line) {
    auto [problems, notes, left_out] = read_arena_problems({options.body}, options.load_case);
    const auto &problem = problems.front();
    for (const auto &part : further_parts(problem))
        if (part.kind == FurtherKind::vessels || part.kind == FurtherKind::map || part.kind == FurtherKind::capsule)
            throw support::InputError("{} has {}, which scenes cannot say; export {} on a body without",
                                      problem.body->name, part.noun, problem.load_case.name);
    const auto place = models::tool_place(problem, msm::lumped_masses(*problem.body));
    results::ToolNodes tool{.held = place.held, .nodes = place.nodes, .displacement = {}};
    for (const double time : core::record_times(place.motion)) {
        const auto position = core::tool_position(place.motion, time);
        for (std::size_t i = 0; i < place.nodes.size(); ++i)
            tool.displacement.push_back(place.displacement(i, position));
    }
    const OutputFile output(options.output, problem, problem.load_case.name + ".scene.h5");
    const auto &file = output.path();
    results::write_tool_scene(file, problem, tool, results::current_provenance(command_line));
    ExportedProblem exported{{file}, std::move(notes)};
    std::istringstream written(support::run_python("convert.scene_files", {file.string()}, {},
                                                   "a job for FEBio and a scene for SOFA",
                                                   "python3-h5py python3-numpy"));
    for (std::string line; std::getline(written, line);)
        exported.files.emplace_back(line);
    return exported;
}

/// The formats that were asked for; where none was, those that need not be named.
std::vector<exchange::ExportFormat> chosen_formats(const std::vector<std::string> &names) {
    std::vector<exchange::ExportFormat> chosen;
    for (const auto &name : names)
        chosen.push_back(support::find_named(exchange::all_formats(), name, "format"));
    if (names.empty())
        std::ranges::copy_if(exchange::all_formats(), std::back_inserter(chosen),
                             [](const exchange::ExportFormat &format) { return !format.only_when_named; });
    return chosen;
}

/// A model that has been solved elsewhere. It says nothing about forces, energy and time.
core::Model outside_model(const ScoreOptions &options, const std::vector<core::Vector3> &displacement) {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    return {.name = options.name,
            .summary = "node displacements of " + options.solution,
            .source = "not ours",
            .prepare = core::solves_each([=](const core::Problem &problem) {
                core::Solution solution;
                solution.displacement = displacement;
                solution.reaction.assign(problem.load_case.num_constraints(), core::Vector3::Constant(nan));
                solution.strain_energy = nan;
                solution.setup_seconds = solution.solve_seconds = nan;
                solution.degrees_of_freedom = static_cast<std::int64_t>(3 * displacement.size());
                return solution;
            }),
            .follows = core::EventSet::all()};
}

/// Displacements this many times as large as they are meant to be are of another unit: centimetres make 100.
constexpr double largest_part_of_target = 30.0;
/// Above this error a unit may be wrong as well.
constexpr double strange_error = 10.0;

double largest_length(const std::vector<core::Vector3> &displacement) {
    double largest = 0.0;
    for (const auto &u : displacement)
        largest = std::max(largest, u.norm());
    return largest;
}

/// Displacements in metres. Coordinates may be in the same unit, or in metres as the exported mesh has them.
void take_unit(OutsideSolution &solution, const core::TetraMesh &mesh, const std::string &unit) {
    const double metres = support::metres_per_unit(unit, "--unit");
    for (auto &u : solution.displacement)
        u *= metres;
    const double ratio = metres * core::extent(solution.points) / core::extent(mesh.points);
    constexpr double close = 0.05;
    if (std::abs(ratio - 1.0) < close)
        for (auto &point : solution.points)
            point *= metres;
}

/// Refuses values that are the places of the nodes: at rest, or moved.
void refuse_positions(const std::vector<core::Vector3> &displacement, const core::Problem &problem,
                      const std::string &source) {
    const auto &points = problem.body->mesh.points;
    core::Vector3 centre = core::Vector3::Zero();
    for (const auto &point : points)
        centre += point / static_cast<double>(points.size());
    constexpr double close = 0.3; // of the size of the body, which no displacement is to its own places
    for (const double per_metre : {1.0, 100.0, 1000.0}) {
        double distance = 0.0, size = 0.0;
        for (std::size_t i = 0; i < points.size(); ++i) {
            distance += (displacement[i] / per_metre - points[i]).squaredNorm();
            size += (points[i] - centre).squaredNorm();
        }
        if (distance < close * close * size)
            throw support::InputError(fmt::format(
                "{}: these seem to be positions of the nodes and not displacements: on average they are {:.2g} m away "
                "from the nodes of {}; subtract the coordinates at rest",
                source, std::sqrt(distance / static_cast<double>(points.size())), problem.body->name));
    }
}

void refuse_other_unit(double largest, const core::Problem &problem, const std::string &source) {
    const double meant = problem.load_case.target_peak_displacement;
    if (meant > 0.0 && largest > largest_part_of_target * meant)
        throw support::InputError(
            fmt::format("{}: these seem to be millimetres: the largest displacement is {:.3g}, and {} moves {} by "
                        "about {:.3g} m; give --unit m if they are metres, otherwise give metres, or --unit mm",
                        source, largest, problem.load_case.name, problem.body->name, meant));
}

void refuse_other_values(const std::vector<core::Vector3> &displacement, const core::Problem &problem,
                         const ScoreOptions &options) {
    refuse_positions(displacement, problem, options.solution);
    if (options.unit.empty())
        refuse_other_unit(largest_length(displacement), problem, options.solution);
}

std::vector<core::Vector3> read_displacement(const ScoreOptions &options, const core::Problem &problem) {
    auto solution = read_outside_solution(options.solution);
    if (!options.unit.empty())
        take_unit(solution, problem.body->mesh, options.unit);
    auto displacement = displacement_at_nodes(solution, problem.body->mesh, options.solution);
    refuse_other_values(displacement, problem, options);
    return displacement;
}

std::vector<std::string> question_of_unit(const results::Result &result, const ScoreOptions &options) {
    for (const auto &model : result.models)
        if (options.unit.empty() && model.name == options.name && model.comparison &&
            model.comparison->relative_l2 > strange_error)
            return {fmt::format("the error of {} is {:.0f} %; check that its displacements are in metres and belong to "
                                "this problem, or give --unit mm",
                                options.name, core::percent * model.comparison->relative_l2)};
    return {};
}

/// The reference and what else an outside model is compared with.
std::vector<core::Model> models_beside(const ScoreOptions &options) {
    auto models = choose_models(options.models, {}, !options.reference_on_mesh);
    if (!options.solve_reference)
        leave_out_unsolved_motions(models);
    for (const auto &model : models)
        if (model.name == options.name)
            throw support::InputError(
                fmt::format("there is a model '{}' already; choose another --name", options.name));
    return models;
}

void refuse_motion(const core::Problem &problem) {
    if (problem.load_case.release)
        throw support::InputError(
            fmt::format("load case {} depends on time, and node displacements belong to one moment; score "
                        "its static start, the load case of the same loads",
                        problem.load_case.name));
}

/// The name of a model, and on what it is solved, with a word before what takes long.
std::string announced(const core::Model &model, const core::Problem &problem, const ScoreOptions &options) {
    if (model.name == options.name)
        return model.name;
    auto on_mesh = fmt::format("{} on {} tetrahedra", model.name, problem.body->mesh.num_tetrahedra());
    if (!is_stored(model, problem))
        return on_mesh;
    if (!options.solve_reference && !SolutionCache::shipped().where(model, problem).empty())
        return model.name + ", which is stored";
    return on_mesh + (model.role_at_rest(problem.load_case.regime) == core::Role::refined_reference
                          ? " and finer meshes, which takes longest; --reference-on-mesh does without"
                          : ", which takes longest");
}

results::Result evaluate_beside(std::vector<core::Model> models, const core::Problem &problem,
                                const std::vector<core::Vector3> &displacement, const ScoreOptions &options,
                                const std::string &command_line, const ProgressReport &report) {
    models.push_back(outside_model(options, displacement));
    PreparedModels prepared(options.solve_reference ? SolutionCache() : SolutionCache::shipped());
    const auto num_steps = std::ranges::count_if(models, [&](const auto &m) { return m.takes_part_in(problem); });
    Steps steps(static_cast<int>(num_steps), report);
    const auto solve = [&](const core::Model &model, const core::Problem &to_solve) {
        steps.next(announced(model, to_solve, options));
        return prepared.solve(model, to_solve);
    };
    return studies::evaluate(problem, models, solve, results::current_provenance(command_line));
}

/// In metres.
results::OutsideMotion read_motion(const ScoreOptions &options, const core::Problem &problem) {
    auto motion = results::read_outside_motion(options.solution, problem);
    auto &displacement = motion.history.displacement;
    if (!options.unit.empty()) {
        const auto metres = static_cast<float>(support::metres_per_unit(options.unit, "--unit"));
        for (auto &u : displacement)
            u *= metres;
    } else {
        double largest = 0.0;
        for (const auto &u : displacement)
            largest = std::max(largest, static_cast<double>(u.norm()));
        refuse_other_unit(largest, problem, options.solution);
    }
    return motion;
}

results::ToolReference reference_for(const core::Problem &problem, const std::filesystem::path &folder,
                                     const std::string &command_line, const ProgressReport &report,
                                     std::vector<std::string> &notes) {
    if (auto stored = find_tool_reference(problem))
        return *std::move(stored);
    Steps steps(1, report);
    const auto path = folder / fmt::format("{}.coarse_reference.h5", problem.load_case.name);
    auto coarse =
        coarse_tool_reference(problem, path, command_line, [&](const std::string &about) { steps.next(about); });
    notes.push_back(fmt::format("no refined reference of {} on {} is stored, so errors are against a coarse one ({}, "
                                "on the mesh itself), whose "
                                "own error is not known; `livermark arena --body ... --load-case {} --solve-reference` "
                                "makes the refined one in "
                                "minutes to an hour",
                                problem.load_case.name, problem.body->name, coarse.model, problem.load_case.name));
    return coarse;
}

/// Leaves out jobs that cannot say all of a problem.
/// @return a sentence for each part of the problem that its .problem.h5 has, and jobs do not
/// @throws support::InputError if such a job was asked for
std::vector<std::string> leave_out_jobs(std::vector<exchange::ExportFormat> &formats, const core::Problem &problem,
                                        const ExportOptions &options) {
    std::vector<std::string> sentences;
    const exchange::JobKind job{problem.load_case.regime, options.choices.quadratic};
    for (const auto &part : further_parts(problem)) {
        const auto knows = [&](const auto &format) { return !format.job_has || format.job_has(part.kind, job); };
        std::vector<std::string> jobs;
        for (const auto &format : formats)
            if (!knows(format))
                jobs.push_back(format.name);
        if (!options.formats.empty() && !jobs.empty())
            throw support::InputError(fmt::format(
                "{} on {} has {}, which files of {} cannot describe; leave the format "
                "out, and read {} of the .problem.h5",
                problem.load_case.name, problem.body->name, part.noun, fmt::join(jobs, " and "), part.group));
        sentences.push_back(fmt::format("{} has {}, which is in {} of {}.problem.h5", problem.load_case.name, part.noun,
                                        part.group, problem.load_case.name));
        if (!jobs.empty())
            sentences.back() += fmt::format(", and no {} is written", fmt::join(jobs, " or "));
        std::erase_if(formats, [&](const auto &format) { return !knows(format); });
        for (const auto &format : formats)
            if (part.kind == FurtherKind::capsule && format.capsule_in_job)
                sentences.push_back(
                    fmt::format("the job of {} has {} as {}", format.name, part.noun, format.capsule_in_job));
    }
    return sentences;
}

} // namespace

std::vector<FurtherPart> further_parts(const core::Problem &problem) {
    std::vector<FurtherPart> parts;
    core::for_each_event(problem.load_case, [&](const auto &event) {
        using Kind = std::decay_t<decltype(event)>;
        if constexpr (!Kind::in_time)
            parts.push_back({Kind::noun, fmt::format("/load_case/{}", Kind::key)});
        if constexpr (std::is_same_v<Kind, core::Foundation>)
            parts.back().kind = FurtherKind::foundation;
        if constexpr (std::is_same_v<Kind, core::TouchingTool>)
            parts.back().kind = exchange::is_plain_ball(event) ? FurtherKind::plain_ball : FurtherKind::other;
    });
    if (problem.body->capsule)
        parts.push_back({"a capsule", "/capsule", FurtherKind::capsule});
    if (problem.body->vessels)
        parts.push_back({"vessels as lines", "/vessels", FurtherKind::vessels});
    if (!problem.body->modulus_factor.empty())
        parts.push_back({"a map of stiffness", "/mesh/modulus_factor", FurtherKind::map});
    return parts;
}

ExportedProblem export_problem(const ExportOptions &options, const std::string &command_line) {
    if (moves_tool(options.load_case))
        return export_tool_scene(options, command_line);
    auto formats = chosen_formats(options.formats);
    auto [problems, notes, left_out] = read_scaled_problems({options.body}, options.load_case, {});
    const auto &problem = problems.front();
    std::ranges::move(leave_out_jobs(formats, problem, options), std::back_inserter(notes));
    const OutputFolder folder(std::filesystem::path(options.output) / problem.body->name);
    ExportedProblem exported{{}, std::move(notes)};
    const auto file = [&](const char *extension) {
        return exported.files.emplace_back(folder.path() / (problem.load_case.name + extension));
    };

    results::Result result;
    result.provenance = results::current_provenance(command_line);
    result.problem = problem;
    results::write_result(file(".problem.h5"), result);
    for (const auto &format : formats)
        for (const auto &[ending, write] : format.files) {
            std::ostringstream text;
            write(text, problem, options.choices);
            support::write_whole(file(ending), text.str());
        }
    return exported;
}

std::string fault_of_name(const std::string &name) {
    const bool is_good = !name.empty() && name.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
                                                                 "0123456789_-") == std::string::npos;
    return is_good ? "" : "a name has letters, digits, _ and - only";
}

results::Result score_displacement(const core::Problem &problem, const std::vector<core::Vector3> &displacement,
                                   const ScoreOptions &options, const std::string &command_line,
                                   const ProgressReport &report) {
    if (const auto fault = fault_of_name(options.name); !fault.empty())
        throw support::InputError(fmt::format("name: {}", fault));
    refuse_motion(problem);
    refuse_other_values(displacement, problem, options);
    return evaluate_beside(models_beside(options), problem, displacement, options, command_line, report);
}

std::vector<std::string> doubts_about_sign(const results::Result &result, const std::string &name) {
    const auto model = std::ranges::find(result.models, name, &results::ModelResult::name);
    if (model == result.models.end() || !model->comparison)
        return {};
    double product = 0.0, own = 0.0, of_reference = 0.0;
    for (std::size_t i = 0; i < model->solution.displacement.size(); ++i) {
        const auto &u = model->solution.displacement[i];
        const core::Vector3 reference = u - model->comparison->error[i];
        product += u.dot(reference);
        own += u.squaredNorm();
        of_reference += reference.squaredNorm();
    }
    const double correlation = product / std::sqrt(own * of_reference);
    constexpr double opposite = -0.8;
    if (!(correlation < opposite))
        return {};
    return {fmt::format("the displacements of {} point against those of {} (correlation {:.2f}); check their sign, and "
                        "that of the loads",
                        name, model->comparison->reference, correlation)};
}

Score score(const ScoreOptions &options, const std::string &command_line, const ProgressReport &report) {
    auto models = models_beside(options);
    auto [problems, notes, left_out] = read_scaled_problems({options.body}, options.load_case, {});
    const auto &problem = problems.front();
    refuse_motion(problem);
    const auto displacement = read_displacement(options, problem);
    const OutputFile file(options.output, problem, fmt::format("{}.{}.h5", problem.load_case.name, options.name));
    Score scored{.result = evaluate_beside(std::move(models), problem, displacement, options, command_line, report),
                 .file = file.path(),
                 .notes = std::move(notes)};
    results::write_result(scored.file, scored.result);
    std::ranges::move(question_of_unit(scored.result, options), std::back_inserter(scored.notes));
    std::ranges::move(doubts_about_sign(scored.result, options.name), std::back_inserter(scored.notes));
    return scored;
}

MotionScore score_motion(const ScoreOptions &options, const std::string &command_line, const ProgressReport &report) {
    auto [problems, notes, left_out] = read_arena_problems({options.body}, options.load_case);
    const auto &problem = problems.front();
    const auto motion = read_motion(options, problem);
    const OutputFile file(options.output, problem, fmt::format("{}.{}.h5", problem.load_case.name, options.name));
    const auto reference = reference_for(problem, file.path().parent_path(), command_line, report, notes);
    results::ArenaRun run;
    run.method = options.name;
    run.setting = "unverified cost";
    run.tetrahedra = static_cast<int>(problem.body->mesh.tetrahedra.size());
    run.budget = run.frame_seconds = run.frame_seconds_95 = run.worst_frame_seconds = motion.seconds_per_frame;
    judge_shape(run, problem.body->mesh, motion.history, reference.history);
    run.errors = core::compare(problem.body->mesh, *problem.load_case.tool, motion.history, reference.history);
    run.force = motion.history.force;
    MotionScore score{empty_arena(problem, &reference, command_line), problem, file.path(), std::move(notes)};
    score.arena.runs.push_back(std::move(run));
    results::write_arena(score.file, score.arena);
    return score;
}

} // namespace livermark::studies
