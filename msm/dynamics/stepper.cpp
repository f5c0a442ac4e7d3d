#include "msm/dynamics/stepper.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <memory>
#include <random>

#include "core/mesh/tetra_mesh.hpp"
#include "core/stopwatch.hpp"
#include "core/support/input_error.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/integrator.hpp"
#include "msm/kernels/fast_steps.hpp"

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

} // namespace livermark::msm
