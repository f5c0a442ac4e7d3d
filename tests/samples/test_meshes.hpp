#pragma once

#include <memory>

#include "core/problem.hpp"

namespace livermark::tests {

/// A box of size [0, a] x [0, b] x [0, c] m cut into nx x ny x nz bricks of six tetrahedra each, one region "solid",
/// and a patch for each side: "x_min", "x_max", "y_min", "y_max", "z_min", "z_max".
core::TetraMesh box_mesh(const core::Vector3 &size, const std::array<int, 3> &bricks);

/// Finds the boundary triangles of the tetrahedra of a box, with the patches of box_mesh().
void put_patches_on_sides(core::TetraMesh &box);

/// One regular tetrahedron of the given edge [m], one region "solid", one patch "surface".
core::TetraMesh regular_tetrahedron(double edge);

/// A body of one mesh and one material for every region.
std::shared_ptr<const core::Body> make_body(core::TetraMesh mesh, const core::Material &material);

/// A load case of the right sizes in which nothing holds and nothing pulls.
core::LoadCase empty_load_case(const core::TetraMesh &mesh);

/// Prescribes a displacement (NaN = component free) on the facets of a patch, as a constraint with the patch's name.
void prescribe(core::LoadCase &load_case, const core::TetraMesh &mesh, const std::string &patch,
               const core::Vector3 &displacement);

/// Puts a traction [Pa] on the facets of a patch.
void pull(core::LoadCase &load_case, const core::TetraMesh &mesh, const std::string &patch,
          const core::Vector3 &traction);

/// Presses evenly on a patch until it has moved by a depth [m] along the direction, in the mean. The only place that
/// does.
void press(core::LoadCase &load_case, const core::TetraMesh &mesh, const std::string &patch,
           const core::Vector3 &direction, double depth);

} // namespace livermark::tests
