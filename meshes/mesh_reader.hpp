#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/tetra_mesh.hpp"

namespace livermark::meshes {

/// Reads a mesh of any format: MSH in ASCII with read_msh(), everything else (binary MSH, VTK, VTU, Abaqus INP and what
/// else meshio knows) after scripts/convert_mesh, a process of its own that may fail without harm.
/// @param remarks  gets a sentence for each change that the conversion made
/// @return coordinates as they are in the file
/// @throws support::InputError with the file, what is wrong and a remedy
core::TetraMesh read_mesh(const std::filesystem::path &file, std::vector<std::string> &remarks);

/// Metres per unit of length: "m", "cm" or "mm".
/// @throws support::InputError for another word; place is named in it
double metres_per_unit(const std::string &unit, const std::string &place);

/// The unit that makes an organ of the mesh: the longest side of the bounding box up to 2 is in metres, up to 60 in
/// centimetres, up to 2000 in millimetres.
/// @throws support::InputError if it is longer, or not positive
std::string guess_unit(const core::TetraMesh &mesh, const std::string &file);

} // namespace livermark::meshes
