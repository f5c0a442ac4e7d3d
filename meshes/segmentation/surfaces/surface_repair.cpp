#include "meshes/segmentation/surfaces/surface_repair.hpp"

#include <CGAL/Dimension.h>
#include <CGAL/Polygon_mesh_processing/connected_components.h>
#include <CGAL/Polygon_mesh_processing/intersection.h>
#include <CGAL/Polygon_mesh_processing/measure.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/orientation.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/repair_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/repair_self_intersections.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Side_of_triangle_mesh.h>
#include <CGAL/alpha_wrap_3.h>
#include <CGAL/bounding_box.h>
#include <CGAL/centroid.h>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/support/input_error.hpp"

namespace livermark::segmentation {

/// Cause for which a surface is wrapped.
struct WrapCause {
    bool is_manifold = true; ///< and then open
    double volume = 0.0;     ///< of the largest part as if it were closed, in the unit of the file to the third power
};

namespace {

namespace pmp = CGAL::Polygon_mesh_processing;

double area_of(const TriangleSoup &soup) {
    double area = 0.0;
    for (const auto &corners : soup.triangles)
        area +=
            std::sqrt(CGAL::squared_area(soup.points[corners[0]], soup.points[corners[1]], soup.points[corners[2]]));
    return area;
}

} // namespace

/// A closed surface around triangles that leave small holes open or cannot be turned alike, as decimation leaves them
/// (Portaneri et al. 2022, Alpha Wrapping with an Offset, ACM Transactions on Graphics 41(4), by CGAL). Holes up to a
/// radius of 1 % of the diagonal are closed, or of 3 % if the wrap goes in through a hole otherwise: it then has
/// triangles along both sides of the surface, and so a larger area. The offset is 1/20 of the radius.
/// @param file     named in the message
/// @param remarks  gets a sentence with the cause, the size of the holes, and the change of area and volume
/// @return nothing if holes are too large
std::optional<CgalSurface> wrapped(const TriangleSoup &soup, const WrapCause &cause, const std::string &file,
                                   std::vector<std::string> &remarks) {
    // Of the radius. A wrap along both sides takes long if it is near, so a rougher one looks first whether it comes to
    // that.
    constexpr double offset = 0.05, rough_offset = 0.25;
    constexpr double most_area = 1.3; // of the triangles: a wrap along both sides has twice as much
    const auto box = CGAL::bounding_box(soup.points.begin(), soup.points.end());
    const double diagonal = std::sqrt(CGAL::squared_distance(box.min(), box.max()));
    for (const double part : {0.01, 0.03}) {
        const auto wrap = [&](double times) {
            CgalSurface surface;
            CGAL::alpha_wrap_3(soup.points, soup.triangles, part * diagonal, times * part * diagonal, surface);
            return surface;
        };
        if (!(pmp::area(wrap(rough_offset)) <= most_area * area_of(soup)))
            continue;
        auto surface = wrap(offset);
        const double area = pmp::area(surface) / area_of(soup);
        if (surface.is_empty() || !(area <= most_area))
            continue;
        remarks.push_back(fmt::format(
            "{}: the surface is {}; CGAL has wrapped it, which closes holes up to {:.2g} in the unit of the file, and "
            "its "
            "area has changed by {:.2g} %, its volume by {:.2g} %",
            file, cause.is_manifold ? "open" : "not manifold: three or more triangles meet in an edge, or parts touch",
            2.0 * part * diagonal, 100.0 * (area - 1.0),
            100.0 * (std::abs(pmp::volume(surface)) / cause.volume - 1.0)));
        return surface;
    }
    return std::nullopt;
}

namespace {

using support::InputError;
using FacePair = std::pair<CgalSurface::Face_index, CgalSurface::Face_index>;

std::string text_of(const Point &p) {
    return fmt::format("({:.6g}, {:.6g}, {:.6g})", p.x(), p.y(), p.z());
}

std::optional<Point> open_place(const CgalSurface &surface) {
    for (const auto edge : surface.halfedges())
        if (surface.is_border(edge))
            return surface.point(surface.target(edge));
    return std::nullopt;
}

double volume_of(const CgalSurface &surface) {
    return std::abs(pmp::volume(surface));
}

std::vector<FacePair> cuts_of(const CgalSurface &surface) {
    std::vector<FacePair> pairs;
    pmp::self_intersections(surface, std::back_inserter(pairs));
    return pairs;
}

Point corner(const CgalSurface &surface, CgalSurface::Face_index face) {
    return surface.point(target(halfedge(face, surface), surface));
}

/// Replaces triangles that cut each other.
void remove_cuts(CgalSurface &part, const std::string &file, std::vector<std::string> &remarks) {
    constexpr double most_change = 0.01; // of the volume: what is repaired is local
    const auto cuts = cuts_of(part);
    if (cuts.empty())
        return;
    const auto place = text_of(corner(part, cuts.front().first));
    auto repaired = part;
    bool is_done = false;
    try {
        is_done = pmp::experimental::remove_self_intersections(repaired);
    } catch (const std::exception &) { // an assertion of CGAL on what it did not expect
        is_done = false;
    }
    repaired.collect_garbage();
    const double change = volume_of(repaired) / volume_of(part) - 1.0;
    if (!is_done || open_place(repaired) || !cuts_of(repaired).empty() || !(std::abs(change) <= most_change))
        throw InputError("{}: the surface cuts itself at {}, and in {} pairs of triangles in all, which CGAL cannot "
                         "repair; repair it, as with 3D Slicer's Surface Toolbox",
                         file, place, cuts.size());
    remarks.push_back(fmt::format("{}: the surface cut itself at {}, and in {} pairs of triangles in all; CGAL has put "
                                  "other triangles there, and the volume has changed by {:.2g} %",
                                  file, place, cuts.size(), 100.0 * change));
    part = std::move(repaired);
}

void look_outwards(CgalSurface &part) {
    if (pmp::volume(part) < 0.0)
        pmp::reverse_face_orientations(part);
}

/// The parts besides the largest that belong to the body; what becomes of the others is counted.
struct OtherParts {
    std::vector<CgalSurface> kept, apart;
    int num_open = 0, num_inside = 0, num_apart = 0;
    double inside_volume = 0.0, apart_volume = 0.0;
};

OtherParts sort_out(std::vector<CgalSurface> parts, const CgalSurface &largest) {
    OtherParts others;
    const CGAL::Side_of_triangle_mesh<CgalSurface, Kernel> side(largest);
    for (auto &part : parts) {
        if (open_place(part)) {
            ++others.num_open;
        } else if (pmp::do_intersect(part, largest)) {
            others.kept.push_back(std::move(part));
        } else if (side(part.point(*part.vertices().begin())) == CGAL::ON_BOUNDED_SIDE) {
            ++others.num_inside;
            others.inside_volume += volume_of(part);
        } else {
            ++others.num_apart;
            others.apart_volume += volume_of(part);
            others.apart.push_back(std::move(part));
        }
    }
    return others;
}

void tell(const OtherParts &others, double volume, const std::string &file, std::vector<std::string> &remarks) {
    if (others.num_open > 0)
        remarks.push_back(
            fmt::format("{}: {} open parts besides the largest part are left out", file, others.num_open));
    if (others.num_inside > 0)
        remarks.push_back(fmt::format("{}: {} surfaces inside, of {:.2g} % of the volume in all, become parenchyma",
                                      file, others.num_inside, 100.0 * others.inside_volume / volume));
    if (others.num_apart > 0)
        remarks.push_back(
            fmt::format("{}: {} parts that do not touch the largest one, of {:.2g} % of its volume in all, "
                        "are left out",
                        file, others.num_apart, 100.0 * others.apart_volume / volume));
    if (!others.kept.empty())
        remarks.push_back(
            fmt::format("{}: {} parts that cut the largest one are united with it", file, others.kept.size()));
}

CgalSurface surface_of(TriangleSoup soup, const std::string &file, std::vector<std::string> &remarks) {
    const auto num_points = soup.points.size();
    if (!pmp::orient_polygon_soup(soup.points, soup.triangles))
        remarks.push_back(
            fmt::format("{}: three or more triangles meet in an edge, or parts touch in a point; they are "
                        "taken apart at {} corners",
                        file, soup.points.size() - num_points));
    CgalSurface surface;
    pmp::polygon_soup_to_polygon_mesh(soup.points, soup.triangles, surface);
    return surface;
}

std::vector<CgalSurface> parts_of(const CgalSurface &surface, const std::string &file) {
    std::vector<CgalSurface> parts;
    pmp::split_connected_components(surface, parts);
    if (parts.empty())
        throw InputError("{}: no triangle of it has an area; export the surface again", file);
    return parts;
}

/// Volume of the largest part with what is missing of it left open, which is right where that is small.
double volume_about_middle(const CgalSurface &surface) {
    const auto middle = CGAL::centroid(surface.points().begin(), surface.points().end(), CGAL::Dimension_tag<0>());
    double volume = 0.0;
    for (const auto face : surface.faces()) {
        const auto edge = surface.halfedge(face);
        volume += CGAL::volume(middle, surface.point(surface.source(edge)), surface.point(surface.target(edge)),
                               surface.point(surface.target(surface.next(edge))));
    }
    return std::abs(volume);
}

double area_of_part(const CgalSurface &part) {
    return pmp::area(part);
}

/// Parts of which the largest is closed, as they are or of a wrap.
std::vector<CgalSurface> parts_or_wrap(TriangleSoup soup, const std::string &file, std::vector<std::string> &remarks) {
    pmp::repair_polygon_soup(soup.points, soup.triangles);
    std::vector<std::string> part_remarks;
    auto parts = parts_of(surface_of(soup, file, part_remarks), file);
    if (const auto largest = std::ranges::max_element(parts, {}, area_of_part); open_place(*largest)) {
        const WrapCause cause{.is_manifold = part_remarks.empty(), .volume = volume_about_middle(*largest)};
        if (const auto closed = wrapped(soup, cause, file, part_remarks)) {
            part_remarks = {part_remarks.back()}; // what was taken apart before does not matter any more
            parts = parts_of(*closed, file);
        }
    }
    remarks.insert(remarks.end(), part_remarks.begin(), part_remarks.end());
    return parts;
}

/// Takes the largest part, and those that cut it, out of some parts.
/// @param are_bodies  whether parts apart are bodies of their own, and stay in parts
std::vector<CgalSurface> take_largest(std::vector<CgalSurface> &parts, bool are_bodies, const std::string &file,
                                      std::vector<std::string> &remarks) {
    const auto largest_area = std::ranges::max_element(parts, {}, area_of_part);
    std::vector<CgalSurface> body{*largest_area};
    parts.erase(largest_area);
    if (const auto place = open_place(body.front()))
        throw InputError("{}: the surface is open at {}; fill its holes, as with 3D Slicer's Surface Toolbox", file,
                         text_of(*place));
    look_outwards(body.front());
    remove_cuts(body.front(), file, remarks);
    auto others = sort_out(std::move(parts), body.front());
    parts.clear();
    if (are_bodies) {
        parts = std::move(others.apart);
        others.num_apart = 0;
    }
    tell(others, volume_of(body.front()), file, remarks);
    for (auto &part : others.kept) {
        look_outwards(part);
        remove_cuts(part, file, remarks);
        body.push_back(std::move(part));
    }
    return body;
}

} // namespace

std::vector<CgalSurface> closed_parts(TriangleSoup soup, const std::string &file, std::vector<std::string> &remarks) {
    auto parts = parts_or_wrap(std::move(soup), file, remarks);
    return take_largest(parts, false, file, remarks);
}

std::vector<std::vector<CgalSurface>> closed_bodies(TriangleSoup soup, const std::string &file,
                                                    std::vector<std::string> &remarks) {
    auto parts = parts_or_wrap(std::move(soup), file, remarks);
    std::vector<std::vector<CgalSurface>> bodies;
    while (!parts.empty())
        bodies.push_back(take_largest(parts, true, file, remarks));
    return bodies;
}

} // namespace livermark::segmentation
