#include "segmentation/surfaces/surface_wrapping.hpp"

#include <CGAL/Polygon_mesh_processing/measure.h>
#include <CGAL/alpha_wrap_3.h>
#include <CGAL/bounding_box.h>
#include <cmath>
#include <fmt/format.h>

namespace livermark::segmentation {

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

} // namespace livermark::segmentation
