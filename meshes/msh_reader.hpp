#pragma once

#include <filesystem>
#include <string>

#include "core/tetra_mesh.hpp"

namespace livermark::meshes {

/// Reads and checks a gmsh mesh: MSH 1, 2.2 or 4.1, ASCII, coordinates in metres, linear tetrahedra. Physical volumes
/// become regions, physical surfaces patches.
/// The reader is our own because gmsh's crashes on damaged files and cannot name a line.
/// @throws support::InputError with file, line or entity, and remedy
core::TetraMesh read_msh(const std::filesystem::path &file);

/// The same from text. The name is for messages.
core::TetraMesh parse_msh(const std::string &text, const std::string &file);

} // namespace livermark::meshes
