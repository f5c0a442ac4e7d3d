#include <fmt/ostream.h>
#include <ostream>

#include "studies/exchange/formats/export_format.hpp"

namespace livermark::exchange {

namespace {

void write_node(std::ostream &out, const core::Problem &problem, const ExportChoices &) {
    const auto &points = problem.body->mesh.points;
    fmt::print(out, "{} 3 0 0\n", points.size());
    for (std::size_t i = 0; i < points.size(); ++i)
        fmt::print(out, "{} {} {} {}\n", i + 1, points[i].x(), points[i].y(), points[i].z());
}

/// Tetrahedra with their region, from 1, as the attribute.
void write_ele(std::ostream &out, const core::Problem &problem, const ExportChoices &) {
    const auto &mesh = problem.body->mesh;
    fmt::print(out, "{} 4 1\n", mesh.num_tetrahedra());
    for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
        const auto &[a, b, c, d] = mesh.tetrahedra[t];
        fmt::print(out, "{} {} {} {} {} {}\n", t + 1, a + 1, b + 1, c + 1, d + 1, mesh.region[t] + 1);
    }
}

/// Triangles of the boundary with their patch, from 1, as the marker.
void write_face(std::ostream &out, const core::Problem &problem, const ExportChoices &) {
    const auto &mesh = problem.body->mesh;
    fmt::print(out, "{} 1\n", mesh.num_boundary_triangles());
    for (std::size_t f = 0; f < mesh.boundary_triangles.size(); ++f) {
        const auto &[a, b, c] = mesh.boundary_triangles[f];
        fmt::print(out, "{} {} {} {} {}\n", f + 1, a + 1, b + 1, c + 1, mesh.boundary_patch[f] + 1);
    }
}

} // namespace

namespace formats {

ExportFormat tetgen() {
    return {.name = {},
            .summary = "the mesh alone with regions and patches, as TetGen writes it",
            .files = {{".node", write_node}, {".ele", write_ele}, {".face", write_face}},
            .only_when_named = true};
}

} // namespace formats

} // namespace livermark::exchange
