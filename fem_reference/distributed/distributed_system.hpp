#pragma once

#include <deal.II/base/index_set.h>
#include <deal.II/distributed/fully_distributed_tria.h>
#include <deal.II/dofs/dof_handler.h>
#include <deal.II/fe/fe_simplex_p.h>
#include <deal.II/fe/mapping_fe.h>
#include <deal.II/lac/trilinos_sparse_matrix.h>
#include <deal.II/lac/trilinos_vector.h>

#include <array>
#include <span>
#include <vector>

#include "core/problem.hpp"

namespace livermark::fem_reference {

/// K u - f of the rows of this rank, and what belongs to it.
struct DistributedResidual {
    std::vector<double> values; ///< (3 n_r) [N]: reactions, and rounding at the free unknowns
    double energy = 0.0;        ///< 1/2 u^T K u over the rows of this rank [J]
};

/// Linear elasticity of one problem, cut among the ranks of MPI_COMM_WORLD. deal.II numbers the nodes; a rank owns a
/// range of n_r of them, and the unknown of node a and component i is 3 a + i. A rank integrates its own cells and
/// the layer of cells around them, so that its rows are complete without any exchange.
class DistributedSystem {
  public:
    using Vector = dealii::TrilinosWrappers::MPI::Vector;

    /// Collective: the mesh is partitioned with METIS, every rank makes the same partition and keeps its part.
    /// @param problem  the same on every rank; kept alive by the caller
    DistributedSystem(const core::Problem &problem, int degree);

    /// Collective. @return the stiffness matrix with the off-diagonal entries of prescribed rows and columns zero
    dealii::TrilinosWrappers::SparseMatrix stiffness() const;

    /// Collective. @return f - K u with u the prescribed values and zero elsewhere; zero in prescribed rows [N]
    Vector right_hand_side() const;

    /// Collective. Sets the prescribed entries of a displacement.
    void impose(Vector &displacement) const;

    /// Collective.
    DistributedResidual residual(const Vector &displacement) const;

    /// The six rigid body modes in the rows of this rank, zero in prescribed ones.
    /// @return shape (6, 3 n_r)
    std::vector<double> rigid_modes() const;

    /// Sum over the rows of this rank that a constraint holds.
    /// @return shape (P)
    std::vector<core::Vector3> reactions(const DistributedResidual &residual) const;

    /// Collective. @return shape (N) the displacement of the mesh nodes in the numbering of the mesh, on every rank
    std::vector<core::Vector3> on_mesh(const Vector &displacement) const;

    /// Number of unknowns of all ranks.
    std::int64_t num_unknowns() const { return 3 * static_cast<std::int64_t>(dof_handler_.n_dofs()); }

    bool is_prescribed(std::size_t owned_row) const { return constraint_[first_owned_ + owned_row] >= 0; }

  private:
    struct Cell;
    template <class Visit> void visit_cells(Visit visit) const;
    void number_nodes(const core::Problem &problem, int degree);
    dealii::types::global_dof_index global(std::size_t relevant_row) const;

    const core::Problem &problem_;
    dealii::parallel::fullydistributed::Triangulation<3> triangulation_;
    dealii::FE_SimplexP<3> fe_;
    dealii::MappingFE<3> mapping_;
    dealii::DoFHandler<3> dof_handler_;
    dealii::IndexSet owned_nodes_, relevant_nodes_; ///< relevant are those of own cells and of the layer around them
    dealii::IndexSet owned_, relevant_;             ///< unknowns
    std::size_t first_owned_ = 0;                   ///< place of the first own unknown among the relevant ones
    std::vector<double> prescribed_;                ///< (relevant unknowns) [m], NaN where free
    std::vector<int> constraint_;                   ///< (relevant unknowns) index of the constraint, -1 where free
    std::vector<double> facet_load_;                ///< (relevant unknowns) [N]
    std::vector<core::Vector3> points_;             ///< (relevant nodes) [m]
    std::vector<int> mesh_node_;                    ///< (relevant nodes) number in the mesh, -1 for middles of edges
};

} // namespace livermark::fem_reference
