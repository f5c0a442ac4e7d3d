#pragma once

#include <span>
#include <vector>

#include "core/mesh/point_location.hpp"
#include "core/mesh/tetra_mesh.hpp"

namespace livermark::experiments {

/// Displacements at points between the nodes of a mesh.
///
/// In a tetrahedron with barycentric coordinates l_i: u = sum l_i (u_i + g_i (x - x_i) / 2), with g_i the gradient at a
/// node, the mean over its tetrahedra weighted by their volumes. That is exact for affine displacements, and for
/// quadratic ones where the gradients are, so that a coarse mesh does not hide how good a model is. A point outside, as
/// a marker on a peg, moves with the nearest point of the body and the gradient there.
class MarkerField {
  public:
    /// @param mesh  kept alive by the caller
    MarkerField(const core::TetraMesh &mesh, std::span<const core::Vector3> points);

    /// @param displacement  shape (N) of the nodes [m]
    /// @return shape (K) at the points [m]
    std::vector<core::Vector3> at_points(std::span<const core::Vector3> displacement) const;

    /// The nodes that displacements at the points depend on, in ascending order.
    std::vector<int> nodes() const;

    /// (K) how far each point is outside the body [m]; 0 inside
    const std::vector<double> &outside() const { return outside_; }

  private:
    struct Place {
        core::LocatedPoint at;                     ///< the nearest point of the body
        core::Vector3 peg = core::Vector3::Zero(); ///< from there to the point [m]
    };
    Place find(const core::Vector3 &point) const;

    const core::TetraMesh *mesh_;
    std::vector<Place> places_;
    std::vector<double> outside_;
};

} // namespace livermark::experiments
