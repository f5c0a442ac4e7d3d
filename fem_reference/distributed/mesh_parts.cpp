#include "fem_reference/distributed/distributed_systems.hpp"

#include <deal.II/base/mpi.h>
#include <deal.II/lac/dynamic_sparsity_pattern.h>
#include <deal.II/lac/sparsity_pattern.h>
#include <deal.II/lac/sparsity_tools.h>

#include <algorithm>
#include <fmt/format.h>
#include <map>
#include <numeric>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include "core/mesh/refinement.hpp"
#include "core/mesh/tetra_mesh.hpp"
#include "core/support/processes/mpi_session.hpp"

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

/// Owner of an edge, one of its two ends by turns, so that no rank has all edges between two.
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
    core::Body out{
        .name = body.name, .mesh = {}, .materials = body.materials, .capsule = body.capsule, .vessels = body.vessels};
    out.mesh.region_names = mesh.region_names;
    out.mesh.patch_names = mesh.patch_names;
    auto &conditions = part.problem.load_case;
    conditions.name = load_case.name;
    conditions.regime = load_case.regime;
    conditions.acceleration = load_case.acceleration;
    conditions.conditions = load_case.conditions;
    conditions.path = load_case.path;
    conditions.press_depth = load_case.press_depth;
    core::SmoothSurface surface;
    const auto whole_surface = body.capsule ? core::capsule_surface(body) : nullptr;
    for (std::size_t node = 0; node < mesh.points.size(); ++node) {
        if (place[node] < 0)
            continue;
        if (whole_surface) {
            surface.normal.push_back(whole_surface->normal[node]);
            surface.offset.push_back(whole_surface->offset[node]);
        }
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
        if (!body.modulus_factor.empty())
            out.modulus_factor.push_back(body.modulus_factor[t]);
    }
    // A face may have all its corners here and its tetrahedron elsewhere.
    std::vector<std::array<int, 3>> outer = core::outer_faces(out.mesh.tetrahedra);
    std::ranges::transform(outer, outer.begin(), [](const auto &face) { return core::face_key(face); });
    std::ranges::sort(outer);
    std::vector<int> kept_facets;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f) {
        auto corners = mesh.boundary_triangles[f];
        for (int &node : corners)
            node = place[node];
        if (!std::ranges::binary_search(outer, core::face_key(corners)))
            continue;
        out.mesh.boundary_triangles.push_back(corners);
        out.mesh.boundary_patch.push_back(mesh.boundary_patch[f]);
        part.facet.push_back(whole.facet[f]);
        kept_facets.push_back(f);
        conditions.condition_on.push_back(load_case.condition_on[f]);
        conditions.value.push_back(load_case.value[f]);
    }
    conditions.foundation = load_case.foundation;
    if (conditions.foundation)
        conditions.foundation->move_to_parts(kept_facets);
    if (out.capsule)
        out.capsule->surface = std::make_shared<const core::SmoothSurface>(std::move(surface));
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

} // namespace livermark::fem_reference
