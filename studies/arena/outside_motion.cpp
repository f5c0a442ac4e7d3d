#include "studies/arena/outside_motion.hpp"

#include <fmt/format.h>
#include <sstream>
#include <string>
#include <utility>

#include "models/tool_motion/tool_place.hpp"
#include "msm/mass_lumping.hpp"
#include "results/hdf5/arena_file.hpp"
#include "results/hdf5/tool_scene_file.hpp"
#include "results/provenance.hpp"
#include "studies/arena/arena.hpp"
#include "studies/arena/arena_run.hpp"
#include "studies/run/output_folder.hpp"
#include "support/python_program.hpp"

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
    const auto file = make_output_folder(options.output, problem) / (problem.load_case.name + ".scene.h5");
    results::write_tool_scene(file, problem, tool, results::current_provenance(command_line));
    ExportedProblem exported{{file}, std::move(notes)};
    std::istringstream written(support::run_python(
        "scene_files", {file.string()}, {}, "a job for FEBio and a scene for SOFA", "python3-h5py python3-numpy"));
    for (std::string line; std::getline(written, line);)
        exported.files.emplace_back(line);
    return exported;
}

MotionScore score_motion(const ScoreOptions &options, const std::string &command_line) {
    auto [problems, notes, left_out] = read_arena_problems({options.body}, options.load_case);
    const auto &problem = problems.front();
    const auto motion = results::read_outside_motion(options.solution, problem);
    const auto reference = stored_tool_reference(problem);
    results::ArenaRun run;
    run.method = options.name;
    run.setting = "unverified cost";
    run.tetrahedra = static_cast<int>(problem.body->mesh.tetrahedra.size());
    run.budget = run.frame_seconds = run.frame_seconds_95 = run.worst_frame_seconds = motion.seconds_per_frame;
    judge_shape(run, problem.body->mesh, motion.history, reference.history);
    run.errors = core::compare(problem.body->mesh, *problem.load_case.tool, motion.history, reference.history);
    run.force = motion.history.force;
    MotionScore score{empty_arena(problem, reference, command_line),
                      make_output_folder(options.output, problem) /
                          fmt::format("{}.{}.h5", problem.load_case.name, options.name),
                      std::move(notes)};
    score.arena.runs.push_back(std::move(run));
    results::write_arena(score.file, score.arena);
    return score;
}

} // namespace livermark::studies
