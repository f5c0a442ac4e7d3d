#pragma once

#include <filesystem>

#include "results/records/result.hpp"

namespace livermark::results {

/// Writes an HDF5 file as described in results/schema.md. The file appears under its name when it is whole: it is
/// written under a temporary name in the same directory and renamed, and an earlier file stays as it was if that fails.
/// @param path    in a directory that exists
/// @param result  every array of the shape that its struct says; model names unique, not empty, without '/' and '.'
/// @throws support::InputError if the place cannot be written to
/// @throws std::invalid_argument if the shapes or names are not as said
void write_result(const std::filesystem::path &path, const Result &result);

/// Maker of a file.
enum class Origin {
    own,     ///< this run
    outside, ///< anybody: it is read in a process of its own first, which a damaged file may end
};

/// Reads what write_result wrote. Shapes, types and ranges are checked, so that nothing after it needs to.
/// Displacements, reactions, errors and norms may be NaN or infinite: that is how a diverged solution looks.
/// @throws support::InputError that names the file and the dataset or attribute, and says what is wrong and what to do
Result read_result(const std::filesystem::path &path, Origin origin = Origin::outside);

/// A single solution without its problem, not compressed: for another process of the same run, which has the problem
/// and reads it soon.
/// @param load_case  of its problem
/// @throws support::InputError if the place cannot be written to
void write_solution(const std::filesystem::path &path, const core::Solution &solution, const core::LoadCase &load_case);

/// Reads what write_solution wrote.
/// @param problem  that it is a solution of
/// @throws support::InputError as read_result()
core::Solution read_solution(const std::filesystem::path &path, const core::Problem &problem);

} // namespace livermark::results
