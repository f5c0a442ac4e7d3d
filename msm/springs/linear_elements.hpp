#pragma once

#include <memory>

#include "core/problem.hpp"
#include "msm/elastic_body.hpp"

namespace livermark::msm {

/// Linear elements of Saint Venant and Kirchhoff's material, written as springs along the six edges of each
/// tetrahedron that are coupled to each other: with q_e = l_e^2 - l0_e^2 of edge e,
///   U = sum over tetrahedra of 1/8 sum over e, f of k_ef q_e q_f,   k_ef = V (lambda tr D_e tr D_f + 2 mu D_e : D_f).
/// The six q are the Green strain E of the tetrahedron, E = 1/2 sum over e of q_e D_e with
/// D_ij = -(g_i g_j^T + g_j g_i^T) / 2 and g the gradients of the barycentric coordinates at rest.
/// (Delingette 2008, IEEE TVCG 14(2), for triangles)
/// @param body  at rest, positive volumes
std::shared_ptr<const ElasticTerm> linear_elements(const core::Body &body);

/// The same of a material with a lambda that is no more than a few mu, as ElasticBody::preconditioner of springs around
/// nodes: their shear stiffness is near that of linear elements, but their volumes give way more easily.
std::shared_ptr<const ElasticTerm> elements_of_softer_volume(const core::Body &body);

} // namespace livermark::msm
