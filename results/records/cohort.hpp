#pragma once

#include <filesystem>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/load_case.hpp"
#include "core/mesh/tetra_mesh.hpp"
#include "core/solution.hpp"
#include "results/records/result.hpp"

/// Errors of models over the bodies of a cohort: many bodies of one kind whose names end in their number. Their
/// statistics are those of python/livermark/studies/cohort.py.
namespace livermark::results {

/// Half of the cohort that a body is in: "training" if its name ends in an odd number, "unseen" if in an even one;
/// nothing if it ends in none. Constants of models may be chosen on the training half, and accuracy is quoted on the
/// unseen one.
std::optional<std::string> cohort_half(const std::string &body);

/// Error of one model on one body under one load case.
struct CohortError {
    std::string body;
    core::Regime regime = core::Regime::small;
    double poisson_ratio = 0.0; ///< of the first region
    std::string load_case;
    std::string model;
    core::SolutionStatus status = core::SolutionStatus::ok;
    double relative_l2 = 0.0;    ///< as in its comparison with the reference; NaN where it was not compared
    double reaction_error = 0.0; ///< the same
    /// core::ToolComparison::worst_stiffness(); NaN also where the load case has no tool.
    double stiffness = std::numeric_limits<double>::quiet_NaN();
    std::string reference{}; ///< that it was compared with; empty where nothing was, and in older files
    /// core::radius_in_edges() of the load case on the body; NaN where it has no tool, and in older files.
    double tool_radius_in_edges = std::numeric_limits<double>::quiet_NaN();
    /// Bars of the reference's relative_l2 and stiffness (ReferenceUncertainty); NaN where they are not known, as of a
    /// reference on the mesh itself, and in older files.
    double uncertainty = std::numeric_limits<double>::quiet_NaN();
    double stiffness_uncertainty = std::numeric_limits<double>::quiet_NaN();
};

/// One for each model that was compared or has not come to an end. Bodies that are in no half, load cases that depend
/// on time, multiples of a load case, and what leaves its regime or ends at rest (see one_reference.hpp) are left out.
std::vector<CohortError> cohort_errors(std::span<const Result> results);

/// An ellipsoid in a body.
struct CohortLesion {
    core::Vector3 center;    ///< [m]
    core::Vector3 semi_axes; ///< [m], in any direction
};

/// A body as it was drawn.
struct CohortBody {
    int number = 0; ///< that it was drawn by
    std::string name;
    double volume = 0.0;        ///< [m^3]
    double body_surface = 0.0;  ///< of the person [m^2]
    double left_part = 0.0;     ///< of the volume, in the left lobe
    double front_to_back = 1.0; ///< thickness, relative to the liver that ships at the same volume
    bool has_riedel_lobe = false;
    std::vector<CohortLesion> lesions;
};

/// The content of one cohort file, without its statistics.
struct Cohort {
    Provenance provenance;
    int tetrahedra = 0; ///< of each body, about; 0: as many as the bodies that ship have
    std::vector<CohortBody> bodies;
    std::vector<CohortError> errors;   ///< of these bodies alone
    std::vector<std::string> failures; ///< a sentence for each body or load case that has no result
};

/// Writes the "cohort files" of results/schema.md, but for the statistics, as write_result() writes results.
/// @throws support::InputError if the place cannot be written to
void write_cohort(const std::filesystem::path &path, const Cohort &cohort);

/// Reads what write_cohort wrote.
/// @throws support::InputError that names the file and the dataset or attribute, and says what is wrong and what to do
Cohort read_cohort(const std::filesystem::path &path);

} // namespace livermark::results
