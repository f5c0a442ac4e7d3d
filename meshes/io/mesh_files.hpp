#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"

namespace livermark::meshes {

/// Whether the name of a file says that it is a surface: STL, OBJ, PLY or OFF.
bool has_surface_ending(const std::filesystem::path &file);

/// Whether the name or the first lines of a file say that it is a surface: STL, OBJ, PLY, OFF, VTP, or VTK polydata.
bool is_surface_file(const std::filesystem::path &file);

/// First bytes of a file, where programs write what it is: a thousand bytes at most. Nothing of what is no plain
/// file; a pipe would keep us waiting.
std::string first_bytes(const std::filesystem::path &file);

/// Reads a mesh of any format: MSH in ASCII with read_msh(), everything else (binary MSH, VTK, VTU, INP, Nastran, MED
/// and what else meshio knows) after scripts/convert_mesh, a process of its own that may fail without harm.
/// @param remarks  gets a sentence for each change that the conversion made
/// @return coordinates as they are in the file, turned to LPS where it says that they are in RAS
/// @throws support::InputError with the file, what is wrong and a remedy
core::TetraMesh read_mesh(const std::filesystem::path &file, std::vector<std::string> &remarks);

/// A unit that a file does not say.
struct UnitGuess {
    std::string unit;
    double metres = 1.0; ///< per unit
    std::string remark;  ///< why, and what speaks against it: a clause
};

/// The unit that makes an organ of a body. The longest side of its bounding box decides: up to 2 is in metres, up to 60
/// in centimetres, up to 2000 in millimetres. The volume is a second reading, which an adult liver passes with 0.5 to 4
/// L (livers after resection to enlarged ones); where it does not, the remark says both, and the unit that would make
/// 1.5 L.
/// @param points  of the body, in the unit
/// @param volume  in the unit to the third power
/// @throws support::InputError if the longest side is beyond all, or not positive
UnitGuess guess_unit(const std::vector<core::Vector3> &points, double volume, const std::string &file);

/// @throws support::InputError if the name of a mesh to write does not end in .msh
void check_name_of_mesh(const std::filesystem::path &mesh_file);

/// Writes a body as a gmsh file, MSH 4.1 ASCII: the same mesh gives the same bytes. Node tag i + 1 is node i; a
/// physical group of dimension 3 stands for each region and one of dimension 2 for each patch, with their names and, as
/// tags, their indices + 1. Elements come patch by patch and region by region, each in the order of the mesh.
/// Coordinates [m] are written in the shortest form that reads back as the same number. The file appears whole or not
/// at all.
/// @throws support::InputError  if the file cannot be written
void write_msh(const std::filesystem::path &file, const core::TetraMesh &mesh);

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
