#include "msm/dynamics/stepper.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <memory>
#include <random>
#include <utility>

#include "core/mesh/tetra_mesh.hpp"
#include "core/stopwatch.hpp"
#include "core/support/input_error.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/elastic_body.hpp"
#include "msm/integrator.hpp"
#include "msm/kernels/fast_steps.hpp"
#include "msm/kernels/relaxation.hpp"

namespace livermark::msm {

EquationOfMotion elastic_motion(const ElasticBody &body, const Field &positions, const NodalConditions &conditions,
                                const core::RayleighDamping &damping, const MassScaling &scaling) {
    EquationOfMotion equation;
    Field mass(positions.size()), is_free(positions.size());
    for (std::size_t i = 0; i < positions.size(); ++i) {
        mass[i].setConstant(body.node_mass[i]);
        for (int c = 0; c < 3; ++c)
            is_free[i][c] = std::isnan(conditions.displacement[i][c]) ? 1.0 : 0.0;
    }
    equation.mass = to_unknowns(mass);
    const Eigen::VectorXd free = to_unknowns(is_free);
    const Eigen::VectorXd free_per_mass = free.cwiseQuotient(equation.mass);

    equation.acceleration = [body, free_per_mass, free, rest = to_unknowns(positions),
                             load = to_unknowns(conditions.force), damping, scaling, x = Eigen::VectorXd()](
                                const Eigen::VectorXd &u, const Eigen::VectorXd &v, Eigen::VectorXd &a) mutable {
        x = rest + u;
        a = load;
        for (const auto &term : body.terms)
            term->add_force(x, v, damping.beta, a);
        a = a.cwiseProduct(free_per_mass);
        scale_acceleration(scaling, x, v, a);
        a -= damping.alpha * v.cwiseProduct(free); // in proportion to the mass that is scaled
    };
    equation.effective_mass = [body, rest = to_unknowns(positions), mass = equation.mass, free,
                               damping](const Eigen::VectorXd &u, double d, double k) {
        const Eigen::VectorXd x = rest + u;
        Eigen::SparseMatrix<double> matrix(x.size(), x.size());
        // What compression makes negative would make the matrix indefinite; the solution does not depend on it.
        for (const auto &term : body.terms)
            matrix +=
                k * term->hessian(x, Tangent::semi_definite) + d * damping.beta * term->hessian(x, Tangent::material);
        matrix = free.asDiagonal() * matrix * free.asDiagonal();
        matrix.diagonal() += mass.cwiseProduct(Eigen::VectorXd::Ones(mass.size()) + d * damping.alpha * free);
        return matrix;
    };
    return equation;
}

double kinetic_energy(const EquationOfMotion &equation, const State &state) {
    return 0.5 * state.velocity.dot(equation.mass.cwiseProduct(state.velocity));
}

const char *to_string(StepKernel kernel) {
    switch (kernel) {
    case StepKernel::scalar:
        return "scalar";
    case StepKernel::simd_double:
        return "simd_double";
    case StepKernel::simd_float:
        return "simd_float";
    }
    return "";
}

Stepper make_stepper(const ElasticBody &body, const Field &positions, const NodalConditions &conditions,
                     const core::RayleighDamping &damping, const Integrator &integrator, double time_step,
                     StepKernel wanted) {
    if (wanted != StepKernel::scalar) {
        const auto precision =
            wanted == StepKernel::simd_float ? ForcePrecision::single_precision : ForcePrecision::double_precision;
        if (auto fast = FastSteps::prepare(
                body, positions, conditions, damping, integrator.name, time_step,
                {.precision = precision, .num_threads = 1, .num_stages = integrator.forces_per_step}))
            return {wanted, [steps = *fast](State &state, int num_steps) mutable {
                        steps.set_state(state);
                        steps.take(num_steps);
                        state = steps.state();
                    }};
    }
    const auto equation = std::make_shared<EquationOfMotion>(elastic_motion(body, positions, conditions, damping));
    return {StepKernel::scalar,
            [equation, step = integrator.prepare(*equation, time_step)](State &state, int num_steps) {
                for (int s = 0; s < num_steps; ++s)
                    step(state);
            }};
}

namespace {

/// Size of the push, relative to that of the mesh: far inside the linear range even when it has grown, and far above
/// the rounding of the positions.
constexpr double push = 1e-9;
constexpr double widest_bracket = 1e4;
constexpr double first_bracket = 2.0;

/// A displacement of every free component, between -scale and scale.
Eigen::VectorXd random_displacement(const NodalConditions &conditions, double scale) {
    std::mt19937 generator(2007); // its sequence is laid down in the standard, that of distributions is not
    Field displacement(conditions.displacement.size(), core::Vector3::Zero());
    for (std::size_t i = 0; i < displacement.size(); ++i)
        for (int c = 0; c < 3; ++c) {
            const double part = 2.0 * generator() / std::mt19937::max() - 1.0;
            if (std::isnan(conditions.displacement[i][c]))
                displacement[i][c] = scale * part;
        }
    return to_unknowns(displacement);
}

} // namespace

double observed_time_step(const Integrator &integrator, const ElasticBody &body, const Field &positions,
                          const NodalConditions &conditions, const core::RayleighDamping &damping, double guess,
                          const ObservationOptions &options) {
    NodalConditions unloaded = conditions;
    unloaded.force.assign(positions.size(), core::Vector3::Zero());
    auto equation = elastic_motion(body, positions, unloaded, damping, options.scaling);
    int num_accelerations = 0;
    equation.acceleration = [uncounted = equation.acceleration, &num_accelerations](
                                const Eigen::VectorXd &u, const Eigen::VectorXd &v, Eigen::VectorXd &a) {
        ++num_accelerations;
        uncounted(u, v, a);
    };
    const auto start = random_displacement(conditions, push * core::extent(positions));
    const double bound = options.growth * start.norm();

    const auto time_step = [&](int power) { return std::pow(1.0 + options.accuracy, power); };
    const auto is_stable = [&](int power) {
        const auto step = integrator.prepare(equation, time_step(power));
        State state{start, Eigen::VectorXd::Zero(start.size())};
        num_accelerations = 0;
        for (int s = 0; s < options.num_steps || num_accelerations < options.num_accelerations; ++s) {
            step(state);
            if (!(state.displacement.norm() <= bound))
                return false;
        }
        return true;
    };

    const double powers_per_factor = 1.0 / std::log1p(options.accuracy);
    const int middle = static_cast<int>(std::lround(std::log(guess) * powers_per_factor));
    const int reach = static_cast<int>(std::lround(std::log(widest_bracket) * powers_per_factor));
    const int stride = static_cast<int>(std::lround(std::log(first_bracket) * powers_per_factor));
    int good = middle - stride;
    int bad = middle + stride;
    while (!is_stable(good)) {
        bad = good;
        good -= stride;
        if (good < middle - reach)
            return 0.0;
    }
    while (is_stable(bad)) {
        good = bad;
        bad += stride;
        if (bad > middle + reach)
            return std::numeric_limits<double>::infinity();
    }
    while (bad - good > 1) {
        const int between = good + (bad - good) / 2;
        (is_stable(between) ? good : bad) = between;
    }
    return time_step(good);
}

namespace {

/// The other core may be busy with the same memory: the shortest of these is close to what an idle machine takes.
constexpr int num_timed_steps = 40;
constexpr auto integrator_name = "symplectic_euler";

double critical(double highest) {
    return critical_time_step(find_integrator(integrator_name), {}, highest, highest);
}

} // namespace

core::ExplicitSteps explicit_steps(const ElasticBody &body, const Field &positions, const NodalConditions &conditions,
                                   double highest) {
    const auto &integrator = find_integrator(integrator_name);
    core::ExplicitSteps steps;
    if (!(highest > 0.0))
        return steps; // nothing can move: every step is stable
    steps.critical_time_step = critical(highest);
    const double time_step = default_safety_factor * steps.critical_time_step;
    const auto measure = [&](const std::function<void()> &take_step) {
        take_step(); // brings everything into the caches
        for (int s = 0; s < num_timed_steps; ++s) {
            const auto start = core::Clock::now();
            take_step();
            const double seconds = core::seconds_since(start);
            steps.seconds_per_step = s == 0 ? seconds : std::min(steps.seconds_per_step, seconds);
        }
    };
    if (auto fast = FastSteps::prepare(body, positions, conditions, {}, integrator.name, time_step)) {
        steps.kernel = to_string(StepKernel::simd_float);
        measure([&] { fast->take(1); });
    } else {
        steps.kernel = to_string(StepKernel::scalar);
        const auto stepper = make_stepper(body, positions, conditions, {}, integrator, time_step, StepKernel::scalar);
        const auto size = static_cast<Eigen::Index>(3 * positions.size());
        State state{Eigen::VectorXd::Zero(size), Eigen::VectorXd::Zero(size)};
        measure([&] { stepper.take(state, 1); });
    }
    return steps;
}

core::ExplicitSteps constrained_otherwise(core::ExplicitSteps steps, double highest) {
    if (!(highest > 0.0))
        return {};
    steps.critical_time_step = critical(highest);
    return steps;
}

namespace {

void check(double ratio, double omega) {
    if (!(ratio >= 0.0) || !std::isfinite(ratio))
        throw support::InputError(fmt::format("the damping ratio is {}; it has to be zero or more", ratio));
    if (!(omega > 0.0) || !std::isfinite(omega))
        throw support::InputError(
            fmt::format("the angular frequency of a damping ratio is {} rad/s; it has to be positive", omega));
}

} // namespace

core::RayleighDamping mass_proportional_damping(double ratio, double omega) {
    check(ratio, omega);
    return {.alpha = 2.0 * ratio * omega, .beta = 0.0};
}

core::RayleighDamping stiffness_proportional_damping(double ratio, double omega) {
    check(ratio, omega);
    return {.alpha = 0.0, .beta = 2.0 * ratio / omega};
}

core::RayleighDamping two_mode_damping(double ratio_1, double omega_1, double ratio_2, double omega_2) {
    check(ratio_1, omega_1);
    check(ratio_2, omega_2);
    if (omega_1 == omega_2)
        throw support::InputError(
            fmt::format("both damping ratios are those of {} rad/s; give two frequencies that differ", omega_1));
    const double difference = (omega_2 - omega_1) * (omega_2 + omega_1);
    const core::RayleighDamping damping{.alpha = 2.0 * omega_1 * omega_2 * (ratio_1 * omega_2 - ratio_2 * omega_1) /
                                                 difference,
                                        .beta = 2.0 * (ratio_2 * omega_2 - ratio_1 * omega_1) / difference};
    if (damping.alpha < 0.0 || damping.beta < 0.0)
        throw support::InputError(fmt::format("damping ratios of {} at {} rad/s and {} at {} rad/s need a negative {}; "
                                              "bring the ratios nearer to each other than the frequencies are",
                                              ratio_1, omega_1, ratio_2, omega_2,
                                              damping.alpha < 0.0 ? "alpha" : "beta"));
    return damping;
}

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
    auto result = body_;
    if (relaxation_.is_elastic())
        return result;
    result.preconditioner = nullptr; // that is of one part for all
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
