#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <numeric>
#include <set>

#include "core/support/toml_input.hpp"
#include "meshes/generators/liver_shape.hpp"
#include "meshes/io/mesh_checks.hpp"
#include "meshes/segmentation/images/segmentation.hpp"
#include "meshes/segmentation/meshing/mesh_operations.hpp"
#include "meshes/segmentation/meshing/patient_body.hpp"
#include "tests/same_bits.hpp"

namespace livermark::segmentation {
namespace {

using core::Vector3;

/// Distance from a surface [m], negative inside.
using Distance = std::function<double(const Vector3 &)>;

/// Bodies that are known exactly, and how well their meshes have to follow them.
struct Phantom {
    std::string name;
    Vector3 low, high; ///< corners of the image [m]
    Vector3 spacing;   ///< of its voxels [m]
    Distance capsule;
    std::vector<Distance> lesions;
    int target_tetrahedra;
    double rms; ///< distance of the boundary's nodes and facet centres from the capsule [m]
    double max;
};

void PrintTo(const Phantom &phantom, std::ostream *stream) {
    *stream << phantom.name;
}

Distance ball(const Vector3 &center, double radius) {
    return [=](const Vector3 &place) { return (place - center).norm() - radius; };
}

/// Along the first axis, and at no right angle to the slices.
Distance tube(double diameter) {
    return [=](const Vector3 &place) { return place.cross(Vector3(0.96, 0.0, 0.28)).norm() - 0.5 * diameter; };
}

/// To first order in the distance.
Distance ellipsoid(const meshes::Lesion &lesion) {
    return [=](const Vector3 &place) {
        Vector3 scaled;
        Vector3 gradient = Vector3::Zero();
        for (int d = 0; d < 3; ++d) {
            scaled[d] = (place - lesion.center).dot(lesion.axes[d]) / lesion.semi_axes[d];
            gradient += scaled[d] / lesion.semi_axes[d] * lesion.axes[d];
        }
        return 0.5 * (scaled.squaredNorm() - 1.0) / std::max(1.0, gradient.norm());
    };
}

constexpr double thick_slice = 0.003;

Phantom ball_phantom(const std::string &name, const std::vector<Distance> &lesions) {
    const Vector3 corner(0.056, 0.056, 0.056);
    return {name, -corner, corner, {0.0008, 0.0008, thick_slice}, ball(Vector3::Zero(), 0.050), lesions,
            5000, 0.0005,  0.002};
}

Phantom liver_phantom() {
    const auto [low, high] = meshes::liver_bounding_box();
    std::vector<Distance> lesions;
    for (const auto &lesion : meshes::liver_lesions())
        lesions.push_back(ellipsoid(lesion));
    return {"LiverWithSixLesions",
            low,
            high,
            {0.0008, 0.0008, thick_slice},
            [](const core::Vector3 &point) { return meshes::liver_level(point); },
            lesions,
            16000,
            0.0005,
            0.003};
}

Segmentation voxels_of(const Phantom &phantom) {
    Segmentation segmentation;
    segmentation.grid.spacing = phantom.spacing;
    segmentation.grid.origin = phantom.low;
    auto &size = segmentation.grid.size;
    for (int d = 0; d < 3; ++d)
        size[d] = 1 + static_cast<int>((phantom.high[d] - phantom.low[d]) / phantom.spacing[d]);
    for (int k = 0; k < size[2]; ++k)
        for (int j = 0; j < size[1]; ++j)
            for (int i = 0; i < size[0]; ++i) {
                const Vector3 place = phantom.low + phantom.spacing.cwiseProduct(Vector3(i, j, k));
                int region = phantom.capsule(place) < 0.0 ? 1 : 0;
                for (std::size_t l = 0; l < phantom.lesions.size(); ++l)
                    if (region == 1 && phantom.lesions[l](place) < 0.0)
                        region = static_cast<int>(l) + 2;
                segmentation.region.push_back(static_cast<std::uint8_t>(region));
            }
    for (std::size_t r = 0; r <= phantom.lesions.size(); ++r)
        segmentation.region_names.push_back("region " + std::to_string(r));
    return segmentation;
}

PatientBody mesh_of(const Phantom &phantom) {
    return mesh_labels(label_fields(voxels_of(phantom), 0.0012), phantom.target_tetrahedra);
}

/// Throws at the first fault of a mesh that a body's file would be refused for.
void check(const core::TetraMesh &mesh) {
    meshes::RawMesh raw;
    raw.points = mesh.points;
    raw.tetrahedra = mesh.tetrahedra;
    raw.triangles = mesh.boundary_triangles;
    raw.node_tag.resize(mesh.points.size());
    std::iota(raw.node_tag.begin(), raw.node_tag.end(), 0);
    raw.tetrahedron_tag.resize(mesh.tetrahedra.size());
    std::iota(raw.tetrahedron_tag.begin(), raw.tetrahedron_tag.end(), 0);
    meshes::check_nodes(raw, "mesh");
    meshes::check_tetrahedra(raw, "mesh");
    meshes::check_faces(raw, "mesh");
}

/// Root of the mean square and largest of some distances [m].
struct Spread {
    double rms = 0.0;
    double max = 0.0;
};

Spread spread_of(const std::vector<double> &distances) {
    Spread spread;
    for (const double distance : distances) {
        spread.rms += distance * distance / static_cast<double>(distances.size());
        spread.max = std::max(spread.max, std::abs(distance));
    }
    spread.rms = std::sqrt(spread.rms);
    return spread;
}

/// Distances of the boundary's nodes and facet centres. Places of the mesh are in the image's axes, from its first
/// voxel.
Spread off_capsule(const Phantom &phantom, const core::TetraMesh &mesh) {
    std::vector<double> distances;
    std::set<int> nodes;
    for (const auto &[a, b, c] : mesh.boundary_triangles) {
        distances.push_back(phantom.capsule(phantom.low + (mesh.points[a] + mesh.points[b] + mesh.points[c]) / 3.0));
        nodes.insert({a, b, c});
    }
    for (const int node : nodes)
        distances.push_back(phantom.capsule(phantom.low + mesh.points[node]));
    return spread_of(distances);
}

/// Distances of the nodes of lesions' borders from the part of the lesion that is in the body.
Spread off_lesions(const Phantom &phantom, const core::TetraMesh &mesh) {
    std::vector<std::set<int>> labels(mesh.points.size());
    for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t)
        for (const int node : mesh.tetrahedra[t])
            labels[node].insert(mesh.region[t]);
    for (const auto &nodes : mesh.boundary_triangles)
        for (const int node : nodes)
            labels[node].insert(-1);
    std::vector<double> distances;
    for (std::size_t node = 0; node < labels.size(); ++node)
        for (const int region : labels[node])
            if (const Vector3 place = phantom.low + mesh.points[node]; region > 0 && labels[node].size() > 1)
                distances.push_back(std::max(phantom.lesions[region - 1](place), phantom.capsule(place)));
    return spread_of(distances);
}

class LabelPhantom : public testing::TestWithParam<Phantom> {};

INSTANTIATE_TEST_SUITE_P(
    Bodies, LabelPhantom,
    testing::Values(ball_phantom("Ball", {}),
                    ball_phantom("BallWithLesionTouchingTheCapsule", {ball({0.036, 0.0, 0.005}, 0.014)}),
                    ball_phantom("BallWithLesionCutByTheCapsule", {ball({0.045, 0.0, 0.005}, 0.014)}),
                    ball_phantom("BallWithTwoLesionsTouching",
                                 {ball({0.005, 0.0, 0.0}, 0.014), ball({-0.018, 0.0, 0.0}, 0.010)}),
                    ball_phantom("BallWithAVesselThroughIt", {tube(0.0145)}),
                    ball_phantom("BallWithLesionOfOneEdge", {ball({0.01, 0.01, 0.005}, 0.004)}),
                    ball_phantom("BallWithLesionOfHalfAnEdge", {ball({0.01, 0.01, 0.005}, 0.0025)}), liver_phantom()),
    [](const auto &info) { return info.param.name; });

TEST_P(LabelPhantom, GivesAMeshThatMeetsItsGatesAndFollowsItsBorders) {
    const Phantom &phantom = GetParam();
    const auto [mesh, quality_criteria, num_attempts, not_measured] = mesh_of(phantom);
    for (const auto &quality_criterion : quality_criteria)
        EXPECT_TRUE(quality_criterion.is_met)
            << quality_criterion.name << ": " << quality_criterion.value << ", bound " << quality_criterion.bound;
    EXPECT_TRUE(all_met(quality_criteria));
    EXPECT_NO_THROW(check(mesh));

    // What the quality criteria say of volumes and regions, told by the voxels and the tetrahedra themselves.
    const auto wanted = region_volumes(voxels_of(phantom));
    std::vector<double> volumes(wanted.size(), 0.0);
    const auto volume = core::tetrahedron_volumes(mesh);
    for (std::size_t t = 0; t < volume.size(); ++t)
        volumes.at(mesh.region[t]) += volume[t];
    for (std::size_t r = 0; r < wanted.size(); ++r)
        EXPECT_NEAR(volumes[r], wanted[r], 0.01 * wanted[r]) << "region " << r;

    const Spread capsule = off_capsule(phantom, mesh);
    EXPECT_LT(capsule.rms, phantom.rms);
    EXPECT_LT(capsule.max, phantom.max);
    // Edges are some 10 mm long; where a lesion touches something at a small angle, the wedge between them is filled as
    // far as half of that.
    const Spread lesions = off_lesions(phantom, mesh);
    EXPECT_LT(lesions.rms, 0.0015);
    EXPECT_LT(lesions.max, 0.005);
}

TEST(MeshLabels, GivesTheSameBitsEveryTime) {
    const auto phantom = ball_phantom(
        "", {ball({0.036, 0.0, 0.005}, 0.014), ball({0.01, 0.01, 0.005}, 0.010), ball({-0.02, 0.01, 0.005}, 0.004)});
    const auto first = mesh_of(phantom).mesh;
    const auto second = mesh_of(phantom).mesh;
    EXPECT_TRUE(tests::same_bits(first.points, second.points));
    EXPECT_EQ(first.tetrahedra, second.tetrahedra);
    EXPECT_EQ(first.region, second.region);
    EXPECT_EQ(first.boundary_triangles, second.boundary_triangles);
}

TEST(MeshLabels, ComesNearTheNumberOfTetrahedraAskedFor) {
    auto phantom = ball_phantom("", {ball({0.01, 0.01, 0.005}, 0.010)});
    for (const int target : {2000, 5000, 12000}) {
        phantom.target_tetrahedra = target;
        EXPECT_NEAR(mesh_of(phantom).mesh.num_tetrahedra(), target, 0.1 * target);
    }
}

TEST(MeshLabels, NamesTheGateThatAMeshMisses) {
    // A plate of 4 mm cannot be had in 200 tetrahedra.
    Phantom plate = ball_phantom("", {});
    plate.capsule = [](const Vector3 &place) { return std::max(place.norm() - 0.050, std::abs(place.z()) - 0.002); };
    plate.spacing = {0.001, 0.001, 0.001};
    plate.target_tetrahedra = 200;
    const auto quality_criteria = mesh_of(plate).quality_criteria;
    EXPECT_FALSE(all_met(quality_criteria));
    for (const auto &quality_criterion : quality_criteria)
        EXPECT_FALSE(quality_criterion.remedy.empty()) << quality_criterion.name;
}

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

TEST(PatientBody, HasABodyFileThatNamesTheImage) {
    auto voxels = coarse_phantom({.spacing = {3e-3, 3e-3, 3e-3}});
    const auto body = patient_body(voxels, 4000);
    EXPECT_EQ(body_toml(body, voxels, "a", "p.msh", "livermark mesh").find("orientation"), std::string::npos);
    voxels.is_lps_by_header = true;
    const auto table = support::parse_toml(body_toml(body, voxels, "a \"b\".nii", "p.msh", "livermark mesh"), "p.toml");
    EXPECT_EQ(table["image"]["name"].value<std::string>(), "a \"b\".nii");
    EXPECT_EQ(table["image"]["orientation"].value<std::string>(), "LPS");
    EXPECT_FALSE(table["image"].as_table()->contains("patient_position"));
    voxels.patient_position = "FFP";
    const auto lying = support::parse_toml(body_toml(body, voxels, "a", "p.msh", "livermark mesh"), "p.toml");
    EXPECT_EQ(lying["image"]["patient_position"].value<std::string>(), "FFP");
    EXPECT_EQ(lying["image"]["remarks"].as_array()->size(), table["image"]["remarks"].as_array()->size());
    EXPECT_EQ(table["image"]["gates"].as_array()->size(), body.quality_criteria.size());
    EXPECT_EQ(table["image"]["mesh"]["tetrahedra"].value<int>(), body.mesh.num_tetrahedra());
    for (const auto &name : body.mesh.region_names)
        EXPECT_TRUE(table["regions"][name].is_table()) << name;
    EXPECT_EQ(table["image"]["mesh"]["surface_from_voxels"].as_table()->size(), 3u);
}

TEST(PatientBody, CountsNoVesselAsALesion) {
    auto voxels = coarse_phantom({.spacing = {3e-3, 3e-3, 3e-3}});
    auto body = patient_body(voxels, 4000);
    voxels.region_names.back() = body.mesh.region_names.back() = "vessel_portal";
    const auto table = support::parse_toml(body_toml(body, voxels, "a", "p.msh", "livermark mesh"), "p.toml");
    EXPECT_EQ(table["title"].value<std::string>(), "Liver of the segmentation a, 5 lesions");
    EXPECT_EQ(table["regions"]["vessel_portal"]["young_modulus"].value<double>(), 124000.0);
}

TEST(PatientBody, MaterialsGoByTheRoleOfARegion) {
    EXPECT_EQ(default_material("parenchyma").material.young_modulus, 5000.0);
    EXPECT_EQ(default_material("tumour_2").material.young_modulus, 50000.0);
    EXPECT_EQ(default_material("cyst_1").material.poisson_ratio, 0.49);
    EXPECT_NE(default_material("vessel").source.find("an assumption"), std::string::npos);
    for (const auto *region : {"parenchyma", "tumour_1", "cyst_1", "vessel_hepatic", "gallbladder"})
        EXPECT_FALSE(default_material(region).source.empty()) << region;
}

TEST(PatientBody, SaysHowFarItsSurfaceIsFromThatOfTheVoxels) {
    // The corners of a cube of one voxel, and a tetrahedron with one corner 2 mm beyond the middle of a face.
    Segmentation voxels{
        .grid = {.size = {3, 3, 3}, .spacing = {1e-3, 1e-3, 2e-3}}, .region = {}, .region_names = {"a"}, .remarks = {}};
    voxels.grid.origin = Vector3(0.1, 0.2, 0.3);
    voxels.region.assign(27, 0);
    voxels.region[13] = 1;
    core::TetraMesh mesh;
    for (const auto &place :
         {Vector3(0.5, 0.5, 1.0), Vector3(1.5, 0.5, 1.0), Vector3(0.5, 1.5, 1.0), Vector3(1.0, 1.0, 5.0)})
        mesh.points.push_back(voxels.grid.origin + 1e-3 * place);
    mesh.boundary_triangles = {{0, 2, 1}};
    const auto flat = distance_from_voxels(mesh, voxels);
    EXPECT_NEAR(flat.worst, 0.0, 1e-9) << "on the face of the voxel";
    mesh.boundary_triangles.push_back({0, 1, 3});
    const auto pointed = distance_from_voxels(mesh, voxels);
    EXPECT_NEAR(pointed.worst, 2e-3, 1e-9);
    EXPECT_LE(pointed.median, pointed.percentile_95);
}

} // namespace
} // namespace livermark::segmentation
