#include "meshes/segmentation/surfaces/surface_file.hpp"

#include <CGAL/AABB_face_graph_triangle_primitive.h>
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/IO/OBJ.h>
#include <CGAL/IO/OFF.h>
#include <CGAL/IO/PLY.h>
#include <CGAL/IO/STL.h>
#include <CGAL/IO/polygon_soup_io.h>
#include <CGAL/Polygon_mesh_processing/connected_components.h>
#include <CGAL/Side_of_triangle_mesh.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <fstream>
#include <iterator>
#include <map>
#include <numeric>
#include <optional>
#include <sstream>
#include <string_view>
#include <utility>

#include "core/mesh/tetra_mesh.hpp"
#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "core/support/processes/child_process.hpp"
#include "core/support/processes/own_process.hpp"
#include "meshes/io/mesh_files.hpp"
#include "meshes/segmentation/surfaces/surface_repair.hpp"

namespace livermark::segmentation {

namespace {

namespace fs = std::filesystem;
using support::InputError;

/// Whether an STL file is text with keywords that are not in lower case. Binary files may begin with the same word.
bool has_capitals(const std::string &text) {
    constexpr std::string_view first = "solid", second = "facet";
    constexpr std::size_t looked_at = 1000;
    const auto begin = text.find_first_not_of(" \t\r\n");
    if (begin == std::string::npos || support::lower_case(text.substr(begin, first.size())) != first)
        return false;
    const auto head = text.substr(begin, looked_at);
    return head.find('\0') == std::string::npos && head.find(second) == std::string::npos &&
           support::lower_case(head).find(second) != std::string::npos;
}

/// Without lines ("l 1 2") and points ("p 1").
std::string only_faces(const std::string &text, std::size_t &num_left_out) {
    std::string faces;
    for (std::size_t begin = 0; begin < text.size();) {
        const auto end = text.find('\n', begin);
        const auto next = end == std::string::npos ? text.size() : end + 1;
        const auto word = text.find_first_not_of(" \t", begin);
        const bool is_other = word != std::string::npos && word + 1 < next &&
                              (text[word] == 'l' || text[word] == 'p') &&
                              (text[word + 1] == ' ' || text[word + 1] == '\t');
        if (is_other)
            ++num_left_out;
        else
            faces.append(text, begin, next - begin);
        begin = next;
    }
    return faces;
}

/// Text of a surface file for a reader that takes its format strictly.
struct PlainSurfaceText {
    std::optional<std::string> text; ///< nothing if the file can be read as it is
    std::size_t num_left_out = 0;    ///< lines and points of an OBJ file, which bound nothing
};

/// Takes away what formats allow, or programs write, and readers stumble over: a byte order mark, keywords of an ASCII
/// STL in capitals, and elements of an OBJ that are no faces.
/// @param ending  of the name, in lower case: .stl, .obj, .ply or .off
PlainSurfaceText plain_surface_text(std::string text, const std::string &ending) {
    constexpr std::string_view byte_order_mark = "\xef\xbb\xbf";
    PlainSurfaceText plain;
    if (text.starts_with(byte_order_mark)) {
        text.erase(0, byte_order_mark.size());
        plain.text = text;
    }
    if (ending == ".stl" && has_capitals(text))
        plain.text = support::lower_case(text);
    if (ending == ".obj")
        if (auto faces = only_faces(text, plain.num_left_out); plain.num_left_out > 0)
            plain.text = std::move(faces);
    return plain;
}

constexpr const char *formats = "STL, OBJ, PLY, OFF, VTK or VTP";

/// MSH 1, which meshio does not know.
bool is_first_msh(const fs::path &file) {
    return support::file_ending(file) == ".msh" && meshes::first_bytes(file).starts_with("$NOD");
}

TriangleSoup boundary_of(const fs::path &file, std::vector<std::string> &remarks) {
    const auto mesh = meshes::read_mesh(file, remarks);
    remarks.push_back(fmt::format("{}: the boundary of its tetrahedra is taken", file.string()));
    TriangleSoup soup;
    for (const auto &p : mesh.points)
        soup.points.emplace_back(p.x(), p.y(), p.z());
    for (const auto &[a, b, c] : mesh.boundary_triangles)
        soup.triangles.push_back(
            {static_cast<std::size_t>(a), static_cast<std::size_t>(b), static_cast<std::size_t>(c)});
    return soup;
}

/// Polygons become the triangles that their first corner has with the others.
void cut_polygons(TriangleSoup &soup, const std::string &file, std::vector<std::string> &remarks) {
    std::vector<std::vector<std::size_t>> triangles;
    std::size_t num_cut = 0;
    for (const auto &polygon : soup.triangles) {
        num_cut += polygon.size() > 3 ? 1 : 0;
        for (std::size_t k = 1; k + 1 < polygon.size(); ++k)
            triangles.push_back({polygon[0], polygon[k], polygon[k + 1]});
    }
    if (num_cut > 0)
        remarks.push_back(fmt::format("{}: {} polygons are cut into triangles", file, num_cut));
    soup.triangles = std::move(triangles);
}

/// All of it, with a byte order mark if it has one.
std::string bytes_of(const fs::path &file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

bool read_soup_of_text(const std::string &ending, const std::string &text, TriangleSoup &soup) {
    std::istringstream stream(text);
    if (ending == ".stl")
        return CGAL::IO::read_STL(stream, soup.points, soup.triangles);
    if (ending == ".obj")
        return CGAL::IO::read_OBJ(stream, soup.points, soup.triangles);
    if (ending == ".ply")
        return CGAL::IO::read_PLY(stream, soup.points, soup.triangles);
    return CGAL::IO::read_OFF(stream, soup.points, soup.triangles);
}

TriangleSoup read_plain(const fs::path &file, std::vector<std::string> &remarks) {
    TriangleSoup soup;
    const auto ending = support::file_ending(file);
    const auto plain = plain_surface_text(bytes_of(file), ending);
    if (plain.num_left_out > 0)
        remarks.push_back(
            fmt::format("{}: {} lines and points beside its faces are not used", file.string(), plain.num_left_out));
    const bool is_read = plain.text ? read_soup_of_text(ending, *plain.text, soup)
                                    : CGAL::IO::read_polygon_soup(file.string(), soup.points, soup.triangles);
    if (!is_read || soup.triangles.empty())
        throw InputError("{}: no triangles can be read from it; export the surface as {}", file.string(), formats);
    cut_polygons(soup, file.string(), remarks);
    return soup;
}

/// Format to which a file of another format is converted; nothing if it is read as it is.
std::optional<support::Converted> converted_if_needed(const fs::path &file) {
    if (is_first_msh(file) || meshes::has_surface_ending(file))
        return std::nullopt;
    auto converted = support::convert_by_script(
        "convert_surface", file,
        fmt::format("export the surface as {}, and check that python3-meshio is installed", formats));
    for (auto &remark : converted.remarks)
        remark = fmt::format("{}: {}", file.string(), remark);
    return converted;
}

TriangleSoup read_converted(const fs::path &file, const support::Converted &converted,
                            std::vector<std::string> &remarks) {
    remarks.insert(remarks.end(), converted.remarks.begin(), converted.remarks.end());
    std::istringstream text(converted.text);
    TriangleSoup soup;
    if (!CGAL::IO::read_OFF(text, soup.points, soup.triangles) || soup.triangles.empty())
        throw InputError("{}: no triangles can be read from it; export the surface as {}", file.string(), formats);
    return soup;
}

TriangleSoup read_soup(const fs::path &file, const std::optional<support::Converted> &converted,
                       std::vector<std::string> &remarks) {
    if (converted)
        return read_converted(file, *converted, remarks);
    return meshes::has_surface_ending(file) ? read_plain(file, remarks) : boundary_of(file, remarks);
}

/// Programs write which axes they mean into the first lines, or into field data, which the conversion tells.
void turn_to_lps(TriangleSoup &soup, const fs::path &file, std::vector<std::string> &remarks) {
    const auto axes_remark = fmt::format("{}: SPACE=RAS", file.string());
    const bool is_in_field_data = std::erase(remarks, axes_remark) > 0;
    if (!is_in_field_data && meshes::first_bytes(file).find("SPACE=RAS") == std::string::npos)
        return;
    for (auto &p : soup.points)
        p = Point(-p.x(), -p.y(), p.z());
    remarks.push_back(fmt::format("{}: it says that it is in RAS, and is turned to LPS", file.string()));
}

meshes::SurfaceMesh united(const std::vector<CgalSurface> &parts) {
    meshes::SurfaceMesh mesh;
    for (const auto &part : parts) {
        std::vector<int> number(part.num_vertices());
        for (const auto v : part.vertices()) {
            number[v.idx()] = static_cast<int>(mesh.points.size());
            const auto &p = part.point(v);
            mesh.points.emplace_back(p.x(), p.y(), p.z());
        }
        for (const auto f : part.faces()) {
            std::array<int, 3> triangle{};
            std::size_t corner = 0;
            for (const auto v : vertices_around_face(part.halfedge(f), part))
                triangle.at(corner++) = number[v.idx()];
            mesh.triangles.push_back(triangle);
        }
    }
    return mesh;
}

/// All that is needed of the other process.
struct ReadSurfaces {
    std::vector<meshes::SurfaceMesh> surfaces;
    std::vector<std::string> remarks;
};

std::string packed(const ReadSurfaces &read) {
    support::Packer packer;
    packer.put(read.remarks);
    packer.put(static_cast<int>(read.surfaces.size()));
    for (const auto &surface : read.surfaces) {
        std::vector<std::array<double, 3>> points;
        for (const auto &p : surface.points)
            points.push_back({p.x(), p.y(), p.z()});
        packer.put(points);
        packer.put(surface.triangles);
    }
    return std::move(packer).bytes();
}

ReadSurfaces unpacked_surfaces(const std::string &bytes) {
    support::Unpacker unpacker(bytes);
    ReadSurfaces read;
    unpacker.get(read.remarks);
    int num_surfaces = 0;
    unpacker.get(num_surfaces);
    for (int s = 0; s < num_surfaces; ++s) {
        auto &surface = read.surfaces.emplace_back();
        std::vector<std::array<double, 3>> points;
        unpacker.get(points);
        for (const auto &[x, y, z] : points)
            surface.points.emplace_back(x, y, z);
        unpacker.get(surface.triangles);
    }
    return read;
}

ReadSurfaces read_surfaces_here(const fs::path &file, const std::optional<support::Converted> &converted,
                                bool are_lesions) {
    ReadSurfaces read;
    auto soup = read_soup(file, converted, read.remarks);
    for (const auto &p : soup.points)
        if (!std::isfinite(p.x()) || !std::isfinite(p.y()) || !std::isfinite(p.z()))
            throw InputError("{}: a coordinate is not a finite number; export the surface again", file.string());
    for (const auto &triangle : soup.triangles)
        for (const auto corner : triangle)
            if (corner >= soup.points.size())
                throw InputError("{}: a triangle names corner {} of {}; export the surface again", file.string(),
                                 corner, soup.points.size());
    turn_to_lps(soup, file, read.remarks);
    if (!are_lesions) {
        read.surfaces.push_back(united(closed_parts(std::move(soup), file.string(), read.remarks)));
        return read;
    }
    for (const auto &body : closed_bodies(std::move(soup), file.string(), read.remarks))
        read.surfaces.push_back(united(body));
    return read;
}

std::vector<meshes::SurfaceMesh> read_apart(const fs::path &file, bool are_lesions, std::vector<std::string> &remarks) {
    std::error_code error;
    if (!fs::exists(file, error))
        throw InputError("{}: there is no such file; check the path", file.string());
    support::check_readable(file);
    const auto converted = converted_if_needed(file);
    constexpr double bytes_per_byte = 2000.0; // exact numbers where triangles cut each other
    auto read = unpacked_surfaces(support::in_own_process(file, support::limits_for(file, bytes_per_byte), [&] {
        return packed(read_surfaces_here(file, converted, are_lesions));
    }));
    remarks.insert(remarks.end(), read.remarks.begin(), read.remarks.end());
    return std::move(read.surfaces);
}

} // namespace

meshes::SurfaceMesh read_surface(const fs::path &file, std::vector<std::string> &remarks) {
    return read_apart(file, false, remarks).front();
}

std::vector<meshes::SurfaceMesh> read_lesions(const fs::path &file, std::vector<std::string> &remarks) {
    return read_apart(file, true, remarks);
}

namespace {

using core::Vector3;

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
