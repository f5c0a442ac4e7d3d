#include "fem_reference/hyperelastic/motion.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <iterator>
#include <limits>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <utility>

#include "core/stopwatch.hpp"
#include "fem_reference/hyperelastic/elements.hpp"
#include "fem_reference/hyperelastic/motion_forces.hpp"
#include "fem_reference/linear/conditions.hpp"

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

namespace {

/// Size of what holds a body in balance at the start, reactions and loads: what a motion is measured by.
double force_at(const Elements &elements, const std::vector<double> &displacement) {
    double square = 0.0;
    for (const double force : elements.internal_forces({displacement, {}}).force)
        square += force * force;
    return std::sqrt(square);
}

} // namespace

ReleasedBody release(const Elements &elements, TetrahedronRule rule, const core::LoadCase &load_case,
                     std::vector<double> displacement) {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    const auto start = core::Clock::now();
    const auto &plan = load_case.release.value();
    const auto conditions = fem_reference::dof_conditions(core::without_tractions(load_case), elements.system());
    std::vector<bool> is_free;
    for (const double value : conditions.prescribed)
        is_free.push_back(std::isnan(value));
    EnergyMomentum steps(elements, rule, is_free, plan.damping, force_at(elements, displacement));
    fem_reference::Motion motion{std::move(displacement), std::vector<double>(is_free.size(), 0.0)};

    core::History history;
    history.integrator = "energy_momentum";
    history.time_step = plan.output_interval;
    history.setup_seconds = core::seconds_since(start);
    const auto motion_start = core::Clock::now();
    const auto &mesh_node = elements.system().mesh_node;
    const auto record = [&](int step, bool is_lost) {
        const auto displacement_of = [&](int node) -> core::Vector3 {
            if (is_lost)
                return core::Vector3::Constant(nan);
            return core::Vector3::Map(&motion.displacement[3 * mesh_node[node]]);
        };
        history.time.push_back(step * plan.output_interval);
        for (const auto &probe : plan.probes)
            history.displacement.push_back(displacement_of(probe.node));
        if (plan.is_frame(step))
            for (std::size_t node = 0; node < mesh_node.size(); ++node)
                history.frames.emplace_back(displacement_of(static_cast<int>(node)).cast<float>());
        const auto energy = is_lost ? fem_reference::Energy{nan, nan} : steps.energy(motion);
        history.kinetic_energy.push_back(energy.kinetic);
        history.strain_energy.push_back(energy.strain);
    };
    record(0, false);
    for (int step = 1; step <= plan.num_steps; ++step) {
        const bool was_lost = !std::isnan(history.diverged_at);
        if (!was_lost && !steps.advance(motion, conditions.load, plan.output_interval))
            history.diverged_at = step * plan.output_interval;
        record(step, !std::isnan(history.diverged_at));
    }
    history.solve_seconds = core::seconds_since(motion_start);
    return {std::move(history), steps.work()};
}

namespace {

using fem_reference::DofConditions;
using fem_reference::ElasticSystem;

/// Displacements prescribed along the way, at all unknowns.
class Way {
  public:
    Way(const core::LoadCase &load_case, const ElasticSystem &system)
        : pressed_(fem_reference::dof_conditions(load_case, system)),
          slid_(fem_reference::dof_conditions(core::with_slide(load_case), system).prescribed),
          tool_(load_case.tool.value()) {}

    std::vector<double> at(double time) const {
        const auto position = core::tool_position(tool_, time);
        std::vector<double> target(slid_.size(), 0.0);
        for (std::size_t dof = 0; dof < target.size(); ++dof)
            if (is_tool(dof))
                target[dof] = position.pressed * pressed_.prescribed[dof] + position.slid * slid_[dof];
        return target;
    }

    /// The sum of forces at the nodes of the place.
    core::Vector3 sum(const std::vector<double> &force) const {
        core::Vector3 sum = core::Vector3::Zero();
        for (std::size_t dof = 0; dof < force.size(); ++dof)
            if (is_tool(dof))
                sum[static_cast<Eigen::Index>(dof % 3)] += force[dof];
        return sum;
    }

  private:
    bool is_tool(std::size_t dof) const { return pressed_.constraint[dof] == tool_.constraint; }

    DofConditions pressed_;
    std::vector<double> slid_;
    core::ToolMotion tool_;
};

std::vector<bool> free_dofs(const core::LoadCase &load_case, const ElasticSystem &system) {
    std::vector<bool> is_free;
    for (const double value : fem_reference::dof_conditions(load_case, system).prescribed)
        is_free.push_back(std::isnan(value));
    return is_free;
}

/// About what a tool presses with: Young's modulus times its size and its depth.
double order_of_force(const core::Body &body, const core::LoadCase &load_case) {
    double area = 0.0, modulus = 0.0;
    if (const auto &ball = load_case.touching)
        area = std::numbers::pi * std::pow(ball->contact().radius, 2);
    for (int f = 0; f < body.mesh.num_boundary_triangles(); ++f)
        if (load_case.constraint_on(f) == load_case.tool->constraint)
            area += core::area_vector(body.mesh, f).norm();
    for (const auto &material : body.materials)
        modulus = std::max(modulus, material.young_modulus);
    return modulus * std::sqrt(area) * load_case.target_peak_displacement;
}

} // namespace

core::ToolHistory move_tool(const core::Problem &problem, const MaterialLaw &law, int degree, int steps_per_frame,
                            TetrahedronRule rule_of_quadratic) {
    const auto &load_case = problem.load_case;
    if (!load_case.tool || steps_per_frame < 1)
        throw std::invalid_argument("a tool moves in a load case that has one, in a step or more per frame");
    const auto &tool = *load_case.tool;
    const auto rule = degree == 1 ? TetrahedronRule::one_point : rule_of_quadratic;
    const Elements elements(problem.body, degree, fem_reference::Formulation::displacement, law, rule);
    const auto &system = elements.system();
    const Way way(load_case, system);
    const core::RayleighDamping damping{.alpha = tool.mass_damping, .beta = 0.0};
    const double force = order_of_force(*problem.body, load_case);
    std::optional<EnergyMomentum> steps(std::in_place, elements, rule, free_dofs(load_case, system), damping, force);
    const std::vector<double> load(static_cast<std::size_t>(elements.num_displacements()), 0.0);
    fem_reference::Motion motion{load, load};
    std::optional<TouchingBall> ball;
    if (load_case.touching) {
        ball.emplace(system, *problem.body, load_case);
        steps->touch_with(&*ball);
    }
    const auto centre_at = [&](double time) {
        if (!ball)
            return core::Vector3(core::Vector3::Zero());
        const auto position = core::tool_position(tool, time);
        return core::Vector3(ball->tool().start + position.pressed * ball->tool().press + position.slid * tool.slide);
    };
    const auto force_on_tool = [&] {
        return ball ? core::Vector3(-steps->force_of_ball())
                    : core::Vector3(-way.sum(elements.internal_forces({motion.displacement, {}}).force));
    };
    core::ToolHistory history;
    const int last_held = core::last_record_held(tool);
    const auto record = [&](int frame) {
        history.time.push_back(tool.time_of(frame));
        history.force.emplace_back(frame <= last_held ? force_on_tool() : core::Vector3(core::Vector3::Zero()));
        if (core::ToolHistory::has_field(frame))
            for (const int node : system.mesh_node)
                history.displacement.emplace_back(core::Vector3::Map(&motion.displacement[3 * node]).cast<float>());
    };
    record(0);
    const double time_step = tool.frame_interval / steps_per_frame;
    for (int frame = 1; frame <= tool.num_frames; ++frame) {
        const double start = tool.time_of(frame - 1);
        if (frame == last_held + 1)
            steps.emplace(elements, rule, free_dofs(core::let_go(load_case), system), damping, force);
        for (int step = 1; step <= steps_per_frame; ++step) {
            const double end = start + step * time_step;
            const auto target = frame > last_held ? std::vector<double>{} : way.at(end);
            if (!steps->advance(motion, load, time_step, target, {centre_at(end - time_step), centre_at(end)}))
                return history;
        }
        record(frame);
    }
    return history;
}

} // namespace livermark::hyperelastic
