#pragma once

#include <deal.II/base/subscriptor.h>
#include <deal.II/lac/trilinos_precondition.h>
#include <deal.II/lac/trilinos_sparse_matrix.h>

#include <Eigen/LU>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "fem_reference/distributed/part.hpp"
#include "fem_reference/linear/elastic_system.hpp"
#include "fem_reference/solvers/algebraic_multigrid.hpp"
#include "fem_reference/solvers/matrices.hpp"

namespace livermark::fem_reference {

/// A stiffness that each rank has on its part, as deal.II's solvers take it: K of what is free, zero elsewhere.
/// @tparam T  of the product
template <class T> class DistributedStiffness : public dealii::Subscriptor {
  public:
    using Vector = NodeExchange::Vector;

    /// All are kept alive by the caller.
    /// @param is_free  shape (3 n)
    DistributedStiffness(const SymmetricBlocks<T> &stiffness, const NodeExchange &nodes,
                         const std::vector<bool> &is_free)
        : stiffness_(stiffness), nodes_(nodes), is_free_(is_free), from_(is_free.size()), to_(is_free.size()) {}

    /// Collective.
    /// @param in  zero where not free
    void vmult(Vector &out, const Vector &in) const {
        nodes_.read(in, std::span(from_));
        stiffness_.multiply(from_, to_);
        clear_constrained(std::span(to_), is_free_);
        nodes_.write(std::span<const T>(to_), out);
    }

  private:
    const SymmetricBlocks<T> &stiffness_;
    const NodeExchange &nodes_;
    const std::vector<bool> &is_free_;
    mutable std::vector<T> from_, to_;
};

/// The inverses of the diagonal blocks, of what is free: what Chebyshev's polynomials smooth with.
class BlockJacobi : public dealii::Subscriptor {
  public:
    using Vector = NodeExchange::Vector;

    BlockJacobi(const SymmetricBlocks<double> &stiffness, const NodeExchange &nodes, const std::vector<bool> &is_free) {
        for (const int node : nodes.owned()) {
            Eigen::Matrix3d block = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>::Map(stiffness.diagonal[node].data());
            for (int i = 0; i < 3; ++i)
                if (!is_free[3 * node + i]) {
                    block.row(i).setZero();
                    block.col(i).setZero();
                    block(i, i) = 1.0;
                }
            Eigen::Matrix3d inverse = block.inverse();
            for (int i = 0; i < 3; ++i)
                if (!is_free[3 * node + i])
                    inverse(i, i) = 0.0;
            inverse_.push_back(inverse);
        }
    }

    void vmult(Vector &out, const Vector &in) const {
        for (std::size_t k = 0; k < inverse_.size(); ++k)
            Eigen::Vector3d::Map(out.begin() + 3 * k) = inverse_[k] * Eigen::Vector3d::Map(in.begin() + 3 * k);
    }

  private:
    std::vector<Eigen::Matrix3d> inverse_; ///< (owned nodes)
};

/// Smoothed aggregation multigrid (Trilinos ML) over all ranks, of a stiffness that each rank has on its part. What is
/// constrained is zero in whatever comes out, if it is in what comes in.
class DistributedMultigrid {
  public:
    using Vector = NodeExchange::Vector;

    /// Collective.
    /// @param stiffness  of the part, complete in the rows of nodes that this rank owns
    /// @param nodes      of the part, three components each
    /// @param points     (n) of the part [m]
    /// @param rigid      of the whole body
    /// @param is_free    shape (3 n)
    DistributedMultigrid(const SymmetricBlocks<double> &stiffness, const NodeExchange &nodes,
                         std::span<const core::Vector3> points, const RigidModes &rigid,
                         const std::vector<bool> &is_free);

    /// Collective. out = an approximate K^-1 in
    void vmult(Vector &out, const Vector &in) const { levels_.vmult(out, in); }

  private:
    dealii::TrilinosWrappers::SparseMatrix matrix_;
    dealii::TrilinosWrappers::PreconditionAMG levels_;
};

/// An approximate inverse of the stiffness of quadratic elements over all ranks: linear elements of the same
/// tetrahedra with a smoothed aggregation multigrid of their own below, and polynomials of Chebyshev over the diagonal
/// blocks before and behind, which are the same however the body is cut. Where the material is nearly incompressible
/// the stiffness has to be the one without lambda, see without_pressure().
/// (M. Adams, M. Brezina, J. Hu, R. Tuminaro 2003, Parallel multigrid smoothing, J. Comput. Phys. 188(2))
class DistributedLevels {
  public:
    using Vector = NodeExchange::Vector;

    /// Collective. Part, system, nodes and is_free are kept alive by the caller.
    /// @param quadratic  assembled on the part
    /// @param nodes      of it, three components each
    /// @param rigid      of the whole body
    /// @param is_free    shape (3 n)
    DistributedLevels(const Part &part, const ElasticSystem &quadratic, const NodeExchange &nodes,
                      const RigidModes &rigid, const std::vector<bool> &is_free);
    ~DistributedLevels();

    /// Collective.
    void set_up(const SymmetricBlocks<double> &stiffness);

    /// Collective, after set_up().
    void vmult(Vector &out, const Vector &in) const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// [K + L, D^T; D, -C] as one rank has it on its part; results are right where this rank owns them.
struct MatricesOfPart {
    const SymmetricBlocks<double> &stiffness;
    const DivergenceRows<double> &divergence;
    const SymmetricMatrix &compliance;
    /// out += L x, or empty
    std::function<void(std::span<const double> x, std::span<double> out)> add_product{};

    /// force = (K + L) u + D^T p, and imbalance = D u - C p
    void apply(std::span<const double> u, std::span<const double> p, std::span<double> force,
               std::span<double> imbalance) const;
};

/// Displacements (3 n) and pressures (m) of a part.
struct MixedField {
    std::vector<double> u, p;
};

/// Solves the systems of mixed elements over all ranks, by generalised minimal residuals with the lower block triangle
/// of approximate inverses: DistributedLevels of K, and for the Schur complement polynomials of Chebyshev of the mass
/// of the pressure, whose spectrum over its diagonal is known ([1/2, 5/2]; A. J. Wathen 1987, IMA J. Numer. Anal.
/// 7(4)). The number of iterations hardly depends on the mesh, on Poisson's ratio and on how many ranks there are.
class DistributedSaddlePoint {
  public:
    /// Collective. All but what is moved are kept alive by the caller.
    /// @param system    quadratic elements assembled on the part; its numbering is used
    /// @param pressure  the same; its numbering and norm are used
    /// @param nodes     of the system, three components each
    /// @param scale     what pressures are divided by [Pa/m], see pressure_scale()
    /// @param is_free   shape (3 n), right for what other ranks own too
    DistributedSaddlePoint(const Part &part, const ElasticSystem &system, const PressureSystem &pressure,
                           const NodeExchange &nodes, const RigidModes &rigid, double scale, std::vector<bool> is_free);
    ~DistributedSaddlePoint();

    const NodeExchange &pressures() const;

    /// Collective. Makes the levels of K.
    void set_up(const SymmetricBlocks<double> &stiffness);

    struct Ending {
        bool converged = false;
        int iterations = 0;
        double relative_residual = 0.0; ///< as the preconditioner sees it, over the first
    };
    /// Collective, after a set_up().
    /// @param right      what is not free or owned does not count
    /// @param tolerance  of the residual as the preconditioner sees it, over the first
    /// @param found      also what other ranks own; zero where not free
    Ending solve(const MatricesOfPart &matrices, const MixedField &right, double tolerance, int max_iterations,
                 MixedField &found) const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace livermark::fem_reference
