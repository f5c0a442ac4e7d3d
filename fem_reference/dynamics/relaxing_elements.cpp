#include "fem_reference/dynamics/relaxing_solver.hpp"

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "core/events.hpp"
#include "core/relaxation.hpp"
#include "core/stopwatch.hpp"
#include "fem_reference/dynamics/modes.hpp"
#include "fem_reference/linear/conditions.hpp"
#include "fem_reference/solvers/constrained_solver.hpp"

namespace livermark::fem_reference {

namespace {

using Unknowns = std::vector<double>;

/// A body on its way: see release_relaxed().
class RelaxingMotion {
  public:
    RelaxingMotion(const core::Body &body, const ElasticSystem &system, const SplitStiffness &stiffness,
                   const core::LoadCase &load_case, RelaxedState start, double time_step)
        : stiffness_(stiffness), mass_(consistent_mass(body, system)),
          conditions_(dof_conditions(core::without_tractions(load_case), system)), time_step_(time_step),
          remaining_(load_case.slow_history->relaxation.remaining()),
          steps_(core::branch_steps(load_case.slow_history->relaxation, time_step)),
          at_rest_(core::branch_steps(load_case.slow_history->relaxation, 0.0)),
          solver_(matrix(load_case.release->damping, core::instant_part(load_case.slow_history->relaxation, steps_))),
          at_(std::move(start)), velocity_(conditions_.load.size(), 0.0), momentum_(velocity_),
          mean_velocity_(velocity_) {
        solver_.factorise(conditions_.prescribed); // the mass makes it positive definite, whatever is constrained
    }

    void advance() {
        Unknowns relaxed = scaled(remaining_, at_.displacement);
        for (std::size_t k = 0; k < steps_.size(); ++k)
            add_scaled(0.5 * (1.0 + steps_[k].fade), at_.branches[k], relaxed);
        auto force = stiffness_.product(at_.displacement, relaxed);
        multiply_mass(mass_, velocity_, momentum_);
        for (std::size_t i = 0; i < force.size(); ++i)
            force[i] = 2.0 / time_step_ * momentum_[i] + conditions_.load[i] - force[i];
        solver_.solve_constrained(force, mean_velocity_);
        for (std::size_t i = 0; i < force.size(); ++i) {
            const double change = time_step_ * mean_velocity_[i];
            at_.displacement[i] += change;
            velocity_[i] = 2.0 * mean_velocity_[i] - velocity_[i];
            for (std::size_t k = 0; k < steps_.size(); ++k)
                at_.branches[k][i] = steps_[k].fade * at_.branches[k][i] + steps_[k].gain * change;
        }
    }

    const Unknowns &displacement() const { return at_.displacement; }

    double kinetic_energy() {
        multiply_mass(mass_, velocity_, momentum_);
        return 0.5 * dot(velocity_, momentum_);
    }

    double stored_energy() const {
        double energy =
            0.5 * dot(at_.displacement, stiffness_.product(at_.displacement, scaled(remaining_, at_.displacement)));
        const Unknowns zero(at_.displacement.size(), 0.0);
        for (std::size_t k = 0; k < at_rest_.size(); ++k)
            energy += at_rest_[k].stored(dot(at_.branches[k], stiffness_.product(zero, at_.branches[k])));
        return energy;
    }

  private:
    static Unknowns scaled(double factor, Unknowns x) {
        for (double &value : x)
            value *= factor;
        return x;
    }

    /// @param instant  of the deviatoric stiffness in a step
    SymmetricMatrix matrix(const core::RayleighDamping &damping, double instant) const {
        const double half = 0.5 * time_step_;
        return combine(1.0, stiffness_.combined(damping.beta + half, damping.beta + half * instant),
                       damping.alpha + 2.0 / time_step_, mass_);
    }

    SplitStiffness stiffness_;
    SymmetricMatrix mass_;
    DofConditions conditions_;
    double time_step_, remaining_;
    std::vector<core::BranchStep> steps_, at_rest_;
    ConstrainedSolver solver_;
    RelaxedState at_;
    Unknowns velocity_, momentum_, mean_velocity_;
};

} // namespace

std::vector<double> SplitStiffness::product(std::span<const double> a, std::span<const double> b) const {
    Unknowns whole_part(a.size()), other_part(a.size()), result(a.size()), more(a.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
        other_part[i] = weight_ * (a[i] - b[i]);
        whole_part[i] = b[i] - other_part[i];
    }
    whole_->multiply(whole_part, result);
    other_->multiply(other_part, more);
    add_scaled(1.0, more, result);
    return result;
}

SymmetricMatrix SplitStiffness::combined(double v, double d) const {
    auto matrix = compressed_rows(*whole_);
    const auto other = compressed_rows(*other_);
    const double other_part = weight_ * (v - d), whole_part = d - other_part;
    for (std::size_t entry = 0; entry < matrix.value.size(); ++entry)
        matrix.value[entry] = whole_part * matrix.value[entry] + other_part * other.value[entry];
    return matrix;
}

core::History release_relaxed(const core::Body &body, const ElasticSystem &system, const SplitStiffness &stiffness,
                              const core::LoadCase &load_case, RelaxedState start, int steps_per_record) {
    const auto begin = core::Clock::now();
    const auto &plan = load_case.release.value();
    core::History history;
    history.integrator = "newmark";
    history.time_step = plan.output_interval / steps_per_record;
    RelaxingMotion motion(body, system, stiffness, load_case, std::move(start), history.time_step);
    history.setup_seconds = core::seconds_since(begin);
    const auto ready = core::Clock::now();
    const auto at_node = [&](int node) {
        return core::Vector3(core::Vector3::Map(&motion.displacement()[3 * static_cast<std::size_t>(node)]));
    };
    for (int record = 0; record <= plan.num_steps; ++record) {
        for (int step = 0; record > 0 && step < steps_per_record; ++step)
            motion.advance();
        history.time.push_back(record * plan.output_interval);
        for (const auto &probe : plan.probes)
            history.displacement.push_back(at_node(system.mesh_node[probe.node]));
        if (plan.is_frame(record))
            for (const int node : system.mesh_node)
                history.frames.emplace_back(at_node(node).cast<float>());
        history.kinetic_energy.push_back(motion.kinetic_energy());
        history.strain_energy.push_back(motion.stored_energy());
    }
    history.solve_seconds = core::seconds_since(ready);
    return history;
}

namespace {

double bulk_modulus(const core::Material &material) {
    return material.lame_lambda() + 2.0 / 3.0 * material.shear_modulus();
}

core::Material with_scaled_bulk(const core::Material &material, double part) {
    const double shear = material.shear_modulus(), bulk = bulk_modulus(material) / part;
    return {material.density, 9.0 * bulk * shear / (3.0 * bulk + shear),
            (3.0 * bulk - 2.0 * shear) / (2.0 * (3.0 * bulk + shear))};
}

bool is_mixed_region(const core::Material &material, const PressureSystem &pressure) {
    return pressure.num_pressures() > 0 && material.poisson_ratio > pressure_above_poisson_ratio;
}

/// The body without the stiffness that pressures stand for, and with other bulk moduli in its other regions.
core::Body body_of_displacements(const core::Body &body, const PressureSystem &pressure, double part) {
    auto scaled = pressure.num_pressures() > 0 ? without_pressure(body) : body;
    for (std::size_t r = 0; r < body.materials.size(); ++r)
        if (!is_mixed_region(body.materials[r], pressure))
            scaled.materials[r] = with_scaled_bulk(body.materials[r], part);
    return scaled;
}

/// The pressures of a body with other bulk moduli: each belongs to one region.
PressureSystem with_scaled_bulk(PressureSystem pressure, const core::Body &body, double part) {
    std::vector<int> region(static_cast<std::size_t>(pressure.num_pressures()), 0);
    for (std::size_t t = 0; t < pressure.cell_pressures.size(); ++t)
        for (const int number : pressure.cell_pressures[t])
            if (number >= 0)
                region[number] = body.mesh.region[t];
    for (std::size_t row = 0; row < region.size(); ++row) {
        const auto &material = body.materials[region[row]];
        const double lambda = material.lame_lambda();
        const double scaled = bulk_modulus(material) / part - 2.0 / 3.0 * material.shear_modulus();
        for (int k = pressure.compliance.row_start[row]; k < pressure.compliance.row_start[row + 1]; ++k) {
            const double mass = lambda * pressure.compliance.value[k];
            pressure.compliance.value[k] = mass / scaled;
            pressure.norm.value[k] = mass * (1.0 / scaled + 0.5 / material.shear_modulus());
        }
    }
    return pressure;
}

} // namespace

ScaledBulk::ScaledBulk(const core::Body &body, const Discretisation &matrices, ChosenSolver &solver,
                       SolverChoice choice, double part)
    : choice_(choice), body_solver_(&solver), system_(&matrices.system),
      pressure_(with_scaled_bulk(matrices.pressure, body, part)) {
    const bool is_all_mixed = std::ranges::all_of(
        body.materials, [&](const core::Material &material) { return is_mixed_region(material, pressure_); });
    if (!is_all_mixed && part != 1.0) {
        const bool is_mixed = pressure_.num_pressures() > 0;
        own_system_ = std::make_unique<ElasticSystem>(assemble(body_of_displacements(body, pressure_, part),
                                                               matrices.system.nodes_per_cell == 4 ? 1 : 2,
                                                               is_mixed ? NodeOrder::by_distance : NodeOrder::of_mesh));
        system_ = own_system_.get();
    }
    if (pressure_.num_pressures() > 0)
        mixed_.emplace(*system_, this->solver(), pressure_);
}

ScaledBulk::ScaledBulk(const core::Body &body, const Discretisation &matrices, ChosenSolver &solver,
                       SolverChoice choice, double part, ScaledBulk &coarse, double tolerance,
                       std::span<const int> parent)
    : ScaledBulk(body, matrices, solver, choice, part) {
    if (mixed_ && coarse.mixed_)
        mixed_.emplace(*system_, this->solver(), pressure_, tolerance, *coarse.mixed_,
                       nested_iteration(*coarse.system_, coarse.pressure_, *system_, pressure_, parent));
}

ChosenSolver &ScaledBulk::solver() {
    if (!own_system_)
        return *body_solver_;
    if (!own_solver_)
        own_solver_ = std::make_unique<ChosenSolver>(*own_system_, choice_);
    return *own_solver_;
}

ConstrainedSolution ScaledBulk::solve(std::span<const double> prescribed, std::span<const double> load) {
    return mixed_ ? mixed_->solve(prescribed, load) : solver().solve(prescribed, load);
}

std::vector<double> ScaledBulk::force(std::span<const double> displacement) {
    std::vector<double> force(displacement.size());
    system_->stiffness.multiply(displacement, force);
    const auto num_pressures = static_cast<std::size_t>(pressure_.num_pressures());
    if (num_pressures == 0)
        return force;
    if (!compliance_)
        compliance_.emplace(pressure_.compliance);
    const std::vector<double> all_free(num_pressures, std::numeric_limits<double>::quiet_NaN());
    const std::vector<double> none(num_pressures, 0.0);
    std::vector<double> dilation(num_pressures); // D u, of which the pressure is C^-1
    pressure_.divergence.subtract_product(displacement, none, dilation, 1);
    const auto pressure = compliance_->solve(all_free, dilation).displacement;
    std::vector<double> not_needed(num_pressures, 0.0);
    pressure_.divergence.add_products(displacement, pressure, force, not_needed, 1);
    return force;
}

} // namespace livermark::fem_reference
