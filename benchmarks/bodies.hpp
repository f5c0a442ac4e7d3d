#pragma once

#include <memory>
#include <span>
#include <string>

#include "core/problem.hpp"

namespace livermark::benchmarks {

/// Names of the bodies of benchmarks, the smallest first: liver_healthy and liver_tumours as they ship (20,182 and
/// 24,299 springs), and liver_refined_once and liver_refined_twice (154,700 and 1.21 million), liver_healthy with every
/// tetrahedron cut into eight once or twice.
std::span<const std::string> body_names();

/// Makes a body, in seconds. The order of nodes that comes out of a refinement is one that no mesh generator gives, so
/// refined bodies are put in reverse Cuthill-McKee order; the others keep that of their file.
/// @throws support::InputError if there is none of that name
std::shared_ptr<const core::Body> make_body(const std::string &name);

/// How often the tetrahedra of a body were cut into eight.
/// @throws support::InputError if there is none of that name
int num_refinements(const std::string &name);

/// Held where ligaments and veins hold a liver, the patch `posterior`; no loads.
/// @throws support::InputError if the body has no such patch
core::LoadCase constrained(const core::Body &body);

} // namespace livermark::benchmarks
