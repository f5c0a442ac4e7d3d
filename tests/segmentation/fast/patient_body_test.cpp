#include "segmentation/meshing/patient_body.hpp"

#include <gtest/gtest.h>

#include "meshes/io/mesh_figures.hpp"
#include "segmentation/images/phantom.hpp"
#include "support/toml_input.hpp"

namespace livermark::segmentation {
namespace {

Segmentation coarse_phantom(const PhantomOptions &options) {
    return choose_labels(phantom_labels(options), {}, 0.0);
}

double total(const std::vector<double> &volumes) {
    double sum = 0.0;
    for (const double v : volumes)
        sum += v;
    return sum;
}

core::Vector3 centroid(const core::TetraMesh &mesh) {
    const auto volumes = core::nodal_volumes(mesh);
    core::Vector3 sum = core::Vector3::Zero();
    for (std::size_t i = 0; i < volumes.size(); ++i)
        sum += volumes[i] * mesh.points[i];
    return sum / total(volumes);
}

TEST(PatientBody, LiesWhereThePatientLayWhateverTheAxesOfTheImage) {
    const auto straight = patient_body(coarse_phantom({.spacing = {3e-3, 3e-3, 3e-3}}), 4000);
    auto turned_voxels = coarse_phantom({.spacing = {3e-3, 3e-3, 3e-3}, .turn = {0.4, -0.3, 0.8}});
    const auto turned = patient_body(turned_voxels, 4000);
    EXPECT_LT((centroid(straight.mesh) - centroid(turned.mesh)).norm(), 0.5e-3);

    // The same voxels numbered from the other end: left-handed axes.
    auto mirrored_voxels = turned_voxels;
    auto &grid = mirrored_voxels.grid;
    grid.origin = to_world(grid, {(grid.size[0] - 1) * grid.spacing[0], 0.0, 0.0});
    grid.direction.col(0) *= -1.0;
    for (std::size_t row = 0; row < mirrored_voxels.region.size(); row += static_cast<std::size_t>(grid.size[0]))
        std::reverse(mirrored_voxels.region.begin() + static_cast<std::ptrdiff_t>(row),
                     mirrored_voxels.region.begin() + static_cast<std::ptrdiff_t>(row) + grid.size[0]);
    const auto mirrored = patient_body(mirrored_voxels, 4000);
    EXPECT_LT((centroid(mirrored.mesh) - centroid(turned.mesh)).norm(), 0.5e-3);
    for (const auto *mesh : {&straight.mesh, &turned.mesh, &mirrored.mesh}) {
        for (const double volume : core::tetrahedron_volumes(*mesh))
            ASSERT_GT(volume, 0.0);
        core::Vector3 area = core::Vector3::Zero(); // outward all over the closed surface
        double enclosed = 0.0;
        for (int t = 0; t < mesh->num_boundary_triangles(); ++t) {
            area += core::area_vector(*mesh, t);
            enclosed +=
                core::area_vector(*mesh, t).dot(
                    mesh->points[static_cast<std::size_t>(mesh->boundary_triangles[static_cast<std::size_t>(t)][0])]) /
                3.0;
        }
        EXPECT_LT(area.norm(), 1e-12);
        EXPECT_NEAR(enclosed, total(core::nodal_volumes(*mesh)), 1e-9);
    }
}

TEST(PatientBody, IsTheSameEveryTime) {
    const auto voxels = coarse_phantom({.spacing = {2e-3, 2e-3, 4e-3}, .touching = true});
    const auto first = patient_body(voxels, 6000), second = patient_body(voxels, 6000);
    EXPECT_EQ(first.mesh.points, second.mesh.points);
    EXPECT_EQ(first.mesh.tetrahedra, second.mesh.tetrahedra);
}

TEST(PatientBody, HasABodyFileThatNamesTheImage) {
    auto voxels = coarse_phantom({.spacing = {3e-3, 3e-3, 3e-3}});
    const auto body = patient_body(voxels, 4000);
    EXPECT_EQ(body_toml(body, voxels, "a", "p.msh", "livermark mesh").find("orientation"), std::string::npos);
    voxels.is_lps_by_header = true;
    const auto table = support::parse_toml(body_toml(body, voxels, "a \"b\".nii", "p.msh", "livermark mesh"), "p.toml");
    EXPECT_EQ(table["image"]["name"].value<std::string>(), "a \"b\".nii");
    EXPECT_EQ(table["image"]["orientation"].value<std::string>(), "LPS");
    EXPECT_EQ(table["image"]["gates"].as_array()->size(), body.quality_criteria.size());
    EXPECT_EQ(table["image"]["mesh"]["tetrahedra"].value<int>(), body.mesh.num_tetrahedra());
    for (const auto &name : body.mesh.region_names)
        EXPECT_TRUE(table["regions"][name].is_table()) << name;
}

} // namespace
} // namespace livermark::segmentation
