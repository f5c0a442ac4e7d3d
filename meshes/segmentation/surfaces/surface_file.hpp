#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "meshes/generators/surface_mesh.hpp"

namespace livermark::segmentation {

/// Reads a closed triangulated surface: STL, OBJ, PLY or OFF, and, after scripts/convert_surface, VTK and VTP polydata
/// and what meshio reads. Readers and repairs run in
/// a process of their own, which may fail on a damaged file. Of tetrahedra the boundary is taken. Corners in the same
/// place become one, the triangles are turned so that they look outwards, and what is not as it should be is repaired:
/// see closed_parts(). Files in which 3D Slicer has written that they are RAS are turned to LPS.
/// @param remarks  gets a sentence for each change
/// @return coordinates as they are in the file, but for that; of several parts that cut each other the union counts
/// @throws support::InputError  with the file, the place and a remedy: not such a file, no triangles, coordinates that
///                           are no numbers, open edges, triangles that cut each other and cannot be repaired
meshes::SurfaceMesh read_surface(const std::filesystem::path &file, std::vector<std::string> &remarks);

/// Reads a file of lesions in the same way: each closed part by itself is one, the largest first, and parts that cut
/// each other are one together.
std::vector<meshes::SurfaceMesh> read_lesions(const std::filesystem::path &file, std::vector<std::string> &remarks);

/// Rules that a surface file has to keep for a reader that takes its format strictly.
struct PlainSurfaceText {
    std::optional<std::string> text; ///< nothing if the file can be read as it is
    std::size_t num_left_out = 0;    ///< lines and points of an OBJ file, which bound nothing
};

/// Takes away what formats allow, or programs write, and readers stumble over: a byte order mark, keywords of an ASCII
/// STL in capitals, and elements of an OBJ that are no faces.
/// @param ending  of the name, in lower case: .stl, .obj, .ply or .off
PlainSurfaceText plain_surface_text(std::string text, const std::string &ending);

} // namespace livermark::segmentation
