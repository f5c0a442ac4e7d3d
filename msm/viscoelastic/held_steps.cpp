#include "msm/viscoelastic/held_steps.hpp"

#include <cmath>
#include <utility>

#include "msm/dynamics/elastic_motion.hpp"
#include "msm/viscoelastic/relaxing_term.hpp"

namespace livermark::msm {

struct HeldSteps::Implementation {
    /// The stresses of a term, and what each branch has taken off them.
    struct HeldStress {
        std::shared_ptr<const RelaxingTerm> term;
        std::vector<Eigen::VectorXd> taken; ///< (B) of (S), q
        Eigen::VectorXd sum;                ///< (S) of these
    };

    Implementation(const ElasticBody &body, core::PronySeries series, const std::vector<core::Vector3> &positions,
                   const NodalConditions &conditions, const core::RayleighDamping &damping,
                   const Integrator &integrator, double step, int held)
        : relaxation(std::move(series)), rest(to_unknowns(positions)), free_per_mass(rest.size()), time_step(step),
          num_held(held), back(integrator.name == "symplectic_euler" ? 0.5 * step : 0.0),
          equation(elastic_motion(body, positions, conditions, damping)) {
        for (const auto &term : body.terms)
            if (auto relaxing = std::dynamic_pointer_cast<const RelaxingTerm>(term)) {
                const Eigen::VectorXd zero = Eigen::VectorXd::Zero(relaxing->relaxing_compliance().size());
                stresses.push_back(
                    {std::move(relaxing), std::vector<Eigen::VectorXd>(relaxation.moduli.size(), zero), zero});
            }
        for (std::size_t i = 0; i < positions.size(); ++i)
            for (int c = 0; c < 3; ++c)
                free_per_mass[3 * static_cast<Eigen::Index>(i) + c] =
                    std::isnan(conditions.displacement[i][c]) ? 1.0 / body.node_mass[i] : 0.0;
        equation.acceleration = [this, elastic = equation.acceleration, force = Eigen::VectorXd()](
                                    const Eigen::VectorXd &u, const Eigen::VectorXd &v, Eigen::VectorXd &a) mutable {
            elastic(u, v, a);
            force.setZero(u.size());
            for (const auto &stress : stresses)
                stress.term->add_force_of(rest + u, -stress.sum, force);
            a += force.cwiseProduct(free_per_mass);
        };
        take_one = integrator.prepare(equation, time_step);
    }

    void relax(const Eigen::VectorXd &displacement, double time) {
        const Eigen::VectorXd x = rest + displacement;
        for (auto &[term, taken, sum] : stresses) {
            const Eigen::VectorXd stress = term->relaxing_stress(x);
            sum.setZero();
            for (std::size_t b = 0; b < taken.size(); ++b) {
                const double tau = relaxation.times[b], share = std::isinf(tau) ? 0.0 : -std::expm1(-time / tau);
                taken[b] += share * (relaxation.moduli[b] * stress - taken[b]);
                sum += taken[b];
            }
        }
    }

    core::PronySeries relaxation;
    Eigen::VectorXd rest, free_per_mass; ///< (3N)
    double time_step;
    int num_held;
    double back; ///< [s] how far positions are taken back along velocities where branches relax
    std::vector<HeldStress> stresses;
    EquationOfMotion equation;
    Step take_one;
    int num_taken = 0; ///< since the branches were last where the body is
};

HeldSteps::HeldSteps(const ElasticBody &body, const core::PronySeries &relaxation,
                     const std::vector<core::Vector3> &positions, const NodalConditions &conditions,
                     const core::RayleighDamping &damping, const Integrator &integrator, double time_step, int num_held)
    : implementation_(std::make_unique<Implementation>(body, relaxation, positions, conditions, damping, integrator,
                                                       time_step, num_held)) {}
HeldSteps::~HeldSteps() = default;
HeldSteps::HeldSteps(HeldSteps &&) noexcept = default;
HeldSteps &HeldSteps::operator=(HeldSteps &&) noexcept = default;

void HeldSteps::relax(const Eigen::VectorXd &displacement, double time) {
    implementation_->relax(displacement, time);
    implementation_->num_taken = 0;
}

void HeldSteps::take(State &state, int num_steps) {
    auto &at = *implementation_;
    for (int step = 0; step < num_steps; ++step, ++at.num_taken) {
        const double held = at.num_held * at.time_step;
        if (at.num_taken % at.num_held == 0) // from the middle of the steps before to that of the next ones
            at.relax(state.displacement - at.back * state.velocity, at.num_taken == 0 ? 0.5 * held : held);
        at.take_one(state);
    }
}

} // namespace livermark::msm
