#include "msm/viscoelastic/relaxing_stepper.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "msm/dynamics/stepper.hpp"
#include "msm/elastic_body.hpp"
#include "msm/kernels/fast_steps.hpp"
#include "msm/kernels/relaxation.hpp"

namespace livermark::msm {

namespace {

/// The term as one that relaxes; null if it stays elastic.
std::shared_ptr<const RelaxingTerm> as_relaxing(const std::shared_ptr<const ElasticTerm> &term) {
    return std::dynamic_pointer_cast<const RelaxingTerm>(term);
}

} // namespace

ElasticBody relaxed(const ElasticBody &body, double part) {
    auto result = body;
    for (auto &term : result.terms)
        if (const auto relaxing = as_relaxing(term))
            term = relaxing->relaxed(part, {});
    if (body.preconditioner)
        result.preconditioner = [whole = body.preconditioner, part](double left) { return whole(left * part); };
    return result;
}

RelaxingBody::RelaxingBody(ElasticBody body, core::PronySeries relaxation)
    : body_(std::move(body)), relaxation_(std::move(relaxation)) {
    for (std::size_t t = 0; t < body_.terms.size(); ++t)
        if (auto term = as_relaxing(body_.terms[t])) {
            auto &part = parts_.emplace_back();
            part.term = t;
            part.remains = term->relaxed(relaxation_.remaining(), {});
            part.compliance = term->relaxing_compliance();
            part.stress = Eigen::VectorXd::Zero(part.compliance.size());
            part.branches.assign(relaxation_.moduli.size(), part.stress);
            part.instant = std::move(term);
        }
}

ElasticBody RelaxingBody::after(double step) const {
    const auto steps = core::branch_steps(relaxation_, step);
    const double instant = core::instant_part(relaxation_, steps);
    auto result = relaxation_.is_elastic() ? body_ : ElasticBody(body_.node_mass, body_.terms);
    if (relaxation_.is_elastic())
        return result;
    for (const auto &part : parts_) {
        Eigen::VectorXd added = Eigen::VectorXd::Zero(part.stress.size());
        for (std::size_t k = 0; k < steps.size(); ++k)
            added += steps[k].fade * part.branches[k] - steps[k].gain * part.stress;
        result.terms[part.term] = part.instant->relaxed(instant, added);
    }
    return result;
}

void RelaxingBody::go_on(const Eigen::VectorXd &x, double step) {
    const auto steps = core::branch_steps(relaxation_, step);
    for (auto &part : parts_) {
        Eigen::VectorXd stress = part.instant->relaxing_stress(x);
        const Eigen::VectorXd change = stress - part.stress;
        for (std::size_t k = 0; k < steps.size(); ++k) {
            auto &branch = part.branches[k];
            const Eigen::VectorXd per_compliance = part.compliance.cwiseProduct(branch);
            dissipated_ += steps[k].dissipated(per_compliance.dot(branch), per_compliance.dot(change),
                                               part.compliance.cwiseProduct(change).dot(change));
            branch = steps[k].fade * branch + steps[k].gain * change;
        }
        part.stress = std::move(stress);
    }
}

void RelaxingBody::add_force(const Eigen::VectorXd &x, const Eigen::VectorXd &v, double beta,
                             Eigen::VectorXd &force) const {
    for (const auto &term : body_.terms)
        term->add_force(x, v, beta, force);
    for (const auto &part : parts_) {
        Eigen::VectorXd faded = (relaxation_.remaining() - 1.0) * part.stress;
        for (const auto &branch : part.branches)
            faded += branch;
        part.instant->add_force_of(x, faded, force);
    }
}

double RelaxingBody::stored_energy(const Eigen::VectorXd &x) const {
    double energy = 0.0;
    for (std::size_t t = 0; t < body_.terms.size(); ++t)
        if (std::ranges::find(parts_, t, &Part::term) == parts_.end())
            energy += body_.terms[t]->energy(x);
    const auto steps = core::branch_steps(relaxation_, 0.0);
    for (const auto &part : parts_) {
        energy += part.remains->energy(x);
        for (std::size_t k = 0; k < steps.size(); ++k)
            energy += steps[k].stored(part.compliance.cwiseProduct(part.branches[k]).dot(part.branches[k]));
    }
    return energy;
}

HeldSteps::HeldSteps(const ElasticBody &body, const core::PronySeries &relaxation, const Field &positions,
                     const NodalConditions &conditions, const core::RayleighDamping &damping,
                     const Integrator &integrator, double time_step, int num_held)
    : relaxation_(relaxation), rest_(to_unknowns(positions)), free_per_mass_(rest_.size()), time_step_(time_step),
      num_held_(num_held), back_(integrator.name == "symplectic_euler" ? 0.5 * time_step : 0.0),
      equation_(elastic_motion(body, positions, conditions, damping)) {
    for (const auto &term : body.terms)
        if (auto relaxing = as_relaxing(term)) {
            const Eigen::VectorXd zero = Eigen::VectorXd::Zero(relaxing->relaxing_compliance().size());
            stresses_.push_back(
                {std::move(relaxing), std::vector<Eigen::VectorXd>(relaxation_.moduli.size(), zero), zero});
        }
    for (std::size_t i = 0; i < positions.size(); ++i)
        for (int c = 0; c < 3; ++c)
            free_per_mass_[3 * static_cast<Eigen::Index>(i) + c] =
                std::isnan(conditions.displacement[i][c]) ? 1.0 / body.node_mass[i] : 0.0;
    equation_.acceleration = [this, elastic = equation_.acceleration, force = Eigen::VectorXd()](
                                 const Eigen::VectorXd &u, const Eigen::VectorXd &v, Eigen::VectorXd &a) mutable {
        elastic(u, v, a);
        force.setZero(u.size());
        for (const auto &stress : stresses_)
            stress.term->add_force_of(rest_ + u, -stress.sum, force);
        a += force.cwiseProduct(free_per_mass_);
    };
    take_one_ = integrator.prepare(equation_, time_step_);
}

void HeldSteps::relax(const Eigen::VectorXd &displacement, double time) {
    const Eigen::VectorXd x = rest_ + displacement;
    for (auto &[term, taken, sum] : stresses_) {
        const Eigen::VectorXd stress = term->relaxing_stress(x);
        sum.setZero();
        for (std::size_t b = 0; b < taken.size(); ++b) {
            const double tau = relaxation_.times[b], share = std::isinf(tau) ? 0.0 : -std::expm1(-time / tau);
            taken[b] += share * (relaxation_.moduli[b] * stress - taken[b]);
            sum += taken[b];
        }
    }
    num_taken_ = 0;
}

void HeldSteps::take(State &state, int num_steps) {
    for (int step = 0; step < num_steps; ++step, ++num_taken_) {
        const double held = num_held_ * time_step_;
        if (num_taken_ % num_held_ == 0) { // from the middle of the steps before to that of the next ones
            const int before = num_taken_;
            relax(state.displacement - back_ * state.velocity, before == 0 ? 0.5 * held : held);
            num_taken_ = before;
        }
        take_one_(state);
    }
}

namespace {

/// Parts of the time between two records. In each the body is taken to stay in the middle of its way.
constexpr int parts_of_a_record = 8;

Eigen::VectorXd displacement_of(const core::PathPoint &point) {
    Eigen::VectorXd displacement(3 * static_cast<Eigen::Index>(point.displacement.size()));
    for (std::size_t i = 0; i < point.displacement.size(); ++i)
        displacement.segment<3>(3 * static_cast<Eigen::Index>(i)) = point.displacement[i].cast<double>();
    return displacement;
}

/// @param stay  lets a body stay in a displacement for a time
template <class Stay>
void follow_records(const std::vector<double> &times, std::span<const core::PathPoint> history, const Stay &stay) {
    for (std::size_t k = 1; k < history.size(); ++k) {
        const auto before = displacement_of(history[k - 1]), after = displacement_of(history[k]);
        for (int part = 0; part < parts_of_a_record; ++part) {
            const double on_the_way = (part + 0.5) / parts_of_a_record;
            stay((1.0 - on_the_way) * before + on_the_way * after, (times[k] - times[k - 1]) / parts_of_a_record);
        }
    }
}

} // namespace

Stepper make_relaxing_stepper(const ElasticBody &body, const core::Problem &problem, const NodalConditions &conditions,
                              const core::RayleighDamping &damping, const Integrator &integrator, double time_step,
                              StepKernel wanted, std::span<const core::PathPoint> history) {
    const auto &positions = problem.body->mesh.points;
    const auto &[relaxation, times, factors, last_cycle] = problem.load_case.slow_history.value();
    FastStepOptions options{.num_threads = 1, .num_stages = integrator.forces_per_step, .relaxation = relaxation};
    if (wanted != StepKernel::scalar) {
        options.precision =
            wanted == StepKernel::simd_float ? ForcePrecision::single_precision : ForcePrecision::double_precision;
        if (auto fast = FastSteps::prepare(body, positions, conditions, damping, integrator.name, time_step, options)) {
            follow_records(times, history, [&](const Eigen::VectorXd &displacement, double time) {
                fast->set_state({displacement, Eigen::VectorXd::Zero(displacement.size())});
                fast->relax(time);
            });
            return {wanted, [steps = *fast](State &state, int num_steps) mutable {
                        steps.set_state(state);
                        steps.take(num_steps);
                        state = steps.state();
                    }};
        }
    }
    const int num_held = steps_between_turns(relaxation, options.relaxation_error, time_step);
    const auto slow =
        std::make_shared<HeldSteps>(body, relaxation, positions, conditions, damping, integrator, time_step, num_held);
    follow_records(times, history,
                   [&](const Eigen::VectorXd &displacement, double time) { slow->relax(displacement, time); });
    return {StepKernel::scalar, [slow](State &state, int num_steps) { slow->take(state, num_steps); }};
}

} // namespace livermark::msm
