#include "results/hdf5/files/reference_file.hpp"

#include <fmt/format.h>

#include "results/hdf5/file_parts.hpp"
#include "results/hdf5/io/hdf5_io.hpp"
#include "results/hdf5/io/schema.hpp"
#include "results/hdf5/solution_group.hpp"
#include "results/problem_key.hpp"
#include "support/whole_file.hpp"

namespace livermark::results {

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

} // namespace livermark::results
