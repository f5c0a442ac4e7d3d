#pragma once

#include <filesystem>

#include "core/mesh/tetra_mesh.hpp"

namespace livermark::meshes {

/// Writes a body as a gmsh file, MSH 4.1 ASCII: the same mesh gives the same bytes. Node tag i + 1 is node i; a
/// physical group of dimension 3 stands for each region and one of dimension 2 for each patch, with their names and, as
/// tags, their indices + 1. Elements come patch by patch and region by region, each in the order of the mesh.
/// Coordinates [m] are written in the shortest form that reads back as the same number. The file appears whole or not
/// at all.
/// @throws support::InputError  if the file cannot be written
void write_msh(const std::filesystem::path &file, const core::TetraMesh &mesh);

} // namespace livermark::meshes
