#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "core/problem.hpp"
#include "core/solution.hpp"
#include "support/processes/child_process.hpp"

namespace livermark::studies {

/// A folder for temporary files, in which workers leave solutions of models for each other: see support::ScratchFolder.
class SolutionStore {
  public:
    /// @param number  of the problem
    /// @throws support::InputError if the disk is full
    void leave(std::size_t number, const std::string &model, const core::Solution &solution,
               const core::Problem &problem) const;

    /// @return nothing if none was left
    std::optional<core::Solution> find(std::size_t number, const std::string &model,
                                       const core::Problem &problem) const;

  private:
    std::filesystem::path file(std::size_t number, const std::string &model) const;

    support::ScratchFolder folder_;
};

} // namespace livermark::studies
