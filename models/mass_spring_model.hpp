#pragma once

#include <functional>
#include <string>

#include "core/model.hpp"
#include "models/model_table.hpp"
#include "msm/elastic_body.hpp"

namespace livermark::models {

/// What a mass-spring model makes of a body.
struct MassSprings {
    core::SpringNetwork springs; ///< kept in the result file
    msm::ElasticBody body;       ///< what moves: the springs, and what else resists
};

using MakeMassSprings = std::function<MassSprings(const core::Body &)>;

/// A model that comes to rest and moves in time as the options say.
core::Model mass_spring_model(std::string name, std::string summary, std::string source, const MakeMassSprings &make,
                              const ModelOptions &options);

} // namespace livermark::models
