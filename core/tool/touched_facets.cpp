#include "core/tool/touched_facets.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/tool/round_load.hpp"

namespace livermark::core {

namespace {

constexpr int most_divisions = 8;

double mean_side(const Corners &corners) {
    return ((corners[0] - corners[1]).norm() + (corners[1] - corners[2]).norm() + (corners[2] - corners[0]).norm()) /
           3.0;
}

std::array<int, 3> sorted(std::array<int, 3> nodes) {
    std::ranges::sort(nodes);
    return nodes;
}

/// E / (1 - nu^2) of what is behind each facet, by its nodes in ascending order [Pa].
std::map<std::array<int, 3>, double> moduli_behind_facets(const Body &body) {
    const auto &mesh = body.mesh;
    std::map<std::array<int, 3>, double> moduli;
    for (const auto &facet : mesh.boundary_triangles)
        moduli.emplace(sorted(facet), 0.0);
    for (int t = 0; t < mesh.num_tetrahedra(); ++t)
        for (const auto &face : tetrahedron_faces) {
            const auto &nodes = mesh.tetrahedra[t];
            const auto facet = moduli.find(sorted({nodes[face[0]], nodes[face[1]], nodes[face[2]]}));
            if (facet == moduli.end())
                continue;
            const auto &material = body.materials[mesh.region[t]];
            facet->second = material.young_modulus / (1.0 - material.poisson_ratio * material.poisson_ratio);
        }
    return moduli;
}

} // namespace

std::vector<TouchedFacet> touched_facets(const Body &body, const LoadCase &load_case, double stiffness) {
    const auto moduli = moduli_behind_facets(body);
    std::vector<TouchedFacet> facets;
    for (int f = 0; f < body.mesh.num_boundary_triangles(); ++f)
        if (load_case.may_touch(f)) {
            const auto &nodes = body.mesh.boundary_triangles[f];
            facets.push_back({nodes, area_vector(body.mesh, f).norm(),
                              stiffness * moduli.at(sorted(nodes)) / mean_side(corners_of(body.mesh, f))});
        }
    return facets;
}

int contact_divisions(const Body &body, const LoadCase &load_case) {
    double sum = 0.0;
    int number = 0;
    for (int f = 0; f < body.mesh.num_boundary_triangles(); ++f)
        if (load_case.may_touch(f)) {
            sum += mean_side(corners_of(body.mesh, f));
            ++number;
        }
    const double longest = load_case.contact().value().radius;
    return number == 0 ? 1 : std::clamp(static_cast<int>(std::ceil(sum / number / longest)), 1, most_divisions);
}

} // namespace livermark::core
