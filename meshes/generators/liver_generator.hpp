#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"
#include "meshes/anatomy/liver_patches.hpp"
#include "meshes/generators/liver_shape.hpp"

namespace livermark::meshes {

struct LiverOptions {
    bool tumours = false;
    int target_tetrahedra = 0; ///< 0: 15,806, or 19,478 with tumours
};

/// An adult liver of 1.50 L, drawn by liver_level and meshed by gmsh (Delaunay, one thread), with or without six
/// ellipsoidal lesions. The regions are "parenchyma" and "tumour_1" ... "tumour_6", largest first, with shared nodes on
/// their interfaces; the patches are those of assign_liver_patches. Coordinates are LPS (x left, y posterior, z
/// superior) in whole nanometres, tetrahedra come region by region. The same options give the same mesh, bit by bit.
///
/// The canonical counts are met within 0.5 %, with no quality 6 sqrt(2) V / l_rms^3 below 0.2 and no edge shorter than
/// 0.35 (healthy) or 0.25 (tumours) of the mean edge. Any other count is met as well as the search over the edge length
/// can, within 1 % where tried (2,000 to 200,000), and the mesh is handed out as it is: below about 8,000 tetrahedra
/// the smaller lesions become coarse polyhedra and the grooves of the visceral side fade. Measure with mesh_figures.
/// @throws support::InputError   if target_tetrahedra is negative, or too small to hold the anatomy
/// @throws std::runtime_error if gmsh fails, or a canonical body misses one of its figures
core::TetraMesh generate_liver(const LiverOptions &options);

/// The liver of another person in the same way: its volume is met to the last digits of the file, its regions are
/// "parenchyma" and "tumour_1" ... for its lesions, largest first. From 15,806 tetrahedra on its quality and its
/// shortest edge are those of the bodies that ship.
/// @param target_tetrahedra  0: as many as the body that ships with or without lesions has
/// @throws support::InputError   as above
/// @throws std::runtime_error if gmsh fails, or the quality is missed
core::TetraMesh generate_liver(const LiverVariant &variant, int target_tetrahedra = 0);

/// A part of the boundary of a body: facets that stand for equal parts of the area.
struct BoundarySample {
    core::Vector3 place; ///< [m]
    core::Vector3 area;  ///< outward area vector [m^2]
};

/// Mean square of the distance of samples from the capsule of fit.shape [m^2], and of what their normals are off. No
/// distance counts more than 40 mm; a normal that is a right angle off counts as 15 mm.
double boundary_misfit(const LiverFit &fit, const std::vector<BoundarySample> &samples);

/// Bends the liver that ships until its capsule lies on the boundary of a body, from a fit that is near.
///
/// Least squares by Levenberg and Marquardt's method, in which an affine map and the lengths of LiverShape are unknown:
///   boundary_misfit + (1 mm)^2 (|t|^2 + |h|^2 / 0.15^2)
/// where t are lengths of the shape in units of how far they vary from liver to liver (draw_liver()), and h is the
/// logarithmic strain of the map without its change of volume. fit.distance becomes the square root of the sum.
/// @param samples  of the boundary of the body
/// @param has_tongue  whether the liver has a Riedel's lobe, whose length is then unknown too
LiverFit adjusted(const LiverFit &fit, const std::vector<BoundarySample> &samples, bool has_tongue);

/// Writes <stem>.msh, and <stem>.toml beside it with the materials of the bodies that ship: parenchyma of 5 kPa,
/// lesions of 50 kPa, Poisson's ratio 0.45 and 1060 kg/m^3 everywhere.
/// @param mesh_file  ends in .msh
/// @param command    that makes it again
/// @throws support::InputError if the place cannot be written to, or the name has another ending
void write_liver_body(const std::filesystem::path &mesh_file, const core::TetraMesh &mesh, const LiverVariant &variant,
                      const std::string &command);

} // namespace livermark::meshes
