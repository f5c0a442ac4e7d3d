#include "meshes/io/mesh_figures.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <numbers>

#include "core/mesh/bounding_box.hpp"

namespace livermark::meshes {

double tetrahedron_quality(const core::Vector3 &a, const core::Vector3 &b, const core::Vector3 &c,
                           const core::Vector3 &d) {
    const double mean_square = ((b - a).squaredNorm() + (c - a).squaredNorm() + (d - a).squaredNorm() +
                                (c - b).squaredNorm() + (d - b).squaredNorm() + (d - c).squaredNorm()) /
                               6.0;
    return 6.0 * std::numbers::sqrt2 * core::signed_volume(a, b, c, d) / (mean_square * std::sqrt(mean_square));
}

MeshFigures mesh_figures(const core::TetraMesh &mesh) {
    MeshFigures figures;
    figures.num_tetrahedra = mesh.num_tetrahedra();
    figures.num_nodes = mesh.num_nodes();
    figures.smallest_quality = std::numeric_limits<double>::infinity();
    for (const auto &[a, b, c, d] : mesh.tetrahedra) {
        const auto &x = mesh.points;
        figures.volume += core::signed_volume(x[a], x[b], x[c], x[d]);
        figures.smallest_quality = std::min(figures.smallest_quality, tetrahedron_quality(x[a], x[b], x[c], x[d]));
    }
    figures.extent = core::bounding_box(mesh.points).sizes();

    const auto edges = core::edge_table(mesh.tetrahedra).edges;
    figures.num_edges = static_cast<int>(edges.size());
    figures.shortest_edge = std::numeric_limits<double>::infinity();
    for (const auto &[i, j] : edges) {
        const double length = (mesh.points[j] - mesh.points[i]).norm();
        figures.mean_edge += length / static_cast<double>(edges.size());
        figures.shortest_edge = std::min(figures.shortest_edge, length);
    }
    return figures;
}

std::string to_text(const MeshFigures &figures) {
    return fmt::format("tetrahedra        {}\n"
                       "nodes             {}\n"
                       "edges             {}\n"
                       "volume            {:.1f} mL\n"
                       "extent            {:.1f} x {:.1f} x {:.1f} mm\n"
                       "mean edge         {:.2f} mm\n"
                       "shortest edge     {:.2f} mm ({:.3f} of the mean)\n"
                       "smallest quality  {:.3f}\n",
                       figures.num_tetrahedra, figures.num_nodes, figures.num_edges, 1e6 * figures.volume,
                       1e3 * figures.extent.x(), 1e3 * figures.extent.y(), 1e3 * figures.extent.z(),
                       1e3 * figures.mean_edge, 1e3 * figures.shortest_edge, figures.shortest_edge / figures.mean_edge,
                       figures.smallest_quality);
}

} // namespace livermark::meshes
