#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"
#include "core/problem.hpp"
#include "core/support/toml_input.hpp"

namespace livermark::meshes {

/// Ways in which patches are found.
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
