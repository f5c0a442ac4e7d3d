#pragma once

#include <array>
#include <vector>

namespace livermark::core {

/// Where contact is looked at on a facet with straight sides.
struct FacetPoint {
    std::array<double, 3> shape{}; ///< values of the linear shape functions of its corners; they sum to 1
    double part = 0.0;             ///< of the area of the facet; those of all points sum to 1
};

/// The points of a quadrature: the facet is divided into k^2 equal triangles, and each of these has seven points, exact
/// to degree 5. The rule is the same in whatever order the corners are. (J. Radon 1948, Zur mechanischen Kubatur,
/// Monatsh. Math. 52)
/// @param divisions  k of each side, > 0
std::vector<FacetPoint> facet_points(int divisions);

} // namespace livermark::core
