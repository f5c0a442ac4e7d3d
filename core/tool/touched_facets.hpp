#pragma once

#include <array>
#include <vector>

#include "core/problem.hpp"

namespace livermark::core {

/// A flat facet that a ball may touch.
struct TouchedFacet {
    std::array<int, 3> nodes{};
    double area = 0.0; ///< at rest [m^2]
    double penalty =
        0.0; ///< eps = gamma E / ((1 - nu^2) h) [Pa/m], h the mean of its sides and E, nu of what is behind it
};

/// gamma, for linear functions on facets: that with the least error against a closed form on coarse meshes, see
/// docs/studies/contact.md.
inline constexpr double usual_contact_stiffness = 10.0;

/// The facets of LoadCase::may_touch(), in the order of the mesh.
///
/// Facets are flat, and a body of linear functions cannot follow a ball within them. A penalty in 1 / h stands for
/// that: it goes with the mesh as the error of the functions does, so that the whole converges to contact without
/// penetration (F. Chouly, P. Hild 2013, On convergence of the penalty method for unilateral contact problems, Appl.
/// Numer. Math. 65), where facets without penetration are too stiff on coarse meshes.
std::vector<TouchedFacet> touched_facets(const Body &body, const LoadCase &load_case,
                                         double stiffness = usual_contact_stiffness);

/// Parts of a side that facet_points() divides these facets into: their sides are at most sqrt(R d), the radius of
/// contact by Hertz, with the radius R of the ball and its depth d.
int contact_divisions(const Body &body, const LoadCase &load_case);

} // namespace livermark::core
