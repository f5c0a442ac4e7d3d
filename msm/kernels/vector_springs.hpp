#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "msm/elastic_body.hpp"
#include "msm/kernels/energy_kernels.hpp"
#include "msm/kernels/layout/sliced_body.hpp"

namespace livermark::msm {

/// Tetrahedra, or parts around nodes, in a slice here: as many doubles as the widest vectors have.
inline constexpr std::size_t coupled_slice = 8;

/// Springs that are coupled around nodes, with the volumes around nodes and the guard against inversion, as vector
/// units look for equilibria, in double precision. Arrays of tetrahedra are in slices of shape (k, 8), the last one
/// filled up with a tetrahedron of no volume; those of parts around nodes are filled up with zeros. What is averaged is
/// in rows, one of each part, to which tetrahedra add four numbers at a time.
struct CoupledArrays {
    EquilibriumFunctions functions;
    std::size_t num_nodes = 0;      ///< N
    std::size_t num_tetrahedra = 0; ///< a multiple of 8
    std::size_t num_parts = 0;      ///< a multiple of 8
    std::size_t row_size = 0;       ///< of a part: 8, or 12 of a deformation gradient; a relative volume is among it

    Aligned<double> rest;                  ///< (N, 4) positions [m]
    Aligned<std::int32_t> corner;          ///< slices of (4, 8): four times the node
    Aligned<std::int32_t> part;            ///< slices of (4, 8): where the row of the part around each corner begins
    Aligned<double> gradient;              ///< slices of (9, 8): of barycentric coordinates of corners 1 to 3 [1/m]
    Aligned<double> volume;                ///< of tetrahedra at rest [m^3]
    Aligned<double> inner_modulus;         ///< shear modulus of the springs inside them [Pa]
    Aligned<double> least_relative_volume; ///< that they are pushed back below; empty without a guard, as is
    Aligned<double> guard_modulus;         ///< what they are pushed back with [Pa]

    Aligned<double> part_volume;    ///< [m^3]
    Aligned<double> part_weight;    ///< what a sum over the tetrahedra of a part is multiplied by for a mean [1/m^3]
    Aligned<double> part_modulus;   ///< shear modulus of the springs around nodes [Pa]
    Aligned<double> volume_modulus; ///< kappa [Pa]; zeros where nothing is left of lambda
};

/// Memory that the kernels write to, for one thread at a time.
struct CoupledWorkspace {
    explicit CoupledWorkspace(const CoupledArrays &body);

    Aligned<double> displacement; ///< (N, 4) [m]
    Aligned<double> direction;    ///< (N, 4), of products [m]
    Aligned<double> force;        ///< (N, 4), or minus a product [N]
    Aligned<double> mean;         ///< rows of the parts: what is averaged, and the relative change of volume
    Aligned<double> push;         ///< rows of the parts: a quarter of their stresses and pressure [Pa]
    Aligned<double> mean_rate;    ///< rows of the parts, along a direction
    Aligned<double> stress;       ///< slices of (7, 8) of tetrahedra: stress and pressure that turn with them [Pa]
};

/// @param positions  shape (N) [m], at rest
/// @return nothing unless the parts are those of springs that are coupled around nodes, whole and with nothing beside
/// them but volumes around nodes and the guard
std::optional<CoupledArrays> coupled_arrays(const StepParts &parts, const std::vector<core::Vector3> &positions);

/// The same body for those who look for its equilibria, with one term that finds energies, forces and products with
/// second derivatives in vectors of double precision where the fast kernels know how: for springs that are coupled
/// around nodes, see coupled_arrays(). Numbers differ from those of the terms by rounding. All else is still asked of
/// these.
/// @param positions  shape (N) of rest [m]
/// @return a copy of the body where the kernels do not know how
ElasticBody in_vectors(const ElasticBody &body, const std::vector<core::Vector3> &positions);

} // namespace livermark::msm
