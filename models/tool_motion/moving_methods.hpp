#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "models/tool_motion/moving_method.hpp"
#include "msm/cutting/cut_parts.hpp"
#include "msm/elastic_body.hpp"

/// Where methods come from.
namespace livermark::models {

/// Springs that take explicit steps in the arena.
struct MovingSpringModel {
    std::string name;
    std::string source;    ///< literature reference
    std::string objection; ///< as of MovingMethod
    livermark::msm::ElasticBody (*make)(const core::Body &body);
    /// Where their stiffness comes from; nothing of coupled springs
    std::optional<livermark::msm::SpringSource> (*spring_source)(const core::Body &body);
    bool is_scaled = false; ///< there is a method with masses scaled in stiff parts as well
    bool only_when_named = false;
};

std::span<const MovingSpringModel> moving_spring_models();

/// What a method with scaled masses has beside one without them.
inline constexpr const char *scaled_name = "_mass_scaled",
                            *scaled_source = "; Olovsson, Simonsson, Unosson 2005, IJNME 63(10)",
                            *scaled_implementation = ", stiff parts heavier against deformation",
                            *scaled_limit = "; in motion, that of a body whose stiff parts are heavier";

std::vector<MovingMethod> moving_springs();
std::vector<MovingMethod> interactive_moving_methods();

} // namespace livermark::models
