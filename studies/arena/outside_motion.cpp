#include "studies/arena/outside_motion.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <sstream>
#include <string>
#include <utility>

#include "core/support/processes/child_process.hpp"
#include "core/support/toml_input.hpp"
#include "meshes/io/mesh_files.hpp"
#include "msm/elastic_body.hpp"
#include "results/hdf5/references.hpp"
#include "results/records/arena.hpp"
#include "results/records/result.hpp"
#include "studies/arena/arena.hpp"
#include "studies/arena/arena_reference.hpp"
#include "studies/arena/arena_run.hpp"
#include "studies/files.hpp"
#include "studies/models/motion/frame_body.hpp"

namespace livermark::studies {

ExportedProblem export_tool_scene(const ExportOptions &options, const std::string &command_line) {
    auto [problems, notes, left_out] = read_arena_problems({options.body}, options.load_case);
    const auto &problem = problems.front();
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

namespace {

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
    if (has_stored_tool_reference(problem))
        return stored_tool_reference(problem);
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

} // namespace

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
    MotionScore score{empty_arena(problem, &reference, command_line), file.path(), std::move(notes)};
    score.arena.runs.push_back(std::move(run));
    results::write_arena(score.file, score.arena);
    return score;
}

} // namespace livermark::studies
