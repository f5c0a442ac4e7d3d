#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "fem_reference/linear/elastic_system.hpp"

namespace livermark::hyperelastic {

/// The nodes of a boundary triangle in the order of ReferenceTriangle, corners as the mesh has them.
std::vector<int> nodes_of_facet(const fem_reference::ElasticSystem &system, const core::TetraMesh &mesh,
                                std::size_t facet);

/// Minus the derivatives of forces on the surface by displacements, one small matrix for each facet, in two parts: a
/// symmetric one that stands in the stiffness, and so in what preconditions it, and the rest, which products add.
class SurfaceStiffness {
  public:
    struct OfFacet {
        std::vector<int> nodes;
        Eigen::MatrixXd symmetric, rest; ///< shape (3 k, 3 k) [N/m], unknown 3 a + i of its k nodes
    };
    void add(OfFacet facet) { of_facet_.push_back(std::move(facet)); }

    /// Adds the symmetric parts.
    void add_to(fem_reference::SymmetricBlocks<double> &stiffness) const;
    /// out += the rest times x
    /// @param x, out  shape (3 n)
    void add_product(std::span<const double> x, std::span<double> out) const;

  private:
    std::vector<OfFacet> of_facet_;
};

} // namespace livermark::hyperelastic
