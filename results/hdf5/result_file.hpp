#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/support/input_error.hpp"
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

/// Another program has the file open to write.
class FileInUse : public support::InputError {
  public:
    using support::InputError::InputError;
};

/// The kinds of files that results/schema.md describes.
enum class FileKind {
    result,
    modes,
    stability,
    timings,
    calibration,
    cohort,
    arena,
    experiment,
    needle,
    sensitivity,
    other
};

/// Kind of a file, from the groups in it; `other` for HDF5 that holds none of these, such as an exported problem.
/// @throws support::InputError if the file cannot be read, is damaged or no HDF5; FileInUse
FileKind kind_of_file(const std::filesystem::path &path);

/// Every .h5 file below a folder, whatever is in it, by name.
/// @throws support::InputError if the folder cannot be listed
std::vector<std::filesystem::path> hdf5_files_below(const std::filesystem::path &folder);

/// Reads result files, and what is below folders, by name. In folders, files that other commands leave there and that
/// have no models are left out, and what cannot be read is passed over with a line on standard error.
/// @throws support::InputError if a folder cannot be listed, a file that is named cannot be read, or nothing is there
std::vector<Result> read_results(std::span<const std::filesystem::path> paths);

/// Name of the body of a result file, without the rest of it.
/// @throws support::InputError as read_result(); FileInUse
std::string body_in(const std::filesystem::path &path);

/// Whether a file says that it contains what the page of `livermark view` shows: solutions of models, or models beside
/// an experiment. Reading it may still find a fault.
/// @throws FileInUse if another program has it open to write, so that nobody can say
bool is_shown_on_page(const std::filesystem::path &path);

/// The result file of a benchmark case that was evaluated before, if evaluating it again would give the same: made by
/// the same command and commit, on the same mesh, materials and loads.
/// @return empty if there is no such file, or if it is damaged: the benchmark case has to be evaluated again
std::optional<Result> resumable_result(const std::filesystem::path &file, const core::Problem &problem,
                                       const Provenance &provenance);

/// Result files know a body by its name, and two patients may have files of one name. Where bodies of one name have
/// different meshes, each is called <name>#<eight digits of its mesh> from here on, so that no table mixes them.
/// @return a sentence for each such name
std::vector<std::string> tell_bodies_apart(std::span<Result> results);

} // namespace livermark::results
