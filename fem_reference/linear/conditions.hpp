#pragma once

#include <Eigen/SparseCore>
#include <span>
#include <vector>

#include "core/load_case.hpp"
#include "core/mesh/places.hpp"
#include "core/mesh/tetra_mesh.hpp"
#include "core/solution.hpp"
#include "fem_reference/linear/elastic_system.hpp"

namespace livermark::fem_reference {

/// @throws std::invalid_argument if the load case does not have the sizes of the mesh, or names conditions
///   that it does not have
void check_facets(const core::LoadCase &load_case, const core::TetraMesh &mesh);

/// @throws std::invalid_argument if a boundary triangle is not an outer face of the tetrahedra or is given twice
void check_outer_faces(const core::TetraMesh &mesh);

/// Whether the prescribed displacements stop every rigid motion of every part of the body that hangs together.
bool holds_every_part(const core::LoadCase &load_case, const core::TetraMesh &mesh);

/// A load case as the unknowns see it; n is the number of nodes.
struct DofConditions {
    std::vector<double> prescribed; ///< (3 n) [m], NaN where free
    std::vector<int> constraint;    ///< (3 n) index into LoadCase::constraint_names, -1 where free
    std::vector<double> load;       ///< (3 n) [N]; where a place presses, for one newton of it [1]
    double press_depth = 0.0;       ///< LoadCase::press_depth [m]
};

/// Integrates the loads of a load case and spreads its prescribed displacements over the nodes of the facets. Where
/// constraints meet at a node, each component takes value and owner from the constraint of lowest index that prescribes
/// it.
/// @param load_case  of the sizes of the mesh that the system was assembled on
DofConditions dof_conditions(const core::LoadCase &load_case, const ElasticSystem &system);

/// Means of the shape functions over places inside: row k times the displacements of the nodes is the mean over place
/// k, and its transpose times a force on the place what the nodes take of it.
/// @param mesh  that the system was assembled on
/// @return shape (K, n)
/// @throws std::invalid_argument if a place is outside the body
Eigen::SparseMatrix<double, Eigen::RowMajor> place_weights(std::span<const core::InteriorPlace> places,
                                                           const ElasticSystem &system, const core::TetraMesh &mesh);

/// Adds what nodes take of forces on places.
/// @param forces  shape (K) [N]
/// @param load    shape (3 n) [N]
void add_forces(const Eigen::SparseMatrix<double, Eigen::RowMajor> &weights, const std::vector<core::Vector3> &forces,
                std::vector<double> &load);

/// Means of displacements over places.
/// @param displacement  shape (3 n) [m]
/// @return shape (K) [m]
std::vector<core::Vector3> means_at(const Eigen::SparseMatrix<double, Eigen::RowMajor> &weights,
                                    const std::vector<double> &displacement);

/// One newton along an axis on a place.
/// @return shape (3 n) [N]
std::vector<double> load_of(const Eigen::SparseMatrix<double, Eigen::RowMajor> &weights, Eigen::Index place, int axis);

/// Puts NaN into all fields of a solution on a mesh.
void leave_unsolved(core::Solution &solution, const core::TetraMesh &mesh, const core::LoadCase &load_case);

} // namespace livermark::fem_reference
