#pragma once

#include <span>
#include <string>
#include <vector>

#include "results/records/result.hpp"

namespace livermark::results {

/// Result files know a body by its name, and two patients may have files of one name. Where bodies of one name have
/// different meshes, each is called <name>#<eight digits of its mesh> from here on, so that no table mixes them.
/// @return a sentence for each such name
std::vector<std::string> tell_bodies_apart(std::span<Result> results);

} // namespace livermark::results
