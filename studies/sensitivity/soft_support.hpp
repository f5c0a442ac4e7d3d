#pragma once

#include "core/problem.hpp"

namespace livermark::studies {

/// The ratio of the stiffness of a soft support along the surface to that across it: that of a thin layer with a
/// Poisson's ratio of 1/4, at which every model of the suite is at ease.
inline constexpr double support_shear_ratio = 1.0 / 3.0;

/// A Robin condition in place of held facets, t = -k ((u . n) n + (u - (u . n) n) / 3), as ligaments give way: a layer
/// of soft material is put on the held facets, and its outer side is held. The layer is as thin as a twentieth of the
/// mean edge of these facets, so its elements are such a spring up to that part squared, in finite elements as well as
/// in springs. Models that are not linear feel the layer stretch: they have this condition only as long as the held
/// surface moves by much less than the layer is thick.
///
/// Nodes of the body keep their numbers, those of the layer come behind. Facets keep their numbers too: the held ones
/// are now those of the outer side; the rim of the layer comes behind, free. The layer is the last region, "support".
/// @param problem    with a held facet
/// @param stiffness  k [Pa/m], > 0
/// @throws support::InputError if the held surface folds back within the thickness
core::Problem with_soft_support(const core::Problem &problem, double stiffness);

} // namespace livermark::studies
