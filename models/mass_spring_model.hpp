#pragma once

#include <functional>
#include <string>

#include "core/model.hpp"
#include "models/model_table.hpp"
#include "msm/springs_with_volume.hpp"

namespace livermark::models {

using MakeMassSprings = std::function<msm::MassSprings(const core::Body &)>;

/// A model that comes to rest and moves in time as the options say.
core::Model mass_spring_model(std::string name, std::string summary, std::string source, const MakeMassSprings &make,
                              const ModelOptions &options);

} // namespace livermark::models
