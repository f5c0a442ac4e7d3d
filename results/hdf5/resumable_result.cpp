#include "results/hdf5/resumable_result.hpp"

#include "results/hdf5/result_file.hpp"
#include "results/problem_key.hpp"
#include "support/input_error.hpp"

namespace livermark::results {

std::optional<Result> resumable_result(const std::filesystem::path &file, const core::Problem &problem,
                                       const Provenance &provenance) {
    std::error_code error;
    if (!std::filesystem::exists(file, error))
        return {};
    try {
        auto kept = read_result(file);
        if (kept.provenance.command == provenance.command && kept.provenance.git_commit == provenance.git_commit &&
            kept.provenance.build_type == provenance.build_type && problem_key(kept.problem) == problem_key(problem))
            return kept;
    } catch (const support::InputError &) {
        return {}; // not a whole result file, so nothing to go on from
    }
    return {};
}

} // namespace livermark::results
