#include <algorithm>
#include <fmt/format.h>
#include <string>

#include "core/mesh/plausible_liver.hpp"
#include "core/support/toml_input.hpp"
#include "meshes/io/mesh_checks.hpp"
#include "meshes/segmentation/meshing/patient_body.hpp"

namespace livermark::segmentation {

namespace {

/// Headers of images hold some seven digits.
std::string numbers(const core::Vector3 &v) {
    return fmt::format("[{:.7g}, {:.7g}, {:.7g}]", v.x() + 0.0, v.y() + 0.0, v.z() + 0.0);
}

std::string material_toml(const DefaultMaterial &of) {
    return fmt::format("density = {:.1f}\nyoung_modulus = {:.1f}\npoisson_ratio = {}\nsource = {}\n",
                       of.material.density, of.material.young_modulus, of.material.poisson_ratio,
                       support::quoted(of.source));
}

/// Lines on the patient, where the header of the image has them.
std::string said_by_header(const Segmentation &segmentation) {
    std::string lines = segmentation.is_lps_by_header ? "orientation = \"LPS\" # as the header says\n" : "";
    if (!segmentation.patient_position.empty())
        lines +=
            fmt::format("patient_position = {} # as the header says\n", support::quoted(segmentation.patient_position));
    return lines;
}

std::string image_table(const PatientBody &body, const Segmentation &segmentation, const std::string &image) {
    const auto &grid = segmentation.grid;
    auto text =
        fmt::format("[image]\nname = {}\nsize = [{}]\nspacing = {}\norigin = {}\naxes = [{}, {}, {}]\n{}remarks = [\n",
                    support::quoted(image), fmt::join(grid.size, ", "), numbers(grid.spacing), numbers(grid.origin),
                    numbers(grid.direction.col(0)), numbers(grid.direction.col(1)), numbers(grid.direction.col(2)),
                    said_by_header(segmentation));
    for (const auto &remark : segmentation.remarks)
        text += fmt::format("  {},\n", support::quoted(remark));
    text += "]\ngates = [\n";
    for (const auto &quality_criterion : body.quality_criteria)
        text += fmt::format("  {{ name = {}, value = {:.6g}, bound = {:.6g}, met = {}, advice = {} }},\n",
                            support::quoted(quality_criterion.name), quality_criterion.value, quality_criterion.bound,
                            quality_criterion.is_met, quality_criterion.is_advice);
    text += "]\n[image.volumes] # of the voxels\n";
    const auto volumes = region_volumes(segmentation);
    for (std::size_t r = 0; r < volumes.size(); ++r)
        text += fmt::format("{} = {:.7g}\n", segmentation.region_names[r], volumes[r]);
    const auto figures = meshes::mesh_figures(body.mesh);
    const auto &distance = body.surface_from_voxels;
    return text + fmt::format("[image.mesh]\ntetrahedra = {}\nnodes = {}\nvolume = {:.7g}\nmean_edge = {:.7g}\n"
                              "shortest_edge = {:.7g}\nsmallest_quality = {:.4g}\nattempts = {}\n"
                              "surface_from_voxels = {{ median = {:.4g}, percentile_95 = {:.4g}, worst = {:.4g} }}\n",
                              figures.num_tetrahedra, figures.num_nodes, figures.volume, figures.mean_edge,
                              figures.shortest_edge, figures.smallest_quality, body.num_attempts, distance.median,
                              distance.percentile_95, distance.worst);
}

} // namespace

DefaultMaterial default_material(const std::string &region) {
    const auto like_the_livers = [](double young_modulus, const char *measured) {
        return DefaultMaterial{{1060.0, young_modulus, 0.45},
                               fmt::format("assumed, as for the livers that ship: {} (shear wave elastography, "
                                           "10.1177/8756479317733713)",
                                           measured)};
    };
    using core::SegmentRole;
    switch (core::role_of_name(region)) {
    case SegmentRole::lesion:
        return like_the_livers(50000.0, "about 50 +- 14 kPa");
    case SegmentRole::vessel: {
        // A tube of blood: along its axis the wall alone bears, on 2 pi r t of the pi r^2 of its section.
        constexpr double wall = 0.62e6, thickness_over_radius = 0.1;
        return {{1060.0, wall * 2.0 * thickness_over_radius, 0.45},
                "E of the wall times 2 t / r, along the axis of a tube of blood: porcine hepatic veins have 0.62 +- "
                "0.41 MPa at small strain (Umale 2011, 10.1016/j.jbiomech.2011.03.029), a wall of t = r / 10 is an "
                "assumption; across its axis a vessel is softer"};
    }
    case SegmentRole::cyst:
    case SegmentRole::gallbladder:
        return {{1010.0, 1000.0, 0.49},
                "an assumption: a fluid in a thin wall bears no shear, so it is soft and nearly incompressible"};
    case SegmentRole::liver:
    case SegmentRole::other:
    case SegmentRole::unnamed:
        break;
    }
    return like_the_livers(5000.0, "within one standard deviation of 6.6 +- 1.7 kPa");
}

std::string body_toml(const PatientBody &body, const Segmentation &segmentation, const std::string &image,
                      const std::string &mesh_file, const std::string &command) {
    auto text = fmt::format(
        "# Lengths in m, axes LPS: x to the patient's left, y posterior, z superior, as in the image.\ntitle = "
        "{}\nmesh = "
        "{}\ngenerator = {}\nfind_patches = true\n\n",
        support::quoted(fmt::format("Liver of the segmentation {}, {} lesions", image,
                                    std::ranges::count_if(body.mesh.region_names,
                                                          [](const std::string &name) {
                                                              const auto role = core::role_of_name(name);
                                                              return role == core::SegmentRole::lesion ||
                                                                     role == core::SegmentRole::cyst;
                                                          }))),
        support::quoted(mesh_file), support::quoted(command));
    for (const auto &name : body.mesh.region_names)
        text += fmt::format("[regions.{}]\n{}\n", name, material_toml(default_material(name)));
    return text + image_table(body, segmentation, image);
}

} // namespace livermark::segmentation
