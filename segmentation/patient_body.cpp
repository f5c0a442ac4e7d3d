#include "segmentation/patient_body.hpp"

#include <cmath>
#include <fmt/format.h>
#include <sstream>

#include <toml++/toml.h>

#include "meshes/mesh_figures.hpp"

namespace livermark::segmentation {

namespace {

using core::Vector3;

toml::array array_of(const Vector3 &v) {
    return toml::array{v.x(), v.y(), v.z()};
}

toml::array array_of(const std::vector<std::string> &texts) {
    toml::array array;
    for (const auto &text : texts)
        array.push_back(text);
    return array;
}

/// As the livers that ship.
toml::table material(bool is_tumour) {
    return toml::table{
        {"density", 1060.0},
        {"young_modulus", is_tumour ? 50000.0 : 5000.0},
        {"poisson_ratio", 0.45},
        {"source", is_tumour ? "assumed: about 50 +- 14 kPa (shear wave elastography, 10.1177/8756479317733713)"
                             : "assumed: within one standard deviation of 6.6 +- 1.7 kPa (shear wave elastography, "
                               "10.1177/8756479317733713)"}};
}

toml::table image_table(const PatientBody &body, const Segmentation &segmentation, const std::string &image) {
    const auto &grid = segmentation.grid;
    toml::array axes;
    for (int d = 0; d < 3; ++d)
        axes.push_back(array_of(Vector3(grid.direction.col(d))));
    toml::table gates;
    for (const auto &gate : body.gates)
        gates.insert(gate.name, toml::table{{"value", gate.value}, {"bound", gate.bound}, {"met", gate.is_met}});
    toml::table regions;
    const auto volumes = region_volumes(segmentation);
    for (std::size_t r = 0; r < volumes.size(); ++r)
        regions.insert(segmentation.region_names[r], volumes[r]);
    const auto figures = meshes::mesh_figures(body.mesh);
    return toml::table{{"name", image},
                       {"size", toml::array{grid.size[0], grid.size[1], grid.size[2]}},
                       {"spacing", array_of(grid.spacing)},
                       {"origin", array_of(grid.origin)},
                       {"axes", axes},
                       {"remarks", array_of(segmentation.remarks)},
                       {"voxel_volumes", regions},
                       {"gates", gates},
                       {"mesh", toml::table{{"tetrahedra", figures.num_tetrahedra},
                                            {"nodes", figures.num_nodes},
                                            {"volume", figures.volume},
                                            {"mean_edge", figures.mean_edge},
                                            {"shortest_edge", figures.shortest_edge},
                                            {"smallest_quality", figures.smallest_quality},
                                            {"attempts", body.num_attempts}}}};
}

} // namespace

double edge_for(double volume, int num_tetrahedra) {
    return std::cbrt(6.0 * std::sqrt(2.0) * volume / num_tetrahedra);
}

PatientBody patient_body(const Segmentation &segmentation, int target_tetrahedra) {
    double volume = 0.0;
    for (const double v : region_volumes(segmentation))
        volume += v;
    constexpr double samples_per_edge = 8.0;
    const double spacing = edge_for(volume, target_tetrahedra) / samples_per_edge;
    auto labelled = mesh_labels(label_fields(segmentation, spacing), target_tetrahedra);
    PatientBody body{std::move(labelled.mesh), std::move(labelled.gates), labelled.num_attempts};
    const bool is_mirrored = segmentation.grid.direction.determinant() < 0.0;
    for (auto &point : body.mesh.points)
        for (auto &coordinate : point = to_world(segmentation.grid, point))
            coordinate = std::round(1e9 * coordinate) / 1e9; // short in a file
    if (is_mirrored) {
        for (auto &tetrahedron : body.mesh.tetrahedra)
            std::swap(tetrahedron[2], tetrahedron[3]);
        for (auto &triangle : body.mesh.boundary_triangles)
            std::swap(triangle[1], triangle[2]);
    }
    body.mesh.region_names = segmentation.region_names;
    return body;
}

std::string body_toml(const PatientBody &body, const Segmentation &segmentation, const std::string &image,
                      const std::string &mesh_file, const std::string &command) {
    toml::table regions;
    for (const auto &name : body.mesh.region_names)
        regions.insert(name, material(name != "parenchyma"));
    const toml::table table{
        {"title", fmt::format("Liver of the segmentation {}, {} lesions", image, body.mesh.region_names.size() - 1)},
        {"mesh", mesh_file},
        {"generator", command},
        {"find_patches", true},
        {"regions", regions},
        {"image", image_table(body, segmentation, image)}};
    std::ostringstream text;
    text << "# Lengths in m, axes LPS: x to the patient's left, y posterior, z superior, as in the image.\n"
         << table << '\n';
    return text.str();
}

} // namespace livermark::segmentation
