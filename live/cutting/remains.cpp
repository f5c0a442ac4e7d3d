#include "live/cutting/remains.hpp"

#include <algorithm>
#include <map>

#include "core/mesh/tetra_mesh.hpp"
#include "meshes/cutting/cut.hpp"

namespace livermark::live {

namespace {

using FaceKey = std::array<int, 3>;

/// Of the faces on the boundary of a mesh: which boundary triangle each is.
std::map<FaceKey, int> numbers_of_facets(const core::TetraMesh &mesh) {
    std::map<FaceKey, int> numbers;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f) {
        numbers[core::face_key(mesh.boundary_triangles[f])] = f;
    }
    return numbers;
}

} // namespace

Remains remains_of(const core::TetraMesh &whole, const std::vector<char> &is_gone) {
    Remains left;
    auto &mesh = left.mesh;
    mesh.points = whole.points;
    mesh.region_names = whole.region_names;
    mesh.patch_names = whole.patch_names;
    const auto wound = std::ranges::find(mesh.patch_names, meshes::wound_patch) - mesh.patch_names.begin();
    if (wound == std::ssize(mesh.patch_names))
        mesh.patch_names.emplace_back(meshes::wound_patch);
    for (std::size_t t = 0; t < whole.tetrahedra.size(); ++t)
        if (is_gone[t] == 0) {
            left.tetrahedron.push_back(static_cast<int>(t));
            mesh.tetrahedra.push_back(whole.tetrahedra[t]);
            mesh.region.push_back(whole.region[t]);
        }
    const auto number_of_facet = numbers_of_facets(whole);
    const auto neighbours = core::face_neighbours(mesh.tetrahedra);
    std::vector<char> is_left(whole.boundary_triangles.size(), 0);
    std::vector<std::array<int, 3>> in_wound;
    for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t)
        for (std::size_t k = 0; k < 4; ++k) {
            if (neighbours[t][k] >= 0)
                continue;
            const auto &nodes = mesh.tetrahedra[t];
            if (const auto found = number_of_facet.find(core::face_key(nodes, k)); found != number_of_facet.end()) {
                is_left[found->second] = 1;
                continue;
            }
            const auto &[a, b, c] = core::tetrahedron_faces[k];
            in_wound.push_back({nodes[a], nodes[b], nodes[c]});
        }
    for (int f = 0; f < whole.num_boundary_triangles(); ++f)
        if (is_left[f] != 0) {
            left.facet.push_back(f);
            mesh.boundary_triangles.push_back(whole.boundary_triangles[f]);
            mesh.boundary_patch.push_back(whole.boundary_patch[f]);
        }
    for (const auto &triangle : in_wound) {
        left.facet.push_back(-1);
        mesh.boundary_triangles.push_back(triangle);
        mesh.boundary_patch.push_back(static_cast<int>(wound));
    }
    return left;
}

std::vector<bool> constrained_remains(const Remains &remains, const std::vector<bool> &is_constrained) {
    std::vector<bool> constrained;
    for (const int facet : remains.facet)
        constrained.push_back(facet >= 0 && is_constrained[facet]);
    return constrained;
}

double wound_area(const Remains &remains) {
    double area = 0.0;
    for (std::size_t f = 0; f < remains.facet.size(); ++f)
        if (remains.facet[f] < 0)
            area += core::area_vector(remains.mesh, static_cast<int>(f)).norm();
    return area;
}

} // namespace livermark::live
