#include "fem_reference/deal_ii_mesh.hpp"

#include <deal.II/base/multithread_info.h>

#include <algorithm>
#include <vector>

namespace livermark::fem_reference {

void fill(dealii::Triangulation<3> &triangulation, const core::TetraMesh &mesh) {
    // What is left to deal.II is too short for threads, and they would take the core of the load case beside it.
    dealii::MultithreadInfo::set_thread_limit(1);
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
