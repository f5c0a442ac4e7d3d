#include "fem_reference/hyperelastic/hyperelasticity.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "core/support/input_error.hpp"
#include "fem_reference/hyperelastic/equilibrium_search.hpp"
#include "fem_reference/hyperelastic/motion.hpp"
#include "fem_reference/hyperelastic/surface_deformation.hpp"
#include "fem_reference/linear/conditions.hpp"

namespace livermark::hyperelastic {

namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

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
            if (length < path.smallest_step * way) {
                result.status = core::SolutionStatus::not_converged;
                result.message = fmt::format(
                    "Newton's method finds no equilibrium beyond {:.1f} % of the load, in steps of {:.2f} % either: "
                    "the "
                    "body may buckle or fold there; take a smaller load, a finer mesh or constrain more of the body",
                    100.0 * reached, 100.0 * length);
                result.points.push_back(search.point(at, reached));
                result.solve_seconds = seconds_since(start);
                return result;
            }
        }
        if (system.ball() && !settle(search, *system.ball(), at, fraction, result)) {
            result.status = core::SolutionStatus::not_converged;
            result.message = fmt::format("Newton's method finds no equilibrium at {:.1f} % of the load with what the "
                                         "ball may sink in; take a finer mesh or a longer path",
                                         100.0 * fraction);
            result.points.push_back(search.point(at, fraction));
            result.solve_seconds = seconds_since(start);
            return result;
        }
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

void add_motion(core::Solution &solution, const Elements &elements, TetrahedronRule rule,
                const core::LoadCase &load_case, const State &start) {
    auto released = release(elements, rule, load_case, start.displacement);
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
                   const LoadPath &path, std::span<const double> follower_pressure) {
    check(path);
    const auto &mesh = problem.body->mesh;
    fem_reference::check_facets(problem.load_case, mesh);
    const auto start = std::chrono::steady_clock::now();
    const auto rule = discretisation.degree == 1 ? TetrahedronRule::one_point : discretisation.rule;
    const Elements elements(problem.body, discretisation.degree, discretisation.formulation, law, rule);
    const auto conditions = fem_reference::dof_conditions(problem.load_case, elements.system());
    std::optional<TouchingBall> ball;
    if (problem.load_case.touching)
        ball.emplace(elements.system(), *problem.body, problem.load_case);
    const std::chrono::duration<double> assembly = std::chrono::steady_clock::now() - start;
    const auto num_constraints = problem.load_case.num_constraints();
    const auto followed =
        fem_reference::holds_every_part(problem.load_case, mesh)
            ? follow(elements, conditions, num_constraints, follower_pressure, path, ball ? &*ball : nullptr)
            : free_to_move();
    const auto at_mesh_nodes = [&](const std::vector<double> &displacement) {
        std::vector<Vector3> result;
        for (const int node : elements.system().mesh_node)
            result.emplace_back(Vector3::Map(&displacement[3 * node]));
        return result;
    };
    auto result = path_solution(followed, mesh, problem.load_case, at_mesh_nodes);
    auto &solution = result.solution;
    if (solution.status == core::SolutionStatus::ok)
        result.load_work = std::inner_product(conditions.load.begin(), conditions.load.end(),
                                              followed.points.back().state.displacement.begin(), 0.0);
    solution.degrees_of_freedom = elements.num_displacements() + elements.num_pressures();
    solution.setup_seconds += assembly.count();
    solution.solver =
        description(followed, elements.num_pressures() > 0 ? "times two levels over CHOLMOD" : "factors by CHOLMOD");
    solution.message += instability(elements, problem.load_case, followed);
    if (ball && !followed.points.empty())
        solution.solver += touched(followed.points.back().touch);
    if (solution.status == core::SolutionStatus::ok && problem.load_case.release &&
        discretisation.formulation == fem_reference::Formulation::displacement)
        add_motion(solution, elements, rule, problem.load_case, followed.points.back().state);
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
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
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
        solution.displacement.assign(mesh.points.size(), Vector3::Constant(nan));
        solution.reaction.assign(resultants.size(), Vector3::Constant(nan));
        solution.strain_energy = nan;
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
        const Eigen::Map<const RowsOfComponents> of_places(force.data(), weights_.rows(), 3);
        Eigen::Map<RowsOfComponents>(conditions_.load.data(), weights_.cols(), 3) = weights_.transpose() * of_places;
    }

    core::PushedPlaces found() const {
        core::PushedPlaces places{VectorXd(3 * weights_.rows()), elements_.internal_forces(at_.state).energy};
        for (Eigen::Index place = 0; place < weights_.rows(); ++place) {
            core::Vector3 mean = core::Vector3::Zero();
            for (decltype(weights_)::InnerIterator entry(weights_, place); entry; ++entry)
                mean += entry.value() * core::Vector3::Map(&at_.state.displacement[3 * entry.col()]);
            places.displacement.segment<3>(3 * place) = mean;
        }
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

} // namespace livermark::hyperelastic
