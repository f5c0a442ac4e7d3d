#include "segmentation/meshing/patient_body.hpp"

#include <cmath>
#include <fmt/format.h>
#include <sstream>

#include <toml++/toml.h>

#include "meshes/io/mesh_figures.hpp"

namespace livermark::segmentation {

namespace {

using core::Vector3;

/// A TOML string.
std::string quoted(const std::string &text) {
    std::ostringstream stream;
    stream << toml::value<std::string>(text);
    return stream.str();
}

/// Headers of images hold some seven digits.
std::string numbers(const Vector3 &v) {
    return fmt::format("[{:.7g}, {:.7g}, {:.7g}]", v.x() + 0.0, v.y() + 0.0, v.z() + 0.0);
}

/// As of the livers that ship.
std::string material(bool is_tumour) {
    return fmt::format(
        "density = 1060.0\nyoung_modulus = {}\npoisson_ratio = 0.45\nsource = \"assumed, as for the livers "
        "that ship: {} (shear wave elastography, 10.1177/8756479317733713)\"\n",
        is_tumour ? "50000.0" : "5000.0",
        is_tumour ? "about 50 +- 14 kPa" : "within one standard deviation of 6.6 +- 1.7 kPa");
}

std::string image_table(const PatientBody &body, const Segmentation &segmentation, const std::string &image) {
    const auto &grid = segmentation.grid;
    auto text =
        fmt::format("[image]\nname = {}\nsize = [{}]\nspacing = {}\norigin = {}\naxes = [{}, {}, {}]\n{}remarks = [\n",
                    quoted(image), fmt::join(grid.size, ", "), numbers(grid.spacing), numbers(grid.origin),
                    numbers(grid.direction.col(0)), numbers(grid.direction.col(1)), numbers(grid.direction.col(2)),
                    segmentation.is_lps_by_header ? "orientation = \"LPS\" # as the header says\n" : "");
    for (const auto &remark : segmentation.remarks)
        text += fmt::format("  {},\n", quoted(remark));
    text += "]\ngates = [\n";
    for (const auto &quality_criterion : body.quality_criteria)
        text += fmt::format("  {{ name = {}, value = {:.6g}, bound = {:.6g}, met = {}, advice = {} }},\n",
                            quoted(quality_criterion.name), quality_criterion.value, quality_criterion.bound,
                            quality_criterion.is_met, quality_criterion.is_advice);
    text += "]\n[image.volumes] # of the voxels\n";
    const auto volumes = region_volumes(segmentation);
    for (std::size_t r = 0; r < volumes.size(); ++r)
        text += fmt::format("{} = {:.7g}\n", segmentation.region_names[r], volumes[r]);
    const auto figures = meshes::mesh_figures(body.mesh);
    return text + fmt::format("[image.mesh]\ntetrahedra = {}\nnodes = {}\nvolume = {:.7g}\nmean_edge = {:.7g}\n"
                              "shortest_edge = {:.7g}\nsmallest_quality = {:.4g}\nattempts = {}\n",
                              figures.num_tetrahedra, figures.num_nodes, figures.volume, figures.mean_edge,
                              figures.shortest_edge, figures.smallest_quality, body.num_attempts);
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
    PatientBody body{std::move(labelled.mesh), std::move(labelled.quality_criteria), labelled.num_attempts};
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
    auto text = fmt::format(
        "# Lengths in m, axes LPS: x to the patient's left, y posterior, z superior, as in the image.\ntitle = "
        "{}\nmesh = "
        "{}\ngenerator = {}\nfind_patches = true\n\n",
        quoted(fmt::format("Liver of the segmentation {}, {} lesions", image, body.mesh.region_names.size() - 1)),
        quoted(mesh_file), quoted(command));
    for (const auto &name : body.mesh.region_names)
        text += fmt::format("[regions.{}]\n{}\n", name, material(name != "parenchyma"));
    return text + image_table(body, segmentation, image);
}

} // namespace livermark::segmentation
