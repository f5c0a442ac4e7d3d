#include "results/hdf5/files/tool_scene_file.hpp"

#include <fmt/format.h>
#include <limits>

#include "results/hdf5/file_parts.hpp"

namespace livermark::results {

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

namespace {

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

OutsideMotion read_outside_motion(const std::filesystem::path &path, const core::Problem &problem) {
    return hdf5::read_once_tried(path, [&] { return motion_in(path, problem); });
}

} // namespace livermark::results
