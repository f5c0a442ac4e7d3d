#pragma once

#include <Eigen/SparseCore>
#include <array>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"
#include "core/problem.hpp"
#include "core/solution.hpp"
#include "msm/elastic_body.hpp"
#include "msm/spring_energy.hpp"
#include "msm/spring_law.hpp"

namespace livermark::core {
struct Foundation;
}

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

/// Face of a tetrahedron that is a facet of the surface.
struct OuterFace {
    int tetrahedron;
    std::array<int, 3> corners; ///< of the tetrahedron, in the order of the nodes of the facet
    int facet;                  ///< boundary triangle

    bool is_gone(const CutTetrahedra &left) const {
        return left.is_removed[static_cast<std::size_t>(tetrahedron)] != 0;
    }
    /// Its nodes where its tetrahedron is left.
    std::array<int, 3> nodes(const CutTetrahedra &left) const {
        const auto &of = left.nodes[static_cast<std::size_t>(tetrahedron)];
        return {of[static_cast<std::size_t>(corners[0])], of[static_cast<std::size_t>(corners[1])],
                of[static_cast<std::size_t>(corners[2])]};
    }
};

/// The faces that are these boundary triangles, in their order.
/// @throws support::InputError if one of them is no face of a tetrahedron
std::vector<OuterFace> outer_faces_of(const core::TetraMesh &mesh, std::span<const int> facets);

/// Facets with a face and nodes after a cut: one goes with its tetrahedron, or gets the nodes of it.
template <class Facet> void take_cut(std::vector<Facet> &facets, const CutTetrahedra &left) {
    std::erase_if(facets, [&](const Facet &facet) { return facet.face.is_gone(left); });
    for (auto &facet : facets)
        facet.nodes = facet.face.nodes(left);
}

/// The covered faces of a body, in the order of its boundary triangles.
/// @return empty where the body has no capsule
std::vector<OuterFace> covered_faces(const core::Body &body);

/// The capsule of a body as springs on the three edges of each covered facet that are coupled to each other: the energy
/// of core::Capsule with C from the squared lengths of the edges, at which strains are the same all over a facet. Where
/// dashpots act along it, they have its stiffness at rest.
/// @return null where the body has no capsule
std::shared_ptr<const ElasticTerm> coupled_capsule(const core::Body &body);

/// The vessels of a body that are lines, see core::VesselTree. Dashpots act along them.
/// @return null where the body has none
std::shared_ptr<const ElasticTerm> vessel_lines(const core::Body &body);

/// Tissue of a body with its vessels, where it has some.
ElasticBody with_vessel_lines(ElasticBody tissue, const core::Body &body);

/// Springs below the facets of a foundation, on which displacements are linear: U = 1/2 u . K u with u = x - X.
/// Dashpots act along them.
/// @throws support::InputError if one of the facets is no face of a tetrahedron
std::shared_ptr<const ElasticTerm> foundation_springs(const core::TetraMesh &mesh, const core::Foundation &foundation);

/// A guard that keeps tetrahedra from turning inside out, and turns them back: springs are content with a mirror image,
/// and a volume around a node may be kept while one of its tetrahedra is inverted.
///   U = sum over tetrahedra t of m_t / 2 (max(0, c V0_t - V_t))^2 / V0_t,   m_t = 4 (lambda + 2 mu),   c = 1/2
/// It is zero, with all its derivatives, as long as each tetrahedron keeps half its volume, so it changes no solution
/// to a small load and no critical time step; steps that are to bear it have to be shorter.
std::shared_ptr<const ElasticTerm> inversion_guard(const core::Body &body);

/// The guard as if every tetrahedron were below half its volume, at rest: with it the highest frequency is that of a
/// body pressed so far, which bounds the time step of one that is handled roughly.
std::shared_ptr<const ElasticTerm> pressed_guard(const core::Body &body);

/// The part of a body around each node, one for each material at it, with a quarter of each of its tetrahedra there.
/// Stress and pressure jump where two materials meet, so each has its own.
struct NodalParts {
    std::vector<int> node;                     ///< (C) in the middle
    std::vector<int> region;                   ///< (C)
    std::vector<double> volume;                ///< (C) at rest [m^3]
    std::vector<std::array<int, 4>> at_corner; ///< (M) part around each corner of a tetrahedron
    std::vector<double> tetrahedron_volume;    ///< (M) at rest [m^3]
    std::vector<double> modulus_factor;        ///< (C) mean of core::Body::modulus_factor over the volume
};

/// @param body  at rest, positive volumes
NodalParts nodal_parts(const core::Body &body);

/// Parts of a body that each resist a change of their volume.
struct ControlVolumes {
    Eigen::SparseMatrix<double, Eigen::RowMajor> share; ///< (C, M) part of each tetrahedron that belongs to each, >= 0
    std::vector<double> modulus;                        ///< (C) kappa [Pa]
    std::vector<int> centre; ///< (C) node that each is around, with a quarter of its tetrahedra; empty if they are none
    /// (C, C) the means of relative changes that are resisted in place of the changes themselves, each row with the sum
    /// 1; empty if these are
    Eigen::SparseMatrix<double, Eigen::RowMajor> mean;
    MeasureVolume measure = change_of_volume; ///< of the relative changes, or of their means
};

/// The part of the body around each node as a control volume.
/// @param modulus  kappa of each region, shape (R) [Pa]
ControlVolumes volumes_around_nodes(const NodalParts &parts, const std::vector<double> &modulus);

/// The same, with each relative change averaged over the corners of each tetrahedron, and that over the tetrahedra
/// around each node.
/// (Onishi, Iida, Amaya 2017, Int. J. Numer. Meth. Engng. 109, average strains of volume again and again)
ControlVolumes mean_volumes_around_nodes(const NodalParts &parts, const std::vector<double> &modulus);

/// U = sum over control volumes c of kappa_c / 2 V0_c g(e_c)^2 with the relative change e_c = V_c / V0_c - 1,
/// V_c = sum over tetrahedra t of share_ct V_t now and V0_c at rest: the energy that a first Lame parameter kappa adds
/// to small strains. Its forces are p_t grad V_t with the pressure p_t = sum over c of share_ct kappa_c g g'(e_c), and
/// so its exact gradient at any deformation. (Bonet and Burton 1998, Commun. Numer. Meth. Engng. 14: with a quarter of
/// each tetrahedron to each corner this is the average nodal pressure.) With means, the relative changes e = V_c / V0_c
/// - 1 are replaced by mean e, in the energy and so in the pressure, which is mean^T (kappa V0 g g'(mean e)) / V0.
/// @param mesh  at rest
std::shared_ptr<const ElasticTerm> volume_penalty(const core::TetraMesh &mesh, const ControlVolumes &control_volumes);

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

/// Softness of its facets below a tool, as coupled_springs_with_volume() has it.
core::FacetSoftness softness_below_tools(const CoupledSprings &springs);

} // namespace livermark::msm
