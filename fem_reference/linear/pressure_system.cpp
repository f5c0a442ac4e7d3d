#include "fem_reference/linear/pressure_system.hpp"

#include <deal.II/base/quadrature_lib.h>
#include <deal.II/fe/fe_simplex_p.h>
#include <deal.II/fe/fe_values.h>
#include <deal.II/fe/mapping_fe.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <span>
#include <utility>

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
    const auto corner = [&](std::size_t t, int k) { return system.cell_nodes[t * system.nodes_per_cell + k]; };
    std::map<std::pair<int, int>, int> number; // of node and region
    for (std::size_t t = 0; t < body.mesh.tetrahedra.size(); ++t)
        if (const int region = body.mesh.region[t]; has_pressure(body.materials[region]))
            for (int k = 0; k < 4; ++k)
                number[{corner(t, k), region}] = 0;
    PressureNumbers numbers;
    for (auto &[node_and_region, value] : number)
        value = numbers.count++;
    for (std::size_t t = 0; t < body.mesh.tetrahedra.size(); ++t) {
        auto &corners = numbers.of_cell.emplace_back(std::array{-1, -1, -1, -1});
        if (const int region = body.mesh.region[t]; has_pressure(body.materials[region]))
            for (int k = 0; k < 4; ++k)
                corners[k] = number.at({corner(t, k), region});
    }
    return numbers;
}

/// Which columns each row has, and a zero matrix of them.
class Pattern {
  public:
    explicit Pattern(int num_rows) : row_(num_rows) {}

    void link(int row, std::span<const int> columns) {
        row_[row].insert(row_[row].end(), columns.begin(), columns.end());
    }

    template <class Matrix> Matrix zero_matrix() {
        std::size_t num_links = 0;
        for (auto &columns : row_) {
            std::ranges::sort(columns);
            columns.erase(std::unique(columns.begin(), columns.end()), columns.end());
            num_links += columns.size();
        }
        Matrix matrix;
        matrix.row_start.push_back(0);
        matrix.column.reserve(num_links);
        for (const auto &columns : row_) {
            matrix.column.insert(matrix.column.end(), columns.begin(), columns.end());
            matrix.row_start.push_back(static_cast<int>(matrix.column.size()));
        }
        matrix.value.assign(matrix.column.size(), {});
        return matrix;
    }

  private:
    std::vector<std::vector<int>> row_;
};

/// Where the entry of a row and a column stands, which has to be there.
template <class Matrix> auto &entry(Matrix &matrix, int row, int column) {
    const int *const first = matrix.column.data() + matrix.row_start[row];
    const int *const last = matrix.column.data() + matrix.row_start[row + 1];
    return matrix.value[matrix.row_start[row] + (std::lower_bound(first, last, column) - first)];
}

/// With matrices of zeros.
PressureSystem empty_system(const core::Body &body, const ElasticSystem &system) {
    auto numbers = number_pressures(body, system);
    Pattern nodes(numbers.count), neighbours(numbers.count);
    for (std::size_t t = 0; t < numbers.of_cell.size(); ++t)
        if (const auto &corners = numbers.of_cell[t]; corners.front() >= 0)
            for (const int pressure : corners) {
                nodes.link(pressure,
                           std::span(system.cell_nodes).subspan(t * system.nodes_per_cell, system.nodes_per_cell));
                neighbours.link(pressure, corners);
            }
    PressureSystem pressure{std::move(numbers.of_cell), nodes.zero_matrix<DivergenceRows<double>>(), {}, {}};
    pressure.compliance = neighbours.zero_matrix<SymmetricMatrix>();
    pressure.norm = pressure.compliance;
    return pressure;
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

    auto result = empty_system(body, system);
    for (const auto &cell : mesh.triangulation.active_cell_iterators()) {
        const auto t = cell->active_cell_index();
        const auto &corners = result.of_cell[t];
        if (corners[0] < 0)
            continue;
        gradients.reinit(cell);
        const auto &material = body.materials[body.mesh.region[t]];
        const double compliance_here = 1.0 / material.lame_lambda();
        const double norm_here = compliance_here + 0.5 / material.shear_modulus();
        const int *const nodes = system.cell_nodes.data() + t * system.nodes_per_cell;
        // Summed over the points before they go to the rows, where each entry has to be looked up.
        std::array<std::array<double, 30>, 4> divergence_here{};
        std::array<std::array<double, 4>, 4> mass{};
        for (unsigned int q = 0; q < quadrature.size(); ++q) {
            const double weight = gradients.JxW(q);
            for (int a = 0; a < system.nodes_per_cell; ++a) {
                const auto &gradient = gradients.shape_grad(a, q);
                for (int k = 0; k < 4; ++k)
                    for (int i = 0; i < 3; ++i)
                        divergence_here[k][3 * a + i] += weight * psi[q][k] * gradient[i];
            }
            for (int k = 0; k < 4; ++k)
                for (int l = 0; l < 4; ++l)
                    mass[k][l] += weight * psi[q][k] * psi[q][l];
        }
        for (int k = 0; k < 4; ++k) {
            for (int a = 0; a < system.nodes_per_cell; ++a) {
                auto &of_node = entry(result.divergence, corners[k], nodes[a]);
                for (int i = 0; i < 3; ++i)
                    of_node[i] += divergence_here[k][3 * a + i];
            }
            for (int l = 0; l < 4; ++l) {
                entry(result.compliance, corners[k], corners[l]) += compliance_here * mass[k][l];
                entry(result.norm, corners[k], corners[l]) += norm_here * mass[k][l];
            }
        }
    }
    return result;
}

} // namespace livermark::fem_reference
