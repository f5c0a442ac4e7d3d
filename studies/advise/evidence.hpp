#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "results/hdf5/files/cohort_file.hpp"

/// How wrong models were on bodies on which nothing of theirs was chosen, as far as those resemble the body in
/// question.
namespace livermark::studies {

/// Where cohort files that ship stand below the root.
inline constexpr const char *cohorts_folder = "results/cohorts";

/// The body in question, as far as errors depend on it.
struct BodyInQuestion {
    double poisson_ratio = 0.0;        ///< of the region of the largest volume
    double tool_radius_in_edges = 0.0; ///< radius of the tool over the mean length of edges of the surface, > 0
    int tetrahedra = 0;
};

/// What is known of one model. Errors are relative, and NaN where nothing is known. Where a model has not come to an
/// end it counts in medians as infinitely wrong.
struct ExpectedError {
    std::string model;
    double at_tool = nan;          ///< median of the absolute value of stiffness at the tool under small loads
    double worst_at_tool = nan;    ///< the one of the largest absolute value, with its sign
    std::string worst_load_case{}; ///< of that one
    double relative_l2 = nan;      ///< median under small loads
    double worst_relative_l2 = nan;
    double large_at_tool = nan, large_relative_l2 = nan; ///< medians under large loads, along their paths at the tool
    std::size_t num_at_tool = 0, num_l2 = 0, num_large = 0; ///< of how many load cases on bodies these are
    std::size_t num_failed = 0, num_large_failed = 0;       ///< and on how many of these it has not come to an end

    static constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    /// The larger one of both regimes; NaN unless both are known.
    double in_both_at_tool() const { return std::isnan(at_tool) ? nan : std::max(large_at_tool, at_tool); }
    double in_both_relative_l2() const {
        return std::isnan(relative_l2) ? nan : std::max(large_relative_l2, relative_l2);
    }
};

/// Errors of all models, and what they are of.
struct Evidence {
    double poisson_ratio = 0.0;                                    ///< the nearest one at which errors are known
    double least_poisson_ratio = 0.0, largest_poisson_ratio = 0.0; ///< of all that are known
    double least_radius = 0.0, largest_radius = 0.0;               ///< of the tools of ExpectedError::at_tool, in edges
    int tetrahedra = 0;                ///< of the bodies of ExpectedError::relative_l2, as results::Cohort has it
    std::size_t num_bodies = 0;        ///< of the same
    std::string reference;             ///< that errors under small loads are against
    std::string large_reference{};     ///< the same of large ones; empty where none are known
    double large_poisson_ratio = 0.0;  ///< of these
    std::vector<ExpectedError> models; ///< in alphabetical order
    std::vector<std::string> sources;  ///< a sentence for each file

    /// @return nullptr for a model of which nothing is known
    const ExpectedError *find(const std::string &model) const;
};

/// A cohort file that was read.
struct KnownCohort {
    std::string file; ///< for people
    results::Cohort cohort;
};

/// Those that ship.
/// @throws support::InputError if there is none, or one cannot be read
std::vector<KnownCohort> shipped_cohorts();

/// "livers of about 5000 tetrahedra".
/// @param tetrahedra  of results::Cohort: 0 where nobody asked for another number than the livers that ship have
std::string size_in_words(const char *bodies, int tetrahedra);

/// Errors of the unseen halves at the nearest Poisson's ratio. Under small loads those at the tool are of all cohorts
/// and of load cases whose tools have nearly as many edges in their radius; those of the displacement are of the cohort
/// of nearest number of tetrahedra and of all load cases. Under large loads both are of all that is known.
/// @throws support::InputError if the cohorts have no errors under small loads
Evidence find_evidence(std::span<const KnownCohort> cohorts, const BodyInQuestion &question);

/// The same of what ships.
Evidence shipped_evidence(const BodyInQuestion &question);

} // namespace livermark::studies
