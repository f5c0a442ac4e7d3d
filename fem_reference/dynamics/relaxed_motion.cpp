#include "fem_reference/dynamics/relaxed_motion.hpp"

#include <utility>

#include "core/relaxation.hpp"
#include "core/stopwatch.hpp"
#include "fem_reference/dynamics/modes.hpp"
#include "fem_reference/linear/conditions.hpp"
#include "fem_reference/solvers/constrained_solver.hpp"

namespace livermark::fem_reference {

namespace {

using Unknowns = std::vector<double>;

void add_scaled(double factor, const Unknowns &x, Unknowns &out) {
    for (std::size_t i = 0; i < out.size(); ++i)
        out[i] += factor * x[i];
}

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
    Unknowns of_whole(a.size()), of_other(a.size()), result(a.size()), more(a.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
        of_other[i] = weight_ * (a[i] - b[i]);
        of_whole[i] = b[i] - of_other[i];
    }
    whole_->multiply(of_whole, result);
    other_->multiply(of_other, more);
    add_scaled(1.0, more, result);
    return result;
}

SymmetricMatrix SplitStiffness::combined(double v, double d) const {
    auto matrix = compressed_rows(*whole_);
    const auto other = compressed_rows(*other_);
    const double of_other = weight_ * (v - d), of_whole = d - of_other;
    for (std::size_t entry = 0; entry < matrix.value.size(); ++entry)
        matrix.value[entry] = of_whole * matrix.value[entry] + of_other * other.value[entry];
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

} // namespace livermark::fem_reference
