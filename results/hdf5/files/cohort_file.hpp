#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"
#include "results/records/cohort.hpp"
#include "results/records/result.hpp"

namespace livermark::results {

/// An ellipsoid in a body.
struct CohortLesion {
    core::Vector3 center;    ///< [m]
    core::Vector3 semi_axes; ///< [m], in any direction
};

/// What was drawn for one body.
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
