#include "meshes/cutting/articulations.hpp"

#include <algorithm>

namespace livermark::meshes {

namespace {

struct Visit {
    int tetrahedron;
    int parent;
    std::size_t next_face = 0;
};

} // namespace

std::vector<int> articulations(std::span<const int> piece, const std::vector<std::array<int, 4>> &neighbours,
                               const std::vector<bool> &alive) {
    const std::size_t num_all = neighbours.size();
    std::vector<int> order(num_all, -1), lowest(num_all, 0), size_below(num_all, 1);
    std::vector<int> cut_off(num_all, 0);     // tetrahedra in parts below that only this one joins
    std::vector<int> large_parts(num_all, 0); // how many of these parts have more than one
    if (piece.empty())
        return {};
    int count = 0;
    std::vector<Visit> path{{piece.front(), -1}};
    order[piece.front()] = lowest[piece.front()] = count++;
    while (!path.empty()) {
        auto &visit = path.back();
        const int t = visit.tetrahedron;
        if (visit.next_face < 4) {
            const int other = neighbours[t][visit.next_face++];
            if (other < 0 || !alive[other] || other == visit.parent)
                continue;
            if (order[other] >= 0) {
                lowest[t] = std::min(lowest[t], order[other]);
                continue;
            }
            order[other] = lowest[other] = count++;
            path.push_back({other, t}); // `visit` is no longer valid
            continue;
        }
        const int parent = visit.parent;
        path.pop_back();
        if (parent < 0)
            continue;
        lowest[parent] = std::min(lowest[parent], lowest[t]);
        size_below[parent] += size_below[t];
        if (lowest[t] >= order[parent]) {
            cut_off[parent] += size_below[t];
            large_parts[parent] += size_below[t] > 1;
        }
    }
    std::vector<int> found;
    for (const int t : piece) {
        const bool has_large_rest = count - 1 - cut_off[t] > 1;
        if (large_parts[t] + (has_large_rest ? 1 : 0) > 1)
            found.push_back(t);
    }
    return found;
}

} // namespace livermark::meshes
