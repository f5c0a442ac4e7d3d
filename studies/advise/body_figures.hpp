#pragma once

#include <string>
#include <vector>

#include "core/problem.hpp"
#include "meshes/io/mesh_figures.hpp"

/// What a body is, as far as it decides which model is good on it.
namespace livermark::studies {

struct RegionFigures {
    std::string name;
    core::Material material;
    double volume = 0.0; ///< [m^3]
    int num_tetrahedra = 0;
    int num_parts = 0; ///< that are joined by faces
    /// Of the smallest part: its tetrahedra, and the diameter of the ball of its volume over the mean length of its
    /// edges.
    int smallest_part_tetrahedra = 0;
    double smallest_part_in_edges = 0.0;
};

struct BodyFigures {
    std::string name;
    meshes::MeshFigures mesh;
    std::vector<RegionFigures> regions; ///< (R) as in the mesh
    std::size_t main_region = 0;        ///< that of the largest volume
    double surface_edge = 0.0;          ///< mean length of the edges of the surface [m]
    double tool_radius = 0.0;           ///< [m]
    double thin_part = 0.0; ///< of the volume, in tetrahedra that have all corners on the surface: there is one layer

    double tool_radius_in_edges() const { return tool_radius / surface_edge; }
    const core::Material &material() const { return regions[main_region].material; }
};

/// @param tool_radius  [m], > 0
BodyFigures body_figures(const core::Body &body, double tool_radius);

} // namespace livermark::studies
