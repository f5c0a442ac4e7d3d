#pragma once

#include <string>

#include "core/mesh/tetra_mesh.hpp"

namespace livermark::meshes {

/// Size and quality of a mesh. Quality is a performance feature: the shortest edge sets the time step of all.
struct MeshFigures {
    int num_tetrahedra = 0;
    int num_nodes = 0;
    int num_edges = 0;
    double volume = 0.0;                    ///< [m^3]
    core::Vector3 extent = {0.0, 0.0, 0.0}; ///< of the bounding box [m]
    double mean_edge = 0.0;                 ///< [m]
    double shortest_edge = 0.0;             ///< [m]
    double smallest_quality = 0.0;          ///< min over tetrahedra of 6 sqrt(2) V / l_rms^3; 1 for a regular one
};

/// 6 sqrt(2) V / l_rms^3 with l_rms the root mean square of the six edges: 1 for a regular tetrahedron, 0 for a flat
/// one.
double tetrahedron_quality(const core::Vector3 &a, const core::Vector3 &b, const core::Vector3 &c,
                           const core::Vector3 &d);

MeshFigures mesh_figures(const core::TetraMesh &mesh);

/// The figures as lines of "name value unit", for people.
std::string to_text(const MeshFigures &figures);

} // namespace livermark::meshes
