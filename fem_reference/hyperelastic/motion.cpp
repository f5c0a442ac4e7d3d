#include "fem_reference/hyperelastic/motion.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Dense>
#include <Eigen/LU>
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
#include "fem_reference/dynamics/modes.hpp"
#include "fem_reference/hyperelastic/elements.hpp"
#include "fem_reference/linear/conditions.hpp"

namespace livermark::hyperelastic {

EffectiveMass::EffectiveMass(const Elements &elements, std::vector<bool> is_free)
    : elements_(&elements), mass_(fem_reference::consistent_mass(elements.body(), elements.system())),
      tangent_(elements.zero_tangent()), factor_(tangent_.stiffness.rows, std::move(is_free)) {}

void EffectiveMass::multiply_mass(std::span<const double> x, std::span<double> out) const {
    fem_reference::multiply_mass(mass_, x, out);
}

void EffectiveMass::factorise(double m, double k, const std::vector<double> &displacement,
                              const SurfaceStiffness &surface) {
    elements_->assemble_tangent({displacement, {}}, tangent_);
    surface.add_to(tangent_.stiffness);
    if (factorise(m, k))
        return;
    elements_->assemble_tangent(elements_->rest(), tangent_);
    surface.add_to(tangent_.stiffness);
    if (!factorise(m, k))
        throw std::logic_error("a body with mass has a stiffness at rest that is not positive semidefinite");
}

bool EffectiveMass::factorise(double m, double k) {
    auto matrix = tangent_.stiffness;
    const auto combine = [&](fem_reference::Block<double> &block, int mass_entry) {
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                block[3 * i + j] = k * block[3 * i + j] + (i == j ? m * mass_.value[mass_entry] : 0.0);
    };
    for (std::size_t a = 0; a < matrix.rows.num_nodes(); ++a) {
        int entry = mass_.row_start[a]; // columns up to that of the diagonal come in the order of the blocks
        for (int block = matrix.rows.row_start[a]; block < matrix.rows.row_start[a + 1]; ++block)
            combine(matrix.below[block], entry++);
        combine(matrix.diagonal[a], entry);
    }
    return factor_.factorise(matrix);
}

void EffectiveMass::solve(std::span<const double> b, std::span<double> x) const {
    factor_.solve(b, x);
}

namespace {

/// Stress and energy at a point.
struct Response {
    Matrix3 stress; ///< second Piola-Kirchhoff [Pa]
    double energy;  ///< [Pa]
};

/// @param jacobian  det F > 0
Response response(const MaterialLaw &law, const core::Material &material, const Matrix3 &f, double jacobian) {
    const Matrix3 inverse = f.inverse();
    const auto volume = law.volume(jacobian);
    const double modulus = law.volume_modulus(material);
    const Matrix3 first =
        law.stress(material, f) + modulus * volume.value * volume.slope * jacobian * inverse.transpose();
    return {inverse * first, law.energy(material, f) + 0.5 * modulus * volume.value * volume.value};
}

/// S(C) of an objective law: any F with F^T F = C has it.
Matrix3 stress_of(const MaterialLaw &law, const core::Material &material, const Matrix3 &c) {
    const Matrix3 f = c.llt().matrixU();
    return response(law, material, f, f.diagonal().prod()).stress;
}

/// Displacements of the nodes of a tetrahedron, one per column.
template <int nodes>
Eigen::Matrix<double, 3, nodes> gather(std::span<const int> numbers, std::span<const double> displacement) {
    Eigen::Matrix<double, 3, nodes> result;
    for (int a = 0; a < nodes; ++a)
        result.col(a) = core::Vector3::Map(&displacement[3 * numbers[a]]);
    return result;
}

/// Change of C by a step below which S(C_m) is the derivative of W along it to rounding, and the differences of W are
/// nothing else.
constexpr double small_change = 1e-4;

} // namespace

MotionForces::MotionForces(const Elements &elements, TetrahedronRule rule, double viscosity)
    : elements_(&elements), reference_(reference_tetrahedron(elements.degree(), rule)), viscosity_(viscosity) {
    if (elements.num_pressures() > 0)
        throw std::invalid_argument("elements with a pressure do not move in time; take displacements alone");
    const auto &mesh = elements.body().mesh;
    for (const auto &corners : mesh.tetrahedra) {
        Matrix3 edges;
        for (int k = 0; k < 3; ++k)
            edges.col(k) = mesh.points[corners[k + 1]] - mesh.points[corners[0]];
        volume_.push_back(edges.determinant() / 6.0);
        inverse_edges_.emplace_back(edges.inverse());
    }
    start_.resize(volume_.size() * reference_.weight.size());
}

double MotionForces::begin_at(std::span<const double> displacement) {
    return elements_->degree() == 1 ? begin<4>(displacement) : begin<10>(displacement);
}

void MotionForces::end_at(std::span<const double> displacement, double time_step, AtEnd &result) const {
    if (elements_->degree() == 1)
        end<4>(displacement, time_step, result);
    else
        end<10>(displacement, time_step, result);
}

template <int nodes> double MotionForces::begin(std::span<const double> displacement) {
    const auto &body = elements_->body();
    const auto &law = elements_->law();
    double energy = 0.0;
    auto point = start_.begin();
    for (std::size_t t = 0; t < volume_.size(); ++t) {
        const auto numbers = std::span(elements_->system().cell_nodes).subspan(t * nodes, nodes);
        const auto u = gather<nodes>(numbers, displacement);
        const auto material = body.material_of(t);
        for (std::size_t q = 0; q < reference_.weight.size(); ++q, ++point) {
            const Eigen::Map<const Eigen::Matrix<double, 3, nodes>> gradient(reference_.gradient[q].data());
            const Matrix3 slope = u * gradient.transpose();
            point->deformation = Matrix3::Identity() + slope * inverse_edges_[t];
            const auto here = response(law, material, point->deformation, point->deformation.determinant());
            point->stress = here.stress;
            point->energy = here.energy;
            energy += reference_.weight[q] * volume_[t] * here.energy;
        }
    }
    return energy;
}

template <int nodes>
void MotionForces::end(std::span<const double> displacement, double time_step, AtEnd &result) const {
    const auto &body = elements_->body();
    const auto &law = elements_->law();
    result.is_possible = false;
    result.energy = 0.0;
    result.force.assign(displacement.size(), 0.0);
    auto point = start_.begin();
    for (std::size_t t = 0; t < volume_.size(); ++t) {
        const auto numbers = std::span(elements_->system().cell_nodes).subspan(t * nodes, nodes);
        const auto material = body.material_of(t);
        const auto u = gather<nodes>(numbers, displacement);
        Eigen::Matrix<double, 3, nodes> force = Eigen::Matrix<double, 3, nodes>::Zero();
        for (std::size_t q = 0; q < reference_.weight.size(); ++q, ++point) {
            const Eigen::Map<const Eigen::Matrix<double, 3, nodes>> gradient(reference_.gradient[q].data());
            const Matrix3 slope = u * gradient.transpose();
            const Matrix3 f = Matrix3::Identity() + slope * inverse_edges_[t];
            const double jacobian = f.determinant();
            if (!(jacobian > 0.0)) // nor NaN
                return;
            const auto here = response(law, material, f, jacobian);
            const Matrix3 before = point->deformation.transpose() * point->deformation;
            const Matrix3 after = f.transpose() * f;
            const Matrix3 change = after - before;
            Matrix3 stress = stress_of(law, material, 0.5 * (before + after));
            const double missing = here.energy - point->energy - 0.5 * stress.cwiseProduct(change).sum();
            stress += 2.0 * missing / (change.squaredNorm() + small_change * small_change) * change;
            stress += viscosity_ / time_step * (here.stress - point->stress);
            const Matrix3 middle = 0.5 * (point->deformation + f);
            const double weight = reference_.weight[q] * volume_[t];
            const Matrix3 on_reference = weight * (middle * stress) * inverse_edges_[t].transpose();
            force.noalias() += on_reference * gradient;
            result.energy += weight * here.energy;
        }
        for (int a = 0; a < nodes; ++a)
            core::Vector3::Map(&result.force[3 * numbers[a]]) += force.col(a);
    }
    result.is_possible = true;
}

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
            positions_.push_back(x - last_->first);
            corrections_.push_back(correction - last_->second);
            if (positions_.size() > most_differences) {
                positions_.pop_front();
                corrections_.pop_front();
            }
        }
        last_.emplace(x, correction);
        Unknowns result = x + correction;
        if (positions_.empty())
            return result;
        const auto num = static_cast<Eigen::Index>(positions_.size());
        Eigen::MatrixXd differences(x.size(), num);
        for (Eigen::Index k = 0; k < num; ++k)
            differences.col(k) = corrections_[k];
        const Unknowns weight = differences.colPivHouseholderQr().solve(correction);
        for (Eigen::Index k = 0; k < num; ++k)
            result -= weight[k] * (positions_[k] + corrections_[k]);
        return result;
    }

  private:
    std::optional<std::pair<Unknowns, Unknowns>> last_;
    std::deque<Unknowns> positions_, corrections_;
};

} // namespace

EnergyMomentum::EnergyMomentum(const Elements &elements, TetrahedronRule rule, const std::vector<bool> &is_free,
                               const core::RayleighDamping &damping, double force, double tolerance)
    : is_free_(is_free), damping_(damping), largest_residual_(tolerance * force), forces_(elements, rule, damping.beta),
      mass_(elements, is_free) {}

/// @return strain energy there [J]
double EnergyMomentum::begin_at(const std::vector<double> &displacement) {
    if (begun_at_ != displacement) {
        begun_at_ = displacement;
        strain_energy_ = forces_.begin_at(displacement);
    }
    return strain_energy_;
}

/// A parabola through the last three displacements, because velocities of stiff modes change sign from step to step.
EnergyMomentum::Unknowns EnergyMomentum::first_guess(const Motion &motion, double time_step) const {
    Unknowns now = Unknowns::Map(motion.displacement.data(), std::ssize(motion.displacement));
    if (before_.size() < 3 || step_before_ != time_step || before_.back() != now)
        return now;
    return 3.0 * before_[2] - 3.0 * before_[1] + before_[0];
}

void EnergyMomentum::factorise(const Motion &motion, double time_step, const Vector3 &ball_centre) {
    SurfaceStiffness surface;
    if (ball_)
        ball_->add_stiffness(ball_centre, motion.displacement, surface);
    mass_.factorise(2.0 / (time_step * time_step) + damping_.alpha / time_step, 0.5 + damping_.beta / time_step,
                    motion.displacement, surface);
    factored_step_ = time_step;
    fewest_iterations_ = -1;
    excess_iterations_ = 0;
    ++work_.factors;
}

/// @return false, and the motion as it was, if it does not converge
bool EnergyMomentum::step(Motion &motion, std::span<const double> load, double time_step,
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
            if (!is_free_[dof])
                u[static_cast<Eigen::Index>(dof)] = target[dof];
    };
    const auto residual_at = [&](const Unknowns &u) {
        const Unknowns mean_velocity = (u - start) / time_step;
        forces_.end_at(span_of(u), time_step, at_end_);
        if (!at_end_.is_possible)
            return std::numeric_limits<double>::infinity();
        mass_.multiply_mass(
            span_of(Unknowns(2.0 / time_step * (mean_velocity - velocity) + damping_.alpha * mean_velocity)),
            span_of(product));
        if (ball_) {
            std::ranges::fill(touched, 0.0);
            ball_->add_forces(half_way, span_of(Unknowns(0.5 * (start + u))), touched);
        }
        for (Eigen::Index dof = 0; dof < size; ++dof)
            residual[dof] = is_free_[dof] ? load[dof] + touched[dof] - product[dof] - at_end_.force[dof] : 0.0;
        return residual.norm();
    };
    for (const bool has_new_factor : {false, true}) {
        if (has_new_factor || factored_step_ != time_step)
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
        while (size_of_residual > largest_residual_ && iterations < most_iterations &&
               size_of_residual < 1e3 * first_residual) {
            mass_.solve(span_of(residual), span_of(correction));
            u = anderson.next(u, correction);
            size_of_residual = residual_at(u);
            ++iterations;
        }
        work_.iterations += iterations;
        if (!(size_of_residual <= largest_residual_))
            continue;
        if (fewest_iterations_ < 0)
            fewest_iterations_ = iterations;
        excess_iterations_ += iterations - fewest_iterations_;
        if (excess_iterations_ > iterations_of_a_factor)
            factored_step_ = 0.0;
        if (ball_) {
            const Unknowns middle = 0.5 * (start + u);
            ball_force_ = {ball_force_[1], ball_->sums(half_way, span_of(middle)).force};
            ball_->end_step(half_way, span_of(middle));
            ball_->augment(half_way, span_of(middle));
        }
        const Unknowns mean_velocity = (u - start) / time_step;
        Unknowns::Map(motion.displacement.data(), size) = u;
        Unknowns::Map(motion.velocity.data(), size) = 2.0 * mean_velocity - velocity;
        if (step_before_ != time_step || before_.empty() || before_.back() != start)
            before_.assign({start});
        before_.push_back(u);
        if (before_.size() > 3)
            before_.pop_front();
        step_before_ = time_step;
        ++work_.steps;
        return true;
    }
    return false;
}

bool EnergyMomentum::advance(Motion &motion, std::span<const double> load, double time_step,
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

void EnergyMomentum::touch_with(TouchingBall *ball) {
    ball_ = ball;
    factored_step_ = 0.0;
}

bool EnergyMomentum::advance(Motion &motion, std::span<const double> load, double time_step,
                             std::span<const double> target, const BallStep &ball) {
    return advance(motion, load, time_step, target, ball, 0);
}

Energy EnergyMomentum::energy(const Motion &motion) {
    std::vector<double> momentum(motion.velocity.size());
    mass_.multiply_mass(motion.velocity, momentum);
    double kinetic = 0.0;
    for (std::size_t dof = 0; dof < momentum.size(); ++dof)
        kinetic += 0.5 * motion.velocity[dof] * momentum[dof];
    return {.kinetic = kinetic, .strain = begin_at(motion.displacement)};
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
    const auto is_free = fem_reference::free_of(conditions.prescribed);
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
    return fem_reference::free_of(fem_reference::dof_conditions(load_case, system).prescribed);
}

/// About what a tool presses with: Young's modulus times its size and its depth.
double order_of_force(const core::Body &body, const core::LoadCase &load_case) {
    double area = 0.0, modulus = 0.0;
    if (const auto &ball = load_case.touching)
        area = std::numbers::pi * std::pow(ball->contacts().front().radius, 2);
    for (int f = 0; f < body.mesh.num_boundary_triangles(); ++f)
        if (load_case.constraint_on(f) == load_case.tool->constraint)
            area += core::area_vector(body.mesh, f).norm();
    for (std::size_t t = 0; t < body.mesh.tetrahedra.size(); ++t)
        modulus = std::max(modulus, body.young_modulus_of(t));
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
        ball.emplace(system, *problem.body, load_case, contact_settings(degree, load_case.touching->shape));
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
