#include "results/vtkhdf.hpp"

#include "results/schema.hpp"

namespace livermark::results {

namespace {

constexpr std::uint8_t vtk_tetra = 10;
constexpr int nodes_per_tetrahedron = 4;

} // namespace

void write_vtkhdf(hdf5::OutputFile &file, const Result &result) {
    const core::TetraMesh &mesh = result.problem.body->mesh;
    std::vector<std::int64_t> connectivity;
    std::vector<std::int64_t> offsets{0};
    connectivity.reserve(nodes_per_tetrahedron * mesh.tetrahedra.size());
    offsets.reserve(mesh.tetrahedra.size() + 1);
    for (const auto &nodes : mesh.tetrahedra) {
        connectivity.insert(connectivity.end(), nodes.begin(), nodes.end());
        offsets.push_back(static_cast<std::int64_t>(connectivity.size()));
    }

    file.group("/VTKHDF");
    file.ascii("/VTKHDF", "Type", "UnstructuredGrid");
    file.integers("/VTKHDF", "Version", {1, 0});
    file.dataset("/VTKHDF/NumberOfPoints", std::vector<std::int64_t>{mesh.num_nodes()}, "");
    file.dataset("/VTKHDF/NumberOfCells", std::vector<std::int64_t>{mesh.num_tetrahedra()}, "");
    file.dataset("/VTKHDF/NumberOfConnectivityIds", std::vector{static_cast<std::int64_t>(connectivity.size())}, "");
    file.hard_link("/mesh/points", "/VTKHDF/Points");
    file.dataset("/VTKHDF/Connectivity", connectivity, "");
    file.dataset("/VTKHDF/Offsets", offsets, "");
    file.dataset("/VTKHDF/Types", std::vector<std::uint8_t>(mesh.tetrahedra.size(), vtk_tetra), "");

    file.group("/VTKHDF/PointData");
    for (const ModelResult &model : result.models) {
        file.hard_link(solution_group(model.name) + "/displacement", "/VTKHDF/PointData/displacement_" + model.name);
        if (model.comparison)
            file.hard_link(comparison_group(model.name) + "/error", "/VTKHDF/PointData/error_" + model.name);
    }
    file.group("/VTKHDF/CellData");
    file.hard_link("/mesh/region", "/VTKHDF/CellData/region");
}

} // namespace livermark::results
