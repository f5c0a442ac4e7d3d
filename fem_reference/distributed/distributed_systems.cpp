#include "fem_reference/distributed/distributed_systems.hpp"

#include <deal.II/base/mpi.h>
#include <deal.II/base/subscriptor.h>
#include <deal.II/lac/dynamic_sparsity_pattern.h>
#include <deal.II/lac/la_parallel_block_vector.h>
#include <deal.II/lac/precondition.h>
#include <deal.II/lac/solver_control.h>
#include <deal.II/lac/solver_gmres.h>
#include <deal.II/lac/sparsity_pattern.h>
#include <deal.II/lac/sparsity_tools.h>

#include <Eigen/LU>
#include <Teuchos_ParameterList.hpp>
#include <algorithm>
#include <fmt/format.h>
#include <functional>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include "core/mesh/refinement.hpp"
#include "core/mesh/tetra_mesh.hpp"
#include "core/support/processes/mpi_session.hpp"
#include "fem_reference/solvers/algebraic_multigrid.hpp"
#include "fem_reference/solvers/matrices.hpp"
#include "fem_reference/solvers/two_level.hpp"

namespace livermark::fem_reference {

namespace {

/// (N) the rank of each node
std::vector<int> owners(const core::TetraMesh &mesh, int num_ranks) {
    if (mesh.num_nodes() < num_ranks)
        throw std::invalid_argument(fmt::format("{} ranks are too many for {} nodes", num_ranks, mesh.num_nodes()));
    const auto num_nodes = static_cast<unsigned int>(mesh.num_nodes());
    dealii::DynamicSparsityPattern edges(num_nodes, num_nodes);
    for (const auto &corners : mesh.tetrahedra)
        for (const int a : corners)
            for (const int b : corners)
                edges.add(a, b);
    dealii::SparsityPattern graph;
    graph.copy_from(edges);
    std::vector<unsigned int> rank(num_nodes, 0);
    if (num_ranks > 1)
        dealii::SparsityTools::partition(graph, num_ranks, rank, dealii::SparsityTools::Partitioner::metis);
    std::vector<int> count(num_ranks, 0);
    for (const auto owner : rank)
        ++count[owner];
    if (std::ranges::find(count, 0) != count.end())
        throw std::invalid_argument(fmt::format("a rank of {} has no node of {}; start fewer", num_ranks, num_nodes));
    return {rank.begin(), rank.end()};
}

/// Which of two ends owns an edge: by turns, so that no rank has all those between two.
int owner_of_edge(std::int64_t first, std::int64_t second, int owner_of_first, int owner_of_second) {
    return (first + second) % 2 == 0 ? owner_of_first : owner_of_second;
}

SharedEntry edge_between(const Part &part, int a, int b) {
    if (part.vertex_number[a] > part.vertex_number[b])
        std::swap(a, b);
    return {.key = {part.vertex_number[a], part.vertex_number[b]},
            .owner = owner_of_edge(part.vertex_number[a], part.vertex_number[b], part.vertex_owner[a],
                                   part.vertex_owner[b])};
}

/// The tetrahedra at nodes of a rank, with those nodes and facets that they have.
Part at_nodes_of(int rank, const Part &whole) {
    const auto &body = *whole.problem.body;
    const auto &mesh = body.mesh;
    const auto &load_case = whole.problem.load_case;
    std::vector<std::size_t> kept;
    std::vector<int> place(mesh.points.size(), -1);
    for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t)
        if (std::ranges::any_of(mesh.tetrahedra[t], [&](int node) { return whole.vertex_owner[node] == rank; })) {
            kept.push_back(t);
            for (const int node : mesh.tetrahedra[t])
                place[node] = 0;
        }
    Part part;
    core::Body out{.name = body.name, .mesh = {}, .materials = body.materials};
    out.mesh.region_names = mesh.region_names;
    out.mesh.patch_names = mesh.patch_names;
    auto &conditions = part.problem.load_case;
    conditions.name = load_case.name;
    conditions.regime = load_case.regime;
    conditions.acceleration = load_case.acceleration;
    conditions.conditions = load_case.conditions;
    conditions.path = load_case.path;
    conditions.press_depth = load_case.press_depth;
    for (std::size_t node = 0; node < mesh.points.size(); ++node) {
        if (place[node] < 0)
            continue;
        place[node] = out.mesh.num_nodes();
        out.mesh.points.push_back(mesh.points[node]);
        part.vertex_number.push_back(whole.vertex_number[node]);
        part.vertex_owner.push_back(whole.vertex_owner[node]);
        part.mesh_node.push_back(whole.mesh_node[node]);
        if (!load_case.node_factor.empty())
            conditions.node_factor.push_back(load_case.node_factor[node]);
        if (!load_case.node_shift.empty())
            conditions.node_shift.push_back(load_case.node_shift[node]);
    }
    for (const auto t : kept) {
        auto corners = mesh.tetrahedra[t];
        for (int &node : corners)
            node = place[node];
        out.mesh.tetrahedra.push_back(corners);
        out.mesh.region.push_back(mesh.region[t]);
    }
    // A face may have all its corners here and its tetrahedron elsewhere.
    std::vector<std::array<int, 3>> outer = core::outer_faces(out.mesh.tetrahedra);
    std::ranges::transform(outer, outer.begin(), [](const auto &face) { return core::face_key(face); });
    std::ranges::sort(outer);
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f) {
        auto corners = mesh.boundary_triangles[f];
        for (int &node : corners)
            node = place[node];
        if (!std::ranges::binary_search(outer, core::face_key(corners)))
            continue;
        out.mesh.boundary_triangles.push_back(corners);
        out.mesh.boundary_patch.push_back(mesh.boundary_patch[f]);
        part.facet.push_back(whole.facet[f]);
        conditions.condition_on.push_back(load_case.condition_on[f]);
        conditions.value.push_back(load_case.value[f]);
    }
    part.problem.body = std::make_shared<const core::Body>(std::move(out));
    return part;
}

} // namespace

Part cut(const core::Problem &problem) {
    const auto &mesh = problem.body->mesh;
    Part whole{.problem = problem, .vertex_number = {}, .vertex_owner = {}, .facet = {}, .mesh_node = {}};
    whole.facet.resize(mesh.boundary_triangles.size());
    std::iota(whole.facet.begin(), whole.facet.end(), 0);
    whole.vertex_owner = owners(mesh, support::mpi_num_ranks());
    whole.vertex_number.resize(mesh.points.size());
    std::iota(whole.vertex_number.begin(), whole.vertex_number.end(), std::int64_t{0});
    whole.mesh_node.assign(whole.vertex_number.begin(), whole.vertex_number.end());
    return at_nodes_of(support::mpi_rank(), whole);
}

Part refine(const Part &part) {
    const auto &mesh = part.problem.body->mesh;
    // The vertices of the refined mesh are the nodes of quadratic elements on this one.
    const auto edges = core::edge_table(mesh.tetrahedra).edges;
    Part fine{
        .problem = core::refine(part.problem), .vertex_number = {}, .vertex_owner = {}, .facet = {}, .mesh_node = {}};
    for (int child = 0; child < fine.problem.body->mesh.num_boundary_triangles(); ++child)
        fine.facet.push_back(part.facet[child / 4]);
    std::vector<SharedEntry> vertices;
    for (int a = 0; a < mesh.num_nodes(); ++a)
        vertices.push_back(edge_between(part, a, a));
    for (const auto &[a, b] : edges)
        vertices.push_back(edge_between(part, a, b));
    fine.vertex_number = NodeExchange(vertices, 1).numbers();
    for (const auto &vertex : vertices)
        fine.vertex_owner.push_back(vertex.owner);
    fine.mesh_node = part.mesh_node;
    fine.mesh_node.resize(vertices.size(), -1);
    return at_nodes_of(support::mpi_rank(), fine);
}

std::vector<SharedEntry> nodes_of(const Part &part, const ElasticSystem &system) {
    std::vector<SharedEntry> nodes(system.points.size());
    const auto &tetrahedra = part.problem.body->mesh.tetrahedra;
    for (std::size_t t = 0; t < tetrahedra.size(); ++t)
        for (int k = 0; k < system.nodes_per_cell; ++k) {
            const auto &corner = tetrahedra[t];
            const auto ends = k < 4 ? std::array{k, k} : edges_of_quadratic[k - 4];
            nodes[system.cell_nodes[t * system.nodes_per_cell + k]] =
                edge_between(part, corner[ends[0]], corner[ends[1]]);
        }
    return nodes;
}

std::vector<SharedEntry> pressures_of(const Part &part, const PressureSystem &pressure) {
    std::vector<SharedEntry> entries(pressure.num_pressures());
    const auto &mesh = part.problem.body->mesh;
    for (std::size_t t = 0; t < pressure.cell_pressures.size(); ++t)
        for (int k = 0; k < 4; ++k)
            if (const int number = pressure.cell_pressures[t][k]; number >= 0) {
                const int vertex = mesh.tetrahedra[t][k];
                entries[number] = {.key = {part.vertex_number[vertex], mesh.region[t]},
                                   .owner = part.vertex_owner[vertex]};
            }
    return entries;
}

namespace {

using Numbers = std::vector<std::int64_t>;

/// Counts of the ranks before this one, and all together.
std::pair<std::int64_t, std::int64_t> sums_of_ranks(std::int64_t mine) {
    std::int64_t before = 0, all = 0;
    MPI_Exscan(&mine, &before, 1, MPI_INT64_T, MPI_SUM, MPI_COMM_WORLD);
    MPI_Allreduce(&mine, &all, 1, MPI_INT64_T, MPI_SUM, MPI_COMM_WORLD);
    return {support::mpi_rank() == 0 ? 0 : before, all};
}

dealii::IndexSet with_components(dealii::IndexSet::size_type size, const Numbers &entries, int components) {
    dealii::IndexSet set(components * size);
    for (const auto entry : entries)
        set.add_range(components * entry, components * (entry + 1));
    set.compress();
    return set;
}

} // namespace

NodeExchange::NodeExchange(std::span<const SharedEntry> entries, int components) : components_(components) {
    const int rank = support::mpi_rank();
    is_owned_.resize(entries.size());
    for (std::size_t i = 0; i < entries.size(); ++i)
        if (is_owned_[i] = entries[i].owner == rank; is_owned_[i])
            owned_.push_back(static_cast<int>(i));
    const auto [before, all] = sums_of_ranks(static_cast<std::int64_t>(owned_.size()));

    std::map<unsigned int, Numbers> questions; // keys, one behind the other
    std::map<unsigned int, std::vector<std::size_t>> asked;
    for (std::size_t i = 0; i < entries.size(); ++i)
        if (!is_owned_[i]) {
            auto &keys = questions[entries[i].owner];
            keys.insert(keys.end(), entries[i].key.begin(), entries[i].key.end());
            asked[entries[i].owner].push_back(i);
        }
    number_.resize(entries.size());
    std::vector<std::pair<std::array<std::int64_t, 2>, std::int64_t>> known;
    for (std::size_t k = 0; k < owned_.size(); ++k) {
        number_[owned_[k]] = before + static_cast<std::int64_t>(k);
        known.emplace_back(entries[owned_[k]].key, number_[owned_[k]]);
    }
    std::ranges::sort(known);
    std::map<unsigned int, Numbers> answers;
    for (const auto &[asking, keys] : dealii::Utilities::MPI::some_to_some(MPI_COMM_WORLD, questions))
        for (std::size_t k = 0; k < keys.size(); k += 2) {
            const std::array key{keys[k], keys[k + 1]};
            const auto found = std::ranges::lower_bound(known, key, {}, [](const auto &entry) { return entry.first; });
            if (found == known.end() || found->first != key)
                throw std::logic_error("a rank was asked for a node that it does not own");
            answers[asking].push_back(found->second);
        }
    Numbers others;
    for (const auto &[owner, numbers] : dealii::Utilities::MPI::some_to_some(MPI_COMM_WORLD, answers))
        for (std::size_t k = 0; k < numbers.size(); ++k) {
            number_[asked.at(owner)[k]] = numbers[k];
            others.push_back(numbers[k]);
        }
    std::ranges::sort(others);

    if (all == 0) { // deal.II divides by it
        partitioner_ = std::make_shared<const dealii::Utilities::MPI::Partitioner>();
        return;
    }
    dealii::IndexSet mine(components * all);
    mine.add_range(components * before, components * (before + static_cast<std::int64_t>(owned_.size())));
    partitioner_ = std::make_shared<const dealii::Utilities::MPI::Partitioner>(
        mine, with_components(all, others, components), MPI_COMM_WORLD);
    for (const auto number : number_)
        place_.push_back(static_cast<int>(partitioner_->global_to_local(components * number)));
}

std::int64_t NodeExchange::num_entries_of_all_ranks() const {
    return static_cast<std::int64_t>(partitioner_->size()) / components_;
}

template <class T> void NodeExchange::read(const Vector &vector, std::span<T> values) const {
    vector.update_ghost_values();
    const double *const from = vector.begin();
    for (std::size_t i = 0; i < place_.size(); ++i)
        for (int c = 0; c < components_; ++c)
            values[components_ * i + c] = static_cast<T>(from[place_[i] + c]);
    vector.zero_out_ghost_values();
}

template <class T> void NodeExchange::write(std::span<const T> values, Vector &vector) const {
    double *const to = vector.begin();
    for (const int i : owned_)
        for (int c = 0; c < components_; ++c)
            to[place_[i] + c] = static_cast<double>(values[components_ * i + c]);
}

template void NodeExchange::read(const Vector &, std::span<double>) const;
template void NodeExchange::read(const Vector &, std::span<float>) const;
template void NodeExchange::write(std::span<const double>, Vector &) const;
template void NodeExchange::write(std::span<const float>, Vector &) const;

void NodeExchange::share(std::span<double> values) const {
    auto whole = vector();
    write<double>(values, whole);
    read<double>(whole, values);
}

namespace {

/// Over all ranks; what one alone has not zero is exact.
void sum_over_ranks(std::vector<core::Vector3> &vectors) {
    if (!vectors.empty())
        MPI_Allreduce(MPI_IN_PLACE, vectors.front().data(), static_cast<int>(3 * vectors.size()), MPI_DOUBLE, MPI_SUM,
                      MPI_COMM_WORLD);
}

} // namespace

std::vector<core::Vector3> sum_of_reactions(const NodeExchange &nodes, std::span<const int> constraint,
                                            std::span<const double> force, std::size_t num_constraints) {
    std::vector<core::Vector3> sums(num_constraints, core::Vector3::Zero());
    for (const int node : nodes.owned())
        for (int i = 0; i < 3; ++i)
            if (const int owner = constraint[3 * node + i]; owner >= 0)
                sums[owner][i] += force[3 * node + i];
    sum_over_ranks(sums);
    return sums;
}

std::vector<core::Vector3> on_mesh(const Part &part, const ElasticSystem &system, const NodeExchange &nodes,
                                   std::span<const double> displacement) {
    int last = -1;
    for (std::size_t vertex = 0; vertex < part.mesh_node.size(); ++vertex)
        last = std::max(last, part.mesh_node[vertex]);
    std::vector<core::Vector3> result(dealii::Utilities::MPI::max(last, MPI_COMM_WORLD) + 1, core::Vector3::Zero());
    for (std::size_t vertex = 0; vertex < part.mesh_node.size(); ++vertex)
        if (const int node = system.mesh_node[vertex]; part.mesh_node[vertex] >= 0 && nodes.owns(node))
            result[part.mesh_node[vertex]] = core::Vector3::Map(&displacement[3 * node]);
    sum_over_ranks(result);
    return result;
}

namespace {

using Number = dealii::types::global_dof_index;

Number unknown(const NodeExchange &nodes, int node, int component) {
    return static_cast<Number>(3 * nodes.numbers()[node] + component);
}

/// Entries of the rows of this rank.
dealii::DynamicSparsityPattern pattern(const SymmetricMatrix &blocks, const NodeExchange &nodes) {
    const auto &own = nodes.partitioner()->locally_owned_range();
    dealii::DynamicSparsityPattern result(own.size(), own.size(), own);
    std::vector<Number> columns;
    for (const int node : nodes.owned()) {
        columns.clear();
        for (int k = blocks.row_start[node]; k < blocks.row_start[node + 1]; ++k)
            for (int j = 0; j < 3; ++j)
                columns.push_back(unknown(nodes, blocks.column[k], j));
        for (int i = 0; i < 3; ++i)
            result.add_entries(unknown(nodes, node, i), columns.begin(), columns.end());
    }
    return result;
}

/// Calls action(a, b, block, is_transposed) for the blocks on and below the diagonal of which this rank owns row a, and
/// for those above.
template <class Action>
void for_each_owned_block(const SymmetricBlocks<double> &matrix, const NodeExchange &nodes, const Action &action) {
    for (int a = 0; a < static_cast<int>(matrix.diagonal.size()); ++a) {
        if (nodes.owns(a))
            action(a, a, matrix.diagonal[a], false);
        for (int k = matrix.rows.row_start[a]; k < matrix.rows.row_start[a + 1]; ++k) {
            const int b = matrix.rows.column[k];
            if (nodes.owns(a))
                action(a, b, matrix.below[k], false);
            if (nodes.owns(b))
                action(b, a, matrix.below[k], true);
        }
    }
}

dealii::TrilinosWrappers::SparseMatrix global_matrix(const SymmetricBlocks<double> &stiffness,
                                                     const NodeExchange &nodes, const std::vector<bool> &is_free) {
    dealii::TrilinosWrappers::SparseMatrix result;
    result.reinit(nodes.partitioner()->locally_owned_range(), pattern(zero_of_blocks(stiffness.rows), nodes),
                  MPI_COMM_WORLD);
    for_each_owned_block(stiffness, nodes, [&](int a, int b, const Block<double> &block, bool is_transposed) {
        for (int i = 0; i < 3; ++i) {
            std::array<Number, 3> columns{};
            std::array<double, 3> values{};
            for (int j = 0; j < 3; ++j) {
                const bool counts = (a == b && i == j) || (is_free[3 * a + i] && is_free[3 * b + j]);
                columns[j] = unknown(nodes, b, j);
                values[j] = counts ? block[is_transposed ? 3 * j + i : 3 * i + j] : 0.0;
            }
            result.set(unknown(nodes, a, i), columns.size(), columns.data(), values.data(), false);
        }
    });
    result.compress(dealii::VectorOperation::insert);
    return result;
}

/// At the unknowns of this rank, zero where constrained.
/// @return shape (6, owned unknowns)
std::vector<double> modes_of_rank(const NodeExchange &nodes, std::span<const core::Vector3> points,
                                  const RigidModes &rigid, const std::vector<bool> &is_free) {
    const auto size = 3 * nodes.owned().size();
    std::vector<double> modes(RigidModes::count * size, 0.0);
    for (std::size_t k = 0; k < nodes.owned().size(); ++k) {
        const int node = nodes.owned()[k];
        const auto at_node = rigid.at(points[node]);
        for (int i = 0; i < 3; ++i)
            for (int m = 0; m < RigidModes::count; ++m)
                modes[m * size + 3 * k + i] = is_free[3 * node + i] ? at_node(i, m) : 0.0;
    }
    return modes;
}

} // namespace

DistributedMultigrid::DistributedMultigrid(const SymmetricBlocks<double> &stiffness, const NodeExchange &nodes,
                                           std::span<const core::Vector3> points, const RigidModes &rigid,
                                           const std::vector<bool> &is_free)
    : matrix_(global_matrix(stiffness, nodes, is_free)) {
    auto modes = modes_of_rank(nodes, points, rigid, is_free);
    auto settings = multigrid_settings(modes);
    levels_.initialize(matrix_, settings);
}

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

using Smoothed = DistributedStiffness<float>;
using Chebyshev = dealii::PreconditionChebyshev<Smoothed, NodeExchange::Vector, BlockJacobi>;

/// Products before and behind the correction, and over which part of the spectrum they act: beyond that linear elements
/// see what is left.
constexpr unsigned int smoother_degree = 3;
constexpr double smoothing_range = 12.0;
constexpr unsigned int eigenvalue_iterations = 12;

/// An approximate inverse of the stiffness of quadratic elements over all ranks: linear elements of the same
/// tetrahedra with a smoothed aggregation multigrid of their own below, and polynomials of Chebyshev over the diagonal
/// blocks before and behind, which are the same however the body is cut. Where the material is nearly incompressible
/// the stiffness has to be the one without lambda, see without_pressure().
/// (M. Adams, M. Brezina, J. Hu, R. Tuminaro 2003, Parallel multigrid smoothing, J. Comput. Phys. 188(2))
struct DistributedLevels {
    /// Collective. System, nodes and is_free are kept alive by the caller.
    /// @param quadratic_system  assembled on the part
    /// @param exchange          of its nodes, three components each
    /// @param body_modes        of the whole body
    /// @param free              shape (3 n)
    DistributedLevels(const Part &part, const ElasticSystem &quadratic_system, const NodeExchange &exchange,
                      const RigidModes &body_modes, const std::vector<bool> &free)
        : quadratic(quadratic_system), nodes(exchange), rigid(body_modes), is_free(free),
          linear(assemble(without_pressure(*part.problem.body), 1)), vertices(nodes_of(part, linear), 3),
          from_linear(prolongation(linear, quadratic)), is_vertex_free(3 * linear.points.size()),
          residual(vertices.vector()), correction(vertices.vector()) {
        for (std::size_t dof = 0; dof < is_vertex_free.size(); ++dof)
            is_vertex_free[dof] = is_free[3 * from_linear.fine_node[dof / 3] + dof % 3];
        fine_values.resize(3 * quadratic.points.size());
        coarse_values.resize(is_vertex_free.size());
    }

    /// Collective.
    void set_up(const SymmetricBlocks<double> &stiffness) {
        coarse.reset();
        smoother.reset();
        smoothed.reset();
        rounded_stiffness = rounded(stiffness);
        smoothed.emplace(rounded_stiffness, nodes, is_free);
        Chebyshev::AdditionalData settings;
        settings.degree = smoother_degree;
        settings.smoothing_range = smoothing_range;
        settings.eig_cg_n_iterations = eigenvalue_iterations;
        settings.preconditioner = std::make_shared<BlockJacobi>(stiffness, nodes, is_free);
        smoother.emplace();
        smoother->initialize(*smoothed, settings);
        linear.stiffness = galerkin(from_linear, stiffness, linear.stiffness.rows);
        coarse.emplace(linear.stiffness, vertices, linear.points, rigid, is_vertex_free);
    }

    /// Collective, after set_up().
    void vmult(NodeExchange::Vector &out, const NodeExchange::Vector &in) const {
        smoother->vmult(out, in);
        correct(out, in);
        smoother->step(out, in);
    }

    /// out += the correction of linear elements for what in is without out.
    void correct(NodeExchange::Vector &out, const NodeExchange::Vector &in) const {
        auto left = nodes.vector();
        smoothed->vmult(left, out);
        left.sadd(-1.0, 1.0, in);
        nodes.read(left, std::span(fine_values));
        from_linear.restrict_to(std::span<const double>(fine_values), coarse_values);
        clear_constrained(std::span(coarse_values), is_vertex_free);
        vertices.write(std::span<const double>(coarse_values), residual);
        coarse->vmult(correction, residual);
        vertices.read(correction, std::span(coarse_values));
        std::ranges::fill(fine_values, 0.0);
        from_linear.add_prolonged(std::span<const double>(coarse_values), fine_values);
        clear_constrained(std::span(fine_values), is_free);
        nodes.write(std::span<const double>(fine_values), left);
        out += left;
    }

    const ElasticSystem &quadratic;
    const NodeExchange &nodes;
    RigidModes rigid;
    const std::vector<bool> &is_free;
    ElasticSystem linear; ///< its stiffness is P^T K P
    NodeExchange vertices;
    Prolongation from_linear;
    std::vector<bool> is_vertex_free;
    SymmetricBlocks<float> rounded_stiffness;
    std::optional<Smoothed> smoothed;
    std::optional<Chebyshev> smoother;
    std::optional<DistributedMultigrid> coarse;
    mutable NodeExchange::Vector residual, correction; ///< of linear elements
    mutable std::vector<double> fine_values, coarse_values;
};

/// The mass of the pressure that each rank has on its part.
class DistributedMass : public dealii::Subscriptor {
  public:
    using Vector = NodeExchange::Vector;

    /// Both are kept alive by the caller.
    /// @param matrix  of the part, complete in the rows that this rank owns
    DistributedMass(const SymmetricMatrix &matrix, const NodeExchange &pressures)
        : matrix_(matrix), pressures_(pressures), from_(matrix.value.empty() ? 0 : matrix.num_rows()),
          to_(from_.size()) {}

    void vmult(Vector &out, const Vector &in) const {
        pressures_.read(in, std::span(from_));
        if (!from_.empty())
            multiply(matrix_, from_, to_, 1);
        pressures_.write(std::span<const double>(to_), out);
    }

  private:
    const SymmetricMatrix &matrix_;
    const NodeExchange &pressures_;
    mutable std::vector<double> from_, to_;
};

/// Over its diagonal.
class InverseDiagonal : public dealii::Subscriptor {
  public:
    using Vector = NodeExchange::Vector;

    InverseDiagonal(const SymmetricMatrix &matrix, const NodeExchange &pressures) {
        for (const int row : pressures.owned())
            for (int k = matrix.row_start[row]; k < matrix.row_start[row + 1]; ++k)
                if (matrix.column[k] == row)
                    inverse_.push_back(1.0 / matrix.value[k]);
    }
    void vmult(Vector &out, const Vector &in) const {
        std::ranges::transform(inverse_, std::span(in.begin(), inverse_.size()), out.begin(), std::multiplies<>());
    }

  private:
    std::vector<double> inverse_; ///< (owned pressures)
};

using BlockVector = dealii::LinearAlgebra::distributed::BlockVector<double>;

/// Vectors of a Krylov space: more than ever were needed, so that it need not begin anew.
constexpr unsigned int largest_space_on_ranks = 80;
/// Reduction that one round of iterations may reach: the smoothers are in single precision, and so what a round
/// believes to be left differs from what is left.
constexpr double furthest_round_on_ranks = 1e-5;
/// A round that ends further than it was told to begins another one.
constexpr double reserve_on_ranks = 0.5;

using ChebyshevOfMass = dealii::PreconditionChebyshev<DistributedMass, NodeExchange::Vector, InverseDiagonal>;

/// The mass of linear functions on a tetrahedron has these over its diagonal.
constexpr double largest_eigenvalue = 2.5, smallest_eigenvalue = 0.5;
/// Leaves less than a thousandth: more would not save iterations.
constexpr unsigned int mass_degree = 8;

void MatricesOfPart::apply(std::span<const double> u, std::span<const double> p, std::span<double> force,
                           std::span<double> imbalance) const {
    stiffness.multiply(u, force);
    if (!p.empty()) {
        multiply(compliance, p, imbalance);
        divergence.add_products(u, p, force, imbalance, 1);
    }
    if (add_product)
        add_product(u, force);
}

struct DistributedSaddlePoint::Impl {
    Impl(const Part &part, const ElasticSystem &system, const PressureSystem &pressure, const NodeExchange &exchange,
         const RigidModes &rigid, double scale_of_pressure, std::vector<bool> free)
        : nodes(exchange), pressures(pressures_of(part, pressure), 1), is_free(std::move(free)),
          levels(part, system, nodes, rigid, is_free), mass(pressure.norm, pressures), scale(scale_of_pressure),
          num_pressures(pressure.num_pressures()) {
        ChebyshevOfMass::AdditionalData settings;
        settings.degree = mass_degree;
        settings.max_eigenvalue = largest_eigenvalue;
        settings.smoothing_range = largest_eigenvalue / smallest_eigenvalue;
        settings.eig_cg_n_iterations = 0; // they are known
        settings.preconditioner = std::make_shared<InverseDiagonal>(pressure.norm, pressures);
        inverse_mass.initialize(mass, settings);
    }

    BlockVector vector() const {
        BlockVector result(2);
        result.block(0) = nodes.vector();
        result.block(1) = pressures.vector();
        result.collect_sizes();
        return result;
    }

    /// Products on the part, pressures in their scale.
    void apply(const MatricesOfPart &matrices, BlockVector &out, const BlockVector &in) const {
        nodes.read(in.block(0), std::span(u));
        pressures.read(in.block(1), std::span(p));
        for (double &value : p)
            value *= scale;
        matrices.apply(u, p, force, volume);
        write(force, volume, out);
    }

    void write(std::vector<double> &force_on_part, std::vector<double> &volume_on_part, BlockVector &out) const {
        clear_constrained(std::span(force_on_part), is_free);
        for (double &value : volume_on_part)
            value *= scale;
        nodes.write(std::span<const double>(force_on_part), out.block(0));
        pressures.write(std::span<const double>(volume_on_part), out.block(1));
    }

    /// u = K^-1 f, p = S^-1 (D u - g)
    void precondition(const MatricesOfPart &matrices, BlockVector &out, const BlockVector &in) const {
        levels.vmult(out.block(0), in.block(0));
        if (pressures.num_entries_of_all_ranks() == 0)
            return;
        nodes.read(out.block(0), std::span(u));
        std::ranges::fill(p, 0.0);
        if (num_pressures > 0)
            matrices.divergence.subtract_product(u, p, volume, 1);
        auto imbalance = pressures.vector();
        pressures.write(std::span<const double>(volume), imbalance);
        imbalance.add(-1.0 / scale, in.block(1));
        inverse_mass.vmult(out.block(1), imbalance);
        out.block(1) *= 1.0 / scale;
    }

    const NodeExchange &nodes;
    NodeExchange pressures;
    std::vector<bool> is_free;
    DistributedLevels levels;
    DistributedMass mass;
    ChebyshevOfMass inverse_mass;
    double scale;
    int num_pressures;
    mutable std::vector<double> u = std::vector<double>(is_free.size()), force = u; ///< (3 n)
    mutable std::vector<double> p = std::vector<double>(num_pressures), volume = p; ///< (m)
};

DistributedSaddlePoint::DistributedSaddlePoint(const Part &part, const ElasticSystem &system,
                                               const PressureSystem &pressure, const NodeExchange &nodes,
                                               const RigidModes &rigid, double scale, std::vector<bool> is_free)
    : impl_(std::make_unique<Impl>(part, system, pressure, nodes, rigid, scale, std::move(is_free))) {}
DistributedSaddlePoint::~DistributedSaddlePoint() = default;

const NodeExchange &DistributedSaddlePoint::pressures() const {
    return impl_->pressures;
}

void DistributedSaddlePoint::set_up(const SymmetricBlocks<double> &stiffness) {
    impl_->levels.set_up(stiffness);
}

DistributedSaddlePoint::Ending DistributedSaddlePoint::solve(const MatricesOfPart &matrices, const MixedField &right,
                                                             double tolerance, int max_iterations,
                                                             MixedField &found) const {
    const auto &impl = *impl_;
    const Operator matrix{[&](BlockVector &out, const BlockVector &in) { impl.apply(matrices, out, in); }};
    const Operator preconditioner{
        [&](BlockVector &out, const BlockVector &in) { impl.precondition(matrices, out, in); }};
    auto load = impl.vector(), x = impl.vector();
    impl.force = right.u;
    impl.volume = right.p;
    impl.write(impl.force, impl.volume, load);

    Ending ending{.converged = true};
    auto left = load, correction = x;
    double first = 0.0;
    using Solver = dealii::SolverGMRES<BlockVector>;
    for (double reached = 1.0; ending.converged && reached > tolerance;) {
        dealii::ReductionControl control(max_iterations - ending.iterations, std::numeric_limits<double>::min(),
                                         std::max(reserve_on_ranks * tolerance / reached, furthest_round_on_ranks));
        correction = 0.0;
        try {
            Solver(control, Solver::AdditionalData(largest_space_on_ranks))
                .solve(matrix, correction, left, preconditioner);
        } catch (const dealii::SolverControl::NoConvergence &) {
            ending.converged = false;
        }
        ending.iterations += static_cast<int>(control.last_step());
        x += correction;
        matrix.vmult(left, x);
        left.sadd(-1.0, 1.0, load);
        preconditioner.vmult(correction, left);
        if (first == 0.0)
            first = control.initial_value();
        const double before = std::exchange(reached, first > 0.0 ? correction.l2_norm() / first : 0.0);
        ending.relative_residual = reached;
        ending.converged = ending.converged && reached < reserve_on_ranks * before;
    }
    found.u.resize(impl.is_free.size());
    found.p.resize(impl.num_pressures);
    impl.nodes.read(x.block(0), std::span(found.u));
    impl.pressures.read(x.block(1), std::span(found.p));
    for (double &pressure : found.p)
        pressure *= impl.scale;
    return ending;
}

} // namespace livermark::fem_reference
