#include "core/tool/needle/needle_line.hpp"

#include <algorithm>
#include <cmath>

namespace livermark::core {

namespace {

constexpr double spacing_over_radius = 1.0 / 3.0;
/// Beyond the target, so that the tissue before the tip is there; the tip itself never gets there.
constexpr int places_beyond = 2;

} // namespace

NeedleLine needle_line(const Needle &needle) {
    NeedleLine line;
    line.target = std::max(2, static_cast<int>(std::ceil(needle.depth() / (spacing_over_radius * needle.spread))));
    line.spacing = needle.depth() / line.target;
    for (int k = 0; k <= line.target + places_beyond; ++k)
        line.places.push_back({needle.entry + k * line.spacing * needle.direction(), needle.spread});
    return line;
}

double smallest_spread(const Needle &needle, const TetraMesh &mesh) {
    Eigen::AlignedBox3d way(needle.entry);
    way.extend(needle.target);
    way.min().array() -= needle.spread;
    way.max().array() += needle.spread;
    double longest = 0.0;
    for (const auto &nodes : mesh.tetrahedra) {
        Eigen::AlignedBox3d box;
        for (const int node : nodes)
            box.extend(mesh.points[node]);
        if (box.intersects(way))
            for (const auto &[i, j] : tetrahedron_edges)
                longest = std::max(longest, (mesh.points[nodes[i]] - mesh.points[nodes[j]]).norm());
    }
    // A third of the radius is inside, a point of a part is within three quarters of its edge of the centroid, and the
    // parts in the middle of a tetrahedron have edges of up to the root of two times the others.
    return 3.0 * 0.75 * std::sqrt(2.0) * longest / 64.0;
}

double shaft_length(const NeedleLine &line, int place, double tip) {
    const double position = tip / line.spacing - place; // of the tip, from the place on
    const double before = std::clamp(position + 1.0, 0.0, 1.0), behind = std::clamp(position, 0.0, 1.0);
    const bool is_first = place == 0, is_last = place + 1 == static_cast<int>(line.places.size());
    return line.spacing * ((is_first ? 0.0 : 0.5 * before * before) + (is_last ? 0.0 : behind - 0.5 * behind * behind));
}

PointOfLine point_of_line(const NeedleLine &line, double point) {
    const int last = static_cast<int>(line.places.size()) - 1;
    const double position = std::clamp(point / line.spacing, 0.0, static_cast<double>(last));
    const int below = std::min(static_cast<int>(position), last - 1);
    return {below, 1.0 - (position - below)};
}

} // namespace livermark::core
