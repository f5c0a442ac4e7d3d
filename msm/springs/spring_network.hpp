#pragma once

#include <memory>
#include <string_view>

#include "core/problem.hpp"
#include "core/solution.hpp"
#include "msm/elastic_body.hpp"
#include "msm/spring_law.hpp"

namespace livermark::msm {

/// The springs of a body: an edge of the mesh each, at rest in the mesh.
core::SpringNetwork spring_network(const core::Body &body, const SpringLaw &law);

/// The energy of springs, U = sum over springs of k l0^2 energy(l / l0), with Hooke's curve k (l - l0)^2 / 2. Where it
/// is asked for forces, no two ends of a spring may be in one place. Second derivative: k [slope n n^T + force l0/l
/// (I - n n^T)] with n along the spring; the first part is the material one, and the second is negative where the
/// spring is compressed.
std::shared_ptr<const ElasticTerm> spring_term(const core::SpringNetwork &springs, const ForceCurve &curve = hooke);

// Springs that carry lambda = mu of the material beside a volume term that carries the rest, so that any Poisson's
// ratio can be had.

/// Springs that a mass-spring model makes of a body.
struct MassSprings {
    core::SpringNetwork springs; ///< kept in the result file
    ElasticBody body;            ///< what moves: the springs, and what else resists
};

/// The same body for the law of springs beside a volume term: with the body's shear modulus and lambda = mu.
core::Body for_springs_beside_volume(core::Body body);

/// The springs of a law for a material with the body's shear modulus and lambda = mu: Young's modulus 5 mu / 2 and
/// Poisson's ratio 1/4.
core::SpringNetwork springs_beside_volume(const core::Body &body, const SpringLaw &law);

/// The rest of lambda, for a volume term [Pa].
double modulus_beside_springs(const core::Material &material);

/// Whether anything is left of lambda: not at Poisson's ratio 1/4.
bool needs_volume(const core::Body &body);

/// A term that resists changes of volume with the rest of lambda.
std::shared_ptr<const ElasticTerm> volume_beside_springs(const core::Body &body, const VolumeTerm &term);

/// Both together, at Poisson's ratio 1/4 the springs alone. Tetrahedra are kept from turning inside out.
MassSprings springs_with_volume(const core::Body &body, core::SpringNetwork springs, const VolumeTerm &term,
                                const ForceCurve &curve = hooke);

/// @throws support::InputError if there is no volume term of that name
const VolumeTerm &find_volume_term(std::string_view name);

/// A guard that keeps tetrahedra from turning inside out, and turns them back: springs are content with a mirror image,
/// and a volume around a node may be kept while one of its tetrahedra is inverted.
///   U = sum over tetrahedra t of m_t / 2 (max(0, c V0_t - V_t))^2 / V0_t,   m_t = 4 (lambda + 2 mu),   c = 1/2
/// It is zero, with all its derivatives, as long as each tetrahedron keeps half its volume, so it changes no solution
/// to a small load and no critical time step; steps that are to bear it have to be shorter.
std::shared_ptr<const ElasticTerm> inversion_guard(const core::Body &body);

/// The guard as if every tetrahedron were below half its volume, at rest: with it the highest frequency is that of a
/// body pressed so far, which bounds the time step of one that is handled roughly.
std::shared_ptr<const ElasticTerm> pressed_guard(const core::Body &body);

} // namespace livermark::msm
