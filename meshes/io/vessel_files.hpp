#pragma once

#include <filesystem>
#include <string>

#include "core/problem.hpp"
#include "core/support/toml_input.hpp"

namespace livermark::meshes {

/// Wall of a vessel over its radius, an assumption, and its Young's modulus [Pa], that of porcine hepatic veins (Umale
/// et al. 2011, J. Biomech. 44), where nobody says others.
inline constexpr double usual_wall_ratio = 0.1, usual_wall_modulus = 0.62e6;

/// Reads a tree of tubes from an SWC file, which VMTK, 3D Slicer's SlicerVMTK and programs for neurons write or convert
/// to: a line for each point with its number, a kind, x, y, z, the radius and the number of the point before it, or -1
/// at a root. Lines that begin with # are comments; the kind is not looked at. (Cannon, Turner, Pyapali, Wheal 1998,
/// J. Neurosci. Methods 84)
/// @param metres  per unit of length of the file
/// @return with the usual wall
/// @throws support::InputError for a line that is none, a point before it that is not there or is itself, a radius that
///         is not positive, two points in one place, and a file without a segment
core::VesselTree read_swc(const std::filesystem::path &file, double metres);

/// Length of all segments together [m].
double length_of(const core::VesselTree &tree);

/// The text of such a file, in metres. A point of which several segments begin becomes one point with several behind
/// it; a ring is refused.
/// @throws std::invalid_argument where a point ends two segments
std::string swc_text(const core::VesselTree &tree, const std::string &comment);

/// Reads the [vessels] of a body: `file`, and `unit`, `wall_ratio`, `wall_modulus` and `source` where they are there.
/// A sentence with their size joins the assumptions of the body.
/// @param body    of which it is; keeps the tree
/// @param metres  per unit of the file, where it says none
/// @throws support::InputError where half of their length or more is outside the body, most often in another unit
void read_vessels(const std::filesystem::path &body_file, const toml::table &table, double metres, core::Body &body);

} // namespace livermark::meshes
