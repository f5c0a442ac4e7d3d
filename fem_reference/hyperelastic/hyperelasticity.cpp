#include "fem_reference/hyperelastic/hyperelasticity.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "core/stopwatch.hpp"
#include "core/support/input_error.hpp"
#include "fem_reference/hyperelastic/equilibrium_search.hpp"
#include "fem_reference/hyperelastic/motion.hpp"
#include "fem_reference/hyperelastic/surface.hpp"
#include "fem_reference/linear/conditions.hpp"

namespace livermark::hyperelastic {

namespace {

using core::Clock;
using core::seconds_since;

/// Augments pressures until the ball sinks in no more than it may, or as often as it may.
/// @return false where an equilibrium is not found
bool settle(EquilibriumSearch &search, TouchingBall &ball, LoadedState &at, double fraction, FollowedPath &result) {
    const auto &settings = ball.settings();
    const auto centre = ball.tool().centre_at(fraction);
    const double most = settings.sunk_in * ball.tool().press.norm();
    for (int time = 0; time < settings.max_augmentations; ++time) {
        if (ball.sums(centre, at.state.displacement).sunk_in <= most)
            return true;
        ball.augment(centre, at.state.displacement);
        LoadStep step{.fraction = fraction, .converged = false, .residuals = {}, .linear_iterations = {}};
        const bool done = search.settle(at, step);
        result.steps.push_back(std::move(step));
        if (!done)
            return false;
    }
    return true;
}

} // namespace

FollowedPath follow(PathSystem &system, int num_constraints, const LoadPath &path) {
    FollowedPath result;
    EquilibriumSearch search(system, num_constraints, path, result);
    auto start = Clock::now();
    LoadedState at{system.rest()};
    const bool is_constrained = search.begin();
    result.setup_seconds = seconds_since(start);
    start = Clock::now();
    double reached = 0.0;
    const auto give_up = [&](double fraction, std::string why) {
        result.status = core::SolutionStatus::not_converged;
        result.message = std::move(why);
        result.points.push_back(search.point(at, fraction));
        result.solve_seconds = seconds_since(start);
        return std::move(result);
    };
    if (!is_constrained) {
        result.status = core::SolutionStatus::not_converged;
        result.message = "the tangent stiffness at rest is singular: the prescribed displacements leave the body, or "
                         "a part of it, free to move as a rigid body; constrain it in all six ways";
        return result;
    }
    for (const double fraction : path.fractions) {
        const double way = fraction - reached;
        double length = way;
        while (reached < fraction) {
            // Not a step that leaves next to nothing for another.
            const double to = reached + 1.001 * length >= fraction ? fraction : reached + length;
            LoadStep step{.fraction = to, .converged = false, .residuals = {}, .linear_iterations = {}};
            const bool done = search.advance(at, reached, to, step);
            result.steps.push_back(std::move(step));
            if (done) {
                reached = to;
                constexpr std::size_t few = 6;
                if (result.steps.back().residuals.size() <= few)
                    length *= 2.0;
            } else {
                length = 0.5 * (to - reached);
                search.distrust_factor();
            }
            if (length < path.smallest_step * way)
                return give_up(reached, fmt::format("Newton's method finds no equilibrium beyond {:.1f} % of the load, "
                                                    "in steps of {:.2f} % either: the body may buckle or fold there; "
                                                    "take a smaller load, a finer mesh or constrain more of the body",
                                                    100.0 * reached, 100.0 * length));
        }
        if (system.ball() && !settle(search, *system.ball(), at, fraction, result))
            return give_up(fraction, fmt::format("Newton's method finds no equilibrium at {:.1f} % of the load with "
                                                 "what the ball may sink in; take a finer mesh or a longer path",
                                                 100.0 * fraction));
        result.points.push_back(search.point(at, fraction));
        if (system.ball())
            system.ball()->end_step(system.ball()->tool().centre_at(fraction), at.state.displacement);
    }
    result.solve_seconds = seconds_since(start);
    return result;
}

FollowedPath follow(const Elements &elements, const fem_reference::DofConditions &conditions, int num_constraints,
                    std::span<const double> follower_pressure, const LoadPath &path, TouchingBall *ball) {
    OneProcessSystem system(elements, conditions, follower_pressure, ball);
    return follow(system, num_constraints, path);
}

namespace {

using core::Vector3;

void add_motion(core::Solution &solution, const Elements &elements, TetrahedronRule rule, bool observes_steps,
                const core::LoadCase &load_case, const State &start) {
    auto released = release(elements, rule, load_case, start.displacement);
    if (observes_steps && std::isnan(released.history.diverged_at))
        released.history.observed_error =
            fem_reference::error_of_longer_steps(load_case, released.history, [&](const core::LoadCase &longer) {
                return release(elements, rule, longer, start.displacement).history;
            });
    solution.history = std::move(released.history);
    solution.solver += fmt::format("; in time {} steps, {} iterations, {} factors", released.work.steps,
                                   released.work.iterations, released.work.factors);
    if (const double time = solution.history->diverged_at; !std::isnan(time)) {
        solution.status = core::SolutionStatus::diverged;
        solution.message = fmt::format("the motion finds no next step at t = {:.3g} s", time);
    }
}

/// For the result file.
std::string touched(const TouchSums &touch) {
    return fmt::format("; touches on {:.4g} mm2, of which {:.3g} % slip", 1e6 * touch.area,
                       touch.area > 0.0 ? 100.0 * touch.slipping_area / touch.area : 0.0);
}

/// Why a path ended, if the load is why: it keeps its direction, and the surface below cannot bear that.
std::string instability(const Elements &elements, const core::LoadCase &load_case, const FollowedPath &followed) {
    constexpr int quadratic = 2;
    if (followed.status == core::SolutionStatus::ok || followed.points.empty() || elements.degree() != quadratic)
        return {};
    const auto &end = followed.points.back();
    const double part =
        unstable_part(elements, load_case, end.state.displacement, end.press > 0.0 ? end.press : end.fraction);
    constexpr double percent = 100.0;
    return part > 0.0 ? fmt::format("; there the surface cannot resist short waves on {:.0f} % of the area under loads "
                                    "that keep their direction",
                                    percent * part)
                      : std::string();
}

} // namespace

PathSolution solve(const core::Problem &problem, const MaterialLaw &law, const Discretisation &discretisation,
                   const LoadPath &path, std::span<const double> follower_pressure,
                   const fem_reference::InnerForces &inner) {
    check(path);
    const auto &mesh = problem.body->mesh;
    fem_reference::check_facets(problem.load_case, mesh);
    const auto start = Clock::now();
    const auto rule = discretisation.degree == 1 ? TetrahedronRule::one_point : discretisation.rule;
    Elements elements(problem.body, discretisation.degree, discretisation.formulation, law, rule);
    if (problem.load_case.foundation)
        elements.stand_on(*problem.load_case.foundation);
    auto conditions = fem_reference::dof_conditions(problem.load_case, elements.system());
    const auto weights = fem_reference::place_weights(inner.places, elements.system(), mesh);
    fem_reference::add_forces(weights, inner.forces, conditions.load);
    std::optional<TouchingBall> ball;
    if (problem.load_case.touching)
        ball.emplace(elements.system(), *problem.body, problem.load_case,
                     contact_settings(discretisation.degree, problem.load_case.touching->shape));
    const double assembly_seconds = seconds_since(start);
    const auto num_constraints = problem.load_case.num_constraints();
    const auto followed =
        fem_reference::holds_every_part(problem.load_case, mesh)
            ? follow(elements, conditions, num_constraints, follower_pressure, path, ball ? &*ball : nullptr)
            : free_to_move();
    auto result = path_solution(followed, mesh, problem.load_case,
                                [&](const auto &u) { return elements.system().at_mesh_nodes(u); });
    auto &solution = result.solution;
    if (solution.status == core::SolutionStatus::ok) {
        const auto &u = followed.points.back().state.displacement;
        result.load_work = std::inner_product(conditions.load.begin(), conditions.load.end(), u.begin(), 0.0);
        result.at_places = fem_reference::means_at(weights, u);
    }
    solution.degrees_of_freedom = elements.num_displacements() + elements.num_pressures();
    solution.setup_seconds += assembly_seconds;
    solution.solver =
        description(followed, elements.num_pressures() > 0 ? "times two levels over CHOLMOD" : "factors by CHOLMOD");
    solution.message += instability(elements, problem.load_case, followed);
    if (ball && !followed.points.empty())
        solution.solver += touched(followed.points.back().touch);
    if (solution.status == core::SolutionStatus::ok && problem.load_case.release &&
        discretisation.formulation == fem_reference::Formulation::displacement)
        add_motion(solution, elements, rule, discretisation.observes_steps, problem.load_case,
                   followed.points.back().state);
    return result;
}

namespace {

/// |u - v| / |u| with the norm of core::Comparison.
double relative_difference(const core::TetraMesh &mesh, const std::vector<Vector3> &u, const std::vector<Vector3> &v) {
    const auto volumes = core::nodal_volumes(mesh);
    double difference = 0.0, size = 0.0;
    for (std::size_t node = 0; node < u.size(); ++node) {
        difference += volumes[node] * (u[node] - v[node]).squaredNorm();
        size += volumes[node] * u[node].squaredNorm();
    }
    return std::sqrt(difference / size);
}

} // namespace

void check(const LoadPath &path) {
    const auto &fractions = path.fractions;
    const bool ascends = std::ranges::adjacent_find(fractions, std::greater_equal<>()) == fractions.end();
    if (fractions.empty() || !ascends || !(fractions.front() > 0.0) || fractions.back() != 1.0)
        throw std::invalid_argument("the fractions of a load path have to ascend from above 0 to 1");
}

std::string description(const FollowedPath &path, const std::string &inverses) {
    std::size_t corrections = 0, linear = 0, most = 0;
    for (const auto &step : path.steps) {
        corrections += step.linear_iterations.size();
        most = std::max(most, step.linear_iterations.size());
        for (const int iterations : step.linear_iterations)
            linear += static_cast<std::size_t>(iterations);
    }
    return fmt::format("Newton, {} load steps, {} linear solves, {} in a step at most; GMRES, {} iterations, {} {}",
                       path.steps.size(), corrections, most, linear, path.factorisations, inverses);
}

FollowedPath free_to_move() {
    return {.status = core::SolutionStatus::not_converged,
            .message = "the prescribed displacements leave the body, or a part of it, free to move as a rigid body; "
                       "constrain it in all six ways"};
}

PathSolution path_solution(const FollowedPath &followed, const core::TetraMesh &mesh, const core::LoadCase &load_case,
                           const std::function<std::vector<Vector3>(const std::vector<double> &)> &at_mesh_nodes) {
    const auto resultants = core::press_resultants(load_case, mesh);
    PathSolution result;
    for (const auto &point : followed.points) {
        auto reaction = point.reaction;
        for (std::size_t place = 0; place < reaction.size(); ++place)
            reaction[place] += point.press * resultants[place];
        result.points.push_back({.fraction = point.fraction,
                                 .displacement = at_mesh_nodes(point.state.displacement),
                                 .reaction = std::move(reaction),
                                 .strain_energy = point.strain_energy,
                                 .smallest_jacobian = point.smallest_jacobian});
    }
    result.steps = followed.steps;
    auto &solution = result.solution;
    solution.status = followed.status;
    solution.message = followed.message;
    solution.setup_seconds = followed.setup_seconds;
    solution.solve_seconds = followed.solve_seconds;
    if (result.points.empty()) {
        fem_reference::leave_unsolved(solution, mesh, load_case);
        return result;
    }
    const auto &end = result.points.back();
    solution.displacement = end.displacement;
    solution.reaction = end.reaction;
    solution.strain_energy = end.strain_energy;
    if (solution.status == core::SolutionStatus::ok)
        solution.nonlinearity = relative_difference(mesh, end.displacement, at_mesh_nodes(followed.linearised));
    return result;
}

namespace {

using Eigen::VectorXd;

LoadPath path_of_pushes() {
    LoadPath path;
    path.tolerance = 1e-5; // of forces out of balance: places move by less than a micrometre for them
    return path;
}

fem_reference::DofConditions held_at_rest(const core::Problem &problem, const fem_reference::ElasticSystem &system) {
    fem_reference::check_facets(problem.load_case, problem.body->mesh);
    auto conditions = fem_reference::dof_conditions(problem.load_case, system);
    for (double &value : conditions.prescribed)
        value = std::isnan(value) ? value : 0.0;
    std::ranges::fill(conditions.load, 0.0);
    conditions.press_depth = 0.0;
    return conditions;
}

class PushedElements : public core::PushedBody {
  public:
    PushedElements(const core::Problem &problem, const MaterialLaw &law, const Discretisation &discretisation,
                   std::span<const core::InteriorPlace> places, Eigen::MatrixXd compliance)
        : elements_(problem.body, discretisation.degree, discretisation.formulation, law,
                    discretisation.degree == 1 ? TetrahedronRule::one_point : discretisation.rule),
          conditions_(held_at_rest(problem, elements_.system())),
          weights_(fem_reference::place_weights(places, elements_.system(), problem.body->mesh)),
          compliance_(std::move(compliance)), system_(elements_, conditions_, {}),
          search_(system_, problem.load_case.num_constraints(), path_, steps_), at_{system_.rest(), 1.0},
          force_(VectorXd::Zero(3 * weights_.rows())) {
        if (!search_.begin())
            throw support::InputError(fmt::format("{}: load case '{}' leaves the body free to move; constrain it, or "
                                                  "leave this model out",
                                                  problem.body->name, problem.load_case.name));
    }

    const Eigen::MatrixXd &compliance() const override { return compliance_; }

    std::optional<core::PushedPlaces> push(const VectorXd &force) override {
        auto there = at_;
        const auto begin = [&] {
            there = at_;
            steps_ = {};
        };
        const auto go_to = [&](const VectorXd &part) {
            load(part);
            LoadStep step;
            const bool is_there = search_.settle(there, step);
            if (!is_there)
                search_.distrust_factor();
            return is_there;
        };
        if (!core::push_in_parts(force_, force, begin, go_to))
            return std::nullopt;
        at_ = std::move(there);
        force_ = force;
        return found();
    }

  private:
    void load(const VectorXd &force) {
        using RowsOfComponents = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
        const Eigen::Map<const RowsOfComponents> place_forces(force.data(), weights_.rows(), 3);
        Eigen::Map<RowsOfComponents>(conditions_.load.data(), weights_.cols(), 3) = weights_.transpose() * place_forces;
    }

    core::PushedPlaces found() const {
        core::PushedPlaces places{VectorXd(3 * weights_.rows()), elements_.internal_forces(at_.state).energy};
        const auto means = fem_reference::means_at(weights_, at_.state.displacement);
        for (std::size_t place = 0; place < means.size(); ++place)
            places.displacement.segment<3>(static_cast<Eigen::Index>(3 * place)) = means[place];
        return places;
    }

    Elements elements_;
    fem_reference::DofConditions conditions_;
    Eigen::SparseMatrix<double, Eigen::RowMajor> weights_; ///< (K, n)
    Eigen::MatrixXd compliance_;
    LoadPath path_ = path_of_pushes();
    FollowedPath steps_;
    OneProcessSystem system_;
    EquilibriumSearch search_;
    LoadedState at_;
    VectorXd force_; ///< (3 K) that it is in equilibrium under [N]
};

} // namespace

std::unique_ptr<core::PushedBody> pushed_elements(const core::Problem &problem, const MaterialLaw &law,
                                                  const Discretisation &discretisation,
                                                  std::span<const core::InteriorPlace> places,
                                                  Eigen::MatrixXd compliance) {
    return std::make_unique<PushedElements>(problem, law, discretisation, places, std::move(compliance));
}

namespace {

/// Before it gives up, in parts of the time between two records.
constexpr double smallest_part_of_record = 1.0 / 64.0;

/// A body on its way through a history.
class SlowBody {
  public:
    SlowBody(Elements &elements, const fem_reference::DofConditions &conditions, int num_constraints,
             std::span<const double> follower_pressure, const LoadPath &path, const core::PronySeries &relaxation)
        : elements_(elements), relaxation_(relaxation), system_(elements, conditions, follower_pressure),
          search_(system_, num_constraints, path, followed_), at_{system_.rest()} {
        const auto num_points = elements.point_volumes().size();
        memory_.remembered.assign(num_points, Matrix3::Zero());
        stress_ = memory_.remembered;
        branches_.assign(relaxation.moduli.size(), memory_.remembered);
        force_.assign(at_.state.displacement.size(), 0.0);
        elements_.set_memory(&memory_);
    }
    ~SlowBody() { elements_.set_memory(nullptr); }
    SlowBody(const SlowBody &) = delete;
    SlowBody &operator=(const SlowBody &) = delete;

    bool begin() { return search_.begin(); }

    /// @param from, to  factors of the loads
    /// @return whether there is equilibrium after it
    bool advance(double duration, double from, double to) {
        const auto steps = core::branch_steps(relaxation_, duration);
        const auto before = memory_;
        memory_.faded = 1.0 - core::instant_part(relaxation_, steps);
        for (std::size_t p = 0; p < stress_.size(); ++p) {
            memory_.remembered[p].setZero();
            for (std::size_t k = 0; k < steps.size(); ++k)
                memory_.remembered[p] += steps[k].fade * branches_[k][p] - steps[k].gain * stress_[p];
        }
        const auto displacement = at_.state.displacement;
        LoadStep step{.fraction = to, .converged = false, .residuals = {}, .linear_iterations = {}};
        const bool done = search_.advance(at_, from, to, step);
        followed_.steps.push_back(std::move(step));
        if (!done) {
            memory_ = before;
            search_.distrust_factor();
            return false;
        }
        const auto now = elements_.isochoric_stresses(at_.state);
        const auto volumes = elements_.point_volumes();
        for (std::size_t p = 0; p < now.size(); ++p) {
            const Matrix3 change = now[p] - stress_[p];
            for (std::size_t k = 0; k < steps.size(); ++k) {
                auto &branch = branches_[k][p];
                dissipated_ +=
                    volumes[p] / (2.0 * shear_modulus_at(p)) *
                    steps[k].dissipated(branch.squaredNorm(), branch.cwiseProduct(change).sum(), change.squaredNorm());
                branch = steps[k].fade * branch + steps[k].gain * change;
            }
        }
        stress_ = now;
        const auto force = elements_.internal_forces(at_.state).force;
        for (std::size_t dof = 0; dof < force.size(); ++dof)
            work_ += 0.5 * (force[dof] + force_[dof]) * (at_.state.displacement[dof] - displacement[dof]);
        force_ = force;
        return true;
    }

    PathPoint point(double factor) const { return search_.point(at_, factor); }
    double work() const { return work_; }
    /// Heat of the dashpots of branches so far, with the moduli of stored_energy() [J].
    double dissipated_energy() const { return dissipated_; }
    const FollowedPath &followed() const { return followed_; }

    /// See solve_history().
    double stored_energy() {
        const DeviatoricMemory after_all{.faded = 1.0 - relaxation_.remaining(),
                                         .remembered = std::vector(stress_.size(), Matrix3(Matrix3::Zero()))};
        elements_.set_memory(&after_all);
        double energy = elements_.internal_forces(at_.state).energy;
        elements_.set_memory(&memory_);
        const auto volumes = elements_.point_volumes();
        for (std::size_t p = 0; p < volumes.size(); ++p)
            for (std::size_t k = 0; k < branches_.size(); ++k)
                if (const double modulus = relaxation_.moduli[k]; modulus > 0.0)
                    energy += volumes[p] * branches_[k][p].squaredNorm() / (4.0 * shear_modulus_at(p) * modulus);
        return energy;
    }

  private:
    double shear_modulus_at(std::size_t point) const {
        const auto &body = elements_.body();
        const auto points_per_cell = stress_.size() / body.mesh.tetrahedra.size();
        return body.shear_modulus_of(point / points_per_cell);
    }

    Elements &elements_;
    const core::PronySeries &relaxation_;
    FollowedPath followed_{};
    OneProcessSystem system_;
    EquilibriumSearch search_;
    LoadedState at_;
    DeviatoricMemory memory_{};
    std::vector<Matrix3> stress_;                ///< at each point, after the last step
    std::vector<std::vector<Matrix3>> branches_; ///< (B) the same of what each remembers
    std::vector<double> force_;                  ///< (3 n) internal, after the last step [N]
    double work_ = 0.0, dissipated_ = 0.0;
};

/// @return whether the body came to the next record
bool go_on(SlowBody &body, const core::SlowHistory &history, int record) {
    const double duration = history.times[record] - history.times[record - 1];
    const double first = history.factors[record - 1], last = history.factors[record];
    double reached = 0.0, length = 1.0;
    while (reached < 1.0) {
        const double to = reached + 1.001 * length >= 1.0 ? 1.0 : reached + length;
        if (body.advance((to - reached) * duration, std::lerp(first, last, reached), std::lerp(first, last, to))) {
            reached = to;
        } else {
            length = 0.5 * (to - reached);
            if (length < smallest_part_of_record)
                return false;
        }
    }
    return true;
}

} // namespace

core::Solution solve_history(const core::Problem &problem, const MaterialLaw &law, const Discretisation &discretisation,
                             double tolerance, std::span<const double> follower_pressure) {
    const auto &mesh = problem.body->mesh;
    const auto &load_case = problem.load_case;
    const auto &history = *load_case.slow_history;
    fem_reference::check_facets(load_case, mesh);
    const auto start = core::Clock::now();
    const auto rule = discretisation.degree == 1 ? TetrahedronRule::one_point : discretisation.rule;
    Elements elements(problem.body, discretisation.degree, discretisation.formulation, law, rule);
    const auto conditions = fem_reference::dof_conditions(load_case, elements.system());
    const auto resultants = core::press_resultants(load_case, mesh);
    core::Solution solution;
    solution.degrees_of_freedom = elements.num_displacements() + elements.num_pressures();
    solution.setup_seconds = core::seconds_since(start);
    fem_reference::leave_unsolved(solution, mesh, load_case);

    const auto solve_start = core::Clock::now();
    const LoadPath path{.fractions = {1.0}, .tolerance = tolerance};
    SlowBody body(elements, conditions, static_cast<int>(resultants.size()), follower_pressure, path,
                  history.relaxation);
    if (!fem_reference::holds_every_part(load_case, mesh) || !body.begin()) {
        const auto free = free_to_move();
        solution.status = free.status;
        solution.message = free.message;
        return solution;
    }
    for (int record = 0; record < history.num_records(); ++record) {
        if (record > 0 && !go_on(body, history, record)) {
            solution.status = core::SolutionStatus::not_converged;
            solution.message =
                fmt::format("Newton's method finds no equilibrium beyond {:.3g} s; take a smaller load, a finer mesh "
                            "or constrain more of the body",
                            history.times[record - 1]);
            break;
        }
        const auto point = body.point(history.factors[record]);
        auto &kept = solution.path.emplace_back();
        auto displacement = elements.system().at_mesh_nodes(point.state.displacement);
        for (const auto &u : displacement)
            kept.displacement.push_back(u.cast<float>());
        kept.reaction = point.reaction;
        for (std::size_t place = 0; place < resultants.size(); ++place)
            kept.reaction[place] += point.press * resultants[place];
        kept.strain_energy = body.stored_energy();
        kept.work = body.work();
        kept.dissipated_energy = body.dissipated_energy();
        if (record == history.whole_load_record()) {
            solution.displacement = std::move(displacement);
            solution.reaction = kept.reaction;
            solution.strain_energy = kept.strain_energy;
        }
    }
    solution.solve_seconds = core::seconds_since(solve_start);
    solution.solver = description(body.followed(), elements.num_pressures() > 0 ? "times two levels over CHOLMOD"
                                                                                : "factors by CHOLMOD");
    return solution;
}

} // namespace livermark::hyperelastic
