#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "meshes/cutting/cut.hpp"

namespace livermark::meshes {

/// @throws support::InputError if the name of a mesh to write does not end in .msh
void check_name_of_mesh(const std::filesystem::path &mesh_file);

/// Writes <stem>.msh, and <stem>.toml beside it with the materials that the body has; small pieces that are kept as
/// <stem>_piece_2.msh and .toml and so on.
/// @param mesh_file  ends in .msh
/// @param command    that makes it again
/// @return the .toml files, that of the body first
/// @throws support::InputError if the place cannot be written to, or the name has another ending
std::vector<std::filesystem::path> write_cut_body(const std::filesystem::path &mesh_file, const CutBody &cut,
                                                  const std::string &command);

} // namespace livermark::meshes
