#pragma once

#include <string>
#include <vector>

#include "core/solution.hpp"
#include "msm/engine_parameters.hpp"

namespace livermark::msm {

/// Springs that stand beside an engine's own model of tissue, for an engine that takes any:
///   capsule_edges, capsule_stiffness, capsule_length   springs of core::capsule_springs
///   vessel_points                                      points that move with the tetrahedra that have them
///   vessel_springs, vessel_stiffness, vessel_length    springs of core::vessel_springs between two of these each
/// @return those of what the body has
std::vector<EngineArray> springs_beside(const core::Body &body);

/// Sentences on what an engine leaves out of these.
std::vector<std::string> left_out_beside(const core::Body &body, const Engine &engine);

/// A sentence on springs of a law, which have the capsule too.
std::string note_on_springs(const core::SpringNetwork &springs, const core::Body &body, const std::string &law);

} // namespace livermark::msm
