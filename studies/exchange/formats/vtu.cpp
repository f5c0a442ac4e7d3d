#include <array>
#include <cmath>
#include <fmt/ostream.h>
#include <ostream>
#include <string>
#include <vector>

#include "studies/exchange/formats/export_format.hpp"

namespace livermark::exchange {

namespace {

using core::Vector3;

template <class Row>
void array(std::ostream &out, const std::string &type, const std::string &name, int components, std::size_t num_rows,
           Row row) {
    fmt::print(out, "<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"ascii\">\n", type, name,
               components);
    for (std::size_t i = 0; i < num_rows; ++i)
        fmt::print(out, "{}\n", row(i));
    fmt::print(out, "</DataArray>\n");
}

std::string text(const Vector3 &value) {
    return fmt::format("{} {} {}", value.x(), value.y(), value.z());
}

/// (N) 1 at the nodes of a patch.
std::vector<int> is_in_patch(const core::TetraMesh &mesh, const std::string &name) {
    std::vector<int> marks(mesh.points.size(), 0);
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (mesh.patch_names[mesh.boundary_patch[f]] == name)
            for (const int node : mesh.boundary_triangles[f])
                marks[node] = 1;
    return marks;
}

/// Depth of a place that presses, whose nodal forces are those of one newton.
std::string press_depth(const core::LoadCase &load_case) {
    return load_case.press_depth == 0.0
               ? ""
               : fmt::format("<FieldData>\n<DataArray type=\"Float64\" Name=\"press_depth\" NumberOfTuples=\"1\" "
                             "format=\"ascii\">{}</DataArray>\n</FieldData>\n",
                             load_case.press_depth);
}

/// Unstructured grid of VTK (.vtu, ASCII) of a problem: tetrahedra with region, young_modulus [Pa],
/// poisson_ratio and density [kg/m^3]; at the nodes is_prescribed (3 flags), prescribed_displacement [m] (zero where
/// free) and nodal_force [N], tractions and weight, consistent with linear tetrahedra.
void write_vtu(std::ostream &out, const core::Problem &problem, const ExportChoices &) {
    const auto &mesh = problem.body->mesh;
    const auto num_nodes = mesh.points.size(), num_cells = mesh.tetrahedra.size();
    const auto fem = discretise(mesh, 1);
    const auto prescribed = prescribed_displacement(problem.load_case, fem);
    const auto force = nodal_forces(problem, fem);
    fmt::print(out,
               "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"0.1\" "
               "byte_order=\"LittleEndian\">\n<UnstructuredGrid>\n"
               "{}<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n<Points>\n",
               press_depth(problem.load_case), num_nodes, num_cells);
    array(out, "Float64", "Points", 3, num_nodes, [&](std::size_t i) { return text(mesh.points[i]); });
    fmt::print(out, "</Points>\n<Cells>\n");
    array(out, "Int64", "connectivity", 1, num_cells,
          [&](std::size_t t) { return fmt::format("{}", fmt::join(mesh.tetrahedra[t], " ")); });
    array(out, "Int64", "offsets", 1, num_cells, [&](std::size_t t) { return 4 * (t + 1); });
    array(out, "UInt8", "types", 1, num_cells, [&](std::size_t) { return 10; });
    fmt::print(out, "</Cells>\n<PointData>\n");
    array(out, "Int32", "is_prescribed", 3, num_nodes, [&](std::size_t i) {
        return fmt::format("{} {} {}", int{!std::isnan(prescribed[i].x())}, int{!std::isnan(prescribed[i].y())},
                           int{!std::isnan(prescribed[i].z())});
    });
    array(out, "Float64", "prescribed_displacement", 3, num_nodes, [&](std::size_t i) {
        const Vector3 &value = prescribed[i];
        return text(value.array().isNaN().select(Vector3::Zero(), value));
    });
    array(out, "Float64", "nodal_force", 3, num_nodes, [&](std::size_t i) { return text(force[i]); });
    for (const auto &name : mesh.patch_names)
        if (name == "wound") {
            const auto marks = is_in_patch(mesh, name);
            array(out, "Int32", name, 1, num_nodes, [&](std::size_t i) { return marks[i]; });
        }
    fmt::print(out, "</PointData>\n<CellData>\n");
    array(out, "Int32", "region", 1, num_cells, [&](std::size_t t) { return mesh.region[t]; });
    const auto material = [&](const std::string &name, double core::Material::*property) {
        array(out, "Float64", name, 1, num_cells,
              [&](std::size_t t) { return problem.body->material_of(t).*property; });
    };
    material("young_modulus", &core::Material::young_modulus);
    material("poisson_ratio", &core::Material::poisson_ratio);
    material("density", &core::Material::density);
    fmt::print(out, "</CellData>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n");
}

} // namespace

namespace formats {

ExportFormat vtu() {
    return {.name = {}, .summary = "a grid of VTK, for ParaView and most libraries", .files = {{".vtu", write_vtu}}};
}

} // namespace formats

} // namespace livermark::exchange
