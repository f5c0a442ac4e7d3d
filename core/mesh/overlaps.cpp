#include "core/mesh/overlaps.hpp"

#include <algorithm>
#include <map>
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
    std::map<std::array<int, 4>, int> first;
    for (std::size_t t = 0; t < tetrahedra.size(); ++t) {
        auto nodes = tetrahedra[t];
        std::ranges::sort(nodes);
        if (const auto [other, is_new] = first.emplace(nodes, static_cast<int>(t)); !is_new)
            return std::pair(other->second, static_cast<int>(t));
    }
    return std::nullopt;
}

std::vector<std::array<int, 3>> sorted_faces(std::span<const std::array<int, 4>> tetrahedra) {
    std::vector<std::array<int, 3>> faces;
    faces.reserve(4 * tetrahedra.size());
    for (const auto &nodes : tetrahedra)
        for (const auto &[a, b, c] : tetrahedron_faces) {
            faces.push_back({nodes[a], nodes[b], nodes[c]});
            std::ranges::sort(faces.back());
        }
    std::ranges::sort(faces);
    return faces;
}

std::optional<std::array<int, 3>> face_of_too_many(std::span<const std::array<int, 3>> sorted) {
    for (std::size_t f = 2; f < sorted.size(); ++f)
        if (sorted[f] == sorted[f - 2])
            return sorted[f];
    return std::nullopt;
}

} // namespace livermark::core
