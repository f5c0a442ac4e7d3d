#pragma once

#include <array>
#include <vector>

#include "fem_reference/linear/elastic_system.hpp"
#include "fem_reference/solvers/divergence_rows.hpp"

namespace livermark::fem_reference {

/// A region with a larger Poisson's ratio gets a pressure of its own.
inline constexpr double pressure_above_poisson_ratio = 0.3;

/// The pressure of Herrmann's formulation, p = lambda div u, where the material is nearly incompressible: linear on
/// tetrahedra and continuous within a region, so that it may jump where the stiffness does. With the quadratic
/// displacement these are the elements of Taylor and Hood, which do not lock.
/// (L. R. Herrmann 1965, Elasticity equations for incompressible and nearly incompressible materials by a variational
/// theorem, AIAA J. 3(10); C. Taylor and P. Hood 1973, Comput. Fluids 1(1))
///
/// One pressure for each node of each region that has one: m of them, none if no region has.
struct PressureSystem {
    std::vector<std::array<int, 4>> of_cell; ///< (M) the pressures at the corners, -1 in regions that have none
    DivergenceRows<double> divergence;       ///< (m, 3 n) D_q(ai) = integral of psi_q d phi_a / d x_i [m^2]
    SymmetricMatrix compliance;              ///< (m, m) C_qr = integral of psi_q psi_r / lambda [m^3/Pa]
    SymmetricMatrix norm;                    ///< (m, m) integral of (1 / (2 mu) + 1 / lambda) psi_q psi_r [m^3/Pa]

    int num_pressures() const { return compliance.row_start.empty() ? 0 : compliance.num_rows(); }
};

/// Whether a region gets one.
bool has_pressure(const core::Body &body);

/// What a pressure is divided by to be in the units of a displacement [Pa/m]: the mean shear modulus over the cube root
/// of the volume.
double pressure_scale(const core::Body &body);

/// The body with lambda = 0 in the regions that get a pressure: what is left of their stiffness is 2 mu eps.
core::Body without_pressure(const core::Body &body);

/// @param body    the whole one
/// @param system  of degree 2, assembled on without_pressure(body) or on the body: only its numbering is used
PressureSystem assemble_pressure(const core::Body &body, const ElasticSystem &system);
/// @param mesh  of this body
PressureSystem assemble_pressure(const core::Body &body, const DealIiMesh &mesh, const ElasticSystem &system);

} // namespace livermark::fem_reference
