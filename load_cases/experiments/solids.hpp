#pragma once

#include <toml++/toml.h>

#include "load_cases/experiments/experiment.hpp"

/// Bodies of experiments without a mesh of their own. Internal to load_cases/experiments.
namespace livermark::experiments {

/// Material of a table, as bodies have it, and beside that `laws` with the constants of hyperelastic laws.
/// @throws support::InputError
core::Material material_of(const toml::table &table);

/// Takes the solid of a table, whose key "box", "cylinder" or "sphere" says which it is, and how to mesh it.
/// @throws support::InputError
void read_solid(const toml::table &table, const core::Material &material, Experiment &experiment);

} // namespace livermark::experiments
