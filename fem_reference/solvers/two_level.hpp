#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "fem_reference/linear/elastic_system.hpp"
#include "fem_reference/solvers/matrices.hpp"

namespace Teuchos {
class ParameterList;
}

namespace livermark::fem_reference {

/// A symmetric positive definite approximation of the inverse of the free rows and columns of a stiffness matrix, in
/// single precision: what is approximate takes no more, and memory comes in half of the time.
/// n is the number of rows of the whole matrix; unknowns that are not free are zero in whatever comes out.
class Preconditioner {
  public:
    virtual ~Preconditioner() = default;

    /// Prepares it, unless the same unknowns were free last time.
    /// @param free  in each of at most max_columns() columns
    /// @return whether the conditions fix the solution in every column
    virtual bool set_up(const FreeUnknowns &free) = 0;

    /// @param residual    shape (n, lanes), zero where not free
    /// @param correction  shape (n, lanes)
    virtual void apply(std::span<const float> residual, std::span<float> correction) = 0;

    /// Number of columns that take less time together than one by one.
    virtual std::size_t max_columns() const { return 1; }

    /// Name of the method, for the result file.
    virtual std::string name() const = 0;
};

/// Corners between which the nodes of a quadratic tetrahedron behind its corners lie.
inline constexpr std::array<std::array<int, 2>, 6> edges_of_quadratic{{{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}}};

/// Lagrange's shape functions in the order of ElasticSystem::cell_nodes; those of linear elements are zero from the
/// fifth on.
/// @param bary  barycentric coordinates of a point
std::array<double, 10> shape_functions(const Eigen::Vector4d &bary, int nodes_per_cell);

/// The functions of a coarse space as functions of a finer one that contains it: the value at fine node i is the sum
/// of weight times the value at a coarse node, the same for each component.
struct Prolongation {
    std::vector<int> row_start;   ///< (n_fine + 1) index into coarse_node and weight
    std::vector<int> coarse_node; ///< (nonzeros)
    std::vector<double> weight;   ///< (nonzeros)
    std::vector<int> fine_node;   ///< (n_coarse) the fine node at the same place as each coarse node

    /// fine_c += P coarse_c
    /// @param coarse  shape (3 n_coarse, lanes), see matrices.hpp
    /// @param fine    shape (3 n_fine, lanes)
    void add_prolonged(std::span<const double> coarse, std::span<double> fine) const;
    void add_prolonged(std::span<const float> coarse, std::span<float> fine) const;

    /// coarse_c = P^T fine_c
    void restrict_to(std::span<const double> fine, std::span<double> coarse) const;
    void restrict_to(std::span<const float> fine, std::span<float> coarse) const;
};

/// The prolongation from a body's system to one of degree 2: from degree 2 to that of a body whose tetrahedra are parts
/// of the coarse ones, or from degree 1 to that of the same body.
/// @param parent  (M_fine) the coarse tetrahedron that each is a part of, whose edges were cut in two at most once
///                (core::bisect()); empty for all of the same body in order, or for core::refine(body)
/// @throws std::invalid_argument if the fine system is not of such parts
Prolongation prolongation(const ElasticSystem &coarse, const ElasticSystem &fine, std::span<const int> parent = {});

/// Gauss-Seidel sweeps over the nodes of a system, three components at a time. A smoother lives from the memory that it
/// does not move: it is in single precision, and of the blocks only those below the diagonal are kept. What a row of
/// them takes from the nodes before gives, transposed, what these nodes take from it, so each sweep reads them once.
/// Neighbours should be near each other, see NodeOrder.
class BlockGaussSeidel {
  public:
    /// @param matrix  kept alive and unchanged by the caller
    explicit BlockGaussSeidel(const SymmetricBlocks<float> &matrix);

    /// Makes sweeps go over the free unknowns of each column; the others are zero in whatever comes out.
    void set_up(const FreeUnknowns &free);

    /// One sweep from the first node to the last, from zero.
    /// @param right_hand_side  shape (3 n, lanes)
    /// @param u                shape (3 n, lanes), what it was does not matter
    /// @param residual         shape (3 n, lanes) right_hand_side - K u
    void sweep_forward_from_zero(std::span<const float> right_hand_side, std::span<float> u, std::span<float> residual);

    /// One sweep from the last node to the first: the adjoint of the forward one.
    /// @param u  shape (3 n, lanes), zero where not free; improved
    void sweep_backward(std::span<const float> right_hand_side, std::span<float> u);

  private:
    template <int lanes> class Sweep;
    template <int lanes>
    void forward(std::span<const float> right_hand_side, std::span<float> u, std::span<float> residual);
    template <int lanes> void backward(std::span<const float> right_hand_side, std::span<float> u);

    const SymmetricBlocks<float> &matrix_;
    std::vector<Block<float>> inverse_diagonal_; ///< (n) where all is free
    int lanes_ = 0;
    std::vector<int> constrained_;           ///< (n) index into the next two, -1 where all columns are free
    std::vector<float> constrained_inverse_; ///< (9, lanes) each: of the free rows and columns, otherwise zero
    std::vector<float> is_free_;             ///< (3, lanes) each: 1 or 0
    std::vector<float> taken_;               ///< (n, 3, lanes) K u of the rows behind
};

/// Two-level preconditioner: a Gauss-Seidel sweep on the fine unknowns, a correction from a coarse space, and a sweep
/// back. The coarse space is contained in the fine one, so a coarse stiffness matrix is P^T K P (see galerkin()) or
/// that of the coarse elements themselves, which is the same where the material is linear.
/// @param prolongation   from the coarse space
/// @param rounded_fine   stiffness of the fine system, for the sweeps; kept alive and unchanged by the caller
/// @param coarse_solver  solves on the coarse space, exactly or nearly so; kept alive by the caller
std::unique_ptr<Preconditioner> two_level(Prolongation prolongation, const SymmetricBlocks<float> &rounded_fine,
                                          Preconditioner &coarse_solver);

/// P^T K P
/// @param coarse_rows  which nodes of the coarse space share a cell, see CellEntries::below_diagonal
SymmetricBlocks<double> galerkin(const Prolongation &prolongation, const SymmetricBlocks<double> &stiffness,
                                 const LowerRows &coarse_rows);

/// A sparse matrix in compressed rows that need not be square.
struct SparseRows {
    std::vector<int> row_start; ///< (m + 1) index into column and value
    std::vector<int> column;    ///< (nonzeros)
    std::vector<double> value;  ///< (nonzeros)
};

/// Displacements and pressures of a body as those of the refined one: iterations there begin at the solution on
/// the mesh before refinement, which is wrong by percents where zero is wrong by all.
struct NestedIteration {
    Prolongation displacement;
    SparseRows pressure; ///< (m_fine, m_coarse)

    /// p_c = P p_coarse,c
    /// @param coarse  shape (m_coarse, lanes), see matrices.hpp
    /// @return shape (m_fine, lanes)
    std::vector<double> prolonged_pressure(std::span<const double> coarse, int lanes) const;
};

/// @param coarse, fine                    systems of degree 2 of a body and of one that is refined
/// @param coarse_pressure, fine_pressure  assembled on them
/// @param parent                          see prolongation()
/// @throws std::invalid_argument if the fine system is not that of the refined body
NestedIteration nested_iteration(const ElasticSystem &coarse, const PressureSystem &coarse_pressure,
                                 const ElasticSystem &fine, const PressureSystem &fine_pressure,
                                 std::span<const int> parent = {});

/// The motions that strain nothing, linearised: three translations, then three rotations about the middle of a body,
/// over its size.
class RigidModes {
  public:
    static constexpr int count = 6;

    /// @param points  of the body [m]; at least two different ones
    explicit RigidModes(std::span<const core::Vector3> points);

    /// Values of the modes (columns) at a point, by components (rows).
    Eigen::Matrix<double, 3, count> at(const core::Vector3 &point) const;

  private:
    core::Vector3 middle_; // [m]
    double size_;          // [m]
};

/// Puts columns in balance: moves all that is free of each by a rigid motion, so that the residual that is left there
/// has neither a resultant nor a moment, and reactions balance the loads. With Z the rigid modes, zero where
/// constrained, u_c
/// += Z (Z^T K Z)^-1 Z^T r_c, which also takes u_c as near to K^-1 f_c as such a motion can, in the norm of the energy
/// (Galerkin). Unless the body is borne by springs, K R = 0 for the modes R of all unknowns, and Z^T K Z = R_h^T K_hh
/// R_h, with what is constrained alone.
/// @param free      in all of its sets what is constrained stops every rigid motion
/// @param residual  shape (n, lanes), see matrices.hpp, r = f - K u where free, zero where constrained
/// @param u         shape (n, lanes)
void balance(const ElasticSystem &system, const FreeUnknowns &free, std::span<const double> residual,
             std::span<double> u);

/// Settings by which Trilinos ML makes and applies the levels of a smoothed aggregation multigrid for elasticity.
/// @param modes  (6, n) rigid body modes at the n unknowns of this rank, the near-nullspace; the list points to them
///               and they are read while the levels are made
Teuchos::ParameterList multigrid_settings(std::vector<double> &modes);

/// Smoothed aggregation multigrid (Trilinos ML) with the six rigid body modes as near-nullspace.
/// @param system  kept alive and unchanged by the caller
std::unique_ptr<Preconditioner> algebraic_multigrid(const ElasticSystem &system);

} // namespace livermark::fem_reference
