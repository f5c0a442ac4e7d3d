#include "core/mesh/parts_by_faces.hpp"

#include <algorithm>
#include <map>
#include <numeric>

#include "core/mesh/tetra_mesh.hpp"

namespace livermark::core {

std::vector<int> parts_by_faces(std::span<const std::array<int, 4>> tetrahedra,
                                const std::function<bool(int, int)> &are_joined) {
    std::vector<int> parent(tetrahedra.size()); // union-find, with path halving
    std::iota(parent.begin(), parent.end(), 0);
    const auto root_of = [&](int t) {
        while (parent[t] != t)
            t = parent[t] = parent[parent[t]];
        return t;
    };
    std::map<std::array<int, 3>, int> owner;
    for (int t = 0; t < static_cast<int>(tetrahedra.size()); ++t)
        for (const auto &[a, b, c] : tetrahedron_faces) {
            std::array face{tetrahedra[t][a], tetrahedra[t][b], tetrahedra[t][c]};
            std::ranges::sort(face);
            const auto [first, is_new] = owner.emplace(face, t);
            if (!is_new && (!are_joined || are_joined(first->second, t)))
                parent[root_of(first->second)] = root_of(t);
        }
    std::vector<int> part(tetrahedra.size()), number(tetrahedra.size(), -1);
    int num_parts = 0;
    for (int t = 0; t < static_cast<int>(tetrahedra.size()); ++t) {
        int &of_root = number[root_of(t)];
        if (of_root < 0)
            of_root = num_parts++;
        part[t] = of_root;
    }
    return part;
}

} // namespace livermark::core
