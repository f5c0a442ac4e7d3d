#include "msm/spring_law.hpp"

namespace livermark::msm::spring_curves {

namespace {

double inverse_cube(double stretch) {
    return 1.0 / (stretch * stretch * stretch);
}

} // namespace

/// force = (s - s^-4) / 5. Springs that point in all directions alike, with sum k l0^2 = 15 mu V, then have exactly
///     W = mu / 2 (I1 - 3) + mu (1 / J - 1),
/// a neo-Hookean material with lambda = mu: over all unit vectors n the mean of s^2 = |F n|^2 is I1 / 3, and that of
/// |F n|^-3 is 1 / J, because a sphere and its image have the same solid angle.
SpringCurve neo_hookean() {
    return {.name = {},
            .summary = "force (s - s^-4) / 5 at the stretch s, which in all directions together is a neo-Hookean "
                       "material",
            .source = "Livermark",
            .curve = {
                // (s^2 - 1) / 10 + (s^-3 - 1) / 15, without what would cancel near rest.
                .energy =
                    [](double stretch) {
                        const double elongation = stretch - 1.0;
                        const double polynomial = ((3.0 * stretch + 6.0) * stretch + 4.0) * stretch + 2.0;
                        return elongation * elongation * polynomial * inverse_cube(stretch) / 30.0;
                    },
                .force = [](double stretch) { return 0.2 * (stretch - inverse_cube(stretch) / stretch); },
                .slope = [](double stretch) { return 0.2 + 0.8 * inverse_cube(stretch) / (stretch * stretch); },
            }};
}

} // namespace livermark::msm::spring_curves
