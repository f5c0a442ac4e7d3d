#include <algorithm>
#include <cstddef>
#include <fmt/format.h>
#include <map>
#include <span>
#include <stdexcept>
#include <utility>

#include "interactive/method.hpp"

namespace livermark::interactive {

namespace {

constexpr int gone = -1;

/// Nodes and tetrahedra before, of a body that was cut along its facets.
struct Parents {
    std::vector<int> tetrahedron; ///< (M') that each was, no two the same; corners keep their order
    std::vector<int> node;        ///< (N') that each was, or was parted from
};

Parents parents_of(const core::TetraMesh &before, const SceneCut &cut) {
    const auto &after = cut.body->mesh;
    Parents parents{cut.parent_tetrahedron, std::vector<int>(after.points.size(), gone)};
    for (std::size_t t = 0; t < parents.tetrahedron.size(); ++t)
        for (std::size_t k = 0; k < 4; ++k)
            parents.node[after.tetrahedra[t][k]] = before.tetrahedra[parents.tetrahedron[t]][k];
    return parents;
}

/// Edges of what a cut has left, from those before.
struct CutEdges {
    core::EdgeTable table;   ///< that of core::edge_table()
    std::vector<int> parent; ///< (S') the edge before that each is, or was parted from
};

/// Nodes and tetrahedra that are left of each before.
class Children {
  public:
    Children(const core::TetraMesh &before, const Parents &parents)
        : child_(before.tetrahedra.size(), gone), start_(before.points.size() + 1, 0), nodes_(parents.node.size()) {
        for (std::size_t t = 0; t < parents.tetrahedron.size(); ++t)
            child_[parents.tetrahedron[t]] = static_cast<int>(t);
        for (const int parent : parents.node)
            ++start_[parent + 1];
        for (std::size_t i = 1; i < start_.size(); ++i)
            start_[i] += start_[i - 1];
        auto next = start_;
        for (std::size_t i = 0; i < parents.node.size(); ++i)
            nodes_[next[parents.node[i]]++] = static_cast<int>(i);
    }

    int child_of(int number) const { return child_[number]; }
    std::span<const int> copies_of(int node) const {
        return std::span(nodes_).subspan(start_[node], start_[node + 1] - start_[node]);
    }
    /// The only one; gone if there is none, or more than one.
    int only_of(int node) const {
        const auto all = copies_of(node);
        return all.size() == 1 ? all.front() : gone;
    }

  private:
    std::vector<int> child_, start_, nodes_;
};

std::vector<int> nodes_as_cut(const std::vector<int> &order, const Children &children) {
    std::vector<int> result;
    for (const int node : order)
        for (const int child : children.copies_of(node))
            result.push_back(child);
    return result;
}

/// Fans of which nothing was cut stay side by side; what is cut off from others stands behind all.
class CutFans {
  public:
    CutFans(const core::TetraMesh &before, const core::TetraMesh &after, const Children &children)
        : before_(&before), after_(&after), children_(&children) {}

    kernels::FanList cut(const kernels::FanList &fans) {
        constexpr std::size_t some_more = 256;
        kept_.reserve(fans.size() + some_more, fans.num_tetrahedra());
        for (std::size_t f = 0; f < fans.size(); ++f)
            cut_fan(fans.axis(f), fans.rim(f), fans.tetrahedra(f));
        for (std::size_t f = 0; f < cut_off_.size(); ++f)
            kept_.add(cut_off_.axis(f), cut_off_.rim(f), cut_off_.tetrahedra(f));
        return std::move(kept_);
    }

  private:
    void cut_fan(const std::array<int, 2> &axis, std::span<const int> rim, std::span<const int> tetrahedra) {
        bool is_first = true;
        const auto close = [&] {
            if (!part_.empty())
                (std::exchange(is_first, false) ? kept_ : cut_off_).add(axis_, rim_, part_);
            part_.clear();
            rim_.clear();
        };
        for (std::size_t k = 0; k < tetrahedra.size(); ++k) {
            const int t = children_->child_of(tetrahedra[k]);
            if (t == gone) {
                close();
                continue;
            }
            const auto &was = before_->tetrahedra[tetrahedra[k]], &is = after_->tetrahedra[t];
            const auto here = [&](int node) { return is[std::ranges::find(was, node) - was.begin()]; };
            const std::array axis_here{here(axis[0]), here(axis[1])};
            const int from = here(rim[k]);
            if (!part_.empty() && (axis_ != axis_here || rim_.back() != from))
                close();
            if (part_.empty()) {
                axis_ = axis_here;
                rim_.push_back(from);
            }
            rim_.push_back(here(rim[k + 1]));
            part_.push_back(t);
        }
        close();
    }

    const core::TetraMesh *before_, *after_;
    const Children *children_;
    kernels::FanList kept_, cut_off_;
    std::array<int, 2> axis_{}; ///< of the part that is open
    std::vector<int> rim_, part_;
};

/// Edges that are left of each before. Those that a cut has not parted are taken over, and only copies are put in
/// order.
class ChildrenOfEdges {
  public:
    ChildrenOfEdges(const core::EdgeTable &edges, const core::TetraMesh &after, const Parents &parents)
        : edges_(&edges), after_(&after), parents_(&parents), first_(edges.edges.size(), nobody),
          is_parted_(edges.edges.size(), false) {
        for (std::size_t t = 0; t < after.tetrahedra.size(); ++t)
            for (std::size_t e = 0; e < 6; ++e) {
                const int parent = parent_of(t, e);
                const auto nodes = nodes_of(t, e);
                if (first_[parent] == nobody) {
                    first_[parent] = nodes;
                } else if (first_[parent] != nodes) {
                    is_parted_[parent] = true;
                    copies_.push_back({nodes, parent});
                }
            }
    }

    CutEdges table() const {
        CutEdges cut;
        std::vector<int> number(first_.size(), gone); // of edges that are not parted
        for (const auto &[nodes, parent] : in_order()) {
            number[parent] = static_cast<int>(cut.parent.size());
            cut.table.edges.push_back(nodes);
            cut.parent.push_back(parent);
        }
        const auto &all = cut.table.edges;
        cut.table.tetrahedron_edge.resize(after_->tetrahedra.size());
        for (std::size_t t = 0; t < after_->tetrahedra.size(); ++t)
            for (std::size_t e = 0; e < 6; ++e) {
                const int parent = parent_of(t, e);
                cut.table.tetrahedron_edge[t][e] =
                    is_parted_[parent] ? static_cast<int>(std::ranges::lower_bound(all, nodes_of(t, e)) - all.begin())
                                       : number[parent];
            }
        return cut;
    }

  private:
    using Edge = std::array<int, 2>;
    static constexpr Edge nobody{gone, gone};
    struct Child {
        Edge nodes;
        int parent;
    };

    int parent_of(std::size_t t, std::size_t e) const { return edges_->tetrahedron_edge[parents_->tetrahedron[t]][e]; }
    Edge nodes_of(std::size_t t, std::size_t e) const {
        const auto &[a, b] = core::tetrahedron_edges[e];
        const auto [low, high] = std::minmax(after_->tetrahedra[t][a], after_->tetrahedra[t][b]);
        return {low, high};
    }

    /// Lexicographic. Between nodes that stand in the order of their parents edges do so too, and only others are
    /// sorted.
    std::vector<Child> in_order() const {
        std::vector<bool> is_in_order(parents_->node.size());
        int last = gone;
        for (std::size_t i = 0; i < is_in_order.size(); ++i) {
            is_in_order[i] = parents_->node[i] > last;
            last = std::max(last, parents_->node[i]);
        }
        std::vector<Child> all, others = copies_;
        all.reserve(first_.size() + copies_.size());
        for (std::size_t parent = 0; parent < first_.size(); ++parent)
            if (const auto &[a, b] = first_[parent]; a != gone)
                (is_in_order[a] && is_in_order[b] ? all : others).push_back({first_[parent], static_cast<int>(parent)});
        const auto by_nodes = [](const Child &a, const Child &b) { return a.nodes < b.nodes; };
        std::ranges::sort(others, by_nodes);
        const auto are_same = [](const Child &a, const Child &b) { return a.nodes == b.nodes; };
        others.erase(std::unique(others.begin(), others.end(), are_same), others.end());
        const auto middle = std::ssize(all);
        all.insert(all.end(), others.begin(), others.end());
        std::inplace_merge(all.begin(), all.begin() + middle, all.end(), by_nodes);
        return all;
    }

    const core::EdgeTable *edges_;
    const core::TetraMesh *after_;
    const Parents *parents_;
    std::vector<Edge> first_;     ///< child of each edge before; nobody where it is gone
    std::vector<bool> is_parted_; ///< has more than one
    std::vector<Child> copies_;   ///< beside the first, some of them more than once
};

/// Copies of an edge may share a node where the cut ends: all but one of them need another colour.
std::vector<int> edge_colours_as_cut(const std::vector<int> &colours, const CutEdges &cut, std::size_t num_nodes) {
    const auto &edges = cut.table.edges;
    std::vector<int> result(edges.size(), gone);
    std::vector<bool> has_child(colours.size(), false), has_copy(num_nodes, false);
    std::vector<int> copies;
    for (std::size_t e = 0; e < edges.size(); ++e) {
        if (!has_child[cut.parent[e]]) {
            has_child[cut.parent[e]] = true;
            result[e] = colours[cut.parent[e]];
            continue;
        }
        copies.push_back(static_cast<int>(e));
        for (const int node : edges[e])
            has_copy[node] = true;
    }
    std::map<int, std::vector<int>> at_node; // of copies alone
    for (std::size_t e = 0; e < edges.size() && !copies.empty(); ++e)
        for (const int node : edges[e])
            if (has_copy[node])
                at_node[node].push_back(static_cast<int>(e));
    std::vector<bool> is_taken;
    for (const int copy : copies) {
        is_taken.clear();
        for (const int node : edges[copy])
            for (const int other : at_node[node])
                if (const int colour = result[other]; colour >= 0) {
                    is_taken.resize(std::max(is_taken.size(), static_cast<std::size_t>(colour) + 1), false);
                    is_taken[colour] = true;
                }
        result[copy] = static_cast<int>(std::ranges::find(is_taken, false) - is_taken.begin());
    }
    return result;
}

std::vector<std::vector<kernels::StripNode>> strips_as_cut(const std::vector<std::vector<kernels::StripNode>> &strips,
                                                           const Parents &parents, const Children &children) {
    std::vector<std::vector<kernels::StripNode>> result(parents.node.size());
    for (std::size_t i = 0; i < result.size(); ++i) {
        if (children.only_of(parents.node[i]) == gone)
            continue;
        auto mapped = strips[parents.node[i]];
        const bool is_kept = std::ranges::all_of(mapped, [&](kernels::StripNode &entry) {
            entry.node = children.only_of(entry.node);
            if (entry.triangle >= 0)
                entry.triangle = children.child_of(entry.triangle);
            else
                return entry.node != gone;
            return entry.node != gone && entry.triangle != gone;
        });
        if (is_kept)
            result[i] = std::move(mapped);
    }
    return result;
}

/// The orders of what a cut has left, from those before: what is gone is left out; parted nodes stand side by side; a
/// fan that was cut through is two; colours stay, but of edges that were parted and still share a node. Strips are
/// kept where the cut has not changed the tetrahedra of a node nor parted a neighbour, and are empty elsewhere.
Orders as_cut(const Orders &orders, const core::TetraMesh &before, const core::TetraMesh &after,
              const Parents &parents) {
    const Children children(before, parents);
    Orders result;
    result.rows = nodes_as_cut(orders.rows, children);
    result.fans = CutFans(before, after, children).cut(orders.fans);
    if (!orders.tetrahedron_colour.empty())
        for (const int parent : parents.tetrahedron)
            result.tetrahedron_colour.push_back(orders.tetrahedron_colour[parent]);
    if (!orders.edge_colour.empty()) {
        auto cut = ChildrenOfEdges(orders.edges, after, parents).table();
        result.edge_colour = edge_colours_as_cut(orders.edge_colour, cut, after.points.size());
        result.edges = std::move(cut.table);
    }
    if (!orders.node_colour.empty())
        for (const int parent : parents.node)
            result.node_colour.push_back(orders.node_colour[parent]);
    if (!orders.strips.empty())
        result.strips = strips_as_cut(orders.strips, parents, children);
    result.factor = nodes_as_cut(orders.factor, children);
    return result;
}

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

Field parent_field(const Field &field, const std::vector<int> &parents) {
    Field result(3, static_cast<Eigen::Index>(parents.size()));
    for (std::size_t i = 0; i < parents.size(); ++i)
        result.col(static_cast<Eigen::Index>(i)) = field.col(parents[i]);
    return result;
}

} // namespace

std::unique_ptr<Simulation> continue_after_cut(const Method &method, const Simulation &before, const SceneCut &cut) {
    const auto &mesh = before.scene().body->mesh;
    check_parents(mesh, cut);
    auto parents = parents_of(mesh, cut);
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
    Field forces = parent_field(before.external_forces(), parents.node);
    for (std::size_t i = 0; i < parents.node.size(); ++i)
        if (const double all = mass_of_copies[parents.node[i]], own = after->scene().node_mass[i]; own != all)
            forces.col(static_cast<Eigen::Index>(i)) *= own / all;
    after->set_external_forces(forces);
    after->set_targets(parent_field(before.targets(), places));
    after->set_state(parent_field(before.positions(), parents.node), parent_field(before.velocities(), parents.node));
    return after;
}

} // namespace livermark::interactive
