#include "fem_reference/deal_ii_mesh.hpp"

#include <algorithm>
#include <vector>

namespace livermark::fem_reference {

void fill(dealii::Triangulation<3> &triangulation, const core::TetraMesh &mesh) {
    std::vector<dealii::Point<3>> vertices;
    vertices.reserve(mesh.points.size());
    for (const auto &point : mesh.points)
        vertices.emplace_back(point.x(), point.y(), point.z());
    std::vector<dealii::CellData<3>> cells(mesh.tetrahedra.size(), dealii::CellData<3>(4));
    for (std::size_t t = 0; t < cells.size(); ++t)
        std::ranges::copy(mesh.tetrahedra[t], cells[t].vertices.begin());
    triangulation.create_triangulation(vertices, cells, {});
}

} // namespace livermark::fem_reference
