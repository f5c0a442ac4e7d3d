#include "fem_reference/hyperelastic/motion/energy_momentum.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <iterator>
#include <limits>
#include <optional>
#include <utility>

#include "fem_reference/hyperelastic/motion/effective_mass.hpp"
#include "fem_reference/hyperelastic/motion/motion_forces.hpp"

namespace livermark::hyperelastic {

namespace {

using Unknowns = Eigen::VectorXd;
using core::Vector3;
using fem_reference::Energy;
using fem_reference::Motion;

/// Differences of iterates that Anderson's acceleration combines.
constexpr std::size_t most_differences = 8;
constexpr int most_iterations = 40;
/// A new tangent and its factor take as long as so many iterations: once an old one has cost as many more than it did
/// at first, another one is made.
constexpr int iterations_of_a_factor = 20;
constexpr int most_halvings = 6;

std::span<const double> span_of(const Unknowns &vector) {
    return {vector.data(), static_cast<std::size_t>(vector.size())};
}
std::span<double> span_of(Unknowns &vector) {
    return {vector.data(), static_cast<std::size_t>(vector.size())};
}

/// Anderson's acceleration of x <- x + c(x): the next iterate of the combination of the last ones whose corrections
/// nearly cancel.
class Anderson {
  public:
    Unknowns next(const Unknowns &x, const Unknowns &correction) {
        if (last_) {
            of_x_.push_back(x - last_->first);
            of_correction_.push_back(correction - last_->second);
            if (of_x_.size() > most_differences) {
                of_x_.pop_front();
                of_correction_.pop_front();
            }
        }
        last_.emplace(x, correction);
        Unknowns result = x + correction;
        if (of_x_.empty())
            return result;
        const auto num = static_cast<Eigen::Index>(of_x_.size());
        Eigen::MatrixXd differences(x.size(), num);
        for (Eigen::Index k = 0; k < num; ++k)
            differences.col(k) = of_correction_[k];
        const Unknowns weight = differences.colPivHouseholderQr().solve(correction);
        for (Eigen::Index k = 0; k < num; ++k)
            result -= weight[k] * (of_x_[k] + of_correction_[k]);
        return result;
    }

  private:
    std::optional<std::pair<Unknowns, Unknowns>> last_;
    std::deque<Unknowns> of_x_, of_correction_;
};

} // namespace

struct EnergyMomentum::Impl {
    Impl(const Elements &elements, TetrahedronRule rule, const std::vector<bool> &free,
         const core::RayleighDamping &rayleigh, double force_, double tolerance)
        : is_free(free), damping(rayleigh), largest_residual(tolerance * force_), forces(elements, rule, rayleigh.beta),
          mass(elements, free) {}

    double begin_at(const std::vector<double> &displacement);
    bool step(Motion &motion, std::span<const double> load, double time_step, std::span<const double> target,
              const BallStep &way);
    bool advance(Motion &motion, std::span<const double> load, double time_step, std::span<const double> target,
                 const BallStep &way, int halvings);
    Unknowns first_guess(const Motion &motion, double time_step) const;
    void factorise(const Motion &motion, double time_step, const Vector3 &ball_centre);

    std::vector<bool> is_free;
    core::RayleighDamping damping;
    double largest_residual; ///< [N]
    MotionForces forces;
    EffectiveMass mass;
    MotionForces::AtEnd at_end;
    TouchingBall *ball = nullptr;
    std::array<Vector3, 2> ball_force{Vector3::Zero(), Vector3::Zero()}; ///< half way through the last two steps [N]
    std::vector<double> begun_at;                                        ///< where the forces have begun a step last
    double strain_energy = 0.0;                                          ///< there [J]
    double factored_step = 0.0; ///< that the factor is for [s]; zero if there is none
    int fewest_iterations = -1; ///< of the first step with the factor, negative before
    int excess_iterations = 0;  ///< beyond these, of all steps with it
    /// The last displacements, the newest behind, all a step of the same length apart.
    std::deque<Unknowns> before;
    double step_before = 0.0;
    Work work;
};

/// @return strain energy there [J]
double EnergyMomentum::Impl::begin_at(const std::vector<double> &displacement) {
    if (begun_at != displacement) {
        begun_at = displacement;
        strain_energy = forces.begin_at(displacement);
    }
    return strain_energy;
}

/// A parabola through the last three displacements, because velocities of stiff modes change sign from step to step.
Unknowns EnergyMomentum::Impl::first_guess(const Motion &motion, double time_step) const {
    Unknowns now = Unknowns::Map(motion.displacement.data(), std::ssize(motion.displacement));
    if (before.size() < 3 || step_before != time_step || before.back() != now)
        return now;
    return 3.0 * before[2] - 3.0 * before[1] + before[0];
}

void EnergyMomentum::Impl::factorise(const Motion &motion, double time_step, const Vector3 &ball_centre) {
    SurfaceStiffness surface;
    if (ball)
        ball->add_stiffness(ball_centre, motion.displacement, surface);
    mass.factorise(2.0 / (time_step * time_step) + damping.alpha / time_step, 0.5 + damping.beta / time_step,
                   motion.displacement, surface);
    factored_step = time_step;
    fewest_iterations = -1;
    excess_iterations = 0;
    ++work.factors;
}

/// @return false, and the motion as it was, if it does not converge
bool EnergyMomentum::Impl::step(Motion &motion, std::span<const double> load, double time_step,
                                std::span<const double> target, const BallStep &way) {
    const Vector3 half_way = 0.5 * (way.from + way.to);
    std::vector<double> touched(motion.displacement.size());
    const auto size = std::ssize(motion.displacement);
    const Unknowns start = Unknowns::Map(motion.displacement.data(), size);
    const Unknowns velocity = Unknowns::Map(motion.velocity.data(), size);
    begin_at(motion.displacement);
    Unknowns residual(size), product(size), correction(size);
    const auto put_on_target = [&](Unknowns &u) {
        for (std::size_t dof = 0; dof < target.size(); ++dof)
            if (!is_free[dof])
                u[static_cast<Eigen::Index>(dof)] = target[dof];
    };
    const auto residual_at = [&](const Unknowns &u) {
        const Unknowns mean_velocity = (u - start) / time_step;
        forces.end_at(span_of(u), time_step, at_end);
        if (!at_end.is_possible)
            return std::numeric_limits<double>::infinity();
        mass.multiply_mass(
            span_of(Unknowns(2.0 / time_step * (mean_velocity - velocity) + damping.alpha * mean_velocity)),
            span_of(product));
        if (ball) {
            std::ranges::fill(touched, 0.0);
            ball->add_forces(half_way, span_of(Unknowns(0.5 * (start + u))), touched);
        }
        for (Eigen::Index dof = 0; dof < size; ++dof)
            residual[dof] = is_free[dof] ? load[dof] + touched[dof] - product[dof] - at_end.force[dof] : 0.0;
        return residual.norm();
    };
    for (const bool has_new_factor : {false, true}) {
        if (has_new_factor || factored_step != time_step)
            factorise(motion, time_step, half_way);
        Anderson anderson;
        Unknowns u = first_guess(motion, time_step);
        put_on_target(u);
        double size_of_residual = residual_at(u);
        if (!std::isfinite(size_of_residual)) {
            u = start;
            put_on_target(u);
            size_of_residual = residual_at(u);
        }
        const double first_residual = size_of_residual;
        int iterations = 0;
        while (size_of_residual > largest_residual && iterations < most_iterations &&
               size_of_residual < 1e3 * first_residual) {
            mass.solve(span_of(residual), span_of(correction));
            u = anderson.next(u, correction);
            size_of_residual = residual_at(u);
            ++iterations;
        }
        work.iterations += iterations;
        if (!(size_of_residual <= largest_residual))
            continue;
        if (fewest_iterations < 0)
            fewest_iterations = iterations;
        excess_iterations += iterations - fewest_iterations;
        if (excess_iterations > iterations_of_a_factor)
            factored_step = 0.0;
        if (ball) {
            const Unknowns middle = 0.5 * (start + u);
            ball_force = {ball_force[1], ball->sums(half_way, span_of(middle)).force};
            ball->end_step(half_way, span_of(middle));
            ball->augment(half_way, span_of(middle));
        }
        const Unknowns mean_velocity = (u - start) / time_step;
        Unknowns::Map(motion.displacement.data(), size) = u;
        Unknowns::Map(motion.velocity.data(), size) = 2.0 * mean_velocity - velocity;
        if (step_before != time_step || before.empty() || before.back() != start)
            before.assign({start});
        before.push_back(u);
        if (before.size() > 3)
            before.pop_front();
        step_before = time_step;
        ++work.steps;
        return true;
    }
    return false;
}

bool EnergyMomentum::Impl::advance(Motion &motion, std::span<const double> load, double time_step,
                                   std::span<const double> target, const BallStep &way, int halvings) {
    if (step(motion, load, time_step, target, way))
        return true;
    if (halvings == most_halvings)
        return false;
    std::vector<double> half_way(target.begin(), target.end());
    for (std::size_t dof = 0; dof < half_way.size(); ++dof)
        half_way[dof] = 0.5 * (half_way[dof] + motion.displacement[dof]);
    const Vector3 middle = 0.5 * (way.from + way.to);
    return advance(motion, load, 0.5 * time_step, half_way, {way.from, middle}, halvings + 1) &&
           advance(motion, load, 0.5 * time_step, target, {middle, way.to}, halvings + 1);
}

EnergyMomentum::EnergyMomentum(const Elements &elements, TetrahedronRule rule, const std::vector<bool> &is_free,
                               const core::RayleighDamping &damping, double force, double tolerance)
    : impl_(std::make_unique<Impl>(elements, rule, is_free, damping, force, tolerance)) {}
EnergyMomentum::~EnergyMomentum() = default;
EnergyMomentum::EnergyMomentum(EnergyMomentum &&) noexcept = default;
EnergyMomentum &EnergyMomentum::operator=(EnergyMomentum &&) noexcept = default;

void EnergyMomentum::touch_with(TouchingBall *ball) {
    impl_->ball = ball;
    impl_->factored_step = 0.0;
}

Vector3 EnergyMomentum::force_of_ball() const {
    return 1.5 * impl_->ball_force[1] - 0.5 * impl_->ball_force[0];
}

bool EnergyMomentum::advance(Motion &motion, std::span<const double> load, double time_step,
                             std::span<const double> target, const BallStep &ball) {
    return impl_->advance(motion, load, time_step, target, ball, 0);
}

Energy EnergyMomentum::energy(const Motion &motion) {
    std::vector<double> momentum(motion.velocity.size());
    impl_->mass.multiply_mass(motion.velocity, momentum);
    double kinetic = 0.0;
    for (std::size_t dof = 0; dof < momentum.size(); ++dof)
        kinetic += 0.5 * motion.velocity[dof] * momentum[dof];
    return {.kinetic = kinetic, .strain = impl_->begin_at(motion.displacement)};
}

EnergyMomentum::Work EnergyMomentum::work() const {
    return impl_->work;
}

} // namespace livermark::hyperelastic
