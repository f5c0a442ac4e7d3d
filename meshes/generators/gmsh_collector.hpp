#pragma once

#include <unordered_map>

#include "core/mesh/tetra_mesh.hpp"

namespace livermark::meshes {

/// Takes nodes and tetrahedra out of the model of a GmshSession, in gmsh's order.
class GmshCollector {
  public:
    /// @param mesh  gets them; kept alive by the caller
    explicit GmshCollector(core::TetraMesh &mesh) : mesh_(mesh) {}

    /// Adds the nodes of an entity, or of a dimension, or of all.
    void add_nodes(int dimension = -1, int entity = -1);

    /// Adds the tetrahedra of a volume, or of all, with positive volume. Their nodes are there already.
    void add_tetrahedra(int volume = -1);

  private:
    core::TetraMesh &mesh_;
    std::unordered_map<std::size_t, int> number_; ///< in the mesh, by gmsh's tag
};

} // namespace livermark::meshes
