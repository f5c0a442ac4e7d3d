#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"
#include "core/problem.hpp"
#include "core/support/toml_input.hpp"
#include "meshes/generators/liver_shape.hpp"

namespace livermark::meshes {

/// Place of a liver in the axes of liver_level(), its shape, and its fit there.
struct LiverFit {
    Eigen::Matrix3d linear = Eigen::Matrix3d::Identity().eval(); ///< from the body's axes, with a positive determinant
    core::Vector3 offset = core::Vector3::Zero();                ///< [m]
    LiverShape shape;      ///< that the liver has there, at the scale and the place of the one that ships
    double distance = 0.0; ///< rms distance of the body's boundary from the capsule, its normals and the bending [m]
    double next_distance = 0.0; ///< the same in the best of the other orientations, 60 degrees away or more [m]

    core::Vector3 place(const core::Vector3 &point) const { return linear * point + offset; }
    /// Unit normal of a facet there.
    core::Vector3 normal(const core::Vector3 &area_vector) const;

    /// The rotation in the map, from LPS to the body's axes.
    Eigen::Matrix3d from_lps() const;
    /// Angle by which the body is turned away from LPS [rad].
    double turn() const;

    /// Certainty of this orientation: 1 - distance / next_distance, from 0 to 1.
    double confidence() const;
};

/// Lays the liver that ships over the liver of a mesh, in any position and orientation, and bends it there.
///
/// Centroid and second moments C of the volume are made those of the liver that ships. That leaves a rotation Q:
///   x' = c_0 + C_0^(1/2) Q V C^(-1/2) (x - c)
/// with the principal axes V of the mesh, towards the longer tails, so that nothing depends on how the mesh is turned.
/// A thousand rotations are tried (Alexa 2022, Super-Fibonacci spirals, CVPR), and those refined that bring the
/// boundary nearest to the capsule. From the best of each valley the liver that ships is bent (adjusted()), with a
/// Riedel's lobe and without. The fit of the least distance is taken.
/// @param mesh      with its boundary [m]
/// @param from_lps  how it lies, where that is known: the best fit within 60 degrees of that is taken, if there is one
LiverFit fit_liver(const core::TetraMesh &mesh, const std::optional<Eigen::Matrix3d> &from_lps = {});

/// posterior, anterior, inferior, superior, right_lobe_dome, right_lateral and left_lobe_tip.
std::vector<std::string> liver_patch_names();

/// Finds the boundary of a liver in the axes of liver_level and divides it into connected patches, by where a facet
/// lies and looks:
///   posterior        bare area, groove of the vena cava and caudate lobe: where the liver is constrained
///   anterior         under the ribs, both lobes
///   inferior         visceral side, gallbladder fossa and porta hepatis
///   superior         left lobe and middle, under the diaphragm and the heart
///   right_lobe_dome  top of the right lobe, under the diaphragm
///   right_lateral    right side, along the ribs
///   left_lobe_tip    all around the end of the left lobe
/// Replaces boundary_triangles, boundary_patch and patch_names. Borders are smoothed by the majority of neighbours, and
/// islands go to the patch around them, so each patch is in one piece.
void assign_liver_patches(core::TetraMesh &mesh);

/// The same for a liver that lies elsewhere, whose boundary is there and stays.
/// The tip is at least half as long as that of the shape, also where the left lobe ends sooner.
/// @param fit  where it lies in the axes of liver_level, and its shape there
void assign_liver_patches(core::TetraMesh &mesh, const LiverFit &fit);

/// The same by the same rules for a liver of another shape, in the axes of liver_level: its boundary is found, and the
/// tip begins where the left lobe of that shape narrows.
void assign_liver_patches(core::TetraMesh &mesh, const LiverShape &shape);

/// Patches that were found, and how surely.
struct FoundPatches {
    double confidence = 0.0;  ///< how clear the orientation of the body is: see LiverFit::confidence()
    std::string remark;       ///< one sentence with the confidence and the areas
    Eigen::Matrix3d from_lps; ///< rotation from LPS to the axes of the mesh
    /// Whether another orientation fits about as well.
    bool is_doubtful() const;
};

/// Finds the patches of a liver that a mesh has no names for, so that the load cases that ship can be put on it:
/// posterior, right_lobe_dome, superior, left_lobe_tip, anterior, inferior and right_lateral.
///
/// The liver that ships is laid over the mesh and bent (fit_liver()), in whatever orientation the mesh is, and each
/// facet gets the patch that it has there (assign_liver_patches()). A mesh that is turned gets the same patches. A
/// facet that the file itself gives to a patch of these names stays there, and of such a name none is found. The
/// patches of other names that the file has keep their facets and share them with those that are found, see
/// core/mesh/tetra_mesh.hpp; only names that say nothing ("surface", "unnamed", "patch_7") go.
/// @param from_lps  how it lies, where that is known, see fit_liver()
/// @return nothing if no patch was missing
std::optional<FoundPatches> find_anatomical_patches(core::TetraMesh &mesh,
                                                    const std::optional<Eigen::Matrix3d> &from_lps = {});

/// Axes of a body as its files say them.
struct SaidAxes {
    std::optional<Eigen::Matrix3d> from_lps{}; ///< "axes" in its .toml
    bool as_registered = false;                ///< "axes" there lets the shape of the liver decide, whatever it is
    bool is_unknown = false;                   ///< "axes" there says that nobody knows
    bool is_lps_by_header = false;             ///< the header of its image or mesh says how the patient lies
};

/// Reads 'axes' of a body, which may be
///     axes = "LPS"         # where x, y and z of the mesh lead to: here to the patient's left, posterior, superior;
///                          # R, A and I are right, anterior and inferior
///     axes = [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]] # left, posterior and superior in the coordinates
///                          # of the mesh
///     axes = "registered"  # as the shape of a liver says that it lies, however unclear
///     axes = "unknown"     # load cases with directions are refused
/// and 'orientation' of its [image].
/// @throws support::InputError for another word, and for axes that are no rotation
SaidAxes read_axes(const toml::table &body);

/// 'axes' for the .toml of a body, a line; empty where its patches and the axes of its mesh need none.
std::string axes_toml(const core::BodyAxes &axes);

/// The axes of a body: those that its .toml says; LPS where its header says so and its shape does not contradict; else
/// as its patches were found. An orientation that is not clear is in doubt, and so is one 60 degrees or more from the
/// header's. Livers in LPS are found turned by up to 28 degrees (docs/studies/segmentation.md), unless their shape is
/// that of the generator; so they count as LPS up to 30. A body whose file names the patches has the axes of its mesh.
/// It is turned where patches lie as only those of the liver that ships do; where they lie otherwise in another
/// orientation a remark asks for 'axes'.
/// @param found    how its patches were found; nothing where its file names them
/// @param remarks  gets a sentence where directions are not simply those of the mesh, or were decided
core::BodyAxes body_axes(const core::TetraMesh &mesh, const std::optional<FoundPatches> &found, const SaidAxes &said,
                         std::vector<std::string> &remarks);

} // namespace livermark::meshes
