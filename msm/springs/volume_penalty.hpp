#pragma once

#include <Eigen/SparseCore>
#include <array>
#include <memory>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"
#include "core/problem.hpp"
#include "msm/elastic_body.hpp"

namespace livermark::msm {

/// The part of a body around each node, one for each material at it, with a quarter of each of its tetrahedra there.
/// Where two materials meet stress and pressure jump, so each has its own.
struct NodalParts {
    std::vector<int> node;                     ///< (C) in the middle
    std::vector<int> region;                   ///< (C)
    std::vector<double> volume;                ///< (C) at rest [m^3]
    std::vector<std::array<int, 4>> at_corner; ///< (M) part around each corner of a tetrahedron
    std::vector<double> tetrahedron_volume;    ///< (M) at rest [m^3]
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

} // namespace livermark::msm
