#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"
#include "fem_reference/hyperelastic/reference_element.hpp"
#include "fem_reference/hyperelastic/surface/surface_stiffness.hpp"
#include "fem_reference/linear/elastic_system.hpp"

namespace livermark::hyperelastic {

/// A pressure that stays perpendicular to the surface as it moves, and acts on its deformed area:
///     f_a = - integral over the triangle of p N_a x_r cross x_s dr ds,   x = X + u,
/// with r and s the coordinates on the unit triangle. The integrals are exact.
/// (K. Schweizerhof, E. Ramm 1984, Displacement dependent pressure loads in nonlinear finite element analyses, Comput.
/// Struct. 18(6))
class FollowerPressure {
  public:
    /// @param system    kept alive and unchanged by the caller
    /// @param mesh      that it was assembled on
    /// @param pressure  shape (T) [Pa], positive inwards, 0 where there is none; or empty
    /// @throws std::invalid_argument if it has another size
    FollowerPressure(const fem_reference::ElasticSystem &system, const core::TetraMesh &mesh,
                     std::span<const double> pressure);

    bool is_empty() const { return facets_.empty(); }

    /// @param factor        that pressures are multiplied by
    /// @param displacement  shape (3 n) [m]
    /// @param force         shape (3 n) [N], added to
    void add_forces(double factor, const std::vector<double> &displacement, std::vector<double> &force) const;

    /// The derivatives of minus the forces. They are not symmetric: a surface whose edge is free or sees the pressure
    /// end there has no potential. The symmetric halves stand in the stiffness.
    SurfaceStiffness load_stiffness(double factor, const std::vector<double> &displacement) const;

  private:
    struct Facet {
        std::vector<int> nodes; ///< corners as in the mesh, then the middles of 01 12 20
        double pressure;        ///< [Pa]
    };
    const fem_reference::ElasticSystem *system_;
    std::vector<Facet> facets_;
    ReferenceTriangle reference_;
};

} // namespace livermark::hyperelastic
