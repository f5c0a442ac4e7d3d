#pragma once

#include <filesystem>
#include <string>

namespace livermark::meshes {

/// Whether the name of a file says that it is a surface: STL, OBJ, PLY or OFF.
bool has_surface_ending(const std::filesystem::path &file);

/// Whether the name or the first lines of a file say that it is a surface: STL, OBJ, PLY, OFF, VTP, or VTK polydata.
bool is_surface_file(const std::filesystem::path &file);

/// What a file begins with, where programs write what it is: a thousand bytes at most. Nothing of what is no plain
/// file; a pipe would keep us waiting.
std::string first_bytes(const std::filesystem::path &file);

} // namespace livermark::meshes
