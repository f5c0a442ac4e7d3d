#include "interactive/cut_motion.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <stdexcept>
#include <utility>

namespace livermark::interactive {

namespace {

void check_parents(const core::TetraMesh &before, const SceneCut &cut) {
    std::vector<bool> is_seen(before.tetrahedra.size(), false);
    if (cut.parent_tetrahedron.size() != cut.body->mesh.tetrahedra.size())
        throw std::invalid_argument(fmt::format("{} parents of {} tetrahedra; give each one",
                                                cut.parent_tetrahedron.size(), cut.body->mesh.tetrahedra.size()));
    for (const int parent : cut.parent_tetrahedron) {
        if (parent < 0 || parent >= before.num_tetrahedra() || is_seen[parent])
            throw std::invalid_argument(fmt::format("parent {} is none of the {} tetrahedra before the cut, or there "
                                                    "twice",
                                                    parent, before.num_tetrahedra()));
        is_seen[parent] = true;
    }
}

/// Children of constrained nodes, in the order of these.
/// @return nodes, and for each the place of its parent among the constrained nodes before
std::pair<std::vector<int>, std::vector<int>> constrained_as_cut(const Scene &before,
                                                                 const std::vector<int> &parent_node) {
    std::vector<int> place(static_cast<std::size_t>(num_nodes(before)), -1);
    for (std::size_t c = 0; c < before.constrained_nodes.size(); ++c)
        place[before.constrained_nodes[c]] = static_cast<int>(c);
    std::vector<int> nodes, places;
    for (std::size_t i = 0; i < parent_node.size(); ++i)
        if (place[parent_node[i]] >= 0)
            nodes.push_back(static_cast<int>(i));
    std::ranges::stable_sort(nodes, {}, [&](int node) { return place[parent_node[node]]; });
    for (const int node : nodes)
        places.push_back(place[parent_node[node]]);
    return {std::move(nodes), std::move(places)};
}

/// With those of nodes in the middle of edges, which come behind the others in the order of the edges.
std::vector<int> with_own_nodes(std::vector<int> parent_node, const core::TetraMesh &before,
                                const core::TetraMesh &after, const std::vector<int> &parent_tetrahedron) {
    const auto edges = core::edge_table(before.tetrahedra), cut_edges = core::edge_table(after.tetrahedra);
    const std::size_t num_corners = parent_node.size();
    parent_node.resize(num_corners + cut_edges.edges.size());
    for (std::size_t t = 0; t < parent_tetrahedron.size(); ++t)
        for (std::size_t e = 0; e < 6; ++e)
            parent_node[num_corners + cut_edges.tetrahedron_edge[t][e]] =
                before.num_nodes() + edges.tetrahedron_edge[parent_tetrahedron[t]][e];
    return parent_node;
}

Field of_parents(const Field &field, const std::vector<int> &parents) {
    Field result(3, static_cast<Eigen::Index>(parents.size()));
    for (std::size_t i = 0; i < parents.size(); ++i)
        result.col(static_cast<Eigen::Index>(i)) = field.col(parents[i]);
    return result;
}

} // namespace

std::unique_ptr<Simulation> continue_after_cut(const Method &method, const Simulation &before, const SceneCut &cut) {
    const auto &mesh = before.scene().body->mesh;
    check_parents(mesh, cut);
    auto parents = parents_of(mesh, cut.body->mesh, cut.parent_tetrahedron);
    auto [constrained, places] = constrained_as_cut(before.scene(), parents.node);
    auto after = method.prepare(
        {.body = cut.body,
         .node_mass = cut.node_mass,
         .constrained_nodes = std::move(constrained),
         .mass_damping = before.scene().mass_damping,
         .orders = std::make_shared<const Orders>(as_cut(before.orders(), mesh, cut.body->mesh, parents))});
    if (!before.scene().own_nodes.empty())
        parents.node = with_own_nodes(std::move(parents.node), mesh, cut.body->mesh, parents.tetrahedron);
    std::vector<double> mass_of_copies(before.scene().node_mass.size(), 0.0);
    for (std::size_t i = 0; i < parents.node.size(); ++i)
        mass_of_copies[parents.node[i]] += after->scene().node_mass[i];
    Field forces = of_parents(before.external_forces(), parents.node);
    for (std::size_t i = 0; i < parents.node.size(); ++i)
        if (const double all = mass_of_copies[parents.node[i]], own = after->scene().node_mass[i]; own != all)
            forces.col(static_cast<Eigen::Index>(i)) *= own / all;
    after->set_external_forces(forces);
    after->set_targets(of_parents(before.targets(), places));
    after->set_state(of_parents(before.positions(), parents.node), of_parents(before.velocities(), parents.node));
    return after;
}

} // namespace livermark::interactive
