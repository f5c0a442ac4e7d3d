#pragma once

#include <vector>

#include "core/mesh/places.hpp"
#include "core/tool/needle/needle.hpp"

namespace livermark::core {

/// Places on the axis of a needle, a third of their radius apart or a little less, from the entry on and some beyond
/// the target, which is one of them.
struct NeedleLine {
    std::vector<InteriorPlace> places; ///< (K)
    double spacing = 0.0;              ///< [m]
    int target = 0;                    ///< number of its place
};

/// @param needle  whose target is some way below its entry
NeedleLine needle_line(const Needle &needle);

/// The smallest radius of the places of a needle that points_of() surely finds points for, in the tetrahedra along it
/// [m]: it halves edges six times at most, and the last place may be two thirds of its radius outside the body.
double smallest_spread(const Needle &needle, const TetraMesh &mesh);

/// Length of the shaft that a place stands for: it falls linearly to zero at the places before and behind it [m].
/// @param place  0 ... K - 1
/// @param tip    how much of the tissue's path is behind the tip, measured at rest [m]
double shaft_length(const NeedleLine &line, int place, double tip);

/// The part that the place behind a point of the axis has of it; the next place has the rest.
struct PointOfLine {
    int below = 0;     ///< 0 ... K - 2
    double part = 1.0; ///< of that place, 0 to 1
};

/// @param point  from the entry on, at rest [m]
PointOfLine point_of_line(const NeedleLine &line, double point);

} // namespace livermark::core
