#include "core/mesh/neighbours.hpp"

#include <algorithm>

namespace livermark::core {

std::array<int, 3> face_key(std::array<int, 3> nodes) {
    std::ranges::sort(nodes);
    return nodes;
}

std::array<int, 3> face_key(const std::array<int, 4> &tetrahedron, std::size_t face) {
    const auto &[a, b, c] = tetrahedron_faces[face];
    return face_key({tetrahedron[a], tetrahedron[b], tetrahedron[c]});
}

std::vector<TetrahedronFace> sorted_faces(std::span<const std::array<int, 4>> tetrahedra) {
    std::vector<TetrahedronFace> faces;
    faces.reserve(4 * tetrahedra.size());
    for (std::size_t t = 0; t < tetrahedra.size(); ++t)
        for (std::size_t k = 0; k < 4; ++k)
            faces.push_back({face_key(tetrahedra[t], k), static_cast<int>(t), static_cast<int>(k)});
    std::ranges::sort(faces);
    return faces;
}

std::optional<std::array<int, 3>> face_of_too_many(std::span<const TetrahedronFace> sorted) {
    for (std::size_t f = 2; f < sorted.size(); ++f)
        if (sorted[f].nodes == sorted[f - 2].nodes)
            return sorted[f].nodes;
    return std::nullopt;
}

std::vector<std::array<int, 4>> face_neighbours(std::span<const std::array<int, 4>> tetrahedra) {
    const auto faces = sorted_faces(tetrahedra);
    std::vector<std::array<int, 4>> neighbours(tetrahedra.size(), {-1, -1, -1, -1});
    for (std::size_t f = 1; f < faces.size(); ++f)
        if (const auto &one = faces[f - 1], &other = faces[f]; one.nodes == other.nodes) {
            neighbours[one.tetrahedron][one.face] = other.tetrahedron;
            neighbours[other.tetrahedron][other.face] = one.tetrahedron;
        }
    return neighbours;
}

std::vector<std::vector<int>> tetrahedra_at_nodes(const TetraMesh &mesh) {
    std::vector<std::vector<int>> stars(mesh.points.size());
    for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t)
        for (const int node : mesh.tetrahedra[t])
            stars[node].push_back(static_cast<int>(t));
    return stars;
}

} // namespace livermark::core
