#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "core/error_norms.hpp"
#include "core/problem.hpp"
#include "core/solution.hpp"

namespace livermark::results {

/// Distance of the reference itself from the exact solution of linear elasticity on this body, as far as one can tell.
struct ReferenceUncertainty {
    std::string reference; ///< the model that all others are compared with
    std::string refined;   ///< the same elements on the mesh refined once
    /// core::Comparison::relative_l2 of the elements on the mesh against those on the refined mesh
    double refinement_difference = 0.0;
    double order = 0.0;          ///< of convergence in the mesh size that the estimate assumes
    double relative_l2 = 0.0;    ///< estimated error of the reference in the norm of core::Comparison
    double energy_error = 0.0;   ///< estimated, of its strain energy, relative, not signed
    double reaction_error = 0.0; ///< estimated, of its reactions, as in core::Comparison
    /// Estimated, of its stiffness at the tool, as in core::ToolComparison, not signed; nothing without a tool, and of
    /// references that were stored without it.
    std::optional<double> stiffness{};
    bool operator==(const ReferenceUncertainty &) const = default;
};

/// Distance of the motion that others are compared with from the exact one.
struct MotionUncertainty {
    std::string reference; ///< the model whose motion all others are compared with: one of the two
    std::string refined;   ///< the one on finer meshes
    /// core::HistoryComparison::relative_l2 of the model on the mesh against the refined one; NaN where there is none
    double difference = 0.0;
    double order = 0.0;       ///< of convergence of the refined one, from mesh to mesh; without one in the steps
    double relative_l2 = 0.0; ///< estimated error of the reference, in the norm of core::HistoryComparison
    bool operator==(const MotionUncertainty &) const = default;

    /// Whether only the error of the steps is known, and not that of the mesh.
    bool is_of_steps_alone() const { return std::isnan(difference); }
};

/// The refined motion is off by what it has observed itself, or where it has not by as much as the two differ
/// (order_at_patch_edges on meshes of half the size). That on the mesh is off by the difference, and at most by that
/// besides; where it is estimated to be more than largest_coarse_error, the refined motion is the reference. What the
/// motion on the mesh has observed of its steps adds to both, of the refined motion with the square of the ratio of
/// their lengths.
/// @throws std::invalid_argument if they were recorded at other times or probes
MotionUncertainty estimate_motion_uncertainty(const core::History &coarse, const std::string &coarse_name,
                                              const core::History &refined, const std::string &refined_name);

/// Uncertainty where no motion on finer meshes is there: of the steps alone, or nothing.
std::optional<MotionUncertainty> uncertainty_of_steps(const core::History &motion, const std::string &name);

/// The order that estimates assume. Where a constrained part of a smooth boundary meets a free one, displacements go
/// with the square root of the distance (Grisvard 1985), and finite elements of any degree converge in L2 and in energy
/// with the first power of the mesh size only. Where nothing is singular the order is higher, and the estimate too
/// large.
inline constexpr double order_at_patch_edges = 1.0;

/// Estimates the errors of the elements on the mesh and on the refined mesh from their difference d (Richardson): of
/// errors C h^p, the coarse one is d / (1 - 2^-p) and the fine one d / (2^p - 1). The finer solution is the reference
/// if the coarser one's relative_l2 is estimated to be above largest_coarse_error.
/// @param mesh, load_case  of both
/// @param coarse   status ok
/// @param refined  at the nodes of the mesh, status ok, not zero everywhere
/// @throws std::invalid_argument if the shapes differ, or if refined is no solution
ReferenceUncertainty estimate_uncertainty(const core::TetraMesh &mesh, const core::LoadCase &load_case,
                                          const core::Solution &coarse, const std::string &coarse_name,
                                          const core::Solution &refined, const std::string &refined_name);
inline constexpr double largest_coarse_error = 0.01;

/// Origin of a result.
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

/// Poisson's ratio of the first region; runs over several Poisson's ratios give every region the same.
inline double poisson_ratio(const Result &result) {
    return result.problem.body->materials.front().poisson_ratio;
}

/// Commit that the program was built from; git_commit.cmake writes the definition at every build.
const char *git_commit();

/// This program, the machine that it runs on, and the time.
/// The commit is that of the tree when the program was built: "-dirty" behind it if anything was modified or untracked,
/// "unknown" if it was not built from a git repository.
/// @param command  command line, as the user would type it again
Provenance current_provenance(std::string command);

} // namespace livermark::results
