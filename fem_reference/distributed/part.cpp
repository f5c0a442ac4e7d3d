#include "fem_reference/distributed/part.hpp"

#include <deal.II/lac/dynamic_sparsity_pattern.h>
#include <deal.II/lac/sparsity_pattern.h>
#include <deal.II/lac/sparsity_tools.h>

#include <algorithm>
#include <fmt/format.h>
#include <limits>
#include <map>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "core/mesh/neighbours.hpp"
#include "core/mesh/refinement.hpp"
#include "fem_reference/distributed/node_exchange.hpp"
#include "fem_reference/solvers/multigrid/prolongation.hpp"
#include "support/processes/mpi_session.hpp"

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
    for (std::size_t t = 0; t < pressure.of_cell.size(); ++t)
        for (int k = 0; k < 4; ++k)
            if (const int number = pressure.of_cell[t][k]; number >= 0) {
                const int vertex = mesh.tetrahedra[t][k];
                entries[number] = {.key = {part.vertex_number[vertex], mesh.region[t]},
                                   .owner = part.vertex_owner[vertex]};
            }
    return entries;
}

} // namespace livermark::fem_reference
