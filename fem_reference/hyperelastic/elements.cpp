#include "fem_reference/hyperelastic/elements.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <deal.II/base/quadrature_lib.h>
#include <deal.II/fe/fe_simplex_p.h>
#include <limits>
#include <stdexcept>
#include <utility>

#include "fem_reference/hyperelastic/surface.hpp"

namespace livermark::hyperelastic {

namespace {

/// deal.II's own rule of its order has six points, and other codes have these.
/// (P. C. Hammer, A. H. Stroud 1956, Numerical integration over simplexes, Math. Tables Aids Comput. 10)
dealii::Quadrature<3> four_points() {
    const double near = (5.0 + 3.0 * std::sqrt(5.0)) / 20.0, far = (5.0 - std::sqrt(5.0)) / 20.0;
    return {{{far, far, far}, {near, far, far}, {far, near, far}, {far, far, near}},
            std::vector<double>(4, 1.0 / 24.0)};
}

dealii::Quadrature<3> points_of(TetrahedronRule rule) {
    switch (rule) {
    case TetrahedronRule::one_point:
        return dealii::QGaussSimplex<3>(1);
    case TetrahedronRule::four_points:
        return four_points();
    default:
        return dealii::QWitherdenVincentSimplex<3>(3);
    }
}

/// Gradients of all shape functions at a point, one per column.
template <int dim>
Eigen::Matrix<double, dim, Eigen::Dynamic> gradients_at(const dealii::FE_SimplexP<dim> &element,
                                                        const dealii::Point<dim> &point) {
    Eigen::Matrix<double, dim, Eigen::Dynamic> gradients(dim, element.n_dofs_per_cell());
    for (unsigned int a = 0; a < element.n_dofs_per_cell(); ++a) {
        const auto gradient = element.shape_grad(a, point);
        for (int d = 0; d < dim; ++d)
            gradients(d, a) = gradient[d];
    }
    return gradients;
}

} // namespace

ReferenceTetrahedron reference_tetrahedron(int degree, TetrahedronRule rule) {
    const dealii::FE_SimplexP<3> element(degree), linear(1);
    const auto quadrature = points_of(rule);
    constexpr double volume = 1.0 / 6.0;
    ReferenceTetrahedron result;
    for (unsigned int q = 0; q < quadrature.size(); ++q) {
        const auto &point = quadrature.point(q);
        result.weight.push_back(quadrature.weight(q) / volume);
        result.gradient.push_back(gradients_at(element, point));
        auto &shape = result.linear_shape.emplace_back();
        for (unsigned int k = 0; k < 4; ++k)
            shape[k] = linear.shape_value(k, point);
    }
    return result;
}

namespace {

using Vector9 = Eigen::Matrix<double, 9, 1>;

/// In the indices of Tangent.
Vector9 as_vector(const Matrix3 &matrix) {
    Vector9 result;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            result[3 * i + j] = matrix(i, j);
    return result;
}

Matrix3 without_dilation(const Matrix3 &f) {
    return f / std::cbrt(f.determinant());
}

/// Derivative by F' of the energy as a function of F'.
Matrix3 stress_of_shape(const IsochoricPart &part, const Matrix3 &shape) {
    return shape * part.remembered - part.faded * part.law.stress(part.material, shape);
}

} // namespace

double IsochoricPart::energy(const Matrix3 &f) const {
    const Matrix3 shape = without_dilation(f);
    const Matrix3 strain = 0.5 * (shape.transpose() * shape - Matrix3::Identity());
    return remembered.cwiseProduct(strain).sum() - faded * law.energy(material, shape);
}

Matrix3 IsochoricPart::stress(const Matrix3 &f) const {
    const Matrix3 shape = without_dilation(f);
    const Matrix3 shape_part = stress_of_shape(*this, shape);
    const double along = shape_part.cwiseProduct(f).sum();
    return (shape_part - along / 3.0 * Matrix3(f.inverse().transpose())) / std::cbrt(f.determinant());
}

Tangent IsochoricPart::tangent(const Matrix3 &f) const {
    const Matrix3 shape = without_dilation(f), inverse = f.inverse();
    const double scale = 1.0 / std::cbrt(f.determinant());
    Tangent shape_part = -faded * law.tangent(material, shape);
    for (int i = 0; i < 3; ++i)
        shape_part.block<3, 3>(3 * i, 3 * i) += remembered;
    const Matrix3 stress = stress_of_shape(*this, shape);
    const double along = stress.cwiseProduct(f).sum();
    const Vector9 normal = as_vector(inverse.transpose()), stresses = as_vector(stress);
    // dF' = scale (I - F (x) F^-T / 3) dF
    const Tangent map = scale * (Tangent::Identity() - as_vector(f) * normal.transpose() / 3.0);
    Tangent result = map.transpose() * shape_part * map;
    result -= scale / 3.0 * (stresses * normal.transpose() + normal * stresses.transpose());
    result += scale * along / 9.0 * normal * normal.transpose();
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            for (int k = 0; k < 3; ++k)
                for (int l = 0; l < 3; ++l)
                    result(3 * i + j, 3 * k + l) += scale * along / 3.0 * inverse(j, k) * inverse(l, i);
    return result;
}

Matrix3 isochoric_stress(const MaterialLaw &law, const core::Material &material, const Matrix3 &f) {
    const Matrix3 shape = without_dilation(f);
    const Matrix3 stress = shape.inverse() * law.stress(material, shape);
    const Matrix3 c = shape.transpose() * shape;
    const Matrix3 deviator = stress - stress.cwiseProduct(c).sum() / 3.0 * Matrix3(c.inverse());
    return 0.5 * (deviator + deviator.transpose());
}

namespace {

using core::Vector3;
using fem_reference::Block;
using fem_reference::Formulation;

constexpr int most_nodes = 10;
using Gradients = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::ColMajor, 3, most_nodes>;

/// The matrices at rest serve for their numbering only, so that of the mixed formulation may be of another material.
fem_reference::PressureSystem pressure_of(const core::Body &body, const fem_reference::ElasticSystem &system,
                                          Formulation formulation) {
    if (formulation == Formulation::displacement || !fem_reference::has_pressure(body))
        return {};
    if (system.nodes_per_cell == 4)
        throw std::invalid_argument("the mixed formulation needs quadratic displacements: linear ones with a linear "
                                    "pressure are not stable");
    return fem_reference::assemble_pressure(body, system);
}

} // namespace

/// A tetrahedron with what does not depend on the point of integration.
struct Elements::Cell {
    int number;
    std::span<const int> nodes;
    const std::array<int, 4> *pressures; ///< nullptr where there are none
    core::Material material;
    Matrix3 inverse_edges; ///< of the matrix whose columns are the edges from the first corner [1/m]
    double volume;         ///< [m^3]

    Gradients gradients(const Eigen::Matrix3Xd &on_reference) const { return inverse_edges.transpose() * on_reference; }
    Matrix3 deformation(const Gradients &gradients, const std::vector<double> &displacement) const {
        Matrix3 f = Matrix3::Identity();
        for (std::size_t a = 0; a < nodes.size(); ++a)
            f += Vector3::Map(&displacement[3 * nodes[a]]) * gradients.col(a).transpose();
        return f;
    }
    double pressure(const Eigen::Vector4d &shape, const std::vector<double> &values) const {
        double sum = 0.0;
        for (int k = 0; k < 4; ++k)
            sum += shape[k] * values[(*pressures)[k]];
        return sum;
    }
};

template <class Action> void Elements::for_each_cell(const Action &action) const {
    const auto num_local = static_cast<std::size_t>(system_.nodes_per_cell);
    for (std::size_t t = 0; t < body_->mesh.tetrahedra.size(); ++t) {
        Cell cell{static_cast<int>(t),
                  std::span(system_.cell_nodes).subspan(t * num_local, num_local),
                  pressure_.num_pressures() > 0 && pressure_.cell_pressures[t][0] >= 0 ? &pressure_.cell_pressures[t]
                                                                                       : nullptr,
                  body_->material_of(t),
                  {},
                  0.0};
        Matrix3 edges;
        for (int k = 0; k < 3; ++k)
            edges.col(k) = system_.points[cell.nodes[k + 1]] - system_.points[cell.nodes[0]];
        cell.volume = edges.determinant() / 6.0;
        cell.inverse_edges = edges.inverse();
        if (!action(cell))
            return;
    }
}

Elements::Elements(std::shared_ptr<const core::Body> body, int degree, Formulation formulation, const MaterialLaw &law,
                   TetrahedronRule rule)
    : body_(std::move(body)), law_(&law), system_(fem_reference::assemble(*body_, degree)),
      pressure_(pressure_of(*body_, system_, formulation)), reference_(reference_tetrahedron(degree, rule)),
      membrane_(*body_, system_), vessels_(*body_, system_) {
    if (pressure_.num_pressures() > 0) {
        compliance_ = pressure_.compliance;
        std::ranges::fill(compliance_.value, 0.0);
    }
    for_each_cell([&](const Cell &cell) {
        for (std::size_t a = 0; a < cell.nodes.size(); ++a)
            for (std::size_t b = 0; b < a; ++b) {
                const auto [low, high] = std::minmax(cell.nodes[a], cell.nodes[b]);
                block_.push_back(fem_reference::place_of_entry(system_.stiffness.rows.row_start,
                                                               system_.stiffness.rows.column, high, low));
            }
        if (cell.pressures)
            for (int k = 0; k < 4; ++k)
                for (int l = 0; l < 4; ++l) { // the integral of psi_k psi_l over a tetrahedron is V (1 + delta_kl) / 20
                    const int at = fem_reference::place_of_entry(compliance_.row_start, compliance_.column,
                                                                 (*cell.pressures)[k], (*cell.pressures)[l]);
                    compliance_.value[at] += cell.volume * (k == l ? 0.1 : 0.05) / law_->volume_modulus(cell.material);
                }
        return true;
    });
}

void Elements::stand_on(const core::Foundation &foundation) {
    foundation_.emplace(foundation, body_->mesh, system_);
}

IsochoricPart Elements::isochoric_part(const Cell &cell, std::size_t point) const {
    return {*law_, cell.material, memory_->faded,
            memory_->remembered[static_cast<std::size_t>(cell.number) * reference_.weight.size() + point]};
}

std::vector<Matrix3> Elements::isochoric_stresses(const State &state) const {
    std::vector<Matrix3> stresses;
    for_each_cell([&](const Cell &cell) {
        for (const auto &gradient : reference_.gradient)
            stresses.push_back(
                isochoric_stress(*law_, cell.material, cell.deformation(cell.gradients(gradient), state.displacement)));
        return true;
    });
    return stresses;
}

std::vector<double> Elements::point_volumes() const {
    std::vector<double> volumes;
    for_each_cell([&](const Cell &cell) {
        for (const double weight : reference_.weight)
            volumes.push_back(weight * cell.volume);
        return true;
    });
    return volumes;
}

State Elements::rest() const {
    return {std::vector<double>(num_displacements(), 0.0), std::vector<double>(num_pressures(), 0.0)};
}

InternalForces Elements::internal_forces(const State &state, std::span<const double> energy_share) const {
    InternalForces result{.smallest_jacobian = std::numeric_limits<double>::infinity(),
                          .energy = 0.0,
                          .force = std::vector<double>(num_displacements(), 0.0),
                          .imbalance = std::vector<double>(num_pressures(), 0.0)};
    for_each_cell([&](const Cell &cell) {
        const double modulus = law_->volume_modulus(cell.material);
        const double share = energy_share.empty() ? 1.0 : energy_share[cell.number];
        for (std::size_t q = 0; q < reference_.weight.size(); ++q) {
            const Gradients gradients = cell.gradients(reference_.gradient[q]);
            const Matrix3 f = cell.deformation(gradients, state.displacement);
            const double jacobian = f.determinant();
            result.smallest_jacobian = std::min(result.smallest_jacobian, jacobian);
            if (!(jacobian > 0.0)) { // nor NaN
                result.smallest_jacobian = std::min(jacobian, 0.0);
                return false;
            }
            const double weight = reference_.weight[q] * cell.volume;
            const auto volume = law_->volume(jacobian);
            const double pressure =
                cell.pressures ? cell.pressure(reference_.linear_shape[q], state.pressure) : modulus * volume.value;
            Matrix3 stress =
                law_->stress(cell.material, f) + pressure * volume.slope * jacobian * Matrix3(f.inverse().transpose());
            if (memory_) {
                const auto part = isochoric_part(cell, q);
                stress += part.stress(f);
                result.energy += share * weight * part.energy(f);
            }
            for (std::size_t a = 0; a < cell.nodes.size(); ++a)
                Vector3::Map(&result.force[3 * cell.nodes[a]]) += weight * (stress * gradients.col(a));
            result.energy += share * weight * law_->energy(cell.material, f);
            if (cell.pressures) {
                const double imbalance = volume.value - pressure / modulus;
                for (int k = 0; k < 4; ++k)
                    result.imbalance[(*cell.pressures)[k]] += weight * reference_.linear_shape[q][k] * imbalance;
                result.energy += share * weight * pressure * (volume.value - 0.5 * pressure / modulus);
            } else {
                result.energy += share * weight * 0.5 * modulus * volume.value * volume.value;
            }
        }
        return true;
    });
    result.energy += membrane_.add_force(state.displacement, result.force, energy_share);
    result.energy += vessels_.add_force(state.displacement, result.force, energy_share);
    if (foundation_)
        foundation_->add_force(state.displacement, result.force);
    return result;
}

TangentMatrices Elements::zero_tangent() const {
    TangentMatrices tangent{system_.stiffness, pressure_.divergence};
    return tangent;
}

void Elements::assemble_tangent(const State &state, TangentMatrices &tangent) const {
    std::ranges::fill(tangent.stiffness.below, Block<double>{});
    std::ranges::fill(tangent.stiffness.diagonal, Block<double>{});
    std::ranges::fill(tangent.divergence.value, std::array<double, 3>{});
    const int *block = block_.data();
    for_each_cell([&](const Cell &cell) {
        const double modulus = law_->volume_modulus(cell.material);
        const auto num_local = cell.nodes.size();
        // Summed over the points before they go where they belong: the block of nodes a >= b at a (a + 1) / 2 + b.
        std::array<Matrix3, most_nodes *(most_nodes + 1) / 2> local;
        std::ranges::fill(local, Matrix3(Matrix3::Zero()));
        std::array<Eigen::Matrix<double, 3, most_nodes>, 4> divergence; // a column for each node
        for (auto &row : divergence)
            row.setZero();
        for (std::size_t q = 0; q < reference_.weight.size(); ++q) {
            const Gradients gradients = cell.gradients(reference_.gradient[q]);
            const Matrix3 f = cell.deformation(gradients, state.displacement);
            const Matrix3 inverse = f.inverse();
            const double jacobian = f.determinant();
            const double weight = reference_.weight[q] * cell.volume;
            const auto volume = law_->volume(jacobian);
            Tangent point_tangent = law_->tangent(cell.material, f);
            if (cell.pressures) {
                const double pressure = cell.pressure(reference_.linear_shape[q], state.pressure);
                add_volume_tangent(pressure * volume.slope, pressure * volume.curvature, jacobian, inverse,
                                   point_tangent);
            } else {
                add_volume_tangent(modulus * volume.value * volume.slope,
                                   modulus * (volume.slope * volume.slope + volume.value * volume.curvature), jacobian,
                                   inverse, point_tangent);
            }
            if (memory_)
                point_tangent += isochoric_part(cell, q).tangent(f);
            point_tangent *= weight;
            std::size_t at = 0;
            for (std::size_t a = 0; a < num_local; ++a) {
                Eigen::Matrix<double, 3, 9> row; // g_aJ A_(iJ)(jL)
                for (int i = 0; i < 3; ++i)
                    row.row(i) = gradients.col(a).transpose() * point_tangent.middleRows<3>(3 * i);
                for (std::size_t b = 0; b <= a; ++b, ++at)
                    for (int j = 0; j < 3; ++j)
                        local[at].col(j) += row.middleCols<3>(3 * j) * gradients.col(b);
                if (cell.pressures) {
                    const Vector3 slope =
                        weight * volume.slope * jacobian * (inverse.transpose() * gradients.col(a)).eval();
                    for (int k = 0; k < 4; ++k)
                        divergence[k].col(a) += reference_.linear_shape[q][k] * slope;
                }
            }
        }
        std::size_t at = 0;
        for (std::size_t a = 0; a < num_local; ++a)
            for (std::size_t b = 0; b <= a; ++b, ++at) {
                auto &to = a == b ? tangent.stiffness.diagonal[cell.nodes[a]] : tangent.stiffness.below[*block++];
                const bool is_transposed = cell.nodes[a] < cell.nodes[b]; // rows are those of the node behind
                for (int i = 0; i < 3; ++i)
                    for (int j = 0; j < 3; ++j)
                        to[3 * i + j] += is_transposed ? local[at](j, i) : local[at](i, j);
            }
        if (cell.pressures)
            for (int k = 0; k < 4; ++k)
                for (std::size_t a = 0; a < num_local; ++a) {
                    auto &rows = tangent.divergence;
                    auto &to = rows.value[fem_reference::place_of_entry(rows.row_start, rows.column,
                                                                        (*cell.pressures)[k], cell.nodes[a])];
                    for (int i = 0; i < 3; ++i)
                        to[i] += divergence[k](i, a);
                }
        return true;
    });
    membrane_.add_stiffness(state.displacement, tangent.stiffness);
    vessels_.add_stiffness(state.displacement, tangent.stiffness);
    if (foundation_)
        foundation_->add_stiffness(tangent.stiffness);
}

} // namespace livermark::hyperelastic
