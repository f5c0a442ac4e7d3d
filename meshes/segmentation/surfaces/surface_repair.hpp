#pragma once

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>

#include <string>
#include <vector>

/// The surfaces of CGAL, for the sources that work on them.
namespace livermark::segmentation {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using CgalSurface = CGAL::Surface_mesh<Point>;

/// Corners, and for each triangle their numbers.
struct TriangleSoup {
    std::vector<Point> points;
    std::vector<std::vector<std::size_t>> triangles;
};

/// The closed parts of which a body is the union, each with triangles that look outwards and do not cut each other.
/// Whatever else a surface has is left out or repaired, and said:
///   corners in one place become one, triangles without an area go;
///   parts that meet in a point or an edge are taken apart there;
///   the part with the largest area stays, and parts that cut it; other parts are left out, open ones as well, and
///   those inside are cavities; triangles of a part that cut each other are replaced (CGAL's
///   remove_self_intersections), if the volume stays.
/// Triangles whose largest part is open are wrapped as a whole: see wrapped().
/// @param soup     of finite coordinates
/// @param file     named in messages
/// @param remarks  gets a sentence for each change
/// @throws support::InputError with the file, the place and a remedy: the largest part has large holes, or
///         cuts itself and cannot be repaired
std::vector<CgalSurface> closed_parts(TriangleSoup soup, const std::string &file, std::vector<std::string> &remarks);

/// The same of several bodies in one file, the largest first: a part that does not touch those before it begins
/// another.
/// @return for each body its parts
std::vector<std::vector<CgalSurface>> closed_bodies(TriangleSoup soup, const std::string &file,
                                                    std::vector<std::string> &remarks);

} // namespace livermark::segmentation
