#pragma once

#include <optional>
#include <string>

#include "core/mesh/tetra_mesh.hpp"

namespace livermark::meshes {

/// How patches were found.
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
/// core/mesh/patches.hpp; only names that say nothing ("surface", "unnamed", "patch_7") go.
/// @param from_lps  how it lies, where that is known, see fit_liver()
/// @return nothing if no patch was missing
std::optional<FoundPatches> find_anatomical_patches(core::TetraMesh &mesh,
                                                    const std::optional<Eigen::Matrix3d> &from_lps = {});

} // namespace livermark::meshes
