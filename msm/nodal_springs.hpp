#pragma once

#include <memory>

#include "core/problem.hpp"
#include "msm/elastic_body.hpp"

namespace livermark::msm {

/// Springs along the edges of a mesh that are coupled to each other around each node, and a part of them inside each
/// tetrahedron:
///   U = (1 - alone) sum over nodal parts c of V_c / 2 E_c : C : E_c
///       + alone sum over tetrahedra t of V_t / 2 E_t : C : E_t
/// E_t is the strain of a tetrahedron in the elongations of its edges (edge_stretches.hpp, q = 2 l0 (l - l0)), E_c its
/// mean over the part of a body around a node, by volume, and C : E = mu (tr E) I + 2 mu E: they carry lambda = mu, as
/// springs do. Forces are proportional to elongations, as those of springs are; with Green's strain, q = l^2 - l0^2, a
/// fingertip that presses a tenth into tissue finds it softer by some percent.
/// For small strains and alone = 1 they are biquadratic springs of Poisson's ratio 1/4.
///
/// Strains of tetrahedra make a body too stiff, and their means around nodes too soft, with motions in which they
/// cancel; a little of the first beside the second is nearly right. (Puso and Solberg 2006, Int. J. Numer. Meth. Engng.
/// 67, and Liu, Nguyen-Thoi and Lam 2008, Comput. Methods Appl. Mech. Engrg. 197, of linear elements.)
/// @param body   at rest, positive volumes
/// @param alone  part of the stiffness that stays inside each tetrahedron, between 0 and 1
std::shared_ptr<const ElasticTerm> nodal_springs(const core::Body &body, double alone);

/// The part alone of the model. It was chosen on the two livers at Poisson's ratios 0.25, 0.45 and 0.49; the beam had
/// no say in it.
inline constexpr double nodal_springs_alone = 0.2;

/// The model: a fifth of them alone, what is left of lambda on means of the volumes around nodes, and a guard against
/// inversion.
ElasticBody nodal_springs_with_volume(const core::Body &body, double alone = nodal_springs_alone);

} // namespace livermark::msm
