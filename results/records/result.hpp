#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/error_norms.hpp"
#include "core/modes.hpp"
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

/// What the relative_l2 of a model on a problem is known to be. Being better than the band is a miss as well: an
/// improvement that nobody can explain is as suspicious as a regression.
struct ErrorBand {
    double expected = 0.0; ///< relative_l2
    double margin = 0.0;   ///< half the width of the band, same unit
    std::string origin;    ///< where the expected value comes from

    /// True in [expected - margin, expected + margin]; false for NaN.
    bool contains(double relative_l2) const {
        return relative_l2 >= expected - margin && relative_l2 <= expected + margin;
    }
    bool operator==(const ErrorBand &) const = default;
};

/// The solution of one model, and how good it is.
struct ModelResult {
    std::string name; ///< name of the model; no '/' and no '.'
    std::string summary;
    std::string source;
    core::Solution solution;
    std::optional<core::Comparison> comparison; ///< none for the reference, and if the reference failed
    std::optional<ErrorBand> band;
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

/// Whether a model did what it was expected to. A solution that is not ok or was not compared misses its band.
/// @return nothing if the model has no band
inline std::optional<bool> meets_band(const ModelResult &model) {
    if (!model.band)
        return std::nullopt;
    return model.solution.status == core::SolutionStatus::ok && model.comparison &&
           model.band->contains(model.comparison->relative_l2);
}

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
    return !load_case.release && !load_case.slow_history && load_case.name.find('@') == std::string::npos;
}

/// Of the first region; runs over several Poisson's ratios give every region the same.
inline double poisson_ratio(const Result &result) {
    return result.problem.body->materials.front().poisson_ratio;
}

} // namespace livermark::results
