#include "studies/models/model_table.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <iterator>
#include <limits>
#include <memory>
#include <optional>
#include <utility>

#include "core/stopwatch.hpp"
#include "core/support/input_error.hpp"
#include "core/support/processes/own_process.hpp"
#include "msm/dynamics/histories.hpp"
#include "msm/dynamics/stepper.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/integrator.hpp"
#include "msm/kernels/vector_springs.hpp"
#include "msm/springs/springs.hpp"
#include "msm/statics/equilibrium.hpp"
#include "msm/statics/load_path.hpp"
#include "msm/statics/rest_stiffness.hpp"

namespace livermark::models {

std::vector<double> ModelOptions::sweep_of(std::string_view constant) const {
    const auto found = sweeps.find(std::string(constant));
    return found == sweeps.end() ? std::vector<double>{} : found->second;
}

std::string swept_name(std::string_view constant, double value) {
    auto name = fmt::format("{}_{}", constant, value);
    std::ranges::replace(name, '.', '_');
    return name;
}

namespace {

/// Other models that cost as much are closer to the reference in displacement and in stiffness at the tool
/// (docs/studies/models.md), so a run over everything has no time for these.
constexpr std::array<std::string_view, 5> dominated{"lloyd_edge", "lloyd_mean_edge", "lloyd_nodal_volume", "uniform",
                                                    "van_gelder_tetrahedral_volume"};

/// @param role  of a model
/// @return an empty name if none has it
std::string name_with(core::Role role, const std::function<core::Role(const core::Model &)> &role_of) {
    const auto models = all_models();
    const auto found = std::ranges::find(models, role, role_of);
    return found == models.end() ? std::string() : found->name;
}

ReferenceNames names_of(const std::function<core::Role(const core::Model &)> &role_of) {
    return {name_with(core::Role::reference, role_of), name_with(core::Role::refined_reference, role_of)};
}

} // namespace

ReferenceNames static_reference(core::Regime regime) {
    return names_of([regime](const core::Model &model) { return model.role_at_rest(regime); });
}

ReferenceNames moving_reference(core::Regime regime) {
    return names_of([regime](const core::Model &model) { return model.role_in_motion(regime); });
}

std::string baseline_name() {
    return name_with(core::Role::baseline, &core::Model::at_rest);
}

std::vector<core::Model> all_models(const ModelOptions &options) {
    std::vector<core::Model> models;
    for (const auto &family : all_families())
        std::ranges::move(family.models(options), std::back_inserter(models));
    for (auto &model : models)
        if (std::ranges::find(dominated, model.name) != dominated.end())
            model.only_when_named = true;
    return models;
}

namespace {

using core::Clock;
using core::seconds_since;

/// Integrator of dynamic relaxation: damping by the mass is no help to stabilised methods.
constexpr const char *default_relaxing_integrator = "runge_kutta_4";

const msm::Integrator &relaxing_integrator(const ModelOptions &options) {
    return msm::find_integrator(options.time_stepping.integrator.value_or(default_relaxing_integrator),
                                msm::known_integrators());
}

/// |u - u_lin| / |u|, NaN where nobody asked for the linear solution
double nonlinearity(const msm::Equilibrium &equilibrium) {
    if (equilibrium.linear_displacement.empty())
        return std::numeric_limits<double>::quiet_NaN();
    double difference = 0.0;
    double size = 0.0;
    for (std::size_t i = 0; i < equilibrium.displacement.size(); ++i) {
        difference += (equilibrium.displacement[i] - equilibrium.linear_displacement[i]).squaredNorm();
        size += equilibrium.displacement[i].squaredNorm();
    }
    return std::sqrt(difference / size);
}

struct HighestFrequency {
    double angular_frequency = 0.0; ///< [rad/s]
    double seconds = 0.0;           ///< that it took to find
};

/// Lets the tractions go where the static solution has come to.
/// @param highest  with what the problem holds
void add_motion(core::Solution &solution, const core::Problem &problem, const msm::ElasticBody &body,
                const HighestFrequency &highest, const msm::TimeStepping &choice) {
    const auto start = Clock::now();
    const auto plan = msm::plan_steps(problem, highest.angular_frequency, choice);
    const auto conditions =
        msm::nodal_conditions({problem.body, core::without_tractions(problem.load_case)}, body.node_mass);
    const double planning_seconds = highest.seconds + seconds_since(start);
    solution.history = msm::release(problem, body, conditions, solution.displacement, plan, solution.path);
    solution.history->setup_seconds += planning_seconds;
    if (!std::isnan(solution.history->diverged_at)) {
        solution.status = core::SolutionStatus::diverged;
        solution.message = fmt::format("the motion left all bounds at t = {:.3g} s with steps of {:.3g} s; {:.3g} s is "
                                       "the longest that is stable",
                                       solution.history->diverged_at, plan.time_step, plan.critical_time_step);
    }
}

bool constrain_the_same(const std::vector<core::Vector3> &a, const std::vector<core::Vector3> &b) {
    return std::ranges::equal(a, b, [](const core::Vector3 &x, const core::Vector3 &y) {
        return (x.array().isNaN() == y.array().isNaN()).all();
    });
}

/// Body of a model and its stiffness at rest, and the factor of that and its explicit steps for the
/// components that were constrained last. The seconds are those that it took when it was made.
class PreparedMassSprings : public core::PreparedModel {
  public:
    PreparedMassSprings(std::shared_ptr<const core::Body> body, const core::LoadCase *common,
                        const MakeMassSprings &make, ModelOptions options)
        : start_(Clock::now()), body_(std::move(body)), options_(std::move(options)), parts_(make(*body_)),
          resting_(msm::in_vectors(parts_.body, body_->mesh.points)), make_seconds_(seconds_since(start_)) {
        if (common)
            common_ = msm::nodal_conditions({body_, *common}, parts_.body.node_mass);
    }

    std::vector<core::Solution> solve(std::span<const core::LoadCase> load_cases) override {
        std::vector<core::Solution> solutions;
        for (const auto &load_case : load_cases)
            solutions.push_back(solve({body_, load_case}));
        return solutions;
    }

    const msm::MassSprings &parts() const { return parts_; }

  private:
    core::Solution solve(const core::Problem &problem) {
        const auto &points = body_->mesh.points;
        const auto conditions = msm::nodal_conditions(problem, parts_.body.node_mass);
        core::Solution solution;
        if (problem.load_case.slow_history)
            follow_history(solution, problem, conditions);
        else
            come_to_rest(solution, problem, conditions);
        solution.degrees_of_freedom = static_cast<std::int64_t>(3 * points.size());
        solution.springs = parts_.springs;
        solution.explicit_steps = steps(conditions);
        if (problem.load_case.release && solution.status == core::SolutionStatus::ok)
            add_motion(solution, problem, parts_.body, highest_, options_.time_stepping);
        return solution;
    }

    /// Puts into a solution where the body is as time passes in its material.
    void follow_history(core::Solution &solution, const core::Problem &problem,
                        const msm::NodalConditions &conditions) const {
        solution.setup_seconds = make_seconds_;
        const auto start = Clock::now();
        auto followed = msm::follow_history(parts_.body, problem, parts_.body.node_mass);
        solution.solver = fmt::format("{} steps in time, {} of Newton's method on {} factors, CHOLMOD",
                                      followed.num_steps, followed.end.num_iterations, followed.end.num_factors + 1);
        solution.solve_seconds = seconds_since(start);
        solution.strain_energy = followed.stored_energy;
        solution.path = std::move(followed.points);
        put_down(solution, problem, conditions, std::move(followed.end));
    }

    static void put_down(core::Solution &solution, const core::Problem &problem, const msm::NodalConditions &conditions,
                         msm::Equilibrium found) {
        solution.status = found.status;
        solution.message = found.message;
        solution.reaction =
            msm::constraint_forces(problem, conditions, found.constraint_force, found.press, found.touch);
        solution.nonlinearity = nonlinearity(found);
        solution.displacement = std::move(found.displacement);
    }

    /// Puts into a solution where the body comes to rest.
    void come_to_rest(core::Solution &solution, const core::Problem &problem, const msm::NodalConditions &conditions) {
        const auto &body = resting_;
        const auto &points = body_->mesh.points;
        solution.setup_seconds = make_seconds_;
        auto start = Clock::now();
        msm::Equilibrium found;
        if (options_.equilibrium == EquilibriumMethod::newton) {
            const auto &rest = at_rest(conditions);
            solution.setup_seconds += stiffness_seconds_ + rest.factor_seconds();
            start = Clock::now();
            std::string along;
            if (problem.load_case.path.empty()) {
                found = msm::find_equilibrium(body, problem, body.node_mass, rest, {.bears_rounding = true});
            } else {
                auto followed = msm::follow_path(body, problem, body.node_mass, rest);
                found = std::move(followed.end);
                solution.path = std::move(followed.points);
                along = fmt::format(" along {} equilibria", followed.num_steps);
            }
            solution.solver = fmt::format("Newton, {} steps on {} factors{}, CHOLMOD", found.num_iterations,
                                          found.num_factors + 1, along);
        } else {
            const auto &integrator = relaxing_integrator(options_);
            auto relaxed = msm::relax(integrator, parts_.body, points, conditions);
            found = std::move(relaxed.equilibrium);
            solution.solver = fmt::format("dynamic relaxation, {} steps of {:.3g} s, {}", found.num_iterations,
                                          relaxed.time_step, integrator.name);
        }
        solution.solve_seconds = seconds_since(start);
        put_down(solution, problem, conditions, std::move(found));
        // To the bit what the terms say elsewhere.
        solution.strain_energy = msm::elastic_energy(parts_.body, msm::moved(points, solution.displacement));
    }

    const msm::RestStiffness &at_rest(const msm::NodalConditions &conditions) {
        if (!rest_) {
            const auto start = Clock::now();
            const auto &points = body_->mesh.points;
            rest_ = msm::RestStiffness::shared(resting_, points,
                                               common_ ? common_->displacement : std::vector<core::Vector3>{});
            support::return_freed_memory(); // a factor comes next, and what made the stiffness was as large
            stiffness_seconds_ = seconds_since(start);
        }
        rest_->constrain(conditions.displacement);
        return *rest_;
    }

    const core::ExplicitSteps &steps(const msm::NodalConditions &conditions) {
        if (!steps_ || !constrain_the_same(constrained_in_steps_, conditions.displacement)) {
            const auto &points = body_->mesh.points;
            const auto start = Clock::now();
            highest_.angular_frequency = largest_angular_frequency(conditions);
            highest_.seconds = seconds_since(start);
            const bool is_measured = steps_ && !steps_->kernel.empty(); // not where nothing could move
            steps_ = is_measured ? msm::constrained_otherwise(*steps_, highest_.angular_frequency)
                                 : msm::explicit_steps(parts_.body, points, conditions, highest_.angular_frequency);
            constrained_in_steps_ = conditions.displacement;
        }
        return *steps_;
    }

    /// Whatever was asked for before, the bits are the same.
    double largest_angular_frequency(const msm::NodalConditions &conditions) {
        const auto &points = body_->mesh.points;
        if (!highest_mode_ && common_)
            highest_mode_ = msm::highest_mode(resting_, points, *common_);
        return highest_mode_ ? msm::largest_angular_frequency(resting_, points, conditions, *highest_mode_)
                             : msm::largest_angular_frequency(resting_, points, conditions);
    }

    Clock::time_point start_; ///< when it was begun to be made
    std::shared_ptr<const core::Body> body_;
    ModelOptions options_;
    msm::MassSprings parts_;
    msm::ElasticBody resting_;                   ///< the same, for equilibria and frequencies at rest
    double make_seconds_;                        ///< what the parts took
    std::optional<msm::NodalConditions> common_; ///< what many load cases constrain, if that is known
    std::optional<msm::RestStiffness> rest_;
    std::optional<core::ExplicitSteps> steps_;
    std::vector<core::Vector3> constrained_in_steps_; ///< prescribed displacements
    std::optional<msm::HighestMode> highest_mode_;    ///< with what is constrained in common
    HighestFrequency highest_;                        ///< with what was constrained in the last steps()
    double stiffness_seconds_ = 0.0;
};

/// Modes or compliance of a body on its foundation, with the seconds that the body takes as well.
/// @param find  (body)
template <class Find> auto found_in(const core::Problem &problem, const MakeMassSprings &make, const Find &find) {
    const auto start = Clock::now();
    auto found = find(msm::on_foundation(make(*problem.body).body, problem));
    found.seconds = seconds_since(start);
    return found;
}

void check(const core::Problem &problem, const MakeMassSprings &make, const ModelOptions &options) {
    const auto &integrator = relaxing_integrator(options); // refuses unknown names even where nothing moves
    if (options.equilibrium == EquilibriumMethod::relaxation) {
        if (!integrator.is_explicit)
            throw support::InputError(
                fmt::format("--equilibrium relaxation takes an explicit integrator, not {}; choose "
                            "another --integrator",
                            integrator.name));
        if (!(msm::critical_time_step(integrator, {}, 1.0, 1.0) > 0.0))
            throw support::InputError(fmt::format("--equilibrium relaxation hardly damps the fast modes, and without "
                                                  "damping {} is unstable at every time step; choose another "
                                                  "--integrator",
                                                  integrator.name));
    }
    const auto &choice = options.time_stepping;
    if (problem.load_case.release && (choice.integrator || choice.time_step)) { // left to choose, some step is stable
        const auto body = make(*problem.body).body;
        const auto conditions = msm::nodal_conditions(problem, body.node_mass);
        msm::plan_steps(problem, msm::largest_angular_frequency(body, problem.body->mesh.points, conditions), choice);
    }
}

/// A type of its own, so that has_springs() knows it.
struct PrepareMassSprings {
    std::unique_ptr<core::PreparedModel> operator()(const std::shared_ptr<const core::Body> &body,
                                                    const core::LoadCase *common) const {
        return std::make_unique<PreparedMassSprings>(body, common, make, options);
    }
    MakeMassSprings make;
    ModelOptions options;
};

} // namespace

core::Model mass_spring_model(std::string name, std::string summary, std::string source,
                              const MakeMassSprings &make_tissue, const ModelOptions &options) {
    const MakeMassSprings make = [make_tissue](const core::Body &body) {
        auto made = make_tissue(body);
        made.body = msm::with_vessel_lines(std::move(made.body), body);
        return made;
    };
    return {
        .name = std::move(name),
        .summary = std::move(summary),
        .source = std::move(source),
        .prepare = PrepareMassSprings{make, options},
        .modes =
            [=](const core::Problem &problem, int count) {
                return found_in(problem, make, [&](const msm::ElasticBody &body) {
                    return msm::lowest_modes(body, problem.body->mesh.points,
                                             msm::nodal_conditions(problem, body.node_mass), count);
                });
            },
        .compliance =
            [=](const core::Problem &problem, std::span<const core::InteriorPlace> places) {
                return found_in(problem, make,
                                [&](const msm::ElasticBody &body) { return msm::compliance(body, problem, places); });
            },
        .check = [=](const core::Problem &problem) { check(problem, make, options); },
        // Time stepping knows the loads before it begins, and the force of what touches or presses to a depth is a
        // result.
        .follows = options.equilibrium == EquilibriumMethod::newton
                       ? core::EventSet::all()
                       : core::EventSet::of<core::Release, core::ToolMotion>(),
        .is_wanted = [relaxes = options.equilibrium == EquilibriumMethod::relaxation](
                         const core::Problem &problem) { return !relaxes || problem.load_case.press_depth == 0.0; },
    };
}

bool has_springs(const core::Model &model) {
    return model.prepare.target<PrepareMassSprings>() != nullptr;
}

std::optional<msm::MassSprings> springs_of(const core::Model &model, const std::shared_ptr<const core::Body> &body) {
    const auto prepared = model.prepare(body, nullptr);
    const auto *springs = dynamic_cast<const PreparedMassSprings *>(prepared.get());
    return springs ? std::optional(springs->parts()) : std::nullopt;
}

} // namespace livermark::models
