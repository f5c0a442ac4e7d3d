#include "fem_reference/linear/elastic_system.hpp"

#include <deal.II/base/multithread_info.h>
#include <deal.II/base/quadrature_lib.h>
#include <deal.II/dofs/dof_handler.h>
#include <deal.II/fe/fe_simplex_p.h>
#include <deal.II/fe/fe_values.h>
#include <deal.II/fe/mapping_fe.h>
#include <deal.II/grid/tria.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"
#include "fem_reference/linear/facets.hpp"
#include "fem_reference/linear/vessel_lines.hpp"
#include "fem_reference/solvers/matrices.hpp"

namespace livermark::fem_reference {

namespace {

/// The cells at each node.
struct CellsOfNodes {
    std::vector<int> start; ///< (n + 1)
    std::vector<int> cell;
};

CellsOfNodes cells_of_nodes(std::span<const int> cell_nodes, int nodes_per_cell, int num_nodes) {
    CellsOfNodes cells{std::vector<int>(num_nodes + 1, 0), std::vector<int>(cell_nodes.size())};
    for (const int node : cell_nodes)
        ++cells.start[node + 1];
    for (int node = 0; node < num_nodes; ++node)
        cells.start[node + 1] += cells.start[node];
    auto next = cells.start;
    for (std::size_t k = 0; k < cell_nodes.size(); ++k)
        cells.cell[next[cell_nodes[k]]++] = static_cast<int>(k) / nodes_per_cell;
    return cells;
}

} // namespace

std::vector<int> order_by_distance(std::span<const int> cell_nodes, int nodes_per_cell, int num_nodes) {
    const auto cells = cells_of_nodes(cell_nodes, nodes_per_cell, num_nodes);
    /// Appends a node and all that hang together with it, the nearest first.
    const auto append_around = [&](int start, std::vector<bool> &is_there, std::vector<int> &order) {
        is_there[start] = true;
        order.push_back(start);
        for (std::size_t next = order.size() - 1; next < order.size(); ++next)
            for (int k = cells.start[order[next]]; k < cells.start[order[next] + 1]; ++k)
                for (const int other : cell_nodes.subspan(cells.cell[k] * nodes_per_cell, nodes_per_cell))
                    if (!is_there[other]) {
                        is_there[other] = true;
                        order.push_back(other);
                    }
    };
    std::vector<int> order;
    std::vector<bool> is_there(num_nodes, false), was_seen(num_nodes, false);
    for (int node = 0; node < num_nodes; ++node) {
        if (is_there[node])
            continue;
        std::vector<int> part;
        append_around(node, was_seen, part);
        append_around(part.back(), is_there, order); // the farthest from an arbitrary one
    }
    return order;
}

namespace {

/// A mesh as deal.II has it, in the same order of nodes, tetrahedra and local vertices: matrices of one mesh share what
/// deal.II works out of it.
struct DealIiMesh {
    explicit DealIiMesh(const core::TetraMesh &mesh) {
        // The rest is deal.II's, too short for threads, and they would take the core of the load case beside it.
        dealii::MultithreadInfo::set_thread_limit(1);
        std::vector<dealii::Point<3>> vertices;
        vertices.reserve(mesh.points.size());
        for (const auto &point : mesh.points)
            vertices.emplace_back(point.x(), point.y(), point.z());
        std::vector<dealii::CellData<3>> cells(mesh.tetrahedra.size(), dealii::CellData<3>(4));
        for (std::size_t t = 0; t < cells.size(); ++t)
            std::ranges::copy(mesh.tetrahedra[t], cells[t].vertices.begin());
        triangulation.create_triangulation(vertices, cells, {});
    }

    dealii::Triangulation<3> triangulation;
};

using Tensor2 = std::array<std::array<double, 3>, 3>;

/// For each unknown of the scalar space its node: mesh nodes first and in the order of the mesh, then the others.
std::vector<int> number_nodes(const dealii::DoFHandler<3> &dof_handler, int num_mesh_nodes) {
    std::vector<int> node(dof_handler.n_dofs(), -1);
    for (const auto &cell : dof_handler.active_cell_iterators())
        for (const unsigned int v : cell->vertex_indices())
            node[cell->vertex_dof_index(v, 0)] = static_cast<int>(cell->vertex_index(v));
    int next = num_mesh_nodes;
    for (int &number : node)
        if (number < 0)
            number = next++;
    return node;
}

/// Numbers nodes so that neighbours are near each other.
/// @param system  with nodes and cells, and nothing that depends on their numbers yet
/// @param node    of each unknown of the scalar space
void number_by_distance(ElasticSystem &system, std::vector<int> &node) {
    const auto order = order_by_distance(system.cell_nodes, system.nodes_per_cell, system.num_nodes());
    std::vector<int> place(order.size());
    std::vector<core::Vector3> points;
    for (std::size_t at = 0; at < order.size(); ++at) {
        place[order[at]] = static_cast<int>(at);
        points.push_back(system.points[order[at]]);
    }
    system.points = std::move(points);
    for (auto *const numbers : {&system.mesh_node, &system.cell_nodes, &node})
        for (int &number : *numbers)
            number = place[number];
}

/// Asks for a block that is to be changed soon.
void ask_for(const Block<double> &block) {
    __builtin_prefetch(&block.front(), 1);
    __builtin_prefetch(&block.back(), 1); // on the next line of the cache, maybe
}

/// Adds the 3 x 3 block of two nodes, given the integral of g_a g_b^T over a cell.
void add_block(Block<double> &block, double lambda, double mu, const Tensor2 &gradients) {
    const double trace = gradients[0][0] + gradients[1][1] + gradients[2][2];
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            block[3 * i + j] += lambda * gradients[i][j] + mu * gradients[j][i] + (i == j ? mu * trace : 0.0);
}

std::vector<double> integrate_reference_mass(const dealii::FE_SimplexP<3> &fe) {
    // Products of quadratic shape functions have degree 4, and this rule is exact to degree 5.
    const dealii::QGaussSimplex<3> quadrature(3);
    constexpr double reference_volume = 1.0 / 6.0;
    const auto num_local = fe.n_dofs_per_cell();
    std::vector<double> share(num_local * num_local, 0.0);
    for (unsigned int q = 0; q < quadrature.size(); ++q)
        for (unsigned int a = 0; a < num_local; ++a)
            for (unsigned int b = 0; b < num_local; ++b)
                share[a * num_local + b] += quadrature.weight(q) / reference_volume *
                                            fe.shape_value(a, quadrature.point(q)) *
                                            fe.shape_value(b, quadrature.point(q));
    return share;
}

void integrate_cells(ElasticSystem &system, const core::Body &body, const dealii::DoFHandler<3> &dof_handler,
                     const dealii::Mapping<3> &mapping, int degree) {
    // Products of gradients and the shape functions themselves have degree 2 for quadratic and at most 1 for linear
    // elements; the rule of this many points per direction is exact for both.
    const dealii::QGaussSimplex<3> quadrature(degree);
    dealii::FEValues<3> values(mapping, dof_handler.get_fe(), quadrature,
                               dealii::update_values | dealii::update_gradients | dealii::update_JxW_values);
    const int num_local = system.nodes_per_cell;
    const auto num_nodes = system.num_nodes();
    auto rows = cell_rows(system.cell_nodes, num_local, num_nodes, system.cell_nodes, num_local, num_nodes,
                          CellEntries::below_diagonal);
    system.stiffness = {{std::move(rows.row_start), std::move(rows.column)}, {}, {}};
    system.stiffness.below.assign(system.stiffness.rows.column.size(), {});
    system.stiffness.diagonal.assign(system.points.size(), {});
    std::vector<std::array<double, 3>> gradient(num_local * quadrature.size()), weighted(gradient.size());
    for (const auto &cell : dof_handler.active_cell_iterators()) {
        values.reinit(cell);
        const auto t = cell->active_cell_index();
        const auto material = body.material_of(t);
        const int *const nodes = system.cell_nodes.data() + t * num_local;
        const double lambda = material.lame_lambda(), mu = material.shear_modulus();
        const int num_pairs = num_local * num_local;
        const int *const places = rows.place.data() + t * num_pairs;
        // Cells are not in the order of the rows, so the blocks of the next one come from far.
        if (t + 1 < body.mesh.tetrahedra.size())
            for (const int place : std::span(places + num_pairs, num_pairs))
                if (place >= 0)
                    ask_for(system.stiffness.below[place]);
        // deal.II's accessors check their arguments in debug mode, so each is asked once.
        for (unsigned int q = 0; q < quadrature.size(); ++q) {
            const double weight = values.JxW(q);
            for (int a = 0; a < num_local; ++a) {
                const auto &g = values.shape_grad(a, q);
                gradient[a * quadrature.size() + q] = {g[0], g[1], g[2]};
                weighted[a * quadrature.size() + q] = {weight * g[0], weight * g[1], weight * g[2]};
                system.mass_integral[nodes[a]] += material.density * values.shape_value(a, q) * weight;
            }
        }
        for (int a = 0; a < num_local; ++a)
            for (int b = 0; b <= a; ++b) {
                const bool is_behind = nodes[a] >= nodes[b]; // of the two the row
                const int row = is_behind ? a : b, column = is_behind ? b : a;
                const auto *const left = weighted.data() + row * quadrature.size();
                const auto *const right = gradient.data() + column * quadrature.size();
                Tensor2 integral{};
                for (unsigned int q = 0; q < quadrature.size(); ++q)
                    for (int i = 0; i < 3; ++i)
                        for (int j = 0; j < 3; ++j)
                            integral[i][j] += left[q][i] * right[q][j];
                add_block(a == b ? system.stiffness.diagonal[nodes[a]]
                                 : system.stiffness.below[places[row * num_local + column]],
                          lambda, mu, integral);
            }
    }
}

void integrate_facets(ElasticSystem &system, const core::TetraMesh &mesh, const dealii::DoFHandler<3> &dof_handler,
                      const std::vector<int> &node_of_dof, const dealii::Mapping<3> &mapping, int degree) {
    std::map<std::array<int, 3>, int> facet_of_corners;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f) {
        auto corners = mesh.boundary_triangles[f];
        std::ranges::sort(corners);
        facet_of_corners[corners] = f;
    }
    const dealii::QGaussSimplex<2> quadrature(degree);
    dealii::FEFaceValues<3> values(mapping, dof_handler.get_fe(), quadrature,
                                   dealii::update_values | dealii::update_JxW_values);
    std::vector<dealii::types::global_dof_index> face_dofs(system.nodes_per_facet);
    system.facet_nodes.assign(system.nodes_per_facet * mesh.boundary_triangles.size(), -1);
    system.facet_integral.assign(system.facet_nodes.size(), 0.0);
    for (const auto &cell : dof_handler.active_cell_iterators()) {
        for (const unsigned int face : cell->face_indices()) {
            if (!cell->face(face)->at_boundary())
                continue;
            std::array<int, 3> corners{};
            for (unsigned int v = 0; v < 3; ++v)
                corners[v] = static_cast<int>(cell->face(face)->vertex_index(v));
            std::ranges::sort(corners);
            const auto found = facet_of_corners.find(corners);
            if (found == facet_of_corners.end())
                continue;
            values.reinit(cell, face);
            cell->face(face)->get_dof_indices(face_dofs);
            const auto nodes = std::span(system.cell_nodes)
                                   .subspan(cell->active_cell_index() * system.nodes_per_cell, system.nodes_per_cell);
            for (int k = 0; k < system.nodes_per_facet; ++k) {
                const int slot = found->second * system.nodes_per_facet + k;
                system.facet_nodes[slot] = node_of_dof[face_dofs[k]];
                const auto local = std::ranges::find(nodes, system.facet_nodes[slot]) - nodes.begin();
                for (unsigned int q = 0; q < quadrature.size(); ++q)
                    system.facet_integral[slot] += values.shape_value(local, q) * values.JxW(q);
            }
            facet_of_corners.erase(found);
        }
    }
    if (!facet_of_corners.empty())
        throw std::invalid_argument("boundary triangle " + std::to_string(facet_of_corners.begin()->second) +
                                    " is not an outer face of the tetrahedra or is given twice");
}

/// @param mesh  of this body
ElasticSystem assemble_on(const DealIiMesh &mesh, const core::Body &body, int degree, NodeOrder order,
                          const std::optional<core::Foundation> &foundation) {
    if (degree != 1 && degree != 2)
        throw std::invalid_argument("finite elements of degree " + std::to_string(degree) +
                                    " are not there; use 1 or 2");
    // The three components of displacement live on the same scalar space, so that deal.II has to tabulate a third of
    // the shape functions and there is one number per node.
    const dealii::FE_SimplexP<3> fe(degree);
    const dealii::MappingFE<3> mapping(dealii::FE_SimplexP<3>(1));
    dealii::DoFHandler<3> dof_handler(mesh.triangulation);
    dof_handler.distribute_dofs(fe);

    ElasticSystem system;
    system.nodes_per_cell = static_cast<int>(fe.n_dofs_per_cell());
    system.nodes_per_facet = degree == 1 ? 3 : 6;
    auto node = number_nodes(dof_handler, body.mesh.num_nodes());
    system.points = body.mesh.points;
    system.points.resize(node.size());
    system.mesh_node.resize(body.mesh.points.size());
    std::iota(system.mesh_node.begin(), system.mesh_node.end(), 0);
    std::vector<dealii::types::global_dof_index> dofs(fe.n_dofs_per_cell());
    system.cell_nodes.reserve(body.mesh.tetrahedra.size() * dofs.size());
    for (const auto &cell : dof_handler.active_cell_iterators()) {
        cell->get_dof_indices(dofs);
        for (const auto dof : dofs)
            system.cell_nodes.push_back(node[dof]);
        const int *const nodes = system.cell_nodes.data() + system.cell_nodes.size() - dofs.size();
        for (std::size_t a = 4; a < dofs.size(); ++a) {
            const auto &reference = fe.get_unit_support_points()[a];
            core::Vector3 point = system.points[nodes[0]];
            for (int d = 0; d < 3; ++d)
                point += reference[d] * (system.points[nodes[d + 1]] - system.points[nodes[0]]);
            system.points[nodes[a]] = point;
        }
    }
    if (order == NodeOrder::by_distance)
        number_by_distance(system, node);
    system.reference_mass = integrate_reference_mass(fe);
    system.mass_integral.assign(system.points.size(), 0.0);
    integrate_cells(system, body, dof_handler, mapping, degree);
    integrate_facets(system, body.mesh, dof_handler, node, mapping, degree);
    Membrane(body, system).add_stiffness({}, system.stiffness);
    VesselLines(body, system).add_stiffness({}, system.stiffness);
    FoundationSprings(foundation, body.mesh, system).add_stiffness(system.stiffness);
    system.is_borne = foundation.has_value();
    return system;
}

bool has_pressure(const core::Material &material) {
    return material.poisson_ratio > pressure_above_poisson_ratio;
}

/// The pressures at the corners of each tetrahedron, -1 in regions that have none.
struct PressureNumbers {
    std::vector<std::array<int, 4>> cell_pressures; ///< (M)
    int count = 0;
};

/// In the order of the nodes, so that what is near each other in the body is so in memory.
PressureNumbers number_pressures(const core::Body &body, const ElasticSystem &system) {
    const auto num_regions = body.materials.size();
    std::vector<int> number(num_regions * system.points.size(), -1); // of each node and region
    PressureNumbers numbers{std::vector(body.mesh.tetrahedra.size(), std::array{-1, -1, -1, -1})};
    const auto for_each_corner = [&](const auto &action) {
        for (std::size_t t = 0; t < numbers.cell_pressures.size(); ++t)
            if (const auto region = static_cast<std::size_t>(body.mesh.region[t]); has_pressure(body.materials[region]))
                for (int k = 0; k < 4; ++k)
                    action(number[num_regions * system.cell_nodes[t * system.nodes_per_cell + k] + region],
                           numbers.cell_pressures[t][k]);
    };
    for_each_corner([](int &number_of_node, int /*corner*/) { number_of_node = 0; });
    for (int &number_of_node : number)
        if (number_of_node == 0)
            number_of_node = numbers.count++;
    for_each_corner([](int number_of_node, int &corner) { corner = number_of_node; });
    return numbers;
}

/// @param mesh  of this body
PressureSystem assemble_pressure_on(const DealIiMesh &mesh, const core::Body &body, const ElasticSystem &system) {
    const dealii::FE_SimplexP<3> displacement(2);
    const dealii::FE_SimplexP<3> pressure(1);
    const dealii::MappingFE<3> mapping(pressure);
    const dealii::QGaussSimplex<3> quadrature(2); // exact for the products, which are of degree 2
    dealii::FEValues<3> gradients(mapping, displacement, quadrature,
                                  dealii::update_gradients | dealii::update_JxW_values);

    std::vector<std::array<double, 4>> psi(quadrature.size());
    for (unsigned int q = 0; q < quadrature.size(); ++q)
        for (unsigned int k = 0; k < 4; ++k)
            psi[q][k] = pressure.shape_value(k, quadrature.point(q));

    auto numbers = number_pressures(body, system);
    PressureSystem result{
        .cell_pressures = std::move(numbers.cell_pressures), .divergence = {}, .compliance = {}, .norm = {}};
    const auto pressures = std::span(result.cell_pressures.data()->data(), 4 * result.cell_pressures.size());
    auto nodes_of =
        cell_rows(pressures, 4, numbers.count, system.cell_nodes, system.nodes_per_cell, system.num_nodes());
    auto neighbours_of = cell_rows(pressures, 4, numbers.count, pressures, 4, numbers.count);
    result.divergence = {std::move(nodes_of.row_start), std::move(nodes_of.column), {}};
    result.divergence.value.assign(result.divergence.column.size(), {});
    result.compliance = {std::move(neighbours_of.row_start), std::move(neighbours_of.column), {}};
    result.compliance.value.assign(result.compliance.column.size(), 0.0);
    result.norm = result.compliance;
    for (const auto &cell : mesh.triangulation.active_cell_iterators()) {
        const auto t = cell->active_cell_index();
        const auto &corners = result.cell_pressures[t];
        if (corners[0] < 0)
            continue;
        gradients.reinit(cell);
        const auto material = body.material_of(t);
        const double compliance_here = 1.0 / material.lame_lambda();
        const double norm_here = compliance_here + 0.5 / material.shear_modulus();
        const int *const places = nodes_of.place.data() + 4 * t * system.nodes_per_cell;
        const int *const neighbours = neighbours_of.place.data() + 16 * t;
        // Summed over the points before they go to the rows.
        std::array<std::array<double, 30>, 4> divergence_here{};
        std::array<std::array<double, 4>, 4> mass{};
        for (unsigned int q = 0; q < quadrature.size(); ++q) {
            std::array<double, 30> gradient;
            for (int a = 0; a < system.nodes_per_cell; ++a) {
                const auto &slope = gradients.shape_grad(a, q);
                for (int i = 0; i < 3; ++i)
                    gradient[3 * a + i] = slope[i];
            }
            for (int k = 0; k < 4; ++k) {
                const double weight = gradients.JxW(q) * psi[q][k];
                for (std::size_t n = 0; n < gradient.size(); ++n)
                    divergence_here[k][n] += weight * gradient[n];
                for (int l = 0; l < 4; ++l)
                    mass[k][l] += weight * psi[q][l];
            }
        }
        for (int k = 0; k < 4; ++k) {
            for (int a = 0; a < system.nodes_per_cell; ++a) {
                auto &entry = result.divergence.value[places[k * system.nodes_per_cell + a]];
                for (int i = 0; i < 3; ++i)
                    entry[i] += divergence_here[k][3 * a + i];
            }
            for (int l = 0; l < 4; ++l) {
                result.compliance.value[neighbours[4 * k + l]] += compliance_here * mass[k][l];
                result.norm.value[neighbours[4 * k + l]] += norm_here * mass[k][l];
            }
        }
    }
    return result;
}

} // namespace

bool has_pressure(const core::Body &body) {
    return std::ranges::any_of(body.materials, [](const core::Material &material) { return has_pressure(material); });
}

double pressure_scale(const core::Body &body) {
    double modulus = 0.0, volume = 0.0;
    const auto volumes = core::tetrahedron_volumes(body.mesh);
    for (std::size_t t = 0; t < volumes.size(); ++t) {
        modulus += volumes[t] * body.shear_modulus_of(t);
        volume += volumes[t];
    }
    return modulus / volume / std::cbrt(volume);
}

core::Body without_pressure(const core::Body &body) {
    auto rest = body;
    for (auto &material : rest.materials)
        if (has_pressure(material)) {
            material.young_modulus = 2.0 * material.shear_modulus();
            material.poisson_ratio = 0.0;
        }
    return rest;
}

ElasticSystem assemble(const core::Body &body, int degree, NodeOrder order,
                       const std::optional<core::Foundation> &foundation) {
    return assemble_on(DealIiMesh(body.mesh), body, degree, order, foundation);
}

PressureSystem assemble_pressure(const core::Body &body, const ElasticSystem &system) {
    return assemble_pressure_on(DealIiMesh(body.mesh), body, system);
}

Discretisation::Discretisation(const core::Body &body, int degree, Formulation formulation,
                               const std::optional<core::Foundation> &foundation) {
    if (formulation == Formulation::displacement) {
        system = assemble(body, degree, NodeOrder::of_mesh, foundation);
        return;
    }
    if (degree != 2)
        throw std::invalid_argument("the mixed formulation takes quadratic elements, not those of degree " +
                                    std::to_string(degree));
    const auto order = has_pressure(body) ? NodeOrder::by_distance : NodeOrder::of_mesh;
    const DealIiMesh mesh(body.mesh);
    system = assemble_on(mesh, without_pressure(body), degree, order, foundation);
    pressure = assemble_pressure_on(mesh, body, system);
}

} // namespace livermark::fem_reference
