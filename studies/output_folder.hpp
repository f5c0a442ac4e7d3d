#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/problem.hpp"
#include "support/file_claim.hpp"

namespace livermark::studies {

/// A folder for result files, made where it is missing. If nothing has come into a folder that was made, it is removed
/// again, so that refused input leaves none.
class OutputFolder {
  public:
    /// @throws support::InputError if it cannot be made
    explicit OutputFolder(std::filesystem::path path);
    ~OutputFolder();
    OutputFolder(const OutputFolder &) = delete;
    OutputFolder &operator=(const OutputFolder &) = delete;

    const std::filesystem::path &path() const { return path_; }

  private:
    std::filesystem::path path_;
    std::vector<std::filesystem::path> made_; ///< the inner ones first
};

/// A file in such a folder that this process alone writes as long as this lives.
class OutputFile {
  public:
    /// @throws support::InputError if the folder cannot be made, the file cannot be written, or another process is
    ///   about to write it
    OutputFile(const std::filesystem::path &folder, const std::string &name);
    /// The same in the folder of a body, <output>/<body>.
    OutputFile(const std::filesystem::path &output, const core::Problem &problem, const std::string &name)
        : OutputFile(output / problem.body->name, name) {}

    const std::filesystem::path &path() const { return path_; }

  private:
    std::unique_ptr<OutputFolder> folder_;
    std::filesystem::path path_;
    std::unique_ptr<support::FileClaim> claim_; ///< given back before the folder
};

} // namespace livermark::studies
