#pragma once

#include <string>
#include <vector>

#include "core/tetra_mesh.hpp"
#include "core/toml_input.hpp"

namespace livermark::load_cases {

/// Boundary triangles that a condition applies to.
struct Selection {
    std::string name;        ///< of the place, for reactions
    std::vector<int> facets; ///< indices into mesh.boundary_triangles, ascending
    /// Area of the place that was meant over the area of the facets: a mesh has no facets that make a circle, and a
    /// load that is multiplied by this has the same resultant on every mesh.
    double area_ratio = 1.0;
};

/// Finds the place that a [[condition]] names.
/// @throws core::InputError if it names none or several, or if no facet is there
Selection select_facets(const toml::table &condition, const core::TetraMesh &mesh);

/// Finds the node in the middle of the patch that a [[probe]] names: of the patch's nodes the one nearest to its area
/// centroid.
/// @throws core::InputError if there is no such patch, or if it has no facet
int select_node(const toml::table &probe, const core::TetraMesh &mesh);

} // namespace livermark::load_cases
