#pragma once

#include <filesystem>
#include <string>

#include "core/mesh/tetra_mesh.hpp"
#include "meshes/generators/liver/liver_variation.hpp"

namespace livermark::meshes {

/// Writes <stem>.msh, and <stem>.toml beside it with the materials of the bodies that ship: parenchyma of 5 kPa,
/// lesions of 50 kPa, Poisson's ratio 0.45 and 1060 kg/m^3 everywhere.
/// @param mesh_file  ends in .msh
/// @param command    that makes it again
/// @throws support::InputError if the place cannot be written to, or the name has another ending
void write_liver_body(const std::filesystem::path &mesh_file, const core::TetraMesh &mesh, const LiverVariant &variant,
                      const std::string &command);

} // namespace livermark::meshes
