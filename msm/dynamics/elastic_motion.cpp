#include "msm/dynamics/elastic_motion.hpp"

#include <cmath>

namespace livermark::msm {

namespace {

using Unknowns = Eigen::VectorXd;

} // namespace

EquationOfMotion elastic_motion(const ElasticBody &body, const std::vector<core::Vector3> &positions,
                                const NodalConditions &conditions, const core::RayleighDamping &damping,
                                const MassScaling &scaling) {
    EquationOfMotion equation;
    std::vector<core::Vector3> mass(positions.size()), is_free(positions.size());
    for (std::size_t i = 0; i < positions.size(); ++i) {
        mass[i].setConstant(body.node_mass[i]);
        for (int c = 0; c < 3; ++c)
            is_free[i][c] = std::isnan(conditions.displacement[i][c]) ? 1.0 : 0.0;
    }
    equation.mass = to_unknowns(mass);
    const Unknowns free = to_unknowns(is_free);
    const Unknowns free_per_mass = free.cwiseQuotient(equation.mass);

    equation.acceleration = [body, free_per_mass, free, rest = to_unknowns(positions),
                             load = to_unknowns(conditions.force), damping, scaling,
                             x = Unknowns()](const Unknowns &u, const Unknowns &v, Unknowns &a) mutable {
        x = rest + u;
        a = load;
        for (const auto &term : body.terms)
            term->add_force(x, v, damping.beta, a);
        a = a.cwiseProduct(free_per_mass);
        scale_acceleration(scaling, x, v, a);
        a -= damping.alpha * v.cwiseProduct(free); // in proportion to the mass that is scaled
    };
    equation.effective_mass = [body, rest = to_unknowns(positions), mass = equation.mass, free,
                               damping](const Unknowns &u, double d, double k) {
        const Unknowns x = rest + u;
        Eigen::SparseMatrix<double> matrix(x.size(), x.size());
        // What compression makes negative would make the matrix indefinite; the solution does not depend on it.
        for (const auto &term : body.terms)
            matrix +=
                k * term->hessian(x, Tangent::semi_definite) + d * damping.beta * term->hessian(x, Tangent::material);
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
