#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <string>
#include <vector>

#include "core/problem.hpp"
#include "fem_reference/linear/elastic_system.hpp"

/// Lagrange elements on straight tetrahedra, written a second time: loads that vary from point to point, errors against
/// exact fields and stresses, without the library that is being tested.
namespace livermark::tests {

/// A smooth displacement field and what it takes to have it.
struct ElasticField {
    std::function<core::Vector3(const core::Vector3 &)> displacement; ///< u [m]
    std::function<Eigen::Matrix3d(const core::Vector3 &)> gradient;   ///< (i, j) = d u_i / d x_j
    std::function<core::Vector3(const core::Vector3 &)> body_force;   ///< -div sigma [N/m^3]; none where empty
};

/// sigma = lambda tr(eps) I + 2 mu eps [Pa]
Eigen::Matrix3d stress(const core::Material &material, const Eigen::Matrix3d &gradient);

/// Shape functions of the 4 or 10 nodes of a cell, in the order of ElasticSystem::cell_nodes.
/// @param barycentric  of the four corners
/// @return shape (nodes_per_cell)
Eigen::VectorXd shape_functions(int nodes_per_cell, const Eigen::Vector4d &barycentric);

/// Gradients of the barycentric coordinates of a tetrahedron, one per column [1/m].
Eigen::Matrix<double, 3, 4> barycentric_gradients(const std::array<core::Vector3, 4> &corners);

/// Gradients of the shape functions, one per column [1/m].
/// @param corner_gradients  what barycentric_gradients gives
/// @return shape (3, nodes_per_cell)
Eigen::Matrix3Xd shape_gradients(int nodes_per_cell, const Eigen::Vector4d &barycentric,
                                 const Eigen::Matrix<double, 3, 4> &corner_gradients);

/// The displacement gradient (i, j) = d u_i / d x_j of a discrete field in one cell.
/// @param displacement  shape (3 n), as ConstrainedSolution gives it
Eigen::Matrix3d displacement_gradient(const fem_reference::ElasticSystem &system, int cell,
                                      const Eigen::Vector4d &barycentric, const std::vector<double> &displacement);

/// Adds the integral of force times shape function.
/// @param load   shape (3 n) [N]
/// @param force  per volume [N/m^3]
void add_body_force(const fem_reference::ElasticSystem &system,
                    const std::function<core::Vector3(const core::Vector3 &)> &force, std::vector<double> &load);

/// Adds the integral of traction times shape function over the facets of one patch.
/// @param load      shape (3 n) [N]
/// @param traction  [Pa]
void add_traction(const fem_reference::ElasticSystem &system, const core::TetraMesh &mesh, const std::string &patch,
                  const std::function<core::Vector3(const core::Vector3 &)> &traction, std::vector<double> &load);

/// The size h of a mesh that the error estimate err^2 <= C sum over t of h_t^(2 p) |u|_(p + 1, t)^2 speaks of: the mean
/// over the volume of the longest edges h_t to the power 2 p [m].
/// @param degree  p
double mesh_size(const core::TetraMesh &mesh, int degree);

/// Norms of the difference of a discrete and an exact field, over those of the exact field.
struct RelativeError {
    double l2 = 0.0; ///< of the displacement
    double h1 = 0.0; ///< of its gradient
};

/// @param displacement  shape (3 n), as ConstrainedSolution gives it
RelativeError relative_error(const fem_reference::ElasticSystem &system, const std::vector<double> &displacement,
                             const ElasticField &exact);

} // namespace livermark::tests
