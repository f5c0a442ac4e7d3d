#include "segmentation/surface_file.hpp"

#include <CGAL/AABB_face_graph_triangle_primitive.h>
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/IO/polygon_soup_io.h>
#include <CGAL/Polygon_mesh_processing/measure.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/orientation.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/repair_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Side_of_triangle_mesh.h>
#include <CGAL/Surface_mesh.h>
#include <cmath>
#include <fmt/format.h>
#include <optional>
#include <unistd.h>

#include "core/bounding_box.hpp"
#include "support/input_error.hpp"

namespace livermark::segmentation {

namespace {

using core::Vector3;
using support::InputError;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Surface = CGAL::Surface_mesh<Point>;
namespace pmp = CGAL::Polygon_mesh_processing;

std::string text_of(const Point &p) {
    return fmt::format("({:.6g}, {:.6g}, {:.6g})", p.x(), p.y(), p.z());
}

Point corner(const Surface &surface, Surface::Face_index face) {
    return surface.point(target(halfedge(face, surface), surface));
}

Surface read_closed_surface(const std::filesystem::path &path) {
    const auto file = path.string();
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error))
        throw InputError(fmt::format("{}: there is no such file; check the path", file));
    if (access(file.c_str(), R_OK) != 0)
        throw InputError(fmt::format("{}: cannot be read; see who may read it", file));
    std::vector<Point> points;
    std::vector<std::vector<std::size_t>> polygons;
    if (!CGAL::IO::read_polygon_soup(file, points, polygons) || polygons.empty())
        throw InputError(
            fmt::format("{}: no triangles can be read from it; export the surface as STL, OBJ or PLY", file));
    for (const auto &p : points)
        if (!std::isfinite(p.x()) || !std::isfinite(p.y()) || !std::isfinite(p.z()))
            throw InputError(fmt::format("{}: a coordinate is no finite number; export the surface again", file));
    for (const auto &polygon : polygons)
        if (polygon.size() != 3)
            throw InputError(fmt::format("{}: a face has {} corners; export triangles", file, polygon.size()));
    pmp::repair_polygon_soup(points, polygons);
    if (!pmp::orient_polygon_soup(points, polygons))
        throw InputError(
            fmt::format("{}: three or more triangles meet in an edge or parts touch in a point, so inside "
                        "and outside are not clear; repair the surface, as with 3D Slicer's Surface Toolbox",
                        file));
    Surface surface;
    pmp::polygon_soup_to_polygon_mesh(points, polygons, surface);
    for (const auto edge : surface.halfedges())
        if (surface.is_border(edge))
            throw InputError(fmt::format("{}: the surface is open at {}; fill its holes, as with 3D Slicer's Surface "
                                         "Toolbox",
                                         file, text_of(surface.point(surface.target(edge)))));
    std::vector<std::pair<Surface::Face_index, Surface::Face_index>> pairs;
    pmp::self_intersections(surface, std::back_inserter(pairs));
    if (!pairs.empty())
        throw InputError(
            fmt::format("{}: the surface cuts itself at {}, and in {} pairs of triangles in all; repair it, "
                        "as with 3D Slicer's Surface Toolbox",
                        file, text_of(corner(surface, pairs.front().first)), pairs.size()));
    pmp::orient_to_bound_a_volume(surface);
    return surface;
}

Surface to_cgal(const meshes::SurfaceMesh &mesh) {
    Surface surface;
    std::vector<Surface::Vertex_index> vertices;
    for (const auto &p : mesh.points)
        vertices.push_back(surface.add_vertex(Point(p.x(), p.y(), p.z())));
    for (const auto &t : mesh.triangles)
        surface.add_face(vertices[static_cast<std::size_t>(t[0])], vertices[static_cast<std::size_t>(t[1])],
                         vertices[static_cast<std::size_t>(t[2])]);
    return surface;
}

using Tree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, CGAL::AABB_face_graph_triangle_primitive<Surface>>>;

/// Where a row of voxels, which starts outside, meets a surface.
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

/// Gives a region to the voxels inside a surface.
void fill(const Surface &surface, std::uint8_t region, Segmentation &into) {
    const Tree tree(faces(surface).first, faces(surface).second, surface);
    const CGAL::Side_of_triangle_mesh<Surface, Kernel> side(tree);
    const auto &grid = into.grid;
    const auto place = [&](int i, int j, int k) {
        const auto p = to_world(grid, Vector3(i, j, k).cwiseProduct(grid.spacing));
        return Point(p.x(), p.y(), p.z());
    };
    std::size_t voxel = 0;
    for (int k = 0; k < grid.size[2]; ++k)
        for (int j = 0; j < grid.size[1]; ++j) {
            const auto changes = crossings(tree, {place(0, j, k), place(grid.size[0] - 1, j, k)});
            for (int i = 0; i < grid.size[0]; ++i, ++voxel) {
                const auto centre = place(i, j, k);
                const bool is_inside =
                    changes ? (std::ranges::lower_bound(*changes, centre.x()) - changes->begin()) % 2 != 0
                            : side(centre) == CGAL::ON_BOUNDED_SIDE;
                if (is_inside && (region == 1 || into.region[voxel] != 0))
                    into.region[voxel] = region;
            }
        }
}

} // namespace

meshes::SurfaceMesh read_surface(const std::filesystem::path &file) {
    const auto surface = read_closed_surface(file);
    meshes::SurfaceMesh mesh;
    for (const auto v : surface.vertices()) {
        const auto &p = surface.point(v);
        mesh.points.emplace_back(p.x(), p.y(), p.z());
    }
    for (const auto f : surface.faces()) {
        std::array<int, 3> triangle{};
        std::size_t corner = 0;
        for (const auto v : vertices_around_face(surface.halfedge(f), surface))
            triangle.at(corner++) = static_cast<int>(v.idx());
        mesh.triangles.push_back(triangle);
    }
    return mesh;
}

Segmentation voxels_within(const std::vector<meshes::SurfaceMesh> &surfaces, double spacing) {
    const auto box = core::bounding_box(surfaces.front().points);
    const auto &low = box.min(), &high = box.max();
    constexpr double margin = 3.5; // voxels; a half, so that corners on round numbers are on no voxel's centre
    Segmentation result{
        .grid = {.spacing = Vector3::Constant(spacing)}, .region = {}, .region_names = {"parenchyma"}, .remarks = {}};
    constexpr double most_voxels = 1 << 28;
    if (const double wanted = ((high - low) / spacing).prod(); !(wanted < most_voxels))
        throw InputError(
            fmt::format("the first surface fills so little of the box around it that {:.2g} voxels would be "
                        "needed; is it the liver's?",
                        wanted));
    result.grid.origin = low.array() - margin * spacing;
    for (int d = 0; d < 3; ++d)
        result.grid.size[static_cast<std::size_t>(d)] =
            static_cast<int>(std::ceil((high[d] - low[d]) / spacing + 2.0 * margin)) + 1;
    result.region.assign(num_voxels(result.grid), 0);
    for (std::size_t s = 0; s < surfaces.size(); ++s) {
        if (s > 0)
            result.region_names.push_back(fmt::format("tumour_{}", s));
        fill(to_cgal(surfaces[s]), static_cast<std::uint8_t>(s + 1), result);
    }
    const auto volumes = region_volumes(result);
    for (std::size_t r = 0; r < volumes.size(); ++r)
        if (volumes[r] == 0.0)
            throw InputError(
                fmt::format("surface {} of {} contains no part of the liver, which is the first; are both in the "
                            "same coordinates, and is it larger than {:.2g} mm?",
                            r + 1, volumes.size(), 1e3 * spacing));
    return result;
}

} // namespace livermark::segmentation
