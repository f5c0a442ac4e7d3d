#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "core/problem.hpp"
#include "fem_reference/solvers/matrices.hpp"

namespace livermark::fem_reference {

/// Formulation of linear elasticity, by its unknowns.
enum class Formulation {
    displacement, ///< u alone
    mixed         ///< and the pressure p = lambda div u of what is nearly incompressible, see PressureSystem
};

/// Solver of linear systems: sparse Cholesky (CHOLMOD), or conjugate gradients with algebraic multigrid (Trilinos
/// ML). Automatic means sparse Cholesky up to largest_direct_system unknowns; of quadratic elements up to
/// largest_direct_quadratic_system, and two levels beyond it: see Corners.
enum class SolverChoice { automatic, direct, iterative };

/// Number of unknowns beyond which the factor of a quadratic system of tetrahedra takes more memory and time than it is
/// worth.
inline constexpr int largest_direct_system = 250'000;
/// The same of quadratic elements that have two levels beside it: on 220,000 unknowns the factor takes 52 s of a core,
/// two levels and a solution by them a few.
inline constexpr int largest_direct_quadratic_system = 100'000;
/// The same of linear elements that are the coarse level of quadratic ones, see Corners: an approximate inverse is
/// enough there, by multigrid beyond it, whose memory and time grow with the unknowns.
inline constexpr int largest_direct_coarse_system = 100'000;

/// Numbering of the nodes of a system.
enum class NodeOrder {
    of_mesh,    ///< the first N are those of the mesh, in its numbering; with quadratic elements edge midpoints follow
    by_distance ///< neighbours near each other, see order_by_distance(): for iterations, which live from the caches
};

/// The nodes of cells, neighbours near each other: by their distance from one that is far from most (the levels of
/// Cuthill and McKee 1969). A loop over rows in this order finds the entries of a vector that it needs in a cache.
/// @param cell_nodes  (M, nodes_per_cell)
/// @param num_nodes   all in some cell
/// @return shape (n) the nodes in their new order
std::vector<int> order_by_distance(std::span<const int> cell_nodes, int nodes_per_cell, int num_nodes);

/// Linear elasticity of one body, discretised on its tetrahedra with Lagrange elements and before any condition is put
/// on it. Everything is plain data, so that only the assembly has to see deal.II.
///
/// The unknown of node a and component i is 3 a + i.
struct ElasticSystem {
    std::vector<int> mesh_node;         ///< (N) the node at each node of the mesh
    int nodes_per_cell = 0;             ///< 4 or 10
    int nodes_per_facet = 0;            ///< 3 or 6
    std::vector<core::Vector3> points;  ///< (n) [m]
    std::vector<int> cell_nodes;        ///< (M, nodes_per_cell) four corners, then midpoints of 01 12 20 03 13 23
    std::vector<int> facet_nodes;       ///< (T, nodes_per_facet) nodes of each boundary triangle of the mesh
    std::vector<double> facet_integral; ///< (T, nodes_per_facet) integral of the node's shape function [m^2]
    std::vector<double> mass_integral;  ///< (n) integral of density times shape function [kg]; negative at P2 corners
    /// (nodes_per_cell, nodes_per_cell) integral of the product of two shape functions over a tetrahedron, divided by
    /// its volume: the same for all, because their sides are straight
    std::vector<double> reference_mass;
    SymmetricBlocks<double> stiffness; ///< (3 n, 3 n) [N/m]
    bool is_borne = false;             ///< whether it has springs of a foundation, which rigid motions strain as well

    int num_nodes() const { return static_cast<int>(points.size()); }

    /// @param u  shape (3 n)
    /// @return shape (N) at the nodes of the mesh
    std::vector<core::Vector3> at_mesh_nodes(std::span<const double> u) const {
        std::vector<core::Vector3> result;
        result.reserve(mesh_node.size());
        for (const int node : mesh_node)
            result.emplace_back(core::Vector3::Map(&u[3 * static_cast<std::size_t>(node)]));
        return result;
    }
};

/// Assembles a body.
/// K_(ai)(bj) = sum over t of the integral of lambda g_ai g_bj + mu g_aj g_bi + mu delta_ij g_a . g_b, with g_a the
/// gradient of shape function a (the weak form of isotropic linear elasticity in the Lame parameters), and the Membrane
/// of a capsule, the VesselLines, and the FoundationSprings of what the body stands on.
/// @param body    tetrahedra of positive volume, every node used
/// @param degree  1 or 2
/// @throws std::invalid_argument for another degree, or if a boundary triangle is not an outer face of the tetrahedra
ElasticSystem assemble(const core::Body &body, int degree, NodeOrder order = NodeOrder::of_mesh,
                       const std::optional<core::Foundation> &foundation = {});

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
    std::vector<std::array<int, 4>> cell_pressures; ///< (M) the pressures at the corners, -1 in regions that have none
    DivergenceRows<double> divergence;              ///< (m, 3 n) D_q(ai) = integral of psi_q d phi_a / d x_i [m^2]
    SymmetricMatrix compliance;                     ///< (m, m) C_qr = integral of psi_q psi_r / lambda [m^3/Pa]
    SymmetricMatrix norm; ///< (m, m) integral of (1 / (2 mu) + 1 / lambda) psi_q psi_r [m^3/Pa]

    int num_pressures() const { return compliance.row_start.empty() ? 0 : compliance.num_rows(); }
};

/// Whether a region gets one.
bool has_pressure(const core::Body &body);

/// Divisor of a pressure, for it to be in the units of a displacement [Pa/m]: the mean shear modulus over the cube root
/// of the volume.
double pressure_scale(const core::Body &body);

/// The body with lambda = 0 in the regions that get a pressure: what is left of their stiffness is 2 mu eps.
core::Body without_pressure(const core::Body &body);

/// @param body    the whole one
/// @param system  of degree 2, assembled on without_pressure(body) or on the body: only its numbering is used
PressureSystem assemble_pressure(const core::Body &body, const ElasticSystem &system);

/// The matrices of one body and of what it stands on.
struct Discretisation {
    /// @throws std::invalid_argument for the mixed formulation of linear elements, or as assemble() does
    Discretisation(const core::Body &body, int degree, Formulation formulation,
                   const std::optional<core::Foundation> &foundation = {});

    ElasticSystem system;
    PressureSystem pressure; ///< empty where nothing is nearly incompressible
};

} // namespace livermark::fem_reference
