#include "msm/equilibrium.hpp"

#include <Eigen/CholmodSupport>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>

#include "msm/extent.hpp"
#include "msm/free_components.hpp"

namespace livermark::msm {

namespace {

using Field = std::vector<core::Vector3>;

Field sum(const Field &a, const Field &b) {
    Field result(a.size());
    std::ranges::transform(a, b, result.begin(), [](const auto &x, const auto &y) -> core::Vector3 { return x + y; });
    return result;
}

/// The Newton iteration on one body, loads and constraints.
class Newton {
  public:
    Newton(const ElasticBody &body, const Field &positions, const NodalConditions &conditions)
        : body_(body), positions_(positions), conditions_(conditions), free_(conditions.displacement) {
        solver_.cholmod().print = 0;
    }

    /// Answer of the body linearised at rest: K_ff u_f = f_f - K_fc u_c.
    bool solve_linear(Field &displacement) {
        displacement.assign(positions_.size(), core::Vector3::Zero());
        Eigen::VectorXd prescribed = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(3 * positions_.size()));
        for (std::size_t i = 0; i < positions_.size(); ++i)
            for (int c = 0; c < 3; ++c)
                if (!std::isnan(conditions_.displacement[i][c]))
                    displacement[i][c] = prescribed[static_cast<Eigen::Index>(3 * i) + c] =
                        conditions_.displacement[i][c];
        const auto stiffness = elastic_hessian(body_, positions_, Tangent::exact);
        const Eigen::VectorXd pull = stiffness * prescribed;
        Field load = conditions_.force;
        for (std::size_t i = 0; i < load.size(); ++i)
            load[i] -= pull.segment<3>(static_cast<Eigen::Index>(3 * i));
        const auto restricted = free_.restrict(stiffness);
        rounding_force_ = std::numeric_limits<double>::epsilon() * extent(positions_) * restricted.diagonal().norm();
        solver_.analyzePattern(restricted);
        solver_.factorize(restricted);
        if (solver_.info() != Eigen::Success)
            return false;
        free_.add(displacement, solver_.solve(free_.gather(load)), 1.0);
        return true;
    }

    /// U(x) - f . u
    double potential(const Field &displacement) const {
        double energy = elastic_energy(body_, sum(positions_, displacement));
        for (std::size_t i = 0; i < displacement.size(); ++i)
            energy -= conditions_.force[i].dot(displacement[i]);
        return energy;
    }

    /// What holds each node where it is, beyond the loads: zero on free components in equilibrium.
    Field unbalanced_force(const Field &displacement) const {
        Field force = elastic_gradient(body_, sum(positions_, displacement));
        for (std::size_t i = 0; i < force.size(); ++i)
            force[i] -= conditions_.force[i];
        return force;
    }

    /// Norm of the free part of the unbalanced force, relative to all forces at work.
    double relative_residual(const Field &unbalanced) const {
        double all = 0.0;
        for (std::size_t i = 0; i < unbalanced.size(); ++i)
            all += unbalanced[i].squaredNorm() + conditions_.force[i].squaredNorm();
        return all > 0.0 ? free_.gather(unbalanced).norm() / std::sqrt(all) : 0.0;
    }

    /// Whether the free part of the unbalanced force is within the tolerance, or within what rounding leaves of it.
    bool is_balanced(const Field &unbalanced, double tolerance) const {
        return relative_residual(unbalanced) <= tolerance || free_.gather(unbalanced).norm() <= rounding_force_;
    }

    /// One step downhill in the potential.
    /// @return false where no step was found
    bool step(Field &displacement, const Field &unbalanced) {
        const Eigen::VectorXd gradient = free_.gather(unbalanced);
        for (const Tangent tangent : {Tangent::exact, Tangent::semi_definite}) {
            solver_.factorize(free_.restrict(elastic_hessian(body_, sum(positions_, displacement), tangent)));
            if (solver_.info() != Eigen::Success)
                continue;
            const Eigen::VectorXd direction = -solver_.solve(gradient);
            if (search_line(displacement, direction, gradient.dot(direction)))
                return true;
        }
        return false;
    }

  private:
    bool search_line(Field &displacement, const Eigen::VectorXd &direction, double slope) const {
        const double start = potential(displacement);
        // Close to the minimum the decrease is lost in rounding; a full step is then judged by the residual instead.
        const double rounding = 1e-13 * (std::abs(start) + std::abs(slope));
        for (double scale = 1.0; scale > 1e-6; scale *= 0.5) {
            Field trial = displacement;
            free_.add(trial, direction, scale);
            if (potential(trial) <= start + 1e-4 * scale * slope + rounding) {
                displacement = std::move(trial);
                return true;
            }
        }
        return false;
    }

    const ElasticBody &body_;
    const Field &positions_;
    const NodalConditions &conditions_;
    FreeComponents free_;
    double rounding_force_ = 0.0; ///< the forces that the last digit of the positions makes [N]
    Eigen::CholmodSupernodalLLT<Eigen::SparseMatrix<double>> solver_;
};

/// Only constrained nodes carry a constraint force; what is left on the free ones is the residual.
Field constraint_part(Field unbalanced, const NodalConditions &conditions) {
    for (std::size_t i = 0; i < unbalanced.size(); ++i)
        for (int c = 0; c < 3; ++c)
            if (std::isnan(conditions.displacement[i][c]))
                unbalanced[i][c] = 0.0;
    return unbalanced;
}

} // namespace

Equilibrium find_equilibrium(const ElasticBody &body, const Field &positions, const NodalConditions &conditions,
                             const EquilibriumOptions &options) {
    Newton newton(body, positions, conditions);
    Equilibrium result;
    const auto give_up = [&result](std::string why) {
        result.status = core::SolutionStatus::not_converged;
        result.message = std::move(why);
    };
    if (!newton.solve_linear(result.linear_displacement)) {
        give_up("the body at rest is not stiff in every direction; hold the body at more facets");
        result.displacement = result.linear_displacement;
        result.constraint_force.assign(positions.size(), core::Vector3::Zero());
        return result;
    }
    result.displacement = result.linear_displacement;
    Field unbalanced = newton.unbalanced_force(result.displacement);
    while (!newton.is_balanced(unbalanced, options.tolerance)) {
        if (result.num_iterations == options.max_iterations) {
            give_up(fmt::format("a relative residual of {1:.1e} is left after {0} Newton steps; lower the load",
                                result.num_iterations, newton.relative_residual(unbalanced)));
            break;
        }
        if (!newton.step(result.displacement, unbalanced)) {
            give_up(fmt::format("no step downhill from a relative residual of {:.1e}; lower the load",
                                newton.relative_residual(unbalanced)));
            break;
        }
        ++result.num_iterations;
        unbalanced = newton.unbalanced_force(result.displacement);
    }
    result.constraint_force = constraint_part(std::move(unbalanced), conditions);
    return result;
}

} // namespace livermark::msm
