#pragma once

#include <filesystem>

#include "support/input_error.hpp"

namespace livermark::results {

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

/// What a file is, from the groups in it; `other` for HDF5 that holds none of these, such as an exported problem.
/// @throws support::InputError if the file cannot be read, is damaged or no HDF5; FileInUse
FileKind kind_of_file(const std::filesystem::path &path);

} // namespace livermark::results
