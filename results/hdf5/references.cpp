#include "results/hdf5/references.hpp"

#include <fmt/format.h>
#include <limits>

#include "core/support/files.hpp"
#include "results/hdf5/hdf5_io.hpp"
#include "results/hdf5/record_file.hpp"
#include "results/hdf5/solution_group.hpp"
#include "results/problem_key.hpp"

namespace livermark::results {

namespace {

template <class At> void describe_tool_errors(At at, const std::string &name, hdf5::Of<At, core::ToolErrors> &errors) {
    at.number(name + "_contact", errors.contact);
    at.number(name + "_after", errors.after);
    at.number(name + "_force", errors.force);
}

template <class At>
void describe_tool_reference(At at, hdf5::Of<At, ToolReference> &reference, const core::Problem &problem) {
    at.integer("level", reference.level);
    at.integer("steps_per_frame", reference.steps_per_frame);
    describe_tool_errors(at, "last_refinement", reference.last_refinement);
    describe_tool_errors(at, "half_steps", reference.half_steps);
    const int num_records = problem.load_case.tool.value().num_records();
    auto &history = reference.history;
    at.rows("time", history.time, "s", num_records);
    at.rows("force", history.force, "N", num_records);
    at.blocks("displacement", history.displacement, problem.body->mesh.points.size(), "m",
              core::ToolHistory::num_fields(num_records));
}

OutsideMotion motion_in(const std::filesystem::path &path, const core::Problem &problem) {
    const hdf5::InputFile file(path, "h5py.File(..., 'w', libver='latest')");
    const auto num_nodes = problem.body->mesh.points.size();
    const auto &tool = problem.load_case.tool.value();
    const auto num_records = static_cast<std::size_t>(tool.num_records());
    const std::size_t num_fields = core::ToolHistory::num_fields(tool.num_records());
    OutsideMotion motion;
    auto &history = motion.history;
    history.time = core::record_times(tool);
    history.force = file.dataset<core::Vector3>("/force", num_records);
    const auto fields = file.blocks<Eigen::Vector3f>("/displacement", num_nodes);
    const bool has_all = fields.size() == num_records * num_nodes;
    if (!has_all && fields.size() != num_fields * num_nodes)
        file.refuse("/displacement", fmt::format("has {} fields; it needs {}, at every record, or {}, at every fourth",
                                                 fields.size() / num_nodes, num_records, num_fields));
    for (std::size_t k = 0; k < num_records; ++k) {
        if (!core::ToolHistory::has_field(static_cast<int>(k)))
            continue;
        const std::size_t block = has_all ? k : k / core::ToolHistory::frames_per_field;
        const auto first = fields.begin() + static_cast<std::ptrdiff_t>(block * num_nodes);
        history.displacement.insert(history.displacement.end(), first, first + static_cast<std::ptrdiff_t>(num_nodes));
    }
    motion.seconds_per_frame = file.has_attribute("/", "seconds_per_frame") ? file.number("/", "seconds_per_frame")
                                                                            : std::numeric_limits<double>::quiet_NaN();
    return motion;
}

} // namespace

std::filesystem::path reference_path(const std::filesystem::path &folder, const core::Problem &problem,
                                     const std::string &model) {
    return folder / problem.body->name /
           fmt::format("{}.{}.{}.h5", problem.load_case.name, model, fingerprint(problem, model));
}

void write_reference(const std::filesystem::path &path, const core::Solution &solution, const core::Problem &problem,
                     const std::string &model, const Provenance &provenance) {
    hdf5::OutputFile file;
    hdf5::write_provenance(file, provenance);
    file.text("/", "body", problem.body->name);
    file.text("/", "load_case", problem.load_case.name);
    file.text("/", "model", model);
    file.text("/", "fingerprint", fingerprint(problem, model));
    file.group("/solutions");
    auto without_frames = solution; // they would be nearly all of the file
    if (without_frames.history)
        without_frames.history->frames.clear();
    write_solution_group(file, only_solution, without_frames, problem.load_case);
    support::write_whole(path, file.image());
}

std::optional<core::Solution> read_reference(const std::filesystem::path &path, const core::Problem &problem,
                                             const std::string &model) {
    std::error_code nobody_cares;
    if (!std::filesystem::exists(path, nobody_cares))
        return std::nullopt;
    const hdf5::InputFile file(path);
    if (!file.has_attribute("/", "fingerprint") || file.text("/", "fingerprint") != fingerprint(problem, model))
        return std::nullopt;
    auto solution = read_solution_group(file, only_solution, problem);
    solution.solver = fmt::format("stored since {} (commit {}): {}", file.text("/", "created"),
                                  file.text("/", "git_commit"), solution.solver);
    return solution;
}

void write_tool_reference(const std::filesystem::path &path, const ToolReference &reference,
                          const core::Problem &problem, const Provenance &provenance) {
    hdf5::OutputFile file;
    hdf5::write_provenance(file, provenance);
    file.text("/", "body", problem.body->name);
    file.text("/", "load_case", problem.load_case.name);
    file.text("/", "model", reference.model);
    file.text("/", "fingerprint", fingerprint(problem, reference.model));
    describe_tool_reference(hdf5::GroupWriter(file).group("tool_reference"), reference, problem);
    support::write_whole(path, file.image());
}

std::optional<ToolReference> read_tool_reference(const std::filesystem::path &path, const core::Problem &problem,
                                                 const std::string &model) {
    std::error_code nobody_cares;
    if (!std::filesystem::exists(path, nobody_cares))
        return std::nullopt;
    const hdf5::InputFile file(path, "livermark arena --solve-reference");
    if (!file.has_attribute("/", "fingerprint") || file.text("/", "fingerprint") != fingerprint(problem, model))
        return std::nullopt;
    ToolReference reference;
    reference.model = model;
    describe_tool_reference(hdf5::GroupReader(file).on("tool_reference"), reference, problem);
    return reference;
}

void write_tool_scene(const std::filesystem::path &path, const core::Problem &problem, const ToolNodes &tool,
                      const Provenance &provenance) {
    const auto &mesh = problem.body->mesh;
    const auto &motion = problem.load_case.tool.value();
    hdf5::OutputFile file;
    hdf5::write_provenance(file, provenance);
    file.text("/", "body", problem.body->name);
    file.text("/", "load_case", problem.load_case.name);
    file.text("/", "title", problem.load_case.title);
    file.dataset("/points", mesh.points, "m");
    file.dataset("/tetrahedra", mesh.tetrahedra, "");
    file.dataset("/region", mesh.region, "");
    hdf5::describe_materials(hdf5::GroupWriter(file), problem.body->materials);
    file.dataset("/held", tool.held, "");
    file.group("/tool");
    file.dataset("/tool/time", core::record_times(motion), "s");
    file.dataset("/tool/nodes", tool.nodes, "");
    file.blocks("/tool/displacement", tool.displacement, tool.nodes.size(), "m");
    file.integer("/tool", "last_record_held", core::last_record_held(motion));
    file.number("/tool", "mass_damping", motion.mass_damping);
    support::write_whole(path, file.image());
}

OutsideMotion read_outside_motion(const std::filesystem::path &path, const core::Problem &problem) {
    return hdf5::read_once_tried(path, [&] { return motion_in(path, problem); });
}

} // namespace livermark::results
