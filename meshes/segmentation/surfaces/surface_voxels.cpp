#include "meshes/segmentation/surfaces/surface_voxels.hpp"

#include <CGAL/AABB_face_graph_triangle_primitive.h>
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/Polygon_mesh_processing/connected_components.h>
#include <CGAL/Side_of_triangle_mesh.h>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <map>
#include <numeric>
#include <optional>

#include "core/mesh/tetra_mesh.hpp"
#include "core/support/input_error.hpp"
#include "meshes/segmentation/surfaces/surface_repair.hpp"

namespace livermark::segmentation {

namespace {

using core::Vector3;
using support::InputError;

CgalSurface to_cgal(const meshes::SurfaceMesh &mesh) {
    CgalSurface surface;
    std::vector<CgalSurface::Vertex_index> vertices;
    for (const auto &p : mesh.points)
        vertices.push_back(surface.add_vertex(Point(p.x(), p.y(), p.z())));
    for (const auto &t : mesh.triangles)
        surface.add_face(vertices[static_cast<std::size_t>(t[0])], vertices[static_cast<std::size_t>(t[1])],
                         vertices[static_cast<std::size_t>(t[2])]);
    return surface;
}

using Tree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, CGAL::AABB_face_graph_triangle_primitive<CgalSurface>>>;

/// Places where a row of voxels, which starts outside, meets a surface.
/// @return x in ascending order [m]; nothing if the row meets an edge or lies in a triangle, so that counting fails
std::optional<std::vector<double>> crossings(const Tree &tree, const Kernel::Segment_3 &row) {
    constexpr double too_close = 1e-9; // [m]
    std::vector<Tree::Intersection_and_primitive_id<Kernel::Segment_3>::Type> hits;
    tree.all_intersections(row, std::back_inserter(hits));
    std::vector<double> places;
    for (const auto &hit : hits) {
        const auto *point = boost::get<Point>(&hit.first);
        if (!point)
            return {};
        places.push_back(point->x());
    }
    std::ranges::sort(places);
    const auto meets_edge = std::ranges::adjacent_find(places, [](double a, double b) { return b - a < too_close; });
    if (places.size() % 2 != 0 || meets_edge != places.end())
        return {};
    return places;
}

/// Number of voxels that a lesion took from each region before it.
using Taken = std::map<std::uint8_t, std::size_t>;

/// Gives a region to the voxels inside a surface of one part, of lesions within the liver.
/// @return how many
std::size_t fill(const CgalSurface &surface, std::uint8_t region, Segmentation &into, Taken &taken) {
    const Tree tree(faces(surface).first, faces(surface).second, surface);
    const CGAL::Side_of_triangle_mesh<CgalSurface, Kernel> side(tree);
    const auto &grid = into.grid;
    const auto place = [&](int i, int j, int k) {
        const auto p = to_world(grid, Vector3(i, j, k).cwiseProduct(grid.spacing));
        return Point(p.x(), p.y(), p.z());
    };
    // A lesion may reach beyond the box around the liver, and a row has to start outside of it all the same.
    const double margin = grid.spacing.x();
    const double first = std::min(place(0, 0, 0).x(), tree.bbox().xmin() - margin);
    const double last = std::max(place(grid.size[0] - 1, 0, 0).x(), tree.bbox().xmax() + margin);
    std::size_t voxel = 0, num_filled = 0;
    for (int k = 0; k < grid.size[2]; ++k)
        for (int j = 0; j < grid.size[1]; ++j) {
            const auto row = place(0, j, k);
            const auto changes = crossings(tree, {Point(first, row.y(), row.z()), Point(last, row.y(), row.z())});
            for (int i = 0; i < grid.size[0]; ++i, ++voxel) {
                const auto centre = place(i, j, k);
                const bool is_inside =
                    changes ? (std::ranges::lower_bound(*changes, centre.x()) - changes->begin()) % 2 != 0
                            : side(centre) == CGAL::ON_BOUNDED_SIDE;
                auto &known = into.region[voxel];
                if (is_inside && (region == 1 || known != 0)) {
                    if (known > 1 && known != region)
                        ++taken[known];
                    known = region;
                    ++num_filled;
                }
            }
        }
    return num_filled;
}

/// The liver, then lesions from the largest to the smallest.
std::vector<std::size_t> order_of(const std::vector<meshes::SurfaceMesh> &surfaces) {
    std::vector<double> volume;
    for (const auto &surface : surfaces)
        volume.push_back(meshes::enclosed_volume(surface));
    std::vector<std::size_t> order(surfaces.size());
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin() + 1, order.end(),
                     [&](std::size_t a, std::size_t b) { return volume[a] > volume[b]; });
    return order;
}

/// The part of a lesion outside the liver is left out.
void tell_of_outside(std::size_t surface, double volume, double inside, std::vector<std::string> &remarks) {
    constexpr double most = 0.02; // of the lesion: voxels are no finer
    if (volume - inside > most * volume)
        remarks.push_back(fmt::format("tumour_{}: {:.3g} mL, {:.0f} % of it, are outside the liver and are left out",
                                      surface, 1e6 * (volume - inside), 100.0 * (volume - inside) / volume));
}

} // namespace

Segmentation voxels_within(const std::vector<meshes::SurfaceMesh> &surfaces, double spacing) {
    const auto box = core::bounding_box(surfaces.front().points);
    const auto &low = box.min(), &high = box.max();
    constexpr double margin = 3.5; // voxels; a half, so that corners on round numbers are on no voxel's centre
    Segmentation result{
        .grid = {.spacing = Vector3::Constant(spacing)}, .region = {}, .region_names = {"parenchyma"}, .remarks = {}};
    constexpr std::size_t most_lesions = 254;
    if (surfaces.size() > most_lesions + 1)
        throw InputError("there are {} lesions, and a body can have {}; leave out the smallest", surfaces.size() - 1,
                         most_lesions);
    constexpr double most_voxels = 1 << 28;
    if (const double wanted = ((high - low) / spacing).prod(); !(wanted < most_voxels))
        throw InputError("the first surface fills so little of the box around it that {:.2g} voxels would be needed; "
                         "is it the liver's?",
                         wanted);
    result.grid.origin = low.array() - margin * spacing;
    for (int d = 0; d < 3; ++d)
        result.grid.size[static_cast<std::size_t>(d)] =
            static_cast<int>(std::ceil((high[d] - low[d]) / spacing + 2.0 * margin)) + 1;
    result.region.assign(num_voxels(result.grid), 0);
    for (std::size_t s = 1; s < surfaces.size(); ++s)
        result.region_names.push_back(fmt::format("tumour_{}", s));
    for (const std::size_t s : order_of(surfaces)) {
        std::vector<CgalSurface> parts;
        CGAL::Polygon_mesh_processing::split_connected_components(to_cgal(surfaces[s]), parts);
        std::size_t num_filled = 0;
        Taken taken;
        for (const auto &part : parts)
            num_filled += fill(part, static_cast<std::uint8_t>(s + 1), result, taken);
        for (const auto &[region, count] : taken)
            result.remarks.push_back(fmt::format("tumour_{0} and tumour_{1} share {2:.3g} mL, which count as "
                                                 "tumour_{1}, the smaller one",
                                                 region - 1, s,
                                                 1e6 * static_cast<double>(count) * voxel_volume(result.grid)));
        if (s > 0)
            tell_of_outside(s, meshes::enclosed_volume(surfaces[s]),
                            static_cast<double>(num_filled) * voxel_volume(result.grid), result.remarks);
        if (num_filled == 0)
            throw InputError("surface {} of {} contains no part of the liver, which is the first; are both in the same "
                             "coordinates, and is it larger than {:.2g} mm?",
                             s + 1, surfaces.size(), 1e3 * spacing);
    }
    const auto volumes = region_volumes(result);
    for (std::size_t r = 0; r < volumes.size(); ++r)
        if (volumes[r] == 0.0)
            throw InputError(r == 0 ? "the lesions fill all of the liver, which is the first surface; give the liver's "
                                      "first, then those of lesions"
                                    : fmt::format("all of surface {} of {} is in lesions that are smaller, or it is "
                                                  "there twice; leave it out",
                                                  r + 1, volumes.size()));
    return result;
}

} // namespace livermark::segmentation
