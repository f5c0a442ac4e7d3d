#include "meshes/cutting/face_neighbours.hpp"

#include <algorithm>

namespace livermark::meshes {

std::array<int, 3> face_key(const std::array<int, 4> &tetrahedron, std::size_t face) {
    const auto &[a, b, c] = core::tetrahedron_faces[face];
    std::array key{tetrahedron[a], tetrahedron[b], tetrahedron[c]};
    std::ranges::sort(key);
    return key;
}

std::vector<std::array<int, 4>> face_neighbours(std::span<const std::array<int, 4>> tetrahedra) {
    struct Side {
        std::array<int, 3> key;
        int tetrahedron;
        int face;
    };
    std::vector<Side> sides;
    sides.reserve(4 * tetrahedra.size());
    for (std::size_t t = 0; t < tetrahedra.size(); ++t)
        for (std::size_t k = 0; k < 4; ++k)
            sides.push_back({face_key(tetrahedra[t], k), static_cast<int>(t), static_cast<int>(k)});
    std::ranges::sort(sides, {}, &Side::key);
    std::vector<std::array<int, 4>> neighbours(tetrahedra.size(), {-1, -1, -1, -1});
    for (std::size_t s = 1; s < sides.size(); ++s)
        if (const auto &one = sides[s - 1], &other = sides[s]; one.key == other.key) {
            neighbours[one.tetrahedron][one.face] = other.tetrahedron;
            neighbours[other.tetrahedron][other.face] = one.tetrahedron;
        }
    return neighbours;
}

std::vector<std::vector<int>> tetrahedra_at_nodes(const core::TetraMesh &mesh) {
    std::vector<std::vector<int>> stars(mesh.points.size());
    for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t)
        for (const int node : mesh.tetrahedra[t])
            stars[node].push_back(static_cast<int>(t));
    return stars;
}

} // namespace livermark::meshes
