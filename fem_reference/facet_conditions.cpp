#include "fem_reference/facet_conditions.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/mesh/bounding_box.hpp"

namespace livermark::fem_reference {

namespace {

std::array<int, 3> sorted(std::array<int, 3> corners) {
    std::ranges::sort(corners);
    return corners;
}

/// Numbers the parts of a mesh that share no node.
/// @return shape (N) a node of the part as its name
std::vector<int> parts(const core::TetraMesh &mesh) {
    std::vector<int> parent(mesh.points.size());
    std::iota(parent.begin(), parent.end(), 0);
    const auto root = [&](int node) {
        while (parent[node] != node)
            node = parent[node] = parent[parent[node]];
        return node;
    };
    for (const auto &nodes : mesh.tetrahedra)
        for (const int node : nodes)
            parent[root(node)] = root(nodes[0]);
    for (int node = 0; node < mesh.num_nodes(); ++node)
        parent[node] = root(node);
    return parent;
}

} // namespace

void check_facets(const core::LoadCase &load_case, const core::TetraMesh &mesh) {
    if (load_case.condition_on.size() != mesh.boundary_triangles.size() ||
        load_case.value.size() != mesh.boundary_triangles.size())
        throw std::invalid_argument("load case " + load_case.name +
                                    " was put on another mesh: its number of facets is not " +
                                    std::to_string(mesh.boundary_triangles.size()));
    const auto num_conditions = static_cast<int>(load_case.conditions.size());
    if (std::ranges::any_of(load_case.condition_on, [=](int condition) { return condition >= num_conditions; }))
        throw std::invalid_argument("load case " + load_case.name +
                                    " has facets with a condition that it does not have");
}

void check_outer_faces(const core::TetraMesh &mesh) {
    std::set<std::array<int, 3>> outer;
    for (const auto &face : core::outer_faces(mesh.tetrahedra))
        outer.insert(sorted(face));
    for (std::size_t f = 0; f < mesh.boundary_triangles.size(); ++f)
        if (outer.erase(sorted(mesh.boundary_triangles[f])) == 0)
            throw std::invalid_argument("boundary triangle " + std::to_string(f) +
                                        " is not an outer face of the tetrahedra or is given twice");
}

bool holds_every_part(const core::LoadCase &load_case, const core::TetraMesh &mesh) {
    constexpr double least_hold = 1e-12;
    using Vector6 = Eigen::Matrix<double, 6, 1>;
    using Gram = Eigen::Matrix<double, 6, 6>;
    const auto box = core::bounding_box(mesh.points);
    const auto part = parts(mesh);
    std::map<int, Gram> constrained; // the middles of edges move as the mean of the corners and add nothing
    for (const int name : part)
        constrained.try_emplace(name, Gram::Zero());
    for (int f = 0; f < load_case.num_facets(); ++f) {
        if (!load_case.is_constrained(f))
            continue;
        for (const int node : mesh.boundary_triangles[f])
            for (int i = 0; i < 3; ++i) {
                if (std::isnan(load_case.value[f][i]))
                    continue;
                const core::Vector3 arm = (mesh.points[node] - box.center()) / box.diagonal().norm();
                Vector6 row; // component i of the translations and of the rotations
                row << core::Vector3::Unit(i), arm.cross(core::Vector3::Unit(i));
                constrained[part[node]] += row * row.transpose();
            }
    }
    return std::ranges::all_of(constrained, [](const auto &entry) {
        const auto values = Eigen::SelfAdjointEigenSolver<Gram>(entry.second, Eigen::EigenvaluesOnly).eigenvalues();
        return values[0] > least_hold * values[5];
    });
}

} // namespace livermark::fem_reference
