#include "msm/spring_motion.hpp"

#include <algorithm>
#include <cmath>

#include "msm/spring_network.hpp"

namespace livermark::msm {

namespace {

using Unknowns = Eigen::VectorXd;

auto of_node(const Unknowns &field, int node) {
    return field.segment<3>(3 * static_cast<Eigen::Index>(node));
}

auto of_node(Unknowns &field, int node) {
    return field.segment<3>(3 * static_cast<Eigen::Index>(node));
}

} // namespace

Eigen::VectorXd to_unknowns(const std::vector<core::Vector3> &field) {
    Unknowns unknowns(3 * static_cast<Eigen::Index>(field.size()));
    for (std::size_t i = 0; i < field.size(); ++i)
        of_node(unknowns, static_cast<int>(i)) = field[i];
    return unknowns;
}

std::vector<core::Vector3> to_field(const Eigen::VectorXd &unknowns) {
    std::vector<core::Vector3> field(static_cast<std::size_t>(unknowns.size() / 3));
    for (std::size_t i = 0; i < field.size(); ++i)
        field[i] = of_node(unknowns, static_cast<int>(i));
    return field;
}

EquationOfMotion spring_motion(const core::SpringNetwork &springs, const std::vector<core::Vector3> &positions,
                               const NodalConditions &conditions, const core::RayleighDamping &damping) {
    EquationOfMotion equation;
    std::vector<core::Vector3> mass(positions.size()), is_free(positions.size());
    for (std::size_t i = 0; i < positions.size(); ++i) {
        mass[i].setConstant(springs.node_mass[i]);
        for (int c = 0; c < 3; ++c)
            is_free[i][c] = std::isnan(conditions.displacement[i][c]) ? 1.0 : 0.0;
    }
    equation.mass = to_unknowns(mass);
    const Unknowns free = to_unknowns(is_free);
    const Unknowns free_per_mass = free.cwiseQuotient(equation.mass);

    equation.acceleration = [&springs, free_per_mass, free, rest = to_unknowns(positions),
                             load = to_unknowns(conditions.force),
                             damping](const Unknowns &u, const Unknowns &v, Unknowns &a) {
        a = load;
        for (std::size_t s = 0; s < springs.edges.size(); ++s) {
            const auto [i, j] = springs.edges[s];
            const core::Vector3 span = of_node(rest, j) - of_node(rest, i) + of_node(u, j) - of_node(u, i);
            const double length = span.norm();
            const double rate = span.dot(of_node(v, j) - of_node(v, i)) / length;
            const double tension =
                springs.stiffness[s] * (length - springs.rest_length[s] + damping.beta * rate) / length;
            of_node(a, i) += tension * span;
            of_node(a, j) -= tension * span;
        }
        a = a.cwiseProduct(free_per_mass) - damping.alpha * v.cwiseProduct(free);
    };
    equation.effective_mass = [&springs, &positions, mass = equation.mass, free, damping](const Unknowns &u, double d,
                                                                                          double k) {
        auto moved = to_field(u);
        for (std::size_t i = 0; i < moved.size(); ++i)
            moved[i] += positions[i];
        // Compressed springs push sideways, which would make the matrix indefinite; the answer does not depend on it.
        Eigen::SparseMatrix<double> matrix = k * elastic_hessian(springs, moved, Tangent::semi_definite) +
                                             d * damping.beta * elastic_hessian(springs, moved, Tangent::axial);
        matrix = free.asDiagonal() * matrix * free.asDiagonal();
        matrix.diagonal() += mass.cwiseProduct(Unknowns::Ones(mass.size()) + d * damping.alpha * free);
        return matrix;
    };
    return equation;
}

double kinetic_energy(const EquationOfMotion &equation, const State &state) {
    return 0.5 * state.velocity.dot(equation.mass.cwiseProduct(state.velocity));
}

} // namespace livermark::msm
