#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/problem.hpp"
#include "fem_reference/linear/elastic_system.hpp"

namespace livermark::fem_reference {

/// The vessels of a body (core::VesselTree) in its elements, whose shape functions they move with. At a point of a
/// tube of the direction d at rest, F d = d + sum over the nodes of u_a (grad N_a . d), so that each node needs one
/// number alone.
class VesselLines {
  public:
    /// Nothing where the body has no vessels.
    VesselLines(const core::Body &body, const ElasticSystem &system);

    /// force += dW/du.
    /// @param displacement  u of the elements' nodes, shape (3 n) [m]
    /// @param force         shape (3 n) [N]
    /// @param energy_share  shape (M) which part of the energy in each tetrahedron counts; empty for all
    /// @return W [J]
    double add_force(std::span<const double> displacement, std::span<double> force,
                     std::span<const double> energy_share = {}) const;

    /// stiffness += d2W/du2.
    /// @param displacement  shape (3 n) [m]; empty for the body at rest
    void add_stiffness(std::span<const double> displacement, SymmetricBlocks<double> &stiffness) const;

  private:
    struct Point {
        core::VesselPoint on_line;
        std::vector<int> nodes;
        Eigen::VectorXd slope; ///< grad N_a . d of each [1/m]
    };
    static core::Vector3 moved(const Point &point, std::span<const double> displacement);

    std::vector<Point> points_;
};

} // namespace livermark::fem_reference
