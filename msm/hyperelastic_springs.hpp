#pragma once

#include <memory>

#include "core/problem.hpp"
#include "msm/elastic_body.hpp"
#include "msm/spring_energy.hpp"

namespace livermark::msm {

/// Springs along the edges of a mesh that are coupled to each other around each node, and a part of them inside each
/// tetrahedron, with the energy of a hyperelastic material:
///   U = (1 - alone) sum over nodal parts c of V_c W_s(E_c) + alone sum over tetrahedra t of V_t W_s(E_t)
/// E_t is the Green strain of a tetrahedron, linear in the squared lengths of its edges, and E_c its mean over the part
/// of a body around a node, by volume. So C_c = I + 2 E_c is the mean of C, which rotations leave alone, and the forces
/// of a tetrahedron are F_t S_t with S_t = (1 - alone) times the mean of S(E_c) over its four corners + alone S(E_t).
/// Dashpots act on the rate of E with the moduli at rest. Small strains give nodal_springs() (nodal_springs.hpp, which
/// also says why there are two parts).
///
/// The energy grows without bound as a tetrahedron is flattened, and is infinite where one is inside out; forces there
/// are those of its mirror image.
/// @param body    at rest, positive volumes
/// @param energy  W_s with lambda = mu
/// @param alone   part of the stiffness that stays inside each tetrahedron, between 0 and 1
std::shared_ptr<const ElasticTerm> hyperelastic_springs(const core::Body &body, const SpringEnergy &energy,
                                                        double alone);

/// What the model that ships keeps inside tetrahedra. It was chosen, as the means of volumes below, under the large
/// load cases on the two livers.
inline constexpr double hyperelastic_springs_alone = 0.2;

/// The model: springs as above, and what is left of lambda on means of the volumes around nodes,
/// (lambda - mu) / 2 g(J_c)^2. The energy keeps tetrahedra from turning inside out, so there is no other guard.
ElasticBody hyperelastic_springs_with_volume(const core::Body &body, const SpringEnergy &energy,
                                             double alone = hyperelastic_springs_alone);

} // namespace livermark::msm
