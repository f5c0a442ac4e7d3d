#pragma once

#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/model.hpp"

namespace livermark::studies {

/// What models have prepared for the body that is being worked on, by their names, so that load cases share it. That of
/// the body before goes first, so that there is room. For one thread.
class PreparedModels {
  public:
    PreparedModels() = default;

    /// @param common  of bodies, see core::PrepareModel: those of most_shared()
    explicit PreparedModels(std::vector<core::Problem> common) : common_(std::move(common)) {}

    core::Solution solve(const core::Model &model, const core::Problem &problem);

    /// @param problems  of one body, at least one
    std::vector<core::Solution> solve(const core::Model &model, std::span<const core::Problem> problems);

    /// Makes room.
    void clear();

  private:
    core::PreparedModel &on(const core::Model &model, const std::shared_ptr<const core::Body> &body);

    std::vector<core::Problem> common_;
    std::shared_ptr<const core::Body> body_;
    std::map<std::string, std::unique_ptr<core::PreparedModel>> prepared_;
};

} // namespace livermark::studies
