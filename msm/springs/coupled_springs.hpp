#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "core/problem.hpp"
#include "msm/elastic_body.hpp"
#include "msm/spring_energy.hpp"

namespace livermark::msm {

/// Parts of the stiffness of coupled springs that act on means of the strain over each kind of parts of a body: around
/// nodes (a quarter of each tetrahedron there), around edges (a sixth), and over tetrahedra, which have one strain.
/// Not negative, with the sum 1.
struct StrainDomains {
    double nodes = 0.0;
    double edges = 0.0;
    double tetrahedra = 0.0;
};

/// Springs along the edges of a mesh that are coupled to each other. Three choices make them.
struct CoupledSprings {
    std::string name; ///< of the model that they are
    StrainDomains domains;
    StrainMeasure measure = StrainMeasure::cauchy_green;
    SpringEnergy energy; ///< W_s, with lambda = mu
    /// Whether relative changes of the volumes around nodes are averaged with those of their neighbours before they are
    /// resisted, see mean_volumes_around_nodes().
    bool averages_volumes = false;
};

/// The part of the stiffness that springs around nodes keep inside tetrahedra. See docs/studies/models.md on how it was
/// chosen.
inline constexpr double part_inside_beside_nodes = 0.2;

/// The same beside edges: enough for every tetrahedron to be seen when it turns inside out.
inline constexpr double part_inside_beside_edges = 0.05;

/// The springs that are models, by name: nodal_springs with Hooke's law on elongations, and for every energy that grows
/// without bound nodal_<energy> and edge_<energy> with means of C, and the same with an _f behind it with means of F.
std::span<const CoupledSprings> all_coupled_springs();

/// @throws support::InputError if there are none of that name
const CoupledSprings &find_coupled_springs(std::string_view name);

/// Whether the fast kernels know them: springs around nodes or edges, some of them inside tetrahedra, with a measure
/// that SpringEnergy::in_kernels has, elongations around nodes alone, and with means of volumes around edges alone.
/// Others move by the scalar kernel.
bool are_in_kernels(const CoupledSprings &springs);

/// The same with another part of the stiffness inside tetrahedra, taken from all other domains alike.
/// @param part  between 0 and 1
CoupledSprings with_part_inside(CoupledSprings springs, double part);

/// The energy of coupled springs,
///   U = sum over kinds k of domains w_k sum over domains d of that kind of V_d W_s(E_d),
/// where E_d is the strain of the mean over the domain, by volume, of what is averaged. All tetrahedra have the same E
/// where the deformation is the same everywhere, and for small strains what is averaged makes no difference.
///
/// Strains of tetrahedra make a body too stiff, and their means around nodes too soft, with motions in which they
/// cancel. Means around edges lie between. (Puso and Solberg 2006, Int. J. Numer. Meth. Engng. 67; Liu, Nguyen-Thoi and
/// Lam 2008, Comput. Methods Appl. Mech. Engrg. 197, and 2009, J. Sound Vib. 320, of linear elements.)
///
/// Dashpots act on the rate of E_d with the moduli at rest. An energy that has no value where a tetrahedron is inside
/// out is infinite there; forces there are those of its mirror image.
/// @param body  at rest, positive volumes
std::shared_ptr<const ElasticTerm> coupled_springs(const core::Body &body, const CoupledSprings &springs);

/// The rest of lambda on the volumes around nodes, (lambda - mu) / 2 g(J)^2.
/// @return null if nothing is left: at Poisson's ratio 1/4
std::shared_ptr<const ElasticTerm> volume_beside_coupled_springs(const core::Body &body, const CoupledSprings &springs);

/// The model: the springs, the volume beside them, and for an energy that is finite everywhere a guard against
/// inversion.
ElasticBody coupled_springs_with_volume(const core::Body &body, const CoupledSprings &springs);

} // namespace livermark::msm
