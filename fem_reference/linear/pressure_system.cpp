#include "fem_reference/linear/pressure_system.hpp"

#include <deal.II/base/quadrature_lib.h>
#include <deal.II/fe/fe_simplex_p.h>
#include <deal.II/fe/fe_values.h>
#include <deal.II/fe/mapping_fe.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "fem_reference/cell_rows.hpp"
#include "fem_reference/deal_ii_mesh.hpp"

namespace livermark::fem_reference {

namespace {

bool has_pressure(const core::Material &material) {
    return material.poisson_ratio > pressure_above_poisson_ratio;
}

/// The pressures at the corners of each tetrahedron, -1 in regions that have none.
struct PressureNumbers {
    std::vector<std::array<int, 4>> of_cell; ///< (M)
    int count = 0;
};

/// In the order of the nodes, so that what is near each other in the body is so in memory.
PressureNumbers number_pressures(const core::Body &body, const ElasticSystem &system) {
    const auto num_regions = body.materials.size();
    std::vector<int> number(num_regions * system.points.size(), -1); // of each node and region
    PressureNumbers numbers{std::vector(body.mesh.tetrahedra.size(), std::array{-1, -1, -1, -1})};
    const auto for_each_corner = [&](const auto &action) {
        for (std::size_t t = 0; t < numbers.of_cell.size(); ++t)
            if (const auto region = static_cast<std::size_t>(body.mesh.region[t]); has_pressure(body.materials[region]))
                for (int k = 0; k < 4; ++k)
                    action(number[num_regions * system.cell_nodes[t * system.nodes_per_cell + k] + region],
                           numbers.of_cell[t][k]);
    };
    for_each_corner([](int &of_node, int /*of_corner*/) { of_node = 0; });
    for (int &of_node : number)
        if (of_node == 0)
            of_node = numbers.count++;
    for_each_corner([](int of_node, int &of_corner) { of_corner = of_node; });
    return numbers;
}

} // namespace

bool has_pressure(const core::Body &body) {
    return std::ranges::any_of(body.materials, [](const core::Material &material) { return has_pressure(material); });
}

double pressure_scale(const core::Body &body) {
    double modulus = 0.0, volume = 0.0;
    const auto volumes = core::tetrahedron_volumes(body.mesh);
    for (std::size_t t = 0; t < volumes.size(); ++t) {
        modulus += volumes[t] * body.materials[body.mesh.region[t]].shear_modulus();
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

PressureSystem assemble_pressure(const core::Body &body, const ElasticSystem &system) {
    return assemble_pressure(body, DealIiMesh(body.mesh), system);
}

PressureSystem assemble_pressure(const core::Body &body, const DealIiMesh &mesh, const ElasticSystem &system) {
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
    PressureSystem result{.of_cell = std::move(numbers.of_cell), .divergence = {}, .compliance = {}, .norm = {}};
    const auto pressures = std::span(result.of_cell.data()->data(), 4 * result.of_cell.size());
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
        const auto &corners = result.of_cell[t];
        if (corners[0] < 0)
            continue;
        gradients.reinit(cell);
        const auto &material = body.materials[body.mesh.region[t]];
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
                const auto &of_node = gradients.shape_grad(a, q);
                for (int i = 0; i < 3; ++i)
                    gradient[3 * a + i] = of_node[i];
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
                auto &of_node = result.divergence.value[places[k * system.nodes_per_cell + a]];
                for (int i = 0; i < 3; ++i)
                    of_node[i] += divergence_here[k][3 * a + i];
            }
            for (int l = 0; l < 4; ++l) {
                result.compliance.value[neighbours[4 * k + l]] += compliance_here * mass[k][l];
                result.norm.value[neighbours[4 * k + l]] += norm_here * mass[k][l];
            }
        }
    }
    return result;
}

} // namespace livermark::fem_reference
