#pragma once

#include <deal.II/base/partitioner.h>
#include <deal.II/base/subscriptor.h>
#include <deal.II/lac/la_parallel_vector.h>
#include <deal.II/lac/trilinos_precondition.h>
#include <deal.II/lac/trilinos_sparse_matrix.h>

#include <array>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <span>
#include <stdexcept>
#include <vector>

#include "core/problem.hpp"
#include "core/support/processes/mpi_session.hpp"
#include "fem_reference/linear/elastic_system.hpp"
#include "fem_reference/solvers/matrices.hpp"
#include "fem_reference/solvers/two_level.hpp"

namespace livermark::fem_reference {

/// Part of the mesh that a rank works on. Every vertex of the mesh has an owner, and so has every edge: that of one of
/// its ends. A part has all tetrahedra at the vertices of its rank, so what is assembled on it, by what knows of one
/// process only, is complete in the rows of nodes that the rank owns. Rows of other nodes are not: they are there to
/// read from.
struct Part {
    core::Problem problem;                   ///< facets keep their order and conditions; faces of the cut are no facets
    std::vector<std::int64_t> vertex_number; ///< (N') in the whole mesh, the same on all ranks
    std::vector<int> vertex_owner;           ///< (N') rank
    std::vector<int> facet;                  ///< (T') number among the boundary triangles of the mesh that was cut
    std::vector<int> mesh_node;              ///< (N') number in the mesh that was cut, -1 where a refinement is from
};

/// Collective, and the same on every rank: METIS cuts the graph of the edges.
/// @return the part of this rank
/// @throws std::invalid_argument on every rank if there are so few nodes that a rank has none
Part cut(const core::Problem &problem);

/// Collective. Every tetrahedron of a part into eight, see core::refine(): no rank sees the whole refined mesh.
Part refine(const Part &part);

/// Something that a number belongs to, as all ranks know it.
struct SharedEntry {
    std::array<std::int64_t, 2> key; ///< different for different ones
    int owner = 0;                   ///< rank
};

/// The nodes of elements by the ends of their edges, a vertex being the edge from itself to itself.
/// @param system  assembled on the part
/// @return shape (n)
std::vector<SharedEntry> nodes_of(const Part &part, const ElasticSystem &system);

/// Pressures by vertex and region.
/// @return shape (m)
std::vector<SharedEntry> pressures_of(const Part &part, const PressureSystem &pressure);

/// Exchange between the numbers of a part, in the order of its system, and vectors of all ranks, in which each rank has
/// those that it owns. The components of an entry stand together in both.
class NodeExchange {
  public:
    using Vector = dealii::LinearAlgebra::distributed::Vector<double>;

    /// Collective: numbers what each rank owns, and asks for the numbers of the rest.
    /// @param entries  (n) of this rank's part
    NodeExchange(std::span<const SharedEntry> entries, int components);

    /// (n) of each entry among those of all ranks
    const std::vector<std::int64_t> &numbers() const { return number_; }
    /// Entries of this part that this rank owns.
    const std::vector<int> &owned() const { return owned_; }
    bool owns(std::size_t entry) const { return is_owned_[entry]; }
    std::int64_t num_entries_of_all_ranks() const;
    /// Entries of this part that other ranks own: as many come with every exchange.
    std::size_t num_received() const { return number_.size() - owned_.size(); }

    /// Zero.
    Vector vector() const { return Vector(partitioner_); }
    const std::shared_ptr<const dealii::Utilities::MPI::Partitioner> &partitioner() const { return partitioner_; }

    /// Collective. What is owned here and elsewhere, where the part has it.
    /// @param values  shape (components n)
    template <class T> void read(const Vector &vector, std::span<T> values) const;
    /// Entries owned here.
    template <class T> void write(std::span<const T> values, Vector &vector) const;

    /// Collective. Overwrites what others own with what they have.
    /// @param values  shape (components n)
    void share(std::span<double> values) const;

  private:
    int components_;
    std::vector<std::int64_t> number_;
    std::vector<int> owned_;     ///< entries, in ascending order
    std::vector<bool> is_owned_; ///< (n)
    std::vector<int> place_;     ///< (n) in the vectors of this rank
    std::shared_ptr<const dealii::Utilities::MPI::Partitioner> partitioner_;
};

/// Result of action(). If it throws on one rank of several, the others cannot know, and would wait for ever: it says
/// why and ends them all. std::invalid_argument is for what all ranks find wrong alike, and goes on.
template <class Action> auto on_all_ranks(const Action &action) {
    try {
        return action();
    } catch (const std::invalid_argument &) {
        throw;
    } catch (const std::exception &error) {
        if (support::mpi_num_ranks() == 1)
            throw;
        support::abort_all_ranks(error.what());
    }
}

/// Collective.
/// @param constraint  shape (3 n) of the part, index of the constraint of each unknown, -1 where free
/// @param force       shape (3 n)
/// @return shape (P) sums over the unknowns of all ranks
std::vector<core::Vector3> sum_of_reactions(const NodeExchange &nodes, std::span<const int> constraint,
                                            std::span<const double> force, std::size_t num_constraints);

/// Collective.
/// @param displacement  shape (3 n) of the part
/// @return shape (N) at the nodes of the mesh that was cut, on every rank
std::vector<core::Vector3> on_mesh(const Part &part, const ElasticSystem &system, const NodeExchange &nodes,
                                   std::span<const double> displacement);

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
/// of approximate inverses: of K two levels over a multigrid, and for the Schur complement polynomials of Chebyshev of
/// the mass of the pressure, whose spectrum over its diagonal is known ([1/2, 5/2]; A. J. Wathen 1987, IMA J. Numer.
/// Anal. 7(4)). The number of iterations hardly depends on the mesh, on Poisson's ratio and on how many ranks there
/// are.
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
