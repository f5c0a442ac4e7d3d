#include "core/mesh/facet_points.hpp"

#include <cmath>

namespace livermark::core {

namespace {

std::vector<FacetPoint> radon_points() {
    const double root = std::sqrt(15.0);
    std::vector<FacetPoint> points{{{1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0}, 9.0 / 40.0}};
    for (const double sign : {-1.0, 1.0}) {
        const double small = (6.0 + sign * root) / 21.0, part = (155.0 + sign * root) / 1200.0;
        for (std::size_t corner = 0; corner < 3; ++corner) {
            FacetPoint point{{small, small, small}, part};
            point.shape[corner] = 1.0 - 2.0 * small;
            points.push_back(point);
        }
    }
    return points;
}

} // namespace

std::vector<FacetPoint> facet_points(int divisions) {
    const auto rule = radon_points();
    std::vector<FacetPoint> points;
    points.reserve(rule.size() * static_cast<std::size_t>(divisions) * static_cast<std::size_t>(divisions));
    const double side = 1.0 / divisions;
    // The triangle with its first corner at (i, j) in steps along two sides, or turned around, with that opposite.
    const auto add = [&](int i, int j, double way) {
        for (const auto &point : rule) {
            const double first = side * (i + way * point.shape[0]), second = side * (j + way * point.shape[1]);
            points.push_back({{first, second, 1.0 - first - second}, side * side * point.part});
        }
    };
    for (int i = 0; i < divisions; ++i)
        for (int j = 0; i + j < divisions; ++j) {
            add(i, j, 1.0);
            if (i + j + 1 < divisions)
                add(i + 1, j + 1, -1.0);
        }
    return points;
}

} // namespace livermark::core
