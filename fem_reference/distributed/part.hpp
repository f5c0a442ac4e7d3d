#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/problem.hpp"
#include "fem_reference/linear/elastic_system.hpp"
#include "fem_reference/linear/pressure_system.hpp"

namespace livermark::fem_reference {

/// What a rank works on. Every vertex of the mesh has an owner, and so has every edge: that of one of its ends. A part
/// has all tetrahedra at the vertices of its rank, so what is assembled on it, by what knows of one process only, is
/// complete in the rows of nodes that the rank owns. Rows of other nodes are not: they are there to read from.
struct Part {
    core::Problem problem;                   ///< facets keep their order and conditions; faces of the cut are no facets
    std::vector<std::int64_t> vertex_number; ///< (N') in the whole mesh, the same on all ranks
    std::vector<int> vertex_owner;           ///< (N') rank
    std::vector<int> facet;                  ///< (T') number among the boundary triangles of the mesh that was cut
    std::vector<int> mesh_node;              ///< (N') number in the mesh that was cut, -1 where a refinement is from
};

/// Collective, and the same on every rank: METIS cuts the graph of the edges.
/// @return the part of this rank
/// @throws std::invalid_argument on every rank if there are so few nodes that a rank has none
Part cut(const core::Problem &problem);

/// Collective. Every tetrahedron of a part into eight, see core::refine(): no rank sees the whole refined mesh.
Part refine(const Part &part);

/// Something that a number belongs to, as all ranks know it.
struct SharedEntry {
    std::array<std::int64_t, 2> key; ///< different for different ones
    int owner = 0;                   ///< rank
};

/// The nodes of elements by the ends of their edges, a vertex being the edge from itself to itself.
/// @param system  assembled on the part
/// @return shape (n)
std::vector<SharedEntry> nodes_of(const Part &part, const ElasticSystem &system);

/// Pressures by vertex and region.
/// @return shape (m)
std::vector<SharedEntry> pressures_of(const Part &part, const PressureSystem &pressure);

} // namespace livermark::fem_reference
