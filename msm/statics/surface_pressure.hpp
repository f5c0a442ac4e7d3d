#pragma once

#include <array>
#include <vector>

#include "core/problem.hpp"

namespace livermark::msm {

/// Pressures that follow the surface of a body (LoadCase::follows) on its nodes: a third of -p a goes to each corner of
/// a facet, with a the area vector that it has now.
///
/// Around nodes that have facets with one pressure all around, that is minus the derivative of the energy
///     sum over the facets of p / 6 (x_1 x x_2) . x_3,
/// p times the volume below the surface. At the rim of the place it is not, and there is no energy.
class SurfacePressure {
  public:
    explicit SurfacePressure(const core::Problem &problem);

    bool is_empty() const { return facets_.empty(); }

    /// @param positions  shape (N) [m], here and below
    /// @return [J]
    double energy(const std::vector<core::Vector3> &positions) const;

    /// Adds the derivative of the energy to nodal forces.
    void add_gradient(const std::vector<core::Vector3> &positions, std::vector<core::Vector3> &gradient) const;

    /// What the nodes at the rim are pushed with beyond minus that derivative; zero on others.
    /// @return shape (N) [N]
    std::vector<core::Vector3> rim_force(const std::vector<core::Vector3> &positions) const;

    /// @return shape (N) [N], what the facets are pushed with where they are
    std::vector<core::Vector3> force(const std::vector<core::Vector3> &positions) const;

  private:
    struct Facet {
        std::array<int, 3> nodes;
        double pressure; ///< [Pa], positive inwards
    };
    std::vector<Facet> facets_;
    core::Vector3 origin_ = core::Vector3::Zero(); ///< that volumes are measured from [m]
};

} // namespace livermark::msm
