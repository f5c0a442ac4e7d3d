#pragma once

#include "models/tool_motion/contender.hpp"

/// Where contenders come from.
namespace livermark::models {

std::vector<Contender> spring_contenders();
std::vector<Contender> interactive_contenders();

} // namespace livermark::models
