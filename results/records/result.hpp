#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/error_norms.hpp"
#include "core/problem.hpp"
#include "core/solution.hpp"
#include "results/reference_uncertainty.hpp"

namespace livermark::results {

/// Where a result comes from.
struct Provenance {
    std::string software_version;
    std::string git_commit; ///< of the tree that was built, "-dirty" behind it if that was modified, or "unknown"
    std::string created;    ///< ISO 8601, UTC
    std::string command;    ///< command line
    std::string cpu;
    std::string compiler;
    std::string build_type;
    int threads = 1; ///< hardware threads that the program could use

    bool operator==(const Provenance &) const = default;
};

/// The solution of one model, and how good it is.
struct ModelResult {
    std::string name; ///< name of the model; no '/' and no '.'
    std::string summary;
    std::string source;
    core::Solution solution;
    std::optional<core::Comparison> comparison; ///< none for the reference, and if the reference failed
};

/// The modes that one model found.
struct ModelModes {
    std::string name; ///< name of the model; no '/' and no '.'
    core::Modes modes;
};

/// All that is known about one body under one load case: the content of one result file.
struct Result {
    Provenance provenance;
    core::Problem problem;
    std::vector<ModelResult> models;
    std::optional<ReferenceUncertainty> reference_uncertainty{}; ///< none if the refined reference was not solved
    std::vector<ModelModes> modes{};
    std::optional<MotionUncertainty> motion_uncertainty{}; ///< none if no finer motion is known
};

/// Whether a model is closer to the reference than the reference is known to be to the exact solution: it can then not
/// be told from another such model, and is not to be ranked above one.
inline bool is_within_uncertainty(const ModelResult &model, const Result &result) {
    return model.solution.status == core::SolutionStatus::ok && model.comparison && result.reference_uncertainty &&
           model.comparison->relative_l2 < result.reference_uncertainty->relative_l2;
}

/// Whether it is the static result of a load case as it was written: not of a motion or a slow history, nor of a
/// multiple of the loads, whose name has an '@'.
inline bool is_plain_static(const Result &result) {
    const auto &load_case = result.problem.load_case;
    return !load_case.in_time() && load_case.name.find('@') == std::string::npos;
}

/// Of the first region; runs over several Poisson's ratios give every region the same.
inline double poisson_ratio(const Result &result) {
    return result.problem.body->materials.front().poisson_ratio;
}

} // namespace livermark::results
