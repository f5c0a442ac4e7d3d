#include "results/hdf5/files/tool_reference_file.hpp"

#include "results/hdf5/file_parts.hpp"
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

} // namespace

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

} // namespace livermark::results
