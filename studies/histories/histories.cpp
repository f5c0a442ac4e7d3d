#include "studies/histories/histories.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <functional>

#include "core/mesh/bounding_box.hpp"
#include "msm/dynamics/elastic_motion.hpp"
#include "msm/dynamics/highest_frequency.hpp"
#include "msm/dynamics/spectrum.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/springs/spring_network.hpp"
#include "msm/statics/equilibrium.hpp"
#include "results/provenance.hpp"
#include "studies/msm_choice.hpp"
#include "studies/run/problems.hpp"
#include "studies/run/solutions/output_folder.hpp"
#include "studies/seed_paper/table_1_readings.hpp"
#include "support/input_error.hpp"

namespace livermark::studies {

namespace {

/// A motion beyond this many times its start, or the size of the body, has diverged.
constexpr double bound_of_one = 1000.0;
constexpr double bound_of_body = 10.0;
constexpr double most_history_steps = 1e6;
constexpr std::size_t most_records = 4001;
constexpr const char *one_degree_of_freedom = "one_degree_of_freedom";

/// What is looked at while something moves.
struct Watch {
    std::function<double(const msm::State &)> displacement; // [m]
    double bound = 0.0;                                     // of every displacement [m]
};

results::StepHistory move(const msm::Integrator &integrator, const msm::EquationOfMotion &equation, msm::State state,
                          double time_step, double duration, const Watch &watch) {
    results::StepHistory history{.time_step = time_step, .time = {0.0}, .displacement = {watch.displacement(state)}};
    const auto num_steps = static_cast<std::size_t>(std::lround(std::ceil(duration / time_step - 1e-9)));
    const std::size_t steps_per_record = (num_steps + most_records - 2) / (most_records - 1);
    const auto step = integrator.prepare(equation, time_step);
    for (std::size_t s = 1; s <= num_steps; ++s) {
        step(state);
        const double time = static_cast<double>(s) * time_step;
        const bool is_lost = !(state.displacement.lpNorm<Eigen::Infinity>() <= watch.bound);
        if (s % steps_per_record == 0 || s == num_steps || is_lost) {
            history.time.push_back(time);
            history.displacement.push_back(watch.displacement(state));
        }
        if (is_lost) {
            history.diverged_at = time;
            break;
        }
    }
    return history;
}

/// From 1 m let go, or from rest under the force that takes it to 1 m in the end.
results::HistoryCase move_one(const OneDegreeOfFreedom &model, bool is_pushed, const msm::Integrator &integrator,
                              const HistoriesOptions &options) {
    const double force = is_pushed ? model.stiffness : 0.0;
    msm::EquationOfMotion equation;
    equation.mass = Eigen::VectorXd::Constant(1, model.mass);
    equation.acceleration = [=](const Eigen::VectorXd &u, const Eigen::VectorXd &v, Eigen::VectorXd &a) {
        a[0] = (force - model.damping * v[0] - model.stiffness * u[0]) / model.mass;
    };
    equation.effective_mass = [=](const Eigen::VectorXd &, double d, double k) {
        Eigen::SparseMatrix<double> matrix(1, 1);
        matrix.insert(0, 0) = model.mass + d * model.damping + k * model.stiffness;
        return matrix;
    };
    const double omega = std::sqrt(model.stiffness / model.mass);
    results::HistoryCase moved{
        .name = model.name + (is_pushed ? "_step_force" : "_release"),
        .title = model.title + (is_pushed ? ", step force" : ""),
        .parameters = {{"mass", model.mass}, {"stiffness", model.stiffness}, {"damping", model.damping}},
        .critical_time_step =
            msm::critical_time_step(integrator, {.alpha = model.damping / model.mass, .beta = 0.0}, omega, omega),
        .steps = {}};
    const msm::State start{Eigen::VectorXd::Constant(1, is_pushed ? 0.0 : 1.0), Eigen::VectorXd::Zero(1)};
    const Watch watch{[](const msm::State &state) { return state.displacement[0]; }, bound_of_one};
    for (const double time_step : options.time_steps)
        moved.steps.push_back(move(integrator, equation, start, time_step, options.duration, watch));
    return moved;
}

/// The springs of a body, let go where the tractions hold them; the first probe is watched along the way that it had
/// gone.
results::HistoryCase move_body(const core::Problem &problem, const msm::SpringLaw &law,
                               const msm::Integrator &integrator, const HistoriesOptions &options,
                               const std::function<void(double)> &starting) {
    const auto &points = problem.body->mesh.points;
    const auto &release = problem.load_case.release.value();
    const auto springs = msm::spring_network(*problem.body, law);
    const auto loaded = msm::nodal_conditions(problem, springs.node_mass);
    const auto equilibrium = msm::find_equilibrium(springs, points, loaded);
    if (equilibrium.status != core::SolutionStatus::ok)
        throw support::InputError(fmt::format("{} under {}: {}; make the load smaller", problem.body->name,
                                              problem.load_case.name, equilibrium.message));
    const auto let_go =
        msm::nodal_conditions({problem.body, core::without_tractions(problem.load_case)}, springs.node_mass);
    const auto equation = msm::elastic_motion(springs, points, let_go, release.damping);
    results::HistoryCase moved{
        .name = problem.load_case.name,
        .title = fmt::format("{}, {}, {}", problem.body->name, law.name, release.probes.front().name),
        .parameters = {{"alpha", release.damping.alpha}, {"beta", release.damping.beta}},
        .critical_time_step = msm::critical_time_step(
            integrator, release.damping, msm::lowest_modes(springs, points, let_go, 1).angular_frequency.front(),
            msm::largest_angular_frequency(springs, points, let_go)),
        .steps = {}};
    auto time_steps = options.time_steps;
    // What the motion should look like.
    if (std::isfinite(moved.critical_time_step) && moved.critical_time_step > 0.0)
        time_steps.push_back(msm::default_safety_factor * moved.critical_time_step);

    const msm::State start{msm::to_unknowns(equilibrium.displacement),
                           Eigen::VectorXd::Zero(static_cast<Eigen::Index>(3 * points.size()))};
    const auto node = static_cast<Eigen::Index>(release.probes.front().node);
    const core::Vector3 direction = equilibrium.displacement[node].normalized();
    const Watch watch{[=](const msm::State &state) { return direction.dot(state.displacement.segment<3>(3 * node)); },
                      bound_of_body * core::extent(points)};
    for (const double time_step : time_steps) {
        starting(time_step);
        moved.steps.push_back(move(integrator, equation, start, time_step, options.duration, watch));
    }
    return moved;
}

ProblemSet read_released_problems(const HistoriesOptions &options) {
    auto set = read_scaled_problems(options.bodies, options.load_case, options.material);
    for (const auto &problem : set.problems)
        if (!problem.load_case.release)
            throw support::InputError(
                fmt::format("load case {} releases nothing; choose one with a [release]", problem.load_case.name));
    return set;
}

} // namespace

HistoriesResults find_histories(const HistoriesOptions &options, const std::string &command_line,
                                const ProgressReport &report) {
    for (const double time_step : options.time_steps)
        if (!(options.duration / time_step <= most_history_steps))
            throw support::InputError(
                fmt::format("--duration {} in steps of --time-step {} is more than a million steps; "
                            "make the duration shorter or the step longer",
                            options.duration, time_step));
    const auto law = find_spring_law(options.law);
    const auto integrator = find_integrators({options.integrator}).front();
    const auto [problems, notes, left_out] = read_released_problems(options);
    const auto empty_histories = [&](const std::string &subject) {
        return results::Histories{results::current_provenance(command_line), subject, integrator.name, {}};
    };
    HistoriesResults found{{}, notes};
    auto &done = found.of_subject;
    Steps steps(static_cast<int>(1 + problems.size() * (options.time_steps.size() + 1)), report);
    const auto folder = make_output_folder(options.output, one_degree_of_freedom);
    steps.next("one degree of freedom");
    done.push_back(empty_histories(one_degree_of_freedom));
    for (const bool is_pushed : {false, true})
        for (const auto &model : readings_of_table_1())
            done.back().cases.push_back(move_one(model, is_pushed, integrator, options));
    results::write_histories(folder / "histories.h5", done.back());

    for (const auto &problem : problems) {
        const auto body_folder = make_output_folder(options.output, problem.body->name);
        done.push_back(empty_histories(problem.body->name));
        done.back().cases.push_back(move_body(problem, law, integrator, options, [&](double time_step) {
            steps.next(fmt::format("{} / h = {:.3g} s", problem.body->name, time_step));
        }));
        results::write_histories(body_folder / fmt::format("histories.{}.h5", law.name), done.back());
    }
    return found;
}

} // namespace livermark::studies
