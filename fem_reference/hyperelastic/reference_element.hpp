#pragma once

#include <Eigen/Core>
#include <vector>

namespace livermark::hyperelastic {

/// Lagrange elements on the unit tetrahedron (corners 0, e_x, e_y, e_z) at the points of a quadrature rule. Nodes are
/// in the order of fem_reference::ElasticSystem::cell_nodes.
struct ReferenceTetrahedron {
    std::vector<double> weight;                ///< (Q) they sum to 1: parts of the volume
    std::vector<Eigen::Matrix3Xd> gradient;    ///< (Q) of the shape functions, one per column, shape (3, nodes)
    std::vector<Eigen::Vector4d> linear_shape; ///< (Q) values of the four linear shape functions
};

/// The same on the unit triangle: corners, then midpoints of 01 12 20.
struct ReferenceTriangle {
    std::vector<double> weight;             ///< (Q) they sum to 1/2
    std::vector<Eigen::VectorXd> shape;     ///< (Q) values, shape (nodes)
    std::vector<Eigen::Matrix2Xd> gradient; ///< (Q) shape (2, nodes)
};

/// How many points integrate over a tetrahedron.
enum class TetrahedronRule {
    one_point,      ///< exact to degree 1: all there is to integrate on linear elements
    four_points,    ///< exact to degree 2: what other codes take for quadratic elements
    fourteen_points ///< exact to degree 5 (Witherden and Vincent 2015, Comput. Math. Appl. 69(10))
};

/// @param degree  1 or 2
ReferenceTetrahedron reference_tetrahedron(int degree, TetrahedronRule rule);

/// With seven points, exact to degree 5: the follower loads of quadratic elements have degree 4.
/// @param degree  1 or 2
ReferenceTriangle reference_triangle(int degree);

} // namespace livermark::hyperelastic
