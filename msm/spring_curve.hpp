#pragma once

#include <span>
#include <string>

namespace livermark::msm {

/// Tension of a spring against its stretch s = l / l0, all without units: with k its stiffness at rest, a spring has
/// the energy k l0^2 energy(s) [J], pulls its ends together with k l0 force(s) [N], and gets stiffer by slope(s).
/// energy(1) = force(1) = 0 and slope(1) = 1, and each is the derivative of the one before.
struct ForceCurve {
    double (*energy)(double stretch);
    double (*force)(double stretch);
    double (*slope)(double stretch);
};

/// Forces in proportion to elongations.
inline constexpr ForceCurve hooke{
    .energy = [](double stretch) { return 0.5 * (stretch - 1.0) * (stretch - 1.0); },
    .force = [](double stretch) { return stretch - 1.0; },
    .slope = [](double /*stretch*/) { return 1.0; },
};

/// A curve that all springs of a body have, instead of Hooke's. One file each in spring_curves/, named as the curve.
struct SpringCurve {
    std::string name;    ///< the file stem; set by the table
    std::string summary; ///< half a line
    std::string source;  ///< literature reference
    ForceCurve curve;
};

/// Every curve of spring_curves/, in alphabetical order.
std::span<const SpringCurve> all_spring_curves();

} // namespace livermark::msm
