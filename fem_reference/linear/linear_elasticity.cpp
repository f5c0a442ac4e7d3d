#include "fem_reference/linear/linear_elasticity.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <iterator>
#include <limits>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "core/stopwatch.hpp"
#include "core/support/input_error.hpp"
#include "fem_reference/dynamics/release.hpp"
#include "fem_reference/linear/chosen_solver.hpp"
#include "fem_reference/linear/conditions.hpp"
#include "fem_reference/linear/elastic_system.hpp"
#include "fem_reference/linear/facets.hpp"
#include "fem_reference/solvers/constrained_solver.hpp"
#include "fem_reference/solvers/two_level.hpp"

namespace livermark::fem_reference {

namespace {

using core::Clock;
using core::seconds_since;
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// Response to one newton, multiplied by as many as it takes to the depth, where a place presses. The load becomes all
/// of it.
/// @return how many [N], 0 where none presses
double press_to_depth(DofConditions &conditions, ConstrainedSolution &found) {
    if (conditions.press_depth == 0.0 || !found.unique)
        return 0.0;
    const double depth =
        std::inner_product(found.displacement.begin(), found.displacement.end(), conditions.load.begin(), 0.0);
    const double newtons = conditions.press_depth / depth;
    for (auto *const values : {&conditions.load, &found.displacement, &found.residual})
        for (double &value : *values)
            value *= newtons;
    found.energy *= newtons * newtons;
    return newtons;
}

} // namespace

struct StaticSolver::Impl {
    Impl(std::shared_ptr<const core::Body> of, int degree, SolverChoice choice, Formulation form,
         int largest_coarse_factor, const std::optional<core::Foundation> &stands_on)
        : body(std::move(of)), formulation(form), foundation(stands_on), start(Clock::now()),
          matrices(*body, degree, form, foundation), springs(foundation, body->mesh, matrices.system),
          corners(*body, choice, matrices, largest_coarse_factor, foundation), solver(make_solver(choice)) {
        if (matrices.pressure.num_pressures() > 0)
            mixed.emplace(matrices.system, solver, matrices.pressure);
        assembly_seconds = seconds_since(start);
    }
    Impl(std::shared_ptr<const core::Body> refined, Impl &coarse, double tolerance, std::span<const int> parent,
         const std::optional<core::Foundation> &stands_on)
        : body(std::move(refined)), formulation(coarse.formulation), foundation(stands_on), start(Clock::now()),
          matrices(*body, 2, formulation, foundation), springs(foundation, body->mesh, matrices.system),
          solver(matrices.system, coarse.matrices.system, coarse.solver, parent) {
        if (matrices.pressure.num_pressures() > 0)
            mixed.emplace(matrices.system, solver, matrices.pressure, tolerance, *coarse.mixed,
                          nested_iteration(coarse.matrices.system, coarse.matrices.pressure, matrices.system,
                                           matrices.pressure, parent));
        assembly_seconds = seconds_since(start);
    }

    ChosenSolver make_solver(SolverChoice choice) {
        return corners.solver ? ChosenSolver(matrices.system, *corners.system, *corners.solver)
                              : ChosenSolver(matrices.system, choice);
    }

    /// @throws std::invalid_argument if the load case is not for this body on what it stands on
    void check(const core::LoadCase &load_case) const {
        check_facets(load_case, body->mesh);
        if (load_case.foundation != foundation)
            throw std::invalid_argument("load case " + load_case.name + " has another foundation than this solver");
    }

    ConstrainedSolution solve(const DofConditions &conditions) {
        return mixed ? mixed->solve(conditions.prescribed, conditions.load)
                     : solver.solve(conditions.prescribed, conditions.load);
    }

    core::Solution solution(const core::LoadCase &load_case, DofConditions &conditions,
                            ConstrainedSolution &found) const;
    std::vector<core::Solution> solve_together(std::span<const core::LoadCase> load_cases);
    core::Solution solve(const core::LoadCase &load_case, bool moves_mixed);
    core::Compliance compliance(const core::LoadCase &load_case, std::span<const core::InteriorPlace> places);
    core::History motion(const core::LoadCase &load_case, const std::vector<double> &displacement);
    std::optional<core::History> motion_of_mixed(const core::LoadCase &load_case, std::vector<double> force,
                                                 const ConstrainedSolution &start);

    std::shared_ptr<const core::Body> body;
    Formulation formulation;
    std::optional<core::Foundation> foundation;
    Clock::time_point start;
    Discretisation matrices;
    FoundationSprings springs; ///< a part of the stiffness
    Corners corners;
    ChosenSolver solver;
    std::optional<MixedSolver> mixed;
    std::optional<ConstrainedSolver> motion_factor; ///< where the solver has no factor, when the first motion comes
    double assembly_seconds = 0.0;
};

StaticSolver::StaticSolver(std::shared_ptr<const core::Body> body, int degree, SolverChoice choice,
                           Formulation formulation, int largest_coarse_factor,
                           const std::optional<core::Foundation> &foundation)
    : impl_(std::make_unique<Impl>(std::move(body), degree, choice, formulation, largest_coarse_factor, foundation)) {}
StaticSolver::StaticSolver(std::shared_ptr<const core::Body> refined_body, StaticSolver &coarse, double tolerance,
                           std::span<const int> parent, const std::optional<core::Foundation> &foundation)
    : impl_(std::make_unique<Impl>(std::move(refined_body), *coarse.impl_, tolerance, parent, foundation)) {}
StaticSolver::~StaticSolver() = default;
StaticSolver::StaticSolver(StaticSolver &&) noexcept = default;
StaticSolver &StaticSolver::operator=(StaticSolver &&) noexcept = default;

/// @param conditions, found  at the depth on return, where a place presses
/// @return without the seconds of the solve
core::Solution StaticSolver::Impl::solution(const core::LoadCase &load_case, DofConditions &conditions,
                                            ConstrainedSolution &found) const {
    const double press = press_to_depth(conditions, found);
    const auto &mesh = body->mesh;
    core::Solution solution;
    solution.degrees_of_freedom = static_cast<std::int64_t>(conditions.load.size()) + matrices.pressure.num_pressures();
    leave_unsolved(solution, mesh, load_case);
    if (found.unique) {
        solution.displacement = matrices.system.at_mesh_nodes(found.displacement);
        solution.reaction = core::press_resultants(load_case, mesh);
        for (auto &reaction : solution.reaction)
            reaction *= press;
        for (std::size_t dof = 0; dof < conditions.constraint.size(); ++dof)
            if (const int owner = conditions.constraint[dof]; owner >= 0)
                solution.reaction[owner][dof % 3] += found.residual[dof];
        solution.strain_energy = found.energy - springs.energy(found.displacement);
        if (load_case.press_depth == 0.0 && load_case.acceleration.isZero(0.0))
            solution.load_work =
                std::inner_product(conditions.load.begin(), conditions.load.end(), found.displacement.begin(), 0.0);
        if (!found.converged) {
            solution.status = core::SolutionStatus::not_converged;
            solution.message = fmt::format("{} stopped after {} iterations at a relative residual of "
                                           "{:.1e}; use the direct solver",
                                           mixed ? "generalised minimal residuals" : "conjugate gradients",
                                           found.iterations, found.relative_residual);
        }
    } else {
        solution.status = core::SolutionStatus::not_converged;
        solution.message = "the stiffness matrix is singular: the prescribed displacements leave the body, or a part "
                           "of it, free to move as a rigid body; constrain all six rigid body motions";
    }
    solution.solver = mixed ? mixed->description(found) : solver.description(found);
    solution.setup_seconds = assembly_seconds + solver.setup_seconds();
    return solution;
}

core::History StaticSolver::Impl::motion(const core::LoadCase &load_case, const std::vector<double> &displacement) {
    if (auto *const kept = solver.direct())
        return release(*body, matrices.system, load_case, displacement, *kept);
    if (!motion_factor)
        motion_factor.emplace(compressed_rows(matrices.system.stiffness));
    return release(*body, matrices.system, load_case, displacement, *motion_factor);
}

/// @param force  the loads of the static solution
/// @param start  that solution
std::optional<core::History> StaticSolver::Impl::motion_of_mixed(const core::LoadCase &load_case,
                                                                 std::vector<double> force,
                                                                 const ConstrainedSolution &start) {
    for (std::size_t i = 0; i < force.size(); ++i)
        force[i] += start.residual[i];
    auto at_zero = dof_conditions(core::without_tractions(load_case), matrices.system).prescribed;
    for (double &value : at_zero)
        value = std::isnan(value) ? nan : 0.0;
    return release_by_statics(*body, matrices.system, load_case, start.displacement, force,
                              [&](std::span<const double> f, std::span<double> x, std::span<double> k_x) {
                                  const auto found = mixed->solve(at_zero, f);
                                  std::ranges::copy(found.displacement, x.begin());
                                  for (std::size_t i = 0; i < f.size(); ++i)
                                      k_x[i] = f[i] + found.residual[i];
                              });
}

void StaticSolver::prepare(const core::LoadCase &load_case) {
    if (auto *const direct = impl_->solver.direct())
        direct->prepare(dof_conditions(load_case, impl_->matrices.system).prescribed);
}

core::Solution StaticSolver::Impl::solve(const core::LoadCase &load_case, bool moves_mixed) {
    check(load_case);
    const auto conditions_start = Clock::now();
    auto conditions = dof_conditions(load_case, matrices.system);
    const double conditions_seconds = seconds_since(conditions_start);
    solver.set_up(conditions.prescribed);
    const auto solve_start = Clock::now();
    auto found = solve(conditions);
    auto solution = this->solution(load_case, conditions, found);
    solution.solve_seconds = conditions_seconds + seconds_since(solve_start);
    if (!load_case.release || !found.unique)
        return solution;
    if (formulation == Formulation::displacement || (moves_mixed && !mixed))
        solution.history = motion(load_case, found.displacement);
    else if (moves_mixed)
        solution.history = motion_of_mixed(load_case, std::move(conditions.load), found);
    return solution;
}

core::Solution StaticSolver::solve(const core::LoadCase &load_case) {
    return impl_->solve(load_case, false);
}

core::Solution StaticSolver::solve_with_motion(const core::LoadCase &load_case) {
    return impl_->solve(load_case, true);
}

/// @param load_cases  more than one, not more than max_columns()
std::vector<core::Solution> StaticSolver::Impl::solve_together(std::span<const core::LoadCase> load_cases) {
    const auto solve_start = Clock::now();
    std::vector<DofConditions> all;
    for (const auto &load_case : load_cases) {
        check(load_case);
        all.push_back(dof_conditions(load_case, matrices.system));
    }
    std::vector<Conditions> conditions;
    for (const auto &one : all)
        conditions.push_back({one.prescribed, one.load});
    auto found = mixed->solve(conditions);
    std::vector<core::Solution> solutions;
    for (std::size_t c = 0; c < found.size(); ++c) {
        auto &solution = solutions.emplace_back(this->solution(load_cases[c], all[c], found[c]));
        solution.solver += fmt::format(", {} load cases together", found.size());
    }
    for (auto &solution : solutions)
        solution.solve_seconds = seconds_since(solve_start) / static_cast<double>(solutions.size());
    return solutions;
}

std::vector<core::Solution> StaticSolver::solve(std::span<const core::LoadCase> load_cases) {
    std::vector<core::Solution> solutions;
    while (!load_cases.empty()) {
        const auto some = load_cases.first(std::min(load_cases.size(), max_columns()));
        load_cases = load_cases.subspan(some.size());
        auto found = some.size() > 1 ? impl_->solve_together(some) : std::vector<core::Solution>{};
        // One that leaves the body free to move keeps the others from their solutions.
        const auto is_solved = [](const core::Solution &solution) { return !std::isnan(solution.strain_energy); };
        if (found.empty() || !std::ranges::all_of(found, is_solved)) {
            found.clear();
            for (const auto &load_case : some)
                found.push_back(solve(load_case));
        }
        std::ranges::move(found, std::back_inserter(solutions));
    }
    return solutions;
}

core::Compliance StaticSolver::Impl::compliance(const core::LoadCase &load_case,
                                                std::span<const core::InteriorPlace> places) {
    check(load_case);
    const auto begin = Clock::now();
    auto held = dof_conditions(load_case, matrices.system).prescribed;
    for (double &value : held)
        value = std::isnan(value) ? nan : 0.0;
    const auto weights = place_weights(places, matrices.system, body->mesh);
    const auto num_columns = 3 * weights.rows();
    core::Compliance found;
    found.matrix.resize(num_columns, num_columns);
    found.degrees_of_freedom = static_cast<std::int64_t>(held.size()) + matrices.pressure.num_pressures();
    const auto together = mixed ? static_cast<Eigen::Index>(mixed->max_columns()) : 1;
    for (Eigen::Index first = 0; first < num_columns; first += together) {
        std::vector<std::vector<double>> loads;
        std::vector<Conditions> conditions;
        for (auto column = first; column < std::min(first + together, num_columns); ++column)
            loads.push_back(load_of(weights, column / 3, static_cast<int>(column % 3)));
        for (const auto &load : loads)
            conditions.push_back({held, load});
        auto solutions =
            mixed ? mixed->solve(conditions) : std::vector<ConstrainedSolution>{solver.solve(held, loads.front())};
        for (std::size_t c = 0; c < solutions.size(); ++c) {
            if (!solutions[c].unique)
                throw support::InputError(fmt::format("{}: load case '{}' leaves the body free to move; constrain it",
                                                      body->name, load_case.name));
            const Eigen::Map<const Eigen::Matrix3Xd> displacement(solutions[c].displacement.data(), 3, weights.cols());
            const Eigen::Matrix3Xd at_places = displacement * weights.transpose();
            found.matrix.col(first + static_cast<Eigen::Index>(c)) = at_places.reshaped();
        }
    }
    found.seconds = seconds_since(begin);
    return found;
}

core::Compliance StaticSolver::compliance(const core::LoadCase &load_case,
                                          std::span<const core::InteriorPlace> places) {
    return impl_->compliance(load_case, places);
}

std::size_t StaticSolver::max_columns() const {
    return impl_->mixed ? impl_->mixed->max_columns() : 1;
}

const Discretisation &StaticSolver::matrices() const {
    return impl_->matrices;
}

ChosenSolver &StaticSolver::displacement_solver() {
    return impl_->solver;
}

double StaticSolver::assembly_seconds() const {
    return impl_->assembly_seconds;
}

core::Solution solve_static(const core::Problem &problem, int degree, SolverChoice choice, Formulation formulation) {
    return StaticSolver(problem.body, degree, choice, formulation, largest_direct_coarse_system,
                        problem.load_case.foundation)
        .solve(problem.load_case);
}

struct RepeatedLoads::Impl {
    /// Data of iterations on two levels.
    struct Levels {
        Levels(const core::Body &body, const ElasticSystem &fine, const std::optional<core::Foundation> &foundation)
            : coarse(assemble(body, 1, NodeOrder::of_mesh, foundation)), coarse_solver(coarse, SolverChoice::automatic),
              rounded_fine(rounded(fine.stiffness)),
              solver(fine.stiffness, two_level(prolongation(coarse, fine), rounded_fine, coarse_solver.inverse())) {}

        ElasticSystem coarse;
        ChosenSolver coarse_solver;
        SymmetricBlocks<float> rounded_fine;
        IterativeSolver solver;
    };

    core::TetraMesh mesh;
    ElasticSystem system; ///< without its matrix where there is a factor
    std::optional<ConstrainedSolver> factor;
    std::optional<Levels> levels;

    /// Responses of the places that were asked for last: the forces of a needle change more often than its line.
    struct Places {
        std::vector<core::InteriorPlace> places;
        Eigen::SparseMatrix<double, Eigen::RowMajor> weights; ///< (K, n)
    };
    std::optional<Places> last_places;

    const Eigen::SparseMatrix<double, Eigen::RowMajor> &weights_of(const std::vector<core::InteriorPlace> &places) {
        const auto are_equal = [](const core::InteriorPlace &a, const core::InteriorPlace &b) {
            return a.middle == b.middle && a.radius == b.radius;
        };
        if (!last_places || !std::ranges::equal(last_places->places, places, are_equal))
            last_places = Places{places, place_weights(places, system, mesh)};
        return last_places->weights;
    }
};

RepeatedLoads::RepeatedLoads(const core::Body &body, const core::LoadCase &constrained,
                             const std::function<void(const std::string &)> &report, int largest)
    : impl_(std::make_unique<Impl>()) {
    check_facets(constrained, body.mesh);
    report(fmt::format("Quadratic elements are being assembled: {} tetrahedra.", body.mesh.num_tetrahedra()));
    auto &[mesh, system, factor, levels, last_places] = *impl_;
    mesh = body.mesh;
    system = assemble(body, 2, NodeOrder::by_distance, constrained.foundation);
    const auto prescribed = dof_conditions(constrained, system).prescribed;
    const auto num_unknowns = prescribed.size();
    if (num_unknowns <= static_cast<std::size_t>(largest)) {
        report(fmt::format("Their stiffness is being factorised, once for all solutions: {} unknowns.", num_unknowns));
        factor.emplace(compressed_rows(system.stiffness));
        system.stiffness = {}; // the solver has its own
        factor->factorise(prescribed);
    } else {
        report(fmt::format("Two levels of elements are being prepared, once for all solutions: {} unknowns.",
                           num_unknowns));
        levels.emplace(body, system, constrained.foundation);
        levels->solver.set_up(prescribed);
    }
}

RepeatedLoads::~RepeatedLoads() = default;

RepeatedLoads::Solution RepeatedLoads::solve(const core::LoadCase &load_case, std::vector<double> &last,
                                             const InnerForces &inner) {
    auto &[mesh, system, factor, levels, last_places] = *impl_;
    auto conditions = dof_conditions(load_case, system);
    const auto &weights = impl_->weights_of(inner.places);
    add_forces(weights, inner.forces, conditions.load);
    auto found = factor ? factor->solve(conditions.prescribed, conditions.load)
                        : levels->solver.solve(conditions.prescribed, conditions.load, {last, tolerance});
    Solution solution{.is_unique = found.unique,
                      .has_converged = found.unique && found.converged,
                      .iterations = found.iterations,
                      .displacement = {},
                      .at_places = {}};
    if (!found.unique)
        return solution;
    solution.displacement = system.at_mesh_nodes(found.displacement);
    solution.work = std::inner_product(conditions.load.begin(), conditions.load.end(), found.displacement.begin(), 0.0);
    solution.at_places = means_at(weights, found.displacement);
    last.clear();
    if (solution.has_converged)
        last = std::move(found.displacement);
    return solution;
}

} // namespace livermark::fem_reference
