#pragma once

#include <vector>

#include "core/problem.hpp"
#include "fem_reference/node_order.hpp"
#include "fem_reference/solvers/symmetric_blocks.hpp"

namespace livermark::fem_reference {

/// Linear elasticity of one body, discretised on its tetrahedra with Lagrange elements and before any condition is put
/// on it. Everything is plain data, so that only the assembly has to see deal.II.
///
/// The unknown of node a and component i is 3 a + i.
struct ElasticSystem {
    std::vector<int> mesh_node;         ///< (N) the node at each node of the mesh
    int nodes_per_cell = 0;             ///< 4 or 10
    int nodes_per_facet = 0;            ///< 3 or 6
    std::vector<core::Vector3> points;  ///< (n) [m]
    std::vector<int> cell_nodes;        ///< (M, nodes_per_cell) four corners, then midpoints of 01 12 20 03 13 23
    std::vector<int> facet_nodes;       ///< (T, nodes_per_facet) nodes of each boundary triangle of the mesh
    std::vector<double> facet_integral; ///< (T, nodes_per_facet) integral of the node's shape function [m^2]
    std::vector<double> mass_integral;  ///< (n) integral of density times shape function [kg]; negative at P2 corners
    /// (nodes_per_cell, nodes_per_cell) integral of the product of two shape functions over a tetrahedron, divided by
    /// its volume: the same for all, because their sides are straight
    std::vector<double> reference_mass;
    SymmetricBlocks<double> stiffness; ///< (3 n, 3 n) [N/m]

    int num_nodes() const { return static_cast<int>(points.size()); }
};

/// Assembles a body.
/// K_(ai)(bj) = sum over t of the integral of lambda g_ai g_bj + mu g_aj g_bi + mu delta_ij g_a . g_b, with g_a the
/// gradient of shape function a (the weak form of isotropic linear elasticity in the Lame parameters).
/// @param body    tetrahedra of positive volume, every node used
/// @param degree  1 or 2
/// @throws std::invalid_argument for another degree, or if a boundary triangle is not an outer face of the tetrahedra
ElasticSystem assemble(const core::Body &body, int degree, NodeOrder order = NodeOrder::of_mesh);

struct DealIiMesh;
/// @param mesh  of this body
ElasticSystem assemble(const core::Body &body, const DealIiMesh &mesh, int degree, NodeOrder order);

} // namespace livermark::fem_reference
