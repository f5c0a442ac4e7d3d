#include "meshes/generators/liver/liver_generator.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <stdexcept>

#include "meshes/anatomy/liver_patches.hpp"
#include "meshes/generators/cube_root.hpp"
#include "meshes/generators/expected_tetrahedra.hpp"
#include "meshes/generators/gmsh_volume.hpp"
#include "meshes/generators/liver/liver_shape.hpp"
#include "meshes/io/mesh_figures.hpp"
#include "support/input_error.hpp"

namespace livermark::meshes {

namespace {

using core::Vector3;

constexpr int smallest_target = 2000;

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

std::vector<SurfaceMesh> lesion_surfaces(const std::vector<Lesion> &lesions, double edge) {
    std::vector<SurfaceMesh> surfaces;
    for (const auto &lesion : lesions)
        surfaces.push_back(lesion_surface(lesion, edge));
    return surfaces;
}

/// The liver that ships, or another one.
struct Liver {
    LiverShape shape;
    std::array<Vector3, 2> box;
    std::vector<Lesion> lesions;
    double size = 1.0; ///< relative to the one that ships
};

core::TetraMesh mesh_with_edge(const Liver &liver, double edge, const std::vector<SurfaceMesh> &lesions) {
    // The inner edges come out about 1.2 times this, so a little longer than those of the capsule, which has the
    // detail.
    const double inner_size = 0.85 * edge;
    // Fine enough for the sharp inferior margin at any edge length.
    const double spacing = std::min(0.7 * edge, 0.006 * liver.size);
    const auto &[low, high] = liver.box;
    const auto level = [&](const Vector3 &point) { return liver_level(point, liver.shape); };
    const auto project = [&](const Vector3 &point) { return project_to_liver(point, liver.shape); };
    const SurfaceMesh capsule = remesh(march_tetrahedra(level, low, high, spacing), project, edge);
    return fill_with_tetrahedra(capsule, lesions, inner_size);
}

/// The number of tetrahedra jumps by some 0.5 % between neighbouring edge lengths, so the search takes the best of a
/// few attempts that a fixed-point iteration scatters around the target.
/// @param is_good  whether a mesh may be taken
core::TetraMesh search_for_count(const Liver &liver, int target,
                                 const std::function<bool(const core::TetraMesh &)> &is_good) {
    constexpr int max_attempts = 16;
    constexpr double good_enough = 0.003;
    constexpr double healthy_edge = 0.0087; // [m], gives about healthy_liver_tetrahedra
    double edge = liver.size * healthy_edge * cube_root(static_cast<double>(healthy_liver_tetrahedra) / target);
    // The lesions stay as they are during the search: their subdivision changes in steps that it could not step over.
    const auto lesions = lesion_surfaces(liver.lesions, edge);
    core::TetraMesh best;
    bool is_best_good = false;
    for (int attempt = 0; attempt < max_attempts; ++attempt) {
        core::TetraMesh mesh = mesh_with_edge(liver, edge, lesions);
        if (mesh.tetrahedra.empty())
            throw std::runtime_error("gmsh returned a liver without tetrahedra");
        const int miss = std::abs(mesh.num_tetrahedra() - target);
        edge *= cube_root(static_cast<double>(mesh.num_tetrahedra()) / target);
        const bool good = is_good(mesh);
        if (best.tetrahedra.empty() || (good && !is_best_good) ||
            (good == is_best_good && miss < std::abs(best.num_tetrahedra() - target))) {
            best = std::move(mesh);
            is_best_good = good;
        }
        if (good && miss <= good_enough * target)
            break;
        if (!good && miss <= good_enough * target)
            edge *= 1.004; // another surface, which may be better
    }
    return best;
}

double shortest_edge_allowed(const MeshFigures &figures, bool has_lesions) {
    return (has_lesions ? 0.25 : 0.35) * figures.mean_edge;
}

constexpr double smallest_quality_allowed = 0.2;

bool has_quality(const core::TetraMesh &mesh, bool has_lesions) {
    const auto figures = mesh_figures(mesh);
    return figures.smallest_quality >= smallest_quality_allowed &&
           figures.shortest_edge >= shortest_edge_allowed(figures, has_lesions);
}

void require_canonical_figures(const core::TetraMesh &mesh, int target, bool tumours) {
    const auto figures = mesh_figures(mesh);
    const double shortest = shortest_edge_allowed(figures, tumours);
    if (std::abs(figures.num_tetrahedra - target) > 0.005 * target ||
        figures.smallest_quality < smallest_quality_allowed || figures.shortest_edge < shortest ||
        std::abs(figures.volume - 1.5e-3) > 0.03 * 1.5e-3)
        throw std::runtime_error(fmt::format(
            "the generated liver misses what a canonical body must have: {} tetrahedra within 0.5 %, smallest "
            "quality 0.2, shortest edge {:.2f} mm, 1500 mL within 3 %; it has\n{}",
            target, 1e3 * shortest, to_text(figures)));
}

int checked_target(int asked_for, bool has_lesions) {
    const int canonical = has_lesions ? tumour_liver_tetrahedra : healthy_liver_tetrahedra;
    const int target = asked_for == 0 ? canonical : asked_for;
    if (target < smallest_target)
        throw support::InputError(fmt::format("a liver of {} tetrahedra cannot show its anatomy; ask for {} or more",
                                              target, smallest_target));
    if (target > most_tetrahedra)
        throw support::InputError(
            fmt::format("a liver of {} tetrahedra is too large; ask for {:g} or fewer", target, most_tetrahedra));
    return target;
}

void round_points(core::TetraMesh &mesh) {
    for (auto &point : mesh.points)
        for (auto &coordinate : point)
            coordinate = std::round(1e9 * coordinate) / 1e9; // whole nanometres are short in a file
}

void name_regions(core::TetraMesh &mesh, std::size_t num_lesions) {
    mesh.region_names = {"parenchyma"};
    for (std::size_t i = 1; i <= num_lesions; ++i)
        mesh.region_names.push_back(fmt::format("tumour_{}", i));
}

} // namespace

core::TetraMesh generate_liver(const LiverOptions &options) {
    const int target = checked_target(options.target_tetrahedra, options.tumours);
    const Liver liver{{}, liver_bounding_box(), options.tumours ? liver_lesions() : std::vector<Lesion>()};
    core::TetraMesh mesh = search_for_count(liver, target, [](const core::TetraMesh &) { return true; });
    round_points(mesh);
    name_regions(mesh, liver.lesions.size());
    assign_liver_patches(mesh);
    if (target == (options.tumours ? tumour_liver_tetrahedra : healthy_liver_tetrahedra))
        require_canonical_figures(mesh, target, options.tumours);
    return mesh;
}

core::TetraMesh generate_liver(const LiverVariant &variant, int target_tetrahedra) {
    const bool has_lesions = !variant.lesions.empty();
    const int target = checked_target(target_tetrahedra, has_lesions);
    const Liver liver{variant.shape, liver_bounding_box(variant.shape), variant.lesions,
                      cube_root(variant.volume / 1.5e-3)};
    core::TetraMesh mesh =
        search_for_count(liver, target, [&](const core::TetraMesh &tried) { return has_quality(tried, has_lesions); });
    name_regions(mesh, variant.lesions.size());
    assign_liver_patches(mesh, variant.shape);
    // Flat facets cut off a little of a convex body.
    const double scale = cube_root(variant.volume / mesh_figures(mesh).volume);
    for (auto &point : mesh.points)
        point *= scale;
    round_points(mesh);
    if (target >= healthy_liver_tetrahedra && !has_quality(mesh, has_lesions))
        throw std::runtime_error(fmt::format("the generated variant {} of the liver misses the quality of a liver that "
                                             "ships; ask for another number of tetrahedra; it has\n{}",
                                             variant.number, to_text(mesh_figures(mesh))));
    return mesh;
}

} // namespace livermark::meshes
