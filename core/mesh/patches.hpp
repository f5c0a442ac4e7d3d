#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"

/// Patches that share facets. A facet has one index into TetraMesh::patch_names; where it lies in two patches, such as
/// one of the file and one that was found, that name has both with a '+' between them: "back+posterior".
namespace livermark::core {

inline constexpr char patch_joint = '+';

/// Whether a name of TetraMesh::patch_names is that of a patch, or has it among those that it joins.
bool is_in_patch(std::string_view name_of_facet, std::string_view patch);

/// Each patch of a mesh once, in the order of its names.
std::vector<std::string> patches_of(const TetraMesh &mesh);

/// The facets of a patch, in ascending order; none if the mesh has no such patch.
std::vector<int> facets_in_patch(const TetraMesh &mesh, std::string_view patch);

} // namespace livermark::core
