#pragma once

#include <array>
#include <map>

#include "core/load_case.hpp"
#include "core/tetra_mesh.hpp"

namespace livermark::fem_reference {

/// @throws std::invalid_argument if the load case does not have the sizes of the mesh, or prescribes a displacement
///   without naming its constraint
void check_facets(const core::LoadCase &load_case, const core::TetraMesh &mesh);

/// @throws std::invalid_argument if a boundary triangle is not an outer face of the tetrahedra or is given twice
void check_outer_faces(const core::TetraMesh &mesh);

/// Whether the prescribed displacements stop every rigid motion of every part of the body that hangs together.
bool holds_every_part(const core::LoadCase &load_case, const core::TetraMesh &mesh);

/// A node of the elements by the nodes of the mesh: {a, a} is node a, {a, b} with a < b the middle of an edge.
using NodeKey = std::array<int, 2>;

NodeKey node_key(int a, int b);

/// What the facets of a load case say of a node.
struct NodeCondition {
    core::Vector3 prescribed;           ///< [m], NaN where free
    std::array<int, 3> constraint;      ///< index into LoadCase::constraint_names for each component, -1 where free
    core::Vector3 force{0.0, 0.0, 0.0}; ///< integral of traction times shape function [N]
};

/// The nodes on facets with a condition. Where several constraints meet at a node, each component takes its value from
/// the constraint of lowest index that prescribes it, and of the first such facet.
/// On a plane triangle of area A a linear shape function has the integral A / 3; of the quadratic ones those of the
/// corners have 0 and those of the edges A / 3.
/// @param degree  1 or 2
std::map<NodeKey, NodeCondition> node_conditions(const core::LoadCase &load_case, const core::TetraMesh &mesh,
                                                 int degree);

} // namespace livermark::fem_reference
