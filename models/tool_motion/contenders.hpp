#pragma once

#include <span>

#include "models/tool_motion/contender.hpp"
#include "msm/elastic_body.hpp"

/// Where contenders come from.
namespace livermark::models {

/// Springs that take explicit steps in the arena.
struct MovingSpringModel {
    std::string name;
    std::string source; ///< literature reference
    livermark::msm::ElasticBody (*make)(const core::Body &body);
    bool is_scaled = false; ///< there is a contender with masses scaled in stiff parts as well
    bool only_when_named = false;
};

std::span<const MovingSpringModel> moving_spring_models();

std::vector<Contender> spring_contenders();
std::vector<Contender> interactive_contenders(Precision precision);

} // namespace livermark::models
