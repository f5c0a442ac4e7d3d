#include "core/mesh/parts_by_faces.hpp"

#include <numeric>

#include "core/mesh/neighbours.hpp"

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
    const auto faces = sorted_faces(tetrahedra);
    for (std::size_t first = 0, other = 1; other < faces.size(); ++other)
        if (faces[other].nodes != faces[first].nodes)
            first = other;
        else if (!are_joined || are_joined(faces[first].tetrahedron, faces[other].tetrahedron))
            parent[root_of(faces[first].tetrahedron)] = root_of(faces[other].tetrahedron);
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
