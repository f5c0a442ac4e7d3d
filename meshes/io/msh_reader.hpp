#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"

namespace livermark::meshes {

/// Reads and checks a gmsh mesh: MSH 1, 2.2 or 4.1, ASCII, coordinates in metres, linear tetrahedra. Physical volumes
/// become regions, physical surfaces patches.
/// The reader is our own because gmsh's crashes on damaged files and cannot name a line.
/// @throws support::InputError with file, line or entity, and remedy
/// @param remarks  gets a sentence where groups overlap, of which the smaller one counts, and for triangles that are no
///                 faces, which are left out
core::TetraMesh read_msh(const std::filesystem::path &file, std::vector<std::string> *remarks = nullptr);

/// The same from text. The name is for messages.
core::TetraMesh parse_msh(const std::string &text, const std::string &file,
                          std::vector<std::string> *remarks = nullptr);

} // namespace livermark::meshes
