#include "fem_reference/distributed/distributed_system.hpp"

#include <deal.II/base/mpi.h>
#include <deal.II/base/quadrature_lib.h>
#include <deal.II/dofs/dof_tools.h>
#include <deal.II/fe/fe_values.h>
#include <deal.II/grid/grid_tools.h>
#include <deal.II/grid/tria_description.h>
#include <deal.II/lac/dynamic_sparsity_pattern.h>

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "fem_reference/deal_ii_mesh.hpp"
#include "fem_reference/facet_conditions.hpp"
#include "fem_reference/solvers/rigid_modes.hpp"

namespace livermark::fem_reference {

namespace {

/// In the order in which deal.II numbers the edges of a tetrahedron.
constexpr std::array<std::array<int, 2>, 6> edge_corners{{{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}}};

dealii::IndexSet three_each(const dealii::IndexSet &nodes) {
    dealii::IndexSet unknowns(3 * nodes.size());
    for (auto range = nodes.begin_intervals(); range != nodes.end_intervals(); ++range)
        unknowns.add_range(3 * *range->begin(), 3 * (range->last() + 1));
    unknowns.compress();
    return unknowns;
}

dealii::TriangulationDescription::Description<3, 3> partition(const core::TetraMesh &mesh) {
    dealii::Triangulation<3> whole;
    fill(whole, mesh);
    dealii::GridTools::partition_triangulation(dealii::Utilities::MPI::n_mpi_processes(MPI_COMM_WORLD), whole,
                                               dealii::SparsityTools::Partitioner::metis);
    return dealii::TriangulationDescription::Utilities::create_description_from_triangulation(whole, MPI_COMM_WORLD);
}

} // namespace

/// One cell as a rank sees it; m is its number of nodes.
struct DistributedSystem::Cell {
    std::vector<dealii::types::global_dof_index> unknowns; ///< (3 m)
    std::vector<std::size_t> rows;                         ///< (3 m) places among the relevant unknowns
    std::vector<bool> is_owned;                            ///< (m)
    Eigen::MatrixXd stiffness;                             ///< (3 m, 3 m)
    Eigen::VectorXd mass_integral;                         ///< (m) integral of density times shape function [kg]
};

DistributedSystem::DistributedSystem(const core::Problem &problem, int degree)
    : problem_(problem), triangulation_(MPI_COMM_WORLD), fe_(degree), mapping_(dealii::FE_SimplexP<3>(1)) {
    triangulation_.create_triangulation(partition(problem.body->mesh));
    dof_handler_.reinit(triangulation_);
    dof_handler_.distribute_dofs(fe_);
    owned_nodes_ = dof_handler_.locally_owned_dofs();
    dealii::DoFTools::extract_locally_relevant_dofs(dof_handler_, relevant_nodes_);
    owned_ = three_each(owned_nodes_);
    relevant_ = three_each(relevant_nodes_);
    first_owned_ = owned_.n_elements() == 0 ? 0 : relevant_.index_within_set(owned_.nth_index_in_set(0));
    number_nodes(problem, degree);
}

/// Every rank has the whole mesh, so what the facets say of a node is known wherever the node is seen.
void DistributedSystem::number_nodes(const core::Problem &problem, int degree) {
    const auto &mesh = problem.body->mesh;
    const auto conditions = node_conditions(problem.load_case, mesh, degree);
    const auto num_nodes = relevant_nodes_.n_elements();
    prescribed_.assign(3 * num_nodes, std::numeric_limits<double>::quiet_NaN());
    constraint_.assign(3 * num_nodes, -1);
    facet_load_.assign(3 * num_nodes, 0.0);
    points_.resize(num_nodes);
    mesh_node_.assign(num_nodes, -1);
    std::vector<dealii::types::global_dof_index> dofs(fe_.n_dofs_per_cell());
    for (const auto &cell : dof_handler_.active_cell_iterators()) {
        if (cell->is_artificial())
            continue;
        cell->get_dof_indices(dofs);
        const auto &corner = mesh.tetrahedra[cell->id().get_coarse_cell_id()];
        for (std::size_t a = 0; a < dofs.size(); ++a) {
            const auto [first, second] = a < 4
                                             ? node_key(corner[a], corner[a])
                                             : node_key(corner[edge_corners[a - 4][0]], corner[edge_corners[a - 4][1]]);
            const auto place = relevant_nodes_.index_within_set(dofs[a]);
            points_[place] = 0.5 * (mesh.points[first] + mesh.points[second]);
            mesh_node_[place] = a < 4 ? first : -1;
            const auto found = conditions.find({first, second});
            if (found == conditions.end())
                continue;
            for (int i = 0; i < 3; ++i) {
                prescribed_[3 * place + i] = found->second.prescribed[i];
                constraint_[3 * place + i] = found->second.constraint[i];
                facet_load_[3 * place + i] = found->second.force[i];
            }
        }
    }
}

dealii::types::global_dof_index DistributedSystem::global(std::size_t relevant_row) const {
    return relevant_.nth_index_in_set(relevant_row);
}

/// Calls visit(cell) for every cell with a node of this rank.
/// K_(ai)(bj) = integral of lambda g_ai g_bj + mu g_aj g_bi + mu delta_ij g_a . g_b, as in assemble().
template <class Visit> void DistributedSystem::visit_cells(Visit visit) const {
    const auto degree = fe_.degree;
    const dealii::QGaussSimplex<3> quadrature(degree);
    dealii::FEValues<3> values(mapping_, fe_, quadrature,
                               dealii::update_values | dealii::update_gradients | dealii::update_JxW_values);
    const auto num_local = fe_.n_dofs_per_cell();
    Cell local{std::vector<dealii::types::global_dof_index>(3 * num_local), std::vector<std::size_t>(3 * num_local),
               std::vector<bool>(num_local), Eigen::MatrixXd(3 * num_local, 3 * num_local), Eigen::VectorXd(num_local)};
    std::vector<dealii::types::global_dof_index> nodes(num_local);
    Eigen::Matrix3Xd gradient(3, num_local);
    std::vector<Eigen::Matrix3d> products(num_local * num_local);
    for (const auto &cell : dof_handler_.active_cell_iterators()) {
        if (cell->is_artificial())
            continue;
        cell->get_dof_indices(nodes);
        bool is_ours = false;
        for (unsigned int a = 0; a < num_local; ++a) {
            local.is_owned[a] = owned_nodes_.is_element(nodes[a]);
            is_ours = is_ours || local.is_owned[a];
        }
        if (!is_ours)
            continue;
        for (unsigned int a = 0; a < num_local; ++a) {
            const auto place = relevant_nodes_.index_within_set(nodes[a]);
            for (int i = 0; i < 3; ++i) {
                local.unknowns[3 * a + i] = 3 * nodes[a] + i;
                local.rows[3 * a + i] = 3 * place + i;
            }
        }
        values.reinit(cell);
        const auto &body = *problem_.body;
        const auto &material = body.materials[body.mesh.region[cell->id().get_coarse_cell_id()]];
        local.mass_integral.setZero();
        std::ranges::fill(products, Eigen::Matrix3d::Zero());
        for (unsigned int q = 0; q < quadrature.size(); ++q) {
            const double weight = values.JxW(q);
            for (unsigned int a = 0; a < num_local; ++a) {
                const auto &g = values.shape_grad(a, q);
                gradient.col(a) << g[0], g[1], g[2];
                local.mass_integral[a] += material.density * values.shape_value(a, q) * weight;
            }
            for (unsigned int a = 0; a < num_local; ++a)
                for (unsigned int b = 0; b <= a; ++b)
                    products[a * num_local + b] += weight * gradient.col(a) * gradient.col(b).transpose();
        }
        const double lambda = material.lame_lambda();
        const double mu = material.shear_modulus();
        for (unsigned int a = 0; a < num_local; ++a)
            for (unsigned int b = 0; b <= a; ++b) {
                const auto &product = products[a * num_local + b];
                const Eigen::Matrix3d block =
                    lambda * product + mu * product.transpose() + mu * product.trace() * Eigen::Matrix3d::Identity();
                local.stiffness.block<3, 3>(3 * a, 3 * b) = block;
                local.stiffness.block<3, 3>(3 * b, 3 * a) = block.transpose();
            }
        visit(local);
    }
}

dealii::TrilinosWrappers::SparseMatrix DistributedSystem::stiffness() const {
    dealii::TrilinosWrappers::SparseMatrix matrix;
    {
        dealii::DynamicSparsityPattern pattern(owned_.size(), owned_.size(), owned_);
        std::vector<dealii::types::global_dof_index> nodes(fe_.n_dofs_per_cell()), columns(3 * nodes.size());
        for (const auto &cell : dof_handler_.active_cell_iterators()) {
            if (cell->is_artificial())
                continue;
            cell->get_dof_indices(nodes);
            for (std::size_t k = 0; k < columns.size(); ++k)
                columns[k] = 3 * nodes[k / 3] + k % 3;
            for (const auto row : columns)
                if (owned_.is_element(row))
                    pattern.add_entries(row, columns.begin(), columns.end());
        }
        matrix.reinit(owned_, pattern, MPI_COMM_WORLD);
    }
    std::vector<double> values;
    visit_cells([&](const Cell &cell) {
        const auto size = cell.rows.size();
        values.resize(size);
        for (std::size_t k = 0; k < size; ++k) {
            if (!cell.is_owned[k / 3])
                continue;
            const bool is_constrained = constraint_[cell.rows[k]] >= 0;
            for (std::size_t l = 0; l < size; ++l)
                values[l] = k == l || (!is_constrained && constraint_[cell.rows[l]] < 0) ? cell.stiffness(k, l) : 0.0;
            matrix.add(cell.unknowns[k], size, cell.unknowns.data(), values.data(), false);
        }
    });
    matrix.compress(dealii::VectorOperation::add);
    return matrix;
}

void DistributedSystem::impose(Vector &displacement) const {
    for (std::size_t row = 0; row < owned_.n_elements(); ++row)
        if (is_prescribed(row))
            displacement(global(first_owned_ + row)) = prescribed_[first_owned_ + row];
    displacement.compress(dealii::VectorOperation::insert);
}

DistributedSystem::Vector DistributedSystem::right_hand_side() const {
    Vector constrained(owned_, MPI_COMM_WORLD);
    impose(constrained);
    const auto imbalance = residual(constrained).values;
    Vector out(owned_, MPI_COMM_WORLD);
    for (std::size_t row = 0; row < imbalance.size(); ++row)
        out(global(first_owned_ + row)) = is_prescribed(row) ? 0.0 : -imbalance[row];
    out.compress(dealii::VectorOperation::insert);
    return out;
}

DistributedResidual DistributedSystem::residual(const Vector &displacement) const {
    Vector ghosted(owned_, relevant_, MPI_COMM_WORLD);
    ghosted = displacement;
    const auto &acceleration = problem_.load_case.acceleration;
    DistributedResidual out{std::vector<double>(owned_.n_elements()), 0.0};
    Eigen::VectorXd u;
    visit_cells([&](const Cell &cell) {
        u.resize(static_cast<Eigen::Index>(cell.rows.size()));
        for (Eigen::Index k = 0; k < u.size(); ++k)
            u[k] = ghosted(cell.unknowns[k]);
        const Eigen::VectorXd force = cell.stiffness * u;
        for (Eigen::Index k = 0; k < u.size(); ++k)
            if (cell.is_owned[k / 3]) {
                out.values[cell.rows[k] - first_owned_] +=
                    force[k] - cell.mass_integral[k / 3] * acceleration[static_cast<int>(k % 3)];
                out.energy += 0.5 * u[k] * force[k];
            }
    });
    for (std::size_t row = 0; row < out.values.size(); ++row)
        out.values[row] -= facet_load_[first_owned_ + row];
    return out;
}

std::vector<double> DistributedSystem::rigid_modes() const {
    const RigidModes rigid(problem_.body->mesh.points);
    const auto size = owned_.n_elements();
    std::vector<double> modes(RigidModes::count * size, 0.0);
    for (std::size_t row = 0; row < size; ++row) {
        if (is_prescribed(row))
            continue;
        const auto at_row = rigid.at(points_[(first_owned_ + row) / 3]).row(static_cast<int>(row % 3)).eval();
        for (int m = 0; m < RigidModes::count; ++m)
            modes[m * size + row] = at_row[m];
    }
    return modes;
}

std::vector<core::Vector3> DistributedSystem::reactions(const DistributedResidual &residual) const {
    std::vector<core::Vector3> sums(problem_.load_case.constraint_names.size(), core::Vector3::Zero());
    for (std::size_t row = 0; row < residual.values.size(); ++row)
        if (is_prescribed(row))
            sums[constraint_[first_owned_ + row]][static_cast<int>(row % 3)] += residual.values[row];
    return sums;
}

std::vector<core::Vector3> DistributedSystem::on_mesh(const Vector &displacement) const {
    std::vector<core::Vector3> out(problem_.body->mesh.points.size(), core::Vector3::Zero());
    for (std::size_t row = 0; row < owned_.n_elements(); ++row)
        if (const int node = mesh_node_[(first_owned_ + row) / 3]; node >= 0)
            out[node][static_cast<int>(row % 3)] = displacement(global(first_owned_ + row));
    // Every node has one owner and is zero elsewhere, so the sum is exact.
    const auto flat = std::span(out.front().data(), 3 * out.size());
    MPI_Allreduce(MPI_IN_PLACE, flat.data(), static_cast<int>(flat.size()), MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
    return out;
}

} // namespace livermark::fem_reference
