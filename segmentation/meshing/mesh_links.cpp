#include "segmentation/meshing/mesh_links.hpp"

#include <algorithm>

#include "core/mesh/neighbours.hpp"
#include "meshes/io/mesh_figures.hpp"
#include "segmentation/meshing/label_domain.hpp"

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

std::vector<int> tetrahedra_at_edge(const core::TetraMesh &mesh, const MeshLinks &links, int a, int b) {
    std::vector<int> shared;
    for (const int t : links.tetrahedra_of[a])
        if (corner_of(mesh.tetrahedra[t], b) >= 0)
            shared.push_back(t);
    return shared;
}

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

} // namespace livermark::segmentation
