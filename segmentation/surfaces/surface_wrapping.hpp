#pragma once

#include <optional>
#include <string>
#include <vector>

#include "segmentation/surfaces/surface_repair.hpp"

namespace livermark::segmentation {

/// Why a surface is wrapped.
struct WrapCause {
    bool is_manifold = true; ///< and then open
    double volume = 0.0;     ///< of the largest part as if it were closed, in the unit of the file to the third power
};

/// A closed surface around triangles that leave small holes open or cannot be turned alike, as decimation leaves them
/// (Portaneri et al. 2022, Alpha Wrapping with an Offset, ACM Transactions on Graphics 41(4), by CGAL). Holes up to a
/// radius of 1 % of the diagonal are closed, or of 3 % if the wrap goes in through a hole otherwise: it then has
/// triangles along both sides of the surface, and so a larger area. The offset is 1/20 of the radius.
/// @param file     named in the message
/// @param remarks  gets a sentence with the cause, the size of the holes, and the change of area and volume
/// @return nothing if holes are too large
std::optional<CgalSurface> wrapped(const TriangleSoup &soup, const WrapCause &cause, const std::string &file,
                                   std::vector<std::string> &remarks);

} // namespace livermark::segmentation
