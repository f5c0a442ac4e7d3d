#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "core/model.hpp"
#include "msm/springs/springs.hpp"
#include "studies/models/model_table.hpp"

namespace livermark::models {

using MakeMassSprings = std::function<msm::MassSprings(const core::Body &)>;

/// A model that comes to rest and moves in time as the options say.
core::Model mass_spring_model(std::string name, std::string summary, std::string source, const MakeMassSprings &make,
                              const ModelOptions &options);

/// Whether a model is one of mass_spring_model().
bool has_springs(const core::Model &model);

/// The springs of a model on a body, as it solves and moves with them; nothing of a model that is none of
/// mass_spring_model().
std::optional<msm::MassSprings> springs_of(const core::Model &model, const std::shared_ptr<const core::Body> &body);

} // namespace livermark::models
