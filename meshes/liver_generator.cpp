#include "meshes/liver_generator.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <optional>
#include <stdexcept>

#include "meshes/gmsh_volume.hpp"
#include "meshes/liver_patches.hpp"
#include "meshes/liver_shape.hpp"
#include "meshes/mesh_figures.hpp"
#include "support/input_error.hpp"

namespace livermark::meshes {

namespace {

using core::Vector3;

constexpr int smallest_target = 2000;

/// Newton's iteration, because std::cbrt may round differently elsewhere.
double cube_root(double value) {
    double root = 1.0;
    for (int iteration = 0; iteration < 60; ++iteration)
        root -= (root - value / (root * root)) / 3.0;
    return root;
}

/// A triangulated lesion of the volume of its ellipsoid, with edges somewhat shorter than the capsule's: at least eight
/// triangles to a great circle where that does not make edges below a third of the capsule's, which would set the time
/// step.
SurfaceMesh lesion_surface(const Lesion &lesion, double edge) {
    const double radius = cube_root(1e9 * lesion.semi_axes.prod()) / 1e3;
    const double chord = 1.1 * radius; // edge of the icosahedron
    const double wanted = std::max(std::min(2.0, std::floor(chord / (edge / 3.0))), std::round(chord / (0.55 * edge)));
    SurfaceMesh surface = geodesic_sphere(std::max(1, static_cast<int>(wanted)));
    const double scale = cube_root(4.18879020478639098 / enclosed_volume(surface)); // 4 pi / 3, the unit ball
    for (auto &point : surface.points) {
        const Vector3 on_ball = scale * point;
        point = lesion.center;
        for (int d = 0; d < 3; ++d)
            point += on_ball[d] * lesion.semi_axes[d] * lesion.axes[d];
    }
    return surface;
}

std::vector<SurfaceMesh> lesion_surfaces(double edge) {
    std::vector<SurfaceMesh> surfaces;
    for (const auto &lesion : liver_lesions())
        surfaces.push_back(lesion_surface(lesion, edge));
    return surfaces;
}

core::TetraMesh mesh_with_edge(double edge, const std::vector<SurfaceMesh> &lesions) {
    // The inner edges come out about 1.2 times this, so a little longer than those of the capsule, which has the
    // detail.
    const double inner_size = 0.85 * edge;
    // Fine enough for the sharp inferior margin at any edge length.
    const double spacing = std::min(0.7 * edge, 0.006);
    const auto [low, high] = liver_bounding_box();
    const SurfaceMesh capsule = remesh(march_tetrahedra(liver_level, low, high, spacing), project_to_liver, edge);
    return fill_with_tetrahedra(capsule, lesions, inner_size);
}

/// The number of tetrahedra jumps by some 0.5 % between neighbouring edge lengths, so the search takes the best of a
/// few attempts that a fixed-point iteration scatters around the target.
core::TetraMesh search_for_count(int target, bool tumours) {
    constexpr int max_attempts = 16;
    constexpr double good_enough = 0.003;
    constexpr double healthy_edge = 0.0087; // [m], gives about healthy_liver_tetrahedra
    double edge = healthy_edge * cube_root(static_cast<double>(healthy_liver_tetrahedra) / target);
    // The lesions stay as they are during the search: their subdivision changes in steps that it could not step over.
    const auto lesions = tumours ? lesion_surfaces(edge) : std::vector<SurfaceMesh>();
    core::TetraMesh best;
    for (int attempt = 0; attempt < max_attempts; ++attempt) {
        core::TetraMesh mesh = mesh_with_edge(edge, lesions);
        if (mesh.tetrahedra.empty())
            throw std::runtime_error("gmsh returned a liver without tetrahedra");
        const int miss = std::abs(mesh.num_tetrahedra() - target);
        edge *= cube_root(static_cast<double>(mesh.num_tetrahedra()) / target);
        if (best.tetrahedra.empty() || miss < std::abs(best.num_tetrahedra() - target))
            best = std::move(mesh);
        if (miss <= good_enough * target)
            break;
    }
    return best;
}

void require_canonical_figures(const core::TetraMesh &mesh, int target, bool tumours) {
    const auto figures = mesh_figures(mesh);
    const double shortest = (tumours ? 0.25 : 0.35) * figures.mean_edge;
    if (std::abs(figures.num_tetrahedra - target) > 0.005 * target || figures.smallest_quality < 0.2 ||
        figures.shortest_edge < shortest || std::abs(figures.volume - 1.5e-3) > 0.03 * 1.5e-3)
        throw std::runtime_error(fmt::format(
            "the generated liver misses what a canonical body must have: {} tetrahedra within 0.5 %, smallest "
            "quality 0.2, shortest edge {:.2f} mm, 1500 mL within 3 %; it has\n{}",
            target, 1e3 * shortest, to_text(figures)));
}

} // namespace

core::TetraMesh generate_liver(const LiverOptions &options) {
    const int canonical = options.tumours ? tumour_liver_tetrahedra : healthy_liver_tetrahedra;
    const int target = options.target_tetrahedra == 0 ? canonical : options.target_tetrahedra;
    if (target < smallest_target)
        throw support::InputError(fmt::format("a liver of {} tetrahedra cannot show its anatomy; ask for {} or more",
                                              target, smallest_target));

    core::TetraMesh mesh = search_for_count(target, options.tumours);
    for (auto &point : mesh.points)
        for (auto &coordinate : point)
            coordinate = std::round(1e9 * coordinate) / 1e9; // whole nanometres are short in a file
    mesh.region_names = {"parenchyma"};
    if (options.tumours)
        for (std::size_t i = 1; i <= liver_lesions().size(); ++i)
            mesh.region_names.push_back(fmt::format("tumour_{}", i));
    assign_liver_patches(mesh);
    if (target == canonical)
        require_canonical_figures(mesh, target, options.tumours);
    return mesh;
}

} // namespace livermark::meshes
