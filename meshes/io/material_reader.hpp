#pragma once

#include <string>

#include "core/problem.hpp"
#include "support/toml_input.hpp"

namespace livermark::meshes {

/// Refuses what no material has.
/// @param place  where it is from, for messages
/// @throws support::InputError for a density or Young's modulus that is not positive, a Poisson's ratio outside (-1,
/// 0.5)
///   or too close to 0.5
void check_material(const core::Material &material, const std::string &place);

/// @throws support::InputError for a key that no material has
void refuse_unknown_material_keys(const toml::table &table);

/// Reads density [kg/m^3], young_modulus [Pa], poisson_ratio and, where it is there, source of a table.
/// @throws support::InputError for a missing or unknown key, or as check_material()
core::Material read_material(const toml::table &table);

} // namespace livermark::meshes
