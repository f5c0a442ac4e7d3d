#include "meshes/segmentation/meshing/mesh_operations.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "core/mesh/tetra_mesh.hpp"
#include "meshes/io/mesh_checks.hpp"

namespace livermark::segmentation {

namespace {

void insert_label(std::vector<int> &labels, int label) {
    const auto place = std::ranges::lower_bound(labels, label);
    if (place == labels.end() || *place != label)
        labels.insert(place, label);
}

} // namespace

MeshLinks mesh_links(const core::TetraMesh &mesh) {
    MeshLinks links{core::tetrahedra_at_nodes(mesh), core::face_neighbours(mesh.tetrahedra), {}};
    links.labels_of.resize(mesh.points.size());
    for (int t = 0; t < mesh.num_tetrahedra(); ++t)
        for (int corner = 0; corner < 4; ++corner) {
            insert_label(links.labels_of[mesh.tetrahedra[t][corner]], mesh.region[t]);
            if (links.neighbour[t][corner] < 0)
                for (const int local : core::tetrahedron_faces[corner])
                    insert_label(links.labels_of[mesh.tetrahedra[t][local]], outside);
        }
    return links;
}

int region_across(const core::TetraMesh &mesh, const MeshLinks &links, int tetrahedron, int corner) {
    const int other = links.neighbour[tetrahedron][corner];
    return other < 0 ? outside : mesh.region[other];
}

int corner_of(const std::array<int, 4> &nodes, int node) {
    const auto place = std::ranges::find(nodes, node);
    return place == nodes.end() ? -1 : static_cast<int>(place - nodes.begin());
}

namespace {

/// The tetrahedra at both nodes, ascending.
std::vector<int> tetrahedra_at_edge(const core::TetraMesh &mesh, const MeshLinks &links, int a, int b) {
    std::vector<int> shared;
    for (const int t : links.tetrahedra_of[a])
        if (corner_of(mesh.tetrahedra[t], b) >= 0)
            shared.push_back(t);
    return shared;
}

/// Regions that meet at an edge, `outside` first if it is there.
std::vector<int> labels_at_edge(const core::TetraMesh &mesh, const MeshLinks &links, int a, int b) {
    std::vector<int> labels;
    for (const int t : tetrahedra_at_edge(mesh, links, a, b)) {
        insert_label(labels, mesh.region[t]);
        for (int corner = 0; corner < 4; ++corner)
            if (const int node = mesh.tetrahedra[t][corner]; node != a && node != b && links.neighbour[t][corner] < 0)
                insert_label(labels, outside);
    }
    return labels;
}

} // namespace

double quality_of(const core::TetraMesh &mesh, const std::array<int, 4> &nodes) {
    return meshes::tetrahedron_quality(mesh.points[nodes[0]], mesh.points[nodes[1]], mesh.points[nodes[2]],
                                       mesh.points[nodes[3]]);
}

double mean_edge_length(const core::TetraMesh &mesh) {
    const auto edges = core::edge_table(mesh.tetrahedra).edges;
    double sum = 0.0;
    for (const auto &[a, b] : edges)
        sum += (mesh.points[b] - mesh.points[a]).norm();
    return sum / static_cast<double>(edges.size());
}

void drop_unused(core::TetraMesh &mesh) {
    std::vector<int> number(mesh.points.size(), -1);
    core::TetraMesh kept;
    for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
        if (mesh.region[t] == outside)
            continue;
        for (auto &node : mesh.tetrahedra[t]) {
            if (number[node] < 0) {
                number[node] = kept.num_nodes();
                kept.points.push_back(mesh.points[node]);
            }
            node = number[node];
        }
        kept.tetrahedra.push_back(mesh.tetrahedra[t]);
        kept.region.push_back(mesh.region[t]);
    }
    mesh = std::move(kept);
}

namespace {

using Nodes = std::array<int, 4>;

/// A pass over the mesh, whose links hold wherever nothing was touched before.
struct Pass {
    core::TetraMesh &mesh;
    MeshLinks links;
    std::vector<bool> touched;  ///< nodes
    std::vector<double> volume; ///< of the regions [m^3]
    int num_changes = 0;

    explicit Pass(core::TetraMesh &changed)
        : mesh(changed), links(mesh_links(changed)), touched(changed.points.size(), false),
          volume(volumes_of_regions(changed, 1 + *std::ranges::max_element(changed.region))) {}
};

/// Part that one change may take from a region or add to it, of its volume: a lesion of a few tetrahedra has none to
/// lose.
constexpr double largest_share = 0.1;

double volume_of(const core::TetraMesh &mesh, const Nodes &nodes) {
    return core::signed_volume(mesh.points[nodes[0]], mesh.points[nodes[1]], mesh.points[nodes[2]],
                               mesh.points[nodes[3]]);
}

bool untouched(const Pass &pass, const std::vector<int> &tetrahedra) {
    return std::ranges::all_of(tetrahedra, [&](int t) {
        return std::ranges::none_of(pass.mesh.tetrahedra[t], [&](int node) { return pass.touched[node]; });
    });
}

double worst_of(const core::TetraMesh &mesh, const std::vector<int> &tetrahedra) {
    double worst = std::numeric_limits<double>::infinity();
    for (const int t : tetrahedra)
        worst = std::min(worst, quality_of(mesh, mesh.tetrahedra[t]));
    return worst;
}

/// New tetrahedra of the region of the old ones in their place.
void replace(Pass &pass, const std::vector<int> &old, const std::vector<Nodes> &made) {
    const int region = pass.mesh.region[old.front()];
    for (const int t : old) {
        for (const int node : pass.mesh.tetrahedra[t])
            pass.touched[node] = true;
        pass.mesh.region[t] = outside;
    }
    for (const auto &nodes : made) {
        pass.mesh.tetrahedra.push_back(nodes);
        pass.mesh.region.push_back(region);
    }
    ++pass.num_changes;
}

bool on_border(const MeshLinks &links, int node) {
    return links.labels_of[node].size() > 1;
}

std::vector<int> nodes_around(const Pass &pass, int node) {
    std::vector<int> around;
    for (const int t : pass.links.tetrahedra_of[node])
        for (const int other : pass.mesh.tetrahedra[t])
            if (other != node)
                around.push_back(other);
    std::ranges::sort(around);
    around.erase(std::unique(around.begin(), around.end()), around.end());
    return around;
}

/// Whether node a may go where b is as far as borders are concerned: it leaves none, and the edge lies where a does.
/// Or it is inside the body and nearer than can be: a layer between two borders is given up there.
bool keeps_borders(const Pass &pass, int a, int b, bool tight) {
    const auto &labels = pass.links.labels_of;
    if (tight && labels[a].front() != outside)
        return true;
    return std::ranges::includes(labels[b], labels[a]) &&
           (labels[a].size() == 1 || labels_at_edge(pass.mesh, pass.links, a, b) == labels[a]);
}

/// The link condition (Dey, Edelsbrunner, Guha and Nekhayev 1999, for a mesh whose borders have to survive as well):
/// what both nodes see is seen by their edge.
bool keeps_topology(const Pass &pass, int a, int b, bool tight) {
    const auto at_edge = tetrahedra_at_edge(pass.mesh, pass.links, a, b);
    const auto near_a = nodes_around(pass, a);
    const auto near_b = nodes_around(pass, b);
    std::vector<int> common;
    std::ranges::set_intersection(near_a, near_b, std::back_inserter(common));
    return std::ranges::all_of(common, [&](int node) {
        const auto has_node = [&](int t) { return corner_of(pass.mesh.tetrahedra[t], node) >= 0; };
        const auto here = std::ranges::find_if(at_edge, has_node);
        if (here == at_edge.end())
            return false;
        // Border edges from both nodes have to close a border triangle with their edge.
        if (tight || !on_border(pass.links, a) || !on_border(pass.links, node) ||
            labels_at_edge(pass.mesh, pass.links, a, node).size() < 2 ||
            labels_at_edge(pass.mesh, pass.links, b, node).size() < 2)
            return true;
        return std::ranges::any_of(at_edge, [&](int t) {
            if (!has_node(t))
                return false;
            const auto &nodes = pass.mesh.tetrahedra[t];
            const int apex = nodes[0] + nodes[1] + nodes[2] + nodes[3] - a - b - node;
            return region_across(pass.mesh, pass.links, t, corner_of(nodes, apex)) != pass.mesh.region[t];
        });
    });
}

bool collapse(Pass &pass, int a, int b, double longest, bool tight) {
    // The result of a collapse may be improved, but not from nothing.
    constexpr double fair = 0.1;
    const auto &star = pass.links.tetrahedra_of[a];
    if (!untouched(pass, star) || !keeps_borders(pass, a, b, tight) || !keeps_topology(pass, a, b, tight))
        return false;
    std::map<int, double> gain; // of volume, by region
    for (const int t : star) {
        auto nodes = pass.mesh.tetrahedra[t];
        gain[pass.mesh.region[t]] -= volume_of(pass.mesh, nodes);
        if (corner_of(nodes, b) >= 0)
            continue;
        std::ranges::replace(nodes, a, b);
        gain[pass.mesh.region[t]] += volume_of(pass.mesh, nodes);
        if (quality_of(pass.mesh, nodes) < fair)
            return false;
        for (const int node : nodes)
            if ((pass.mesh.points[node] - pass.mesh.points[b]).norm() > longest)
                return false;
    }
    for (const auto &[region, volume] : gain)
        if (std::abs(volume) > largest_share * pass.volume[region])
            return false;
    for (const int t : star) {
        auto &nodes = pass.mesh.tetrahedra[t];
        for (const int node : nodes)
            pass.touched[node] = true;
        if (corner_of(nodes, b) >= 0)
            pass.mesh.region[t] = outside;
        std::ranges::replace(nodes, a, b);
    }
    ++pass.num_changes;
    return true;
}

/// The nodes around an edge inside a region, in order, so that (a, b, ring[i], ring[i + 1]) has a positive volume.
std::vector<int> ring_around(const Pass &pass, int a, int b, const std::vector<int> &at_edge) {
    std::vector<std::array<int, 2>> sides;
    for (const int t : at_edge) {
        const auto &nodes = pass.mesh.tetrahedra[t];
        std::array<int, 2> side{};
        std::size_t found = 0;
        for (const int node : nodes)
            if (node != a && node != b)
                side[found++] = node;
        if (quality_of(pass.mesh, {a, b, side[0], side[1]}) < 0.0)
            std::swap(side[0], side[1]);
        sides.push_back(side);
    }
    std::vector<int> ring{sides.front()[0]};
    while (ring.size() < sides.size()) {
        const auto next = std::ranges::find(sides, ring.back(), [](const auto &side) { return side[0]; });
        if (next == sides.end())
            return {};
        ring.push_back((*next)[1]);
    }
    const auto last = std::ranges::find(sides, ring.back(), [](const auto &side) { return side[0]; });
    return last != sides.end() && (*last)[1] == ring.front() ? ring : std::vector<int>();
}

/// The triangulation of the ring from i to j (a polygon closed by the chord from j to i) whose worst tetrahedron with a
/// and b is best.
struct RingCut {
    double worst = std::numeric_limits<double>::infinity();
    std::vector<Nodes> tetrahedra;
};

RingCut best_cut(const core::TetraMesh &mesh, const std::vector<int> &ring, std::size_t i, std::size_t j, int a,
                 int b) {
    RingCut best;
    if (j < i + 2)
        return best;
    best.worst = -std::numeric_limits<double>::infinity();
    for (std::size_t k = i + 1; k < j; ++k) {
        const Nodes upper{ring[i], ring[k], ring[j], b};
        const Nodes lower{ring[i], ring[j], ring[k], a};
        const double here = std::min(quality_of(mesh, upper), quality_of(mesh, lower));
        if (here <= best.worst)
            continue;
        RingCut first = best_cut(mesh, ring, i, k, a, b);
        RingCut second = best_cut(mesh, ring, k, j, a, b);
        const double worst = std::min({here, first.worst, second.worst});
        if (worst <= best.worst)
            continue;
        best = {worst, std::move(first.tetrahedra)};
        best.tetrahedra.insert(best.tetrahedra.end(), second.tetrahedra.begin(), second.tetrahedra.end());
        best.tetrahedra.push_back(upper);
        best.tetrahedra.push_back(lower);
    }
    return best;
}

} // namespace

int collapse_edges(core::TetraMesh &mesh, double shortest, double tight, double longest) {
    Pass pass(mesh);
    std::vector<std::pair<double, std::array<int, 2>>> edges;
    for (const auto &edge : core::edge_table(mesh.tetrahedra).edges)
        if (const double length = (mesh.points[edge[1]] - mesh.points[edge[0]]).norm(); length < shortest)
            edges.emplace_back(length, edge);
    std::ranges::sort(edges);
    for (const auto &[length, edge] : edges)
        if (!collapse(pass, edge[0], edge[1], longest, length < tight))
            collapse(pass, edge[1], edge[0], longest, length < tight);
    drop_unused(mesh);
    return pass.num_changes;
}

int remove_edges(core::TetraMesh &mesh, double quality) {
    constexpr std::size_t longest_ring = 7;
    Pass pass(mesh);
    for (const auto &[a, b] : core::edge_table(mesh.tetrahedra).edges) {
        const auto at_edge = tetrahedra_at_edge(mesh, pass.links, a, b);
        const double worst = worst_of(mesh, at_edge);
        if (worst >= quality || at_edge.size() > longest_ring || !untouched(pass, at_edge) ||
            labels_at_edge(mesh, pass.links, a, b).size() > 1)
            continue;
        const auto ring = ring_around(pass, a, b, at_edge);
        if (ring.empty())
            continue;
        const RingCut cut = best_cut(mesh, ring, 0, ring.size() - 1, a, b);
        if (cut.worst > worst)
            replace(pass, at_edge, cut.tetrahedra);
    }
    drop_unused(mesh);
    return pass.num_changes;
}

int swap_faces(core::TetraMesh &mesh, double quality) {
    Pass pass(mesh);
    const int num_before = mesh.num_tetrahedra();
    for (int t = 0; t < num_before; ++t)
        for (int corner = 0; corner < 4; ++corner) {
            const int other = pass.links.neighbour[t][corner];
            if (other < t || mesh.region[t] == outside || mesh.region[other] != mesh.region[t] ||
                !untouched(pass, {t, other}))
                continue;
            const double worst = worst_of(mesh, {t, other});
            if (worst >= quality)
                continue;
            const auto nodes = mesh.tetrahedra[t];
            const auto &[i, j, k] = core::tetrahedron_faces[corner];
            int far = -1;
            for (const int node : mesh.tetrahedra[other])
                if (corner_of(nodes, node) < 0)
                    far = node;
            std::vector<Nodes> made;
            for (const auto &[p, q] : {std::array{i, j}, std::array{j, k}, std::array{k, i}})
                made.push_back({nodes[p], nodes[q], nodes[corner], far});
            if (std::ranges::all_of(made, [&](const auto &m) { return quality_of(mesh, m) > worst; }))
                replace(pass, {t, other}, made);
        }
    drop_unused(mesh);
    return pass.num_changes;
}

int peel_flat(core::TetraMesh &mesh, double quality) {
    Pass pass(mesh);
    for (int t = 0; t < mesh.num_tetrahedra(); ++t) {
        const auto nodes = mesh.tetrahedra[t];
        if (quality_of(mesh, nodes) >= quality || !untouched(pass, {t}) ||
            volume_of(mesh, nodes) > largest_share * pass.volume[mesh.region[t]])
            continue;
        std::vector<int> open; // corners opposite a face on the border
        std::vector<int> shut;
        for (int corner = 0; corner < 4; ++corner)
            (region_across(mesh, pass.links, t, corner) == mesh.region[t] ? shut : open).push_back(corner);
        if (open.size() != 2 ||
            region_across(mesh, pass.links, t, open[0]) != region_across(mesh, pass.links, t, open[1]))
            continue;
        // The edge that comes to light must not be on the border already: the regions would touch themselves there.
        if (labels_at_edge(mesh, pass.links, nodes[open[0]], nodes[open[1]]).size() > 1)
            continue;
        mesh.region[t] = region_across(mesh, pass.links, t, open[0]);
        for (const int node : nodes)
            pass.touched[node] = true;
        ++pass.num_changes;
    }
    drop_unused(mesh);
    return pass.num_changes;
}

} // namespace livermark::segmentation
