#include "core/mesh/overlaps.hpp"

#include <algorithm>
#include <numeric>
#include <vector>

#include "core/mesh/bounding_box.hpp"

namespace livermark::core {

std::optional<std::pair<int, int>> nodes_in_one_place(std::span<const Vector3> points,
                                                      const std::function<bool(int, int)> &is_meant) {
    if (points.empty())
        return std::nullopt;
    const double tolerance = 1e-9 * extent(points);
    std::vector<int> order(points.size());
    std::iota(order.begin(), order.end(), 0);
    std::ranges::sort(order, {}, [&](int node) { return std::pair(points[node].x(), node); });
    for (std::size_t a = 0; a < order.size(); ++a)
        for (std::size_t b = a + 1; b < order.size(); ++b) {
            const Vector3 apart = points[order[b]] - points[order[a]];
            if (apart.x() > tolerance)
                break;
            if (apart.norm() <= tolerance && !(is_meant && is_meant(order[a], order[b])))
                return std::pair(order[a], order[b]);
        }
    return std::nullopt;
}

std::optional<std::pair<int, int>> tetrahedra_of_same_nodes(std::span<const std::array<int, 4>> tetrahedra) {
    std::vector<std::pair<std::array<int, 4>, int>> sorted; // nodes ascending, and the tetrahedron
    sorted.reserve(tetrahedra.size());
    for (std::size_t t = 0; t < tetrahedra.size(); ++t) {
        sorted.emplace_back(tetrahedra[t], static_cast<int>(t));
        std::ranges::sort(sorted.back().first);
    }
    std::ranges::sort(sorted);
    std::optional<std::pair<int, int>> two;
    for (std::size_t k = 1; k < sorted.size(); ++k) {
        const bool is_second =
            sorted[k].first == sorted[k - 1].first && (k == 1 || sorted[k].first != sorted[k - 2].first);
        if (is_second && (!two || sorted[k].second < two->second))
            two.emplace(sorted[k - 1].second, sorted[k].second);
    }
    return two;
}

} // namespace livermark::core
