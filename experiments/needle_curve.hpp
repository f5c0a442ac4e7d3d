#pragma once

#include <string>
#include <vector>

namespace livermark::experiments {

/// What somebody measured at the handle of a needle on its way in.
struct NeedleCurve {
    std::string source;               ///< of the data: publication, and where the public file is
    std::vector<std::string> unknown; ///< sentences on what the source does not say
    double diameter = 0.0;            ///< of the needle [m]
    std::vector<double> depth, force; ///< (P) points in the order of the file, which may turn back [m], [N]
};

/// The points of a stretch of the way.
struct CurveBin {
    double from = 0.0, to = 0.0;                    ///< [m]
    double mean = 0.0, lowest = 0.0, highest = 0.0; ///< force of the points [N]
};

/// A steel needle of 18 G driven into bovine liver at 3 mm/s, as read off a published figure.
/// @throws support::InputError if the data are not below data_folder(), with where to get them, or are damaged
NeedleCurve read_needle_curve();

/// Whether its data are there.
bool has_needle_curve();

/// Stretches of a width from the surface on, without those that have no point.
/// @param width  [m], > 0
std::vector<CurveBin> binned(const NeedleCurve &curve, double width);

/// The point at which the surface gave way: the highest before the first stretch whose points are all below half of it.
struct MeasuredPuncture {
    double depth = 0.0, force = 0.0;
};
/// @throws support::InputError if there is none
MeasuredPuncture puncture_of(const NeedleCurve &curve, double width);

} // namespace livermark::experiments
