#include "results/hdf5/files/tool_reference_file.hpp"

#include <array>

#include "results/hdf5/file_parts.hpp"
#include "results/problem_key.hpp"
#include "support/whole_file.hpp"

namespace livermark::results {

namespace {

constexpr const char *group = "/tool_reference";

void write_errors(hdf5::OutputFile &file, const std::string &name, const core::ToolErrors &errors) {
    file.number(group, name + "_contact", errors.contact);
    file.number(group, name + "_after", errors.after);
    file.number(group, name + "_force", errors.force);
}

core::ToolErrors read_errors(const hdf5::InputFile &file, const std::string &name) {
    return {.contact = file.number(group, name + "_contact"),
            .after = file.number(group, name + "_after"),
            .force = file.number(group, name + "_force"),
            .over_time = {}};
}

} // namespace

void write_tool_reference(const std::filesystem::path &path, const ToolReference &reference,
                          const core::Problem &problem, const Provenance &provenance) {
    hdf5::OutputFile file;
    hdf5::write_provenance(file, provenance);
    file.text("/", "body", problem.body->name);
    file.text("/", "load_case", problem.load_case.name);
    file.text("/", "model", reference.model);
    file.text("/", "fingerprint", fingerprint(problem, reference.model));
    file.group(group);
    file.integer(group, "level", reference.level);
    file.integer(group, "steps_per_frame", reference.steps_per_frame);
    write_errors(file, "last_refinement", reference.last_refinement);
    write_errors(file, "half_steps", reference.half_steps);
    file.dataset(std::string(group) + "/time", reference.history.time, "s");
    file.dataset(std::string(group) + "/force", reference.history.force, "N");
    file.blocks(std::string(group) + "/displacement", reference.history.displacement, problem.body->mesh.points.size(),
                "m");
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
    reference.level = static_cast<int>(file.integer(group, "level"));
    reference.steps_per_frame = static_cast<int>(file.integer(group, "steps_per_frame"));
    reference.last_refinement = read_errors(file, "last_refinement");
    reference.half_steps = read_errors(file, "half_steps");
    const int num_records = problem.load_case.tool.value().num_records();
    reference.history.time = file.dataset<double>(std::string(group) + "/time", num_records);
    reference.history.force = file.dataset<core::Vector3>(std::string(group) + "/force", num_records);
    reference.history.displacement =
        file.blocks<Eigen::Vector3f>(std::string(group) + "/displacement", core::ToolHistory::num_fields(num_records),
                                     problem.body->mesh.points.size());
    return reference;
}

} // namespace livermark::results
