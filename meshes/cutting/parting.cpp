#include "meshes/cutting/parting.hpp"

#include <algorithm>
#include <map>

#include "core/mesh/neighbours.hpp"
#include "meshes/cutting/clean_up.hpp"
#include "meshes/cutting/tool_geometry.hpp"

namespace livermark::meshes {

namespace {

using core::Vector3;

Vector3 middle_of(const core::TetraMesh &mesh, std::size_t t) {
    const auto &[a, b, c, d] = mesh.tetrahedra[t];
    return 0.25 * (mesh.points[a] + mesh.points[b] + mesh.points[c] + mesh.points[d]);
}

/// Asks for every face inside of a mesh, once, and marks it from both sides.
template <class Ask> Faces faces_where(const core::TetraMesh &mesh, const Ask &ask) {
    const auto neighbours = core::face_neighbours(mesh.tetrahedra);
    Faces faces(mesh.tetrahedra.size(), {false, false, false, false});
    for (std::size_t t = 0; t < faces.size(); ++t)
        for (std::size_t k = 0; k < 4; ++k)
            if (const int other = neighbours[t][k]; other > static_cast<int>(t) && ask(t, k, std::size_t(other))) {
                faces[t][k] = true;
                const auto back = std::ranges::find(neighbours[other], static_cast<int>(t));
                faces[other][back - neighbours[other].begin()] = true;
            }
    return faces;
}

/// A tetrahedron most of whose faces are parted goes to the other side: then the others of its faces are.
void smooth(Faces &faces, const std::vector<std::array<int, 4>> &neighbours) {
    for (bool has_changed = true; has_changed;) { // each change leaves fewer parted faces
        has_changed = false;
        for (std::size_t t = 0; t < faces.size(); ++t) {
            int num_inside = 0, num_parted = 0;
            for (std::size_t k = 0; k < 4; ++k) {
                num_inside += neighbours[t][k] >= 0;
                num_parted += faces[t][k];
            }
            if (2 * num_parted <= num_inside)
                continue;
            has_changed = true;
            for (std::size_t k = 0; k < 4; ++k)
                if (const int other = neighbours[t][k]; other >= 0) {
                    const auto back = std::ranges::find(neighbours[other], static_cast<int>(t));
                    faces[t][k] = !faces[t][k];
                    faces[other][back - neighbours[other].begin()] = faces[t][k];
                }
        }
    }
}

/// Gives the tetrahedra around a node that other faces do not join to the first one a node of their own.
void double_node(int node, std::span<const int> star, const core::TetraMesh &mesh, const Faces &faces,
                 const std::vector<std::array<int, 4>> &neighbours, PartedMesh &parted) {
    const auto groups =
        groups_at_node(node, star, mesh.tetrahedra, neighbours, [&](int t, std::size_t k) { return !faces[t][k]; });
    for (std::size_t group = 1; group < groups.size(); ++group) {
        const int copy = static_cast<int>(parted.points.size());
        parted.points.push_back(mesh.points[node]);
        parted.parent_node.push_back(node);
        for (const int t : groups[group])
            std::ranges::replace(parted.tetrahedra[t], node, copy);
    }
}

PartedMesh part_once(const core::TetraMesh &mesh, const Faces &faces,
                     const std::vector<std::array<int, 4>> &neighbours) {
    PartedMesh parted{mesh.points, mesh.tetrahedra, {}, 0};
    for (int node = 0; node < mesh.num_nodes(); ++node)
        parted.parent_node.push_back(node);
    std::vector<bool> is_at_cut(mesh.points.size(), false);
    for (std::size_t t = 0; t < faces.size(); ++t)
        for (std::size_t k = 0; k < 4; ++k)
            if (faces[t][k])
                for (const int corner : core::tetrahedron_faces[k])
                    is_at_cut[mesh.tetrahedra[t][corner]] = true;
    const auto stars = core::tetrahedra_at_nodes(mesh);
    for (int node = 0; node < mesh.num_nodes(); ++node)
        if (is_at_cut[node])
            double_node(node, stars[node], mesh, faces, neighbours, parted);
    return parted;
}

} // namespace

Faces faces_across(const BladeCut &blade, const core::TetraMesh &mesh) {
    // A centroid on the blade is on one side of it, for all faces of its tetrahedron.
    auto faces = faces_where(mesh, [&](std::size_t t, std::size_t, std::size_t other) {
        const Vector3 one = middle_of(mesh, t), next = middle_of(mesh, other);
        return crossing_of(blade, one, next) && is_above(blade, one) != is_above(blade, next);
    });
    smooth(faces, core::face_neighbours(mesh.tetrahedra));
    return faces;
}

Faces faces_on(const BladeCut &blade, const core::TetraMesh &mesh, const std::vector<bool> &is_on_cut) {
    return faces_where(mesh, [&](std::size_t t, std::size_t k, std::size_t other) {
        return std::ranges::all_of(core::tetrahedron_faces[k],
                                   [&](int corner) { return is_on_cut[mesh.tetrahedra[t][corner]]; }) &&
               is_above(blade, middle_of(mesh, t)) != is_above(blade, middle_of(mesh, other));
    });
}

PartedMesh part_along(const core::TetraMesh &mesh, Faces faces) {
    const auto neighbours = core::face_neighbours(mesh.tetrahedra);
    while (true) {
        auto parted = part_once(mesh, faces, neighbours);
        const auto after = core::face_neighbours(parted.tetrahedra);
        Faces is_wound(faces.size(), {false, false, false, false});
        for (std::size_t t = 0; t < faces.size(); ++t)
            for (std::size_t k = 0; k < 4; ++k) {
                is_wound[t][k] = after[t][k] < 0 && neighbours[t][k] >= 0;
                parted.num_faces += is_wound[t][k] && neighbours[t][k] > static_cast<int>(t);
            }
        std::vector<bool> is_pinched(mesh.points.size(), false);
        std::vector<int> all(faces.size());
        for (std::size_t t = 0; t < all.size(); ++t)
            all[t] = static_cast<int>(t);
        const auto pinched = pinched_nodes(all, parted.tetrahedra, after, is_wound);
        if (pinched.empty())
            return parted;
        for (const int node : pinched)
            is_pinched[parted.parent_node[node]] = true;
        bool has_changed = false;
        for (std::size_t t = 0; t < faces.size(); ++t)
            for (std::size_t k = 0; k < 4; ++k)
                if (faces[t][k] && std::ranges::any_of(core::tetrahedron_faces[k], [&](int corner) {
                        return is_pinched[mesh.tetrahedra[t][corner]];
                    })) {
                    faces[t][k] = false;
                    has_changed = true;
                }
        if (!has_changed) // the body itself was no manifold there
            return parted;
    }
}

} // namespace livermark::meshes
