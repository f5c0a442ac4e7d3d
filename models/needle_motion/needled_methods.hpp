#pragma once

#include "interactive/method.hpp"
#include "models/needle_motion/needled_body.hpp"
#include "models/tool_motion/moving_methods.hpp"

/// Where methods with a needle come from.
namespace livermark::models {

PrepareNeedled needled_springs(const MovingSpringModel &model);
PrepareNeedled needled_interactive(const interactive::Method &method);

} // namespace livermark::models
