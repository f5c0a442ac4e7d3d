#include "segmentation/surface_file.hpp"

#include <cmath>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>

#include "support/input_error.hpp"
#include "tests/result_folder.hpp"

namespace livermark::segmentation {
namespace {

namespace fs = std::filesystem;

class SurfaceFile : public tests::ResultFolder {
  protected:
    std::string refusal(const std::string &name) const {
        try {
            read_surface(directory_ / name);
        } catch (const support::InputError &error) {
            return error.what();
        }
        return "none";
    }
};

meshes::SurfaceMesh ball_surface(double radius, const core::Vector3 &centre = {0.0, 0.0, 0.0}) {
    auto surface = meshes::geodesic_sphere(12);
    for (auto &point : surface.points)
        point = centre + radius * point;
    return surface;
}

void write_stl(const fs::path &file, const meshes::SurfaceMesh &surface, std::size_t from = 0) {
    std::ofstream stream(file);
    stream << "solid s\n";
    for (std::size_t t = from; t < surface.triangles.size(); ++t) {
        stream << "facet normal 0 0 0\nouter loop\n";
        for (const int corner : surface.triangles[t]) {
            const auto &p = surface.points[static_cast<std::size_t>(corner)];
            stream << fmt::format("vertex {} {} {}\n", p.x(), p.y(), p.z());
        }
        stream << "endloop\nendfacet\n";
    }
    stream << "endsolid s\n";
}

void write_obj(const fs::path &file, const meshes::SurfaceMesh &surface) {
    std::ofstream stream(file);
    for (const auto &p : surface.points)
        stream << fmt::format("v {} {} {}\n", p.x(), p.y(), p.z());
    for (const auto &t : surface.triangles)
        stream << fmt::format("f {} {} {}\n", t[0] + 1, t[2] + 1, t[1] + 1); // inside out
}

void write_ply(const fs::path &file, const meshes::SurfaceMesh &surface) {
    std::ofstream stream(file);
    stream << fmt::format(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty double z\n"
        "element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        surface.points.size(), surface.triangles.size());
    for (const auto &p : surface.points)
        stream << fmt::format("{} {} {}\n", p.x(), p.y(), p.z());
    for (const auto &t : surface.triangles)
        stream << fmt::format("3 {} {} {}\n", t[0], t[1], t[2]);
}

TEST_F(SurfaceFile, MayBeStlObjOrPly) {
    const auto surface = ball_surface(50.0);
    write_stl(directory_ / "a.stl", surface);
    write_obj(directory_ / "a.obj", surface);
    write_ply(directory_ / "a.ply", surface);
    for (const char *name : {"a.stl", "a.obj", "a.ply"}) {
        SCOPED_TRACE(name);
        const auto back = read_surface(directory_ / name);
        EXPECT_EQ(back.points.size(), surface.points.size());
        EXPECT_EQ(back.triangles.size(), surface.triangles.size());
        EXPECT_NEAR(meshes::enclosed_volume(back) / meshes::enclosed_volume(surface), 1.0, 1e-4);
    }
}

TEST_F(SurfaceFile, ThatIsOpenIsRefusedWithThePlace) {
    write_stl(directory_ / "a.stl", ball_surface(50.0), 1);
    EXPECT_NE(refusal("a.stl").find("is open at ("), std::string::npos) << refusal("a.stl");
}

TEST_F(SurfaceFile, ThatCutsItselfIsRefusedWithThePlace) {
    auto surface = ball_surface(50.0);
    const auto other = ball_surface(50.0, {30.0, 0.0, 0.0});
    const int first = static_cast<int>(surface.points.size());
    surface.points.insert(surface.points.end(), other.points.begin(), other.points.end());
    for (auto triangle : other.triangles) {
        for (int &corner : triangle)
            corner += first;
        surface.triangles.push_back(triangle);
    }
    write_ply(directory_ / "a.ply", surface);
    EXPECT_NE(refusal("a.ply").find("cuts itself at ("), std::string::npos) << refusal("a.ply");
}

TEST_F(SurfaceFile, ThatIsNoneIsRefused) {
    std::ofstream(directory_ / "a.stl") << "solid nothing\nendsolid\n";
    std::ofstream(directory_ / "a.txt") << "v 0 0 0\n";
    std::ofstream(directory_ / "a.obj") << "v 0 0 0\nv 1 0 nan\nv 0 1 0\nf 1 2 3\n";
    for (const char *name : {"a.stl", "a.txt", "a.obj", "nowhere.stl"})
        EXPECT_NE(refusal(name).find(name), std::string::npos) << refusal(name);
}

TEST(VoxelsWithin, HaveTheVolumesOfTheSurfaces) {
    const auto liver = ball_surface(0.05);
    const auto lesion = ball_surface(0.012, {0.04, 0.0, 0.0}); // reaches out of it
    const auto voxels = voxels_within({liver, lesion}, 0.8e-3);
    const auto volumes = region_volumes(voxels);
    ASSERT_EQ(voxels.region_names, (std::vector<std::string>{"parenchyma", "tumour_1"}));
    EXPECT_NEAR((volumes[0] + volumes[1]) / meshes::enclosed_volume(liver), 1.0, 2e-3);
    EXPECT_LT(volumes[1], meshes::enclosed_volume(lesion));
    EXPECT_GT(volumes[1], 0.6 * meshes::enclosed_volume(lesion));
}

TEST(VoxelsWithin, RefuseALesionElsewhere) {
    EXPECT_THROW(voxels_within({ball_surface(0.05), ball_surface(0.01, {0.2, 0.0, 0.0})}, 2e-3), support::InputError);
}

} // namespace
} // namespace livermark::segmentation
