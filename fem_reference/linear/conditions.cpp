#include "fem_reference/linear/conditions.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"
#include "fem_reference/solvers/two_level.hpp"

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

namespace {

constexpr double is_free = std::numeric_limits<double>::quiet_NaN();

/// Values at the nodes of the mesh as those of all nodes of the facets, linear along edges.
/// @param at_mesh_nodes  (N), or empty
/// @param elsewhere      at nodes that are on no facet, and everywhere where there are no values
template <class T>
std::vector<T> at_facet_nodes(const std::vector<T> &at_mesh_nodes, const ElasticSystem &system, const T &elsewhere) {
    std::vector<T> values(system.points.size(), elsewhere);
    if (at_mesh_nodes.empty())
        return values;
    for (std::size_t node = 0; node < system.mesh_node.size(); ++node)
        values[system.mesh_node[node]] = at_mesh_nodes[node];
    for (std::size_t first = 0; first < system.facet_nodes.size(); first += system.nodes_per_facet)
        for (int middle = 3; middle < system.nodes_per_facet; ++middle) {
            const int a = system.facet_nodes[first + middle - 3], b = system.facet_nodes[first + (middle - 2) % 3];
            values[system.facet_nodes[first + middle]] = 0.5 * (values[a] + values[b]);
        }
    return values;
}

/// (nodes_per_facet) integrals of the shape functions over a facet, weighted with what a round tool presses [m^2].
std::vector<double> integrals(const core::LoadCase &load_case, int facet, const ElasticSystem &system) {
    const int size = system.nodes_per_facet;
    const auto first = system.facet_integral.begin() + static_cast<std::ptrdiff_t>(facet) * size;
    std::vector<double> integral(first, first + size);
    const auto *load = load_case.round_load_on(facet);
    if (!load)
        return integral;
    const double area = std::accumulate(integral.begin(), integral.end(), 0.0);
    core::Corners corners;
    for (int k = 0; k < 3; ++k)
        corners[k] = system.points[system.facet_nodes[facet * size + k]];
    const auto share = [&](const auto &parts) {
        std::ranges::transform(parts, integral.begin(), [&](double part) { return area * part; });
    };
    size == 3 ? share(core::linear_parts(load, corners)) : share(core::quadratic_parts(load, corners));
    return integral;
}

void add_traction(const core::LoadCase &load_case, int facet, const ElasticSystem &system, std::vector<double> &load) {
    const auto integral = integrals(load_case, facet, system);
    for (int k = 0; k < system.nodes_per_facet; ++k)
        for (int i = 0; i < 3; ++i)
            if (!std::isnan(load_case.value[facet][i]))
                load[3 * system.facet_nodes[facet * system.nodes_per_facet + k] + i] +=
                    load_case.value[facet][i] * integral[k];
}

} // namespace

DofConditions dof_conditions(const core::LoadCase &load_case, const ElasticSystem &system) {
    DofConditions dofs;
    dofs.press_depth = load_case.press_depth;
    dofs.prescribed.assign(3 * system.points.size(), is_free);
    dofs.constraint.assign(3 * system.points.size(), -1);
    dofs.load.reserve(3 * system.points.size());
    for (const double mass : system.mass_integral)
        for (int i = 0; i < 3; ++i)
            dofs.load.push_back(mass * load_case.acceleration[i]);

    const auto factor = at_facet_nodes(load_case.node_factor, system, 1.0);
    const core::Vector3 none = core::Vector3::Zero();
    const auto shift = at_facet_nodes(load_case.node_shift, system, none);
    for (int f = 0; f < load_case.num_facets(); ++f) {
        if (load_case.is_loaded(f))
            add_traction(load_case, f, system, dofs.load);
        for (int k = f * system.nodes_per_facet; k < (f + 1) * system.nodes_per_facet; ++k) {
            for (int i = 0; i < 3; ++i) {
                const double value = load_case.value[f][i];
                const int dof = 3 * system.facet_nodes[k] + i;
                if (std::isnan(value))
                    continue;
                int &owner = dofs.constraint[dof];
                if (load_case.is_constrained(f) && (owner < 0 || load_case.constraint_on(f) < owner)) {
                    owner = load_case.constraint_on(f);
                    dofs.prescribed[dof] = factor[system.facet_nodes[k]] * value + shift[system.facet_nodes[k]][i];
                }
            }
        }
    }
    return dofs;
}

Eigen::SparseMatrix<double, Eigen::RowMajor> place_weights(std::span<const core::InteriorPlace> places,
                                                           const ElasticSystem &system, const core::TetraMesh &mesh) {
    std::vector<Eigen::Triplet<double>> entries;
    for (std::size_t k = 0; k < places.size(); ++k)
        for (const auto &[tetrahedron, barycentric, weight] : core::points_of(places[k], mesh)) {
            const auto shape = shape_functions(barycentric, system.nodes_per_cell);
            for (int a = 0; a < system.nodes_per_cell; ++a)
                entries.emplace_back(static_cast<int>(k), system.cell_nodes[tetrahedron * system.nodes_per_cell + a],
                                     weight * shape[a]);
        }
    Eigen::SparseMatrix<double, Eigen::RowMajor> weights(static_cast<Eigen::Index>(places.size()), system.num_nodes());
    weights.setFromTriplets(entries.begin(), entries.end());
    return weights;
}

namespace {

using NodeRows = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

} // namespace

void add_forces(const Eigen::SparseMatrix<double, Eigen::RowMajor> &weights, const std::vector<core::Vector3> &forces,
                std::vector<double> &load) {
    NodeRows rows(weights.rows(), 3);
    for (Eigen::Index k = 0; k < rows.rows(); ++k)
        rows.row(k) = forces[static_cast<std::size_t>(k)];
    Eigen::Map<NodeRows>(load.data(), weights.cols(), 3) += weights.transpose() * rows;
}

std::vector<core::Vector3> means_at(const Eigen::SparseMatrix<double, Eigen::RowMajor> &weights,
                                    const std::vector<double> &displacement) {
    const NodeRows means = weights * Eigen::Map<const NodeRows>(displacement.data(), weights.cols(), 3);
    std::vector<core::Vector3> found;
    for (const auto &mean : means.rowwise())
        found.emplace_back(mean);
    return found;
}

std::vector<double> load_of(const Eigen::SparseMatrix<double, Eigen::RowMajor> &weights, Eigen::Index place, int axis) {
    std::vector<double> load(3 * weights.cols(), 0.0);
    for (Eigen::SparseMatrix<double, Eigen::RowMajor>::InnerIterator entry(weights, place); entry; ++entry)
        load[3 * entry.col() + axis] = entry.value();
    return load;
}

void leave_unsolved(core::Solution &solution, const core::TetraMesh &mesh, const core::LoadCase &load_case) {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    solution.displacement.assign(mesh.points.size(), core::Vector3::Constant(nan));
    solution.reaction.assign(load_case.num_constraints(), core::Vector3::Constant(nan));
    solution.strain_energy = nan;
}

} // namespace livermark::fem_reference
