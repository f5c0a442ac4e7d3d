#include "fem_reference/hyperelastic/equilibrium_search.hpp"

#include <deal.II/lac/precondition.h>
#include <deal.II/lac/solver_control.h>
#include <deal.II/lac/solver_gmres.h>
#include <deal.II/lac/vector.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "fem_reference/linear/chosen_solver.hpp"
#include "fem_reference/solvers/constrained_solver.hpp"
#include "fem_reference/solvers/matrices.hpp"
#include "fem_reference/solvers/two_level.hpp"

namespace livermark::hyperelastic {

namespace {

using Vector = dealii::Vector<double>; // displacements, then pressures over their scale

} // namespace

struct TangentSolver::Impl {
    /// Linear elements on the same tetrahedra below the quadratic ones.
    struct Levels {
        explicit Levels(const Elements &elements)
            : linear(fem_reference::assemble(fem_reference::without_pressure(elements.body()), 1)),
              from_linear(fem_reference::prolongation(linear, elements.system())) {}

        bool set_up(const fem_reference::SymmetricBlocks<double> &stiffness, const std::vector<bool> &is_free) {
            inverse.reset();
            rounded = fem_reference::rounded(stiffness);
            linear.stiffness = fem_reference::galerkin(from_linear, stiffness, linear.stiffness.rows);
            coarse.emplace(linear, fem_reference::SolverChoice::automatic);
            inverse = fem_reference::two_level(from_linear, rounded, coarse->inverse());
            return inverse->set_up({.sets = {is_free}, .set = {0}});
        }

        fem_reference::ElasticSystem linear; ///< its stiffness is P^T K P
        fem_reference::Prolongation from_linear;
        fem_reference::SymmetricBlocks<float> rounded;
        std::optional<fem_reference::ChosenSolver> coarse;
        std::unique_ptr<fem_reference::Preconditioner> inverse;
    };

    Impl(const Elements &of, std::vector<bool> free)
        : elements(of), is_free(std::move(free)), scale(fem_reference::pressure_scale(of.body())) {
        if (elements.num_pressures() > 0) {
            norm.emplace(elements.pressure().norm);
            const std::vector<double> nothing_prescribed(elements.num_pressures(),
                                                         std::numeric_limits<double>::quiet_NaN());
            norm->factorise(nothing_prescribed);
            levels.emplace(elements);
        } else {
            factor.emplace(elements.system().stiffness.rows, is_free);
        }
    }

    std::span<double> displacements(Vector &x) const { return std::span(x.begin(), is_free.size()); }
    std::span<const double> displacements(const Vector &x) const { return std::span(x.begin(), is_free.size()); }
    std::span<double> pressures(Vector &x) const { return std::span(x.begin(), x.size()).subspan(is_free.size()); }
    std::span<const double> pressures(const Vector &x) const {
        return std::span(x.begin(), x.size()).subspan(is_free.size());
    }
    /// out = an approximate K^-1 times a force
    void apply_inverse(std::span<const double> force, std::span<double> out) const {
        if (levels) {
            std::vector<float> residual(force.begin(), force.end()), correction(force.size());
            fem_reference::clear_constrained(std::span(residual), is_free);
            levels->inverse->apply(residual, correction);
            std::ranges::copy(correction, out.begin());
            return;
        }
        factor->solve(force, out);
    }

    const Elements &elements;
    std::vector<bool> is_free;
    double scale;
    std::optional<fem_reference::BlockFactor> factor; ///< in displacements alone
    mutable std::optional<fem_reference::ConstrainedSolver> norm;
    mutable std::optional<Levels> levels; ///< with a pressure
};

TangentSolver::TangentSolver(const Elements &elements, std::vector<bool> is_free)
    : impl_(std::make_unique<Impl>(elements, std::move(is_free))) {}
TangentSolver::~TangentSolver() = default;

double TangentSolver::pressure_scale() const {
    return impl_->scale;
}

bool TangentSolver::is_direct() const {
    return !impl_->levels;
}

bool TangentSolver::factorise(const fem_reference::SymmetricBlocks<double> &stiffness) {
    return impl_->levels ? impl_->levels->set_up(stiffness, impl_->is_free) : impl_->factor->factorise(stiffness);
}

TangentSolver::Correction TangentSolver::solve(const TangentMatrices &tangent, const SurfaceStiffness &surface,
                                               const State &right, double tolerance) const {
    const auto &impl = *impl_;
    const auto num_displacements = impl.is_free.size();
    const auto num_pressures = static_cast<std::size_t>(impl.elements.num_pressures());
    std::vector<double> scaled(num_pressures), volumes(num_pressures);
    const fem_reference::Operator matrix{[&](Vector &out, const Vector &x) {
        const auto u = impl.displacements(x);
        const auto force = impl.displacements(out);
        tangent.stiffness.multiply(u, force);
        surface.add_product(u, force);
        if (num_pressures > 0) {
            for (std::size_t k = 0; k < num_pressures; ++k)
                scaled[k] = impl.scale * impl.pressures(x)[k];
            fem_reference::multiply(impl.elements.compliance(), scaled, volumes);
            tangent.divergence.add_products(u, scaled, force, volumes, 1);
            for (std::size_t k = 0; k < num_pressures; ++k)
                impl.pressures(out)[k] = impl.scale * volumes[k];
        }
        fem_reference::clear_constrained(force, impl.is_free);
    }};
    const fem_reference::Operator preconditioner{[&](Vector &out, const Vector &x) {
        impl.apply_inverse(impl.displacements(x), impl.displacements(out));
        if (num_pressures > 0) {
            for (std::size_t k = 0; k < num_pressures; ++k)
                scaled[k] = impl.pressures(x)[k] / impl.scale;
            tangent.divergence.subtract_product(impl.displacements(std::as_const(out)), scaled, volumes, 1);
            impl.norm->solve_constrained(volumes, impl.pressures(out));
            for (double &pressure : impl.pressures(out))
                pressure /= impl.scale;
        }
    }};

    Vector load(num_displacements + num_pressures), x(num_displacements + num_pressures);
    std::ranges::copy(right.displacement, load.begin());
    fem_reference::clear_constrained(impl.displacements(load), impl.is_free);
    for (std::size_t k = 0; k < num_pressures; ++k)
        impl.pressures(load)[k] = impl.scale * right.pressure[k];

    Correction result;
    dealii::ReductionControl control(max_iterations, std::numeric_limits<double>::min(), tolerance);
    constexpr unsigned int most_vectors = 70;
    dealii::SolverGMRES<Vector> gmres(control, dealii::SolverGMRES<Vector>::AdditionalData(most_vectors));
    try {
        gmres.solve(matrix, x, load, preconditioner);
        result.converged = true;
    } catch (const dealii::SolverControl::NoConvergence &) {
        result.converged = false;
    }
    result.iterations = static_cast<int>(control.last_step());
    result.change.displacement.assign(x.begin(), x.begin() + num_displacements);
    for (const double pressure : impl.pressures(std::as_const(x)))
        result.change.pressure.push_back(impl.scale * pressure);
    return result;
}

double volume_of(const core::TetraMesh &mesh) {
    const auto volumes = core::tetrahedron_volumes(mesh);
    return std::accumulate(volumes.begin(), volumes.end(), 0.0);
}

PathSystem::PathSystem(const Elements &elements, const fem_reference::DofConditions &conditions,
                       std::span<const double> pressure, TouchingBall *ball)
    : elements_(elements), conditions_(conditions), follower_(elements.system(), elements.body().mesh, pressure),
      ball_(ball), tangent_(elements.zero_tangent()) {
    if (ball_)
        expected_pressure_.assign(ball_->num_points(), 0.0);
}

std::vector<double> PathSystem::loads(const State &state, double fraction) const {
    auto load = conditions_.load;
    for (double &value : load)
        value *= fraction;
    follower_.add_forces(fraction, state.displacement, load);
    if (ball_)
        ball_->add_forces(ball_->tool().centre_at(fraction), state.displacement, load);
    return load;
}

void PathSystem::assemble(const State &state, double fraction) {
    elements_.assemble_tangent(state, tangent_);
    surface_stiffness_ = follower_.load_stiffness(fraction, state.displacement);
    if (ball_)
        ball_->add_stiffness(ball_->tool().centre_at(fraction), state.displacement, surface_stiffness_,
                             expected_pressure_);
    surface_stiffness_.add_to(tangent_.stiffness);
}

void PathSystem::expect(const State &state, double fraction) {
    if (ball_)
        expected_pressure_ = ball_->expected_pressure(ball_->tool().centre_at(fraction), state.displacement);
}

void PathSystem::expect(const State &state, double fraction, const State &change, double part) {
    if (!ball_)
        return;
    const auto expected =
        ball_->expected_pressure(ball_->tool().centre_at(fraction), state.displacement, change.displacement);
    for (std::size_t point = 0; point < expected.size(); ++point)
        expected_pressure_[point] += part * (expected[point] - expected_pressure_[point]);
}

bool PathSystem::factorise_at_rest() {
    auto at_rest = elements_.zero_tangent();
    elements_.assemble_tangent(rest(), at_rest);
    return set_up(at_rest.stiffness);
}

State PathSystem::product(const std::vector<double> &u) const {
    State result{std::vector<double>(u.size()), std::vector<double>(elements_.num_pressures(), 0.0)};
    tangent_.stiffness.multiply(u, result.displacement);
    surface_stiffness_.add_product(u, result.displacement);
    if (!result.pressure.empty()) {
        const std::vector<double> nothing(result.pressure.size(), 0.0);
        tangent_.divergence.subtract_product(u, nothing, result.pressure, 1);
    }
    return result;
}

OneProcessSystem::OneProcessSystem(const Elements &elements, const fem_reference::DofConditions &conditions,
                                   std::span<const double> pressure, TouchingBall *ball)
    : PathSystem(elements, conditions, pressure, ball),
      solver_(elements, fem_reference::free_of(conditions.prescribed)),
      counted_displacements_(elements.num_displacements(), true), counted_pressures_(elements.num_pressures(), true) {}

namespace {

/// After so many linear iterations a new factor is worth its time.
constexpr int refactor_after = 20;
/// After so many times the iterations with new levels others are worth theirs.
constexpr double renew_levels_after = 1.3;
/// Part that linear solves may leave of a residual far from equilibrium (inexact Newton; Dembo, Eisenstat, Steihaug
/// 1982).
constexpr double largest_tolerance = 1e-3;
/// The response to one newton is worth another solve as long as more than this is out of balance.
constexpr double renew_press_above = 1e-3;

void negate(State &state) {
    for (auto *const part : {&state.displacement, &state.pressure})
        for (double &value : *part)
            value = -value;
}

void add(const State &change, double part, State &state) {
    for (std::size_t dof = 0; dof < state.displacement.size(); ++dof)
        state.displacement[dof] += part * change.displacement[dof];
    for (std::size_t k = 0; k < state.pressure.size(); ++k)
        state.pressure[k] += part * change.pressure[k];
}

} // namespace

EquilibriumSearch::EquilibriumSearch(PathSystem &system, int num_constraints, const LoadPath &path,
                                     FollowedPath &result)
    : system_(system), conditions_(system.conditions()), path_(path), result_(result),
      num_constraints_(num_constraints), is_free_(fem_reference::free_of(conditions_.prescribed)),
      rounding_force_(100.0 * std::numeric_limits<double>::epsilon() * system.pressure_scale() * system.volume()) {
    const auto named = [&](int constraint) { return constraint < num_constraints_; };
    const auto *ball = system.ball();
    if (!std::ranges::all_of(conditions_.constraint, named) || (ball && !named(ball->tool().constraint)))
        throw std::invalid_argument("a force belongs to a constraint beyond the " + std::to_string(num_constraints_) +
                                    " that are asked for");
}

bool EquilibriumSearch::begin() {
    system_.assemble(system_.rest(), 0.0);
    return factorise();
}

double EquilibriumSearch::dot(const State &a, const State &b) const {
    const auto counted = [](const std::vector<bool> &counts, const std::vector<double> &x,
                            const std::vector<double> &y) {
        double sum = 0.0;
        for (std::size_t i = 0; i < counts.size(); ++i)
            sum += counts[i] ? x[i] * y[i] : 0.0;
        return sum;
    };
    return system_.sum(counted(system_.counted_displacements(), a.displacement, b.displacement) +
                       counted(system_.counted_pressures(), a.pressure, b.pressure));
}

/// Along the tractions of the places that press, in the mean weighted with them [m].
double EquilibriumSearch::depth_of(const State &state) const {
    const auto &counts = system_.counted_displacements();
    double sum = 0.0;
    for (std::size_t dof = 0; dof < counts.size(); ++dof)
        sum += counts[dof] ? conditions_.load[dof] * state.displacement[dof] : 0.0;
    return system_.sum(sum);
}

EquilibriumSearch::Balance EquilibriumSearch::balance(const LoadedState &at) const {
    auto internal = system_.internal_forces(at.state);
    Balance now{.smallest_jacobian = internal.smallest_jacobian};
    if (!(now.smallest_jacobian > 0.0))
        return now;
    now.energy = internal.energy;
    const auto load = system_.loads(at.state, at.factor);
    now.residual = {std::move(internal.force), std::move(internal.imbalance)};
    const double rounding = rounding_force_ / path_.tolerance;
    double out_of_balance = 0.0, scale = 0.0;
    for (std::size_t dof = 0; dof < load.size(); ++dof) {
        double &residual = now.residual.displacement[dof];
        residual -= load[dof];
        if (!system_.counted_displacements()[dof])
            continue;
        (is_free_[dof] ? out_of_balance : scale) += residual * residual;
        scale += load[dof] * load[dof];
    }
    const double pressure_scale = system_.pressure_scale();
    for (std::size_t k = 0; k < now.residual.pressure.size(); ++k)
        if (const double volume = pressure_scale * now.residual.pressure[k]; system_.counted_pressures()[k])
            out_of_balance += volume * volume;
    out_of_balance = system_.sum(out_of_balance);
    scale = system_.sum(scale) + rounding * rounding;
    now.size = out_of_balance > 0.0 ? std::sqrt(out_of_balance / scale) : 0.0;
    return now;
}

/// A tangent that is not positive definite cannot be factored: then the one at rest is, and iterations are with it.
bool EquilibriumSearch::factorise() {
    ++result_.factorisations;
    needs_factor_ = false;
    return system_.factorise() || system_.factorise_at_rest();
}

std::optional<TangentSolver::Correction> EquilibriumSearch::solve(const State &right, double tolerance,
                                                                  LoadStep &step) {
    needs_factor_ = needs_factor_ || system_.ball(); // what touches changes, and is stiff
    bool has_old_factor = !needs_factor_;
    if (needs_factor_ && !factorise())
        return std::nullopt;
    auto correction = system_.solve(right, tolerance);
    if (!correction.converged && has_old_factor) {
        if (!factorise())
            return std::nullopt;
        has_old_factor = false;
        correction = system_.solve(right, tolerance);
    }
    step.linear_iterations.push_back(correction.iterations);
    if (system_.is_direct()) {
        needs_factor_ = correction.iterations > refactor_after;
    } else {
        // By what an iteration gains, because tolerances differ.
        const double each = static_cast<double>(correction.iterations) / -std::log(tolerance);
        if (!has_old_factor)
            iterations_when_new_ = each;
        needs_factor_ = each > renew_levels_after * iterations_when_new_;
    }
    if (!correction.converged)
        return std::nullopt;
    return correction;
}

/// Finds what one newton does with the tangent.
bool EquilibriumSearch::press(double tolerance, LoadStep &step) {
    State one_newton = system_.rest();
    std::ranges::fill(one_newton.pressure, 0.0);
    one_newton.displacement = conditions_.load;
    auto found = solve(one_newton, tolerance, step);
    if (!found)
        return false;
    unit_press_.change = std::move(found->change);
    unit_press_.depth = depth_of(unit_press_.change);
    return unit_press_.depth != 0.0;
}

/// Goes along the correction of Newton's method.
/// @return false if there is none, or no way along it
bool EquilibriumSearch::correct(LoadedState &at, Balance &now, LoadStep &step) {
    system_.assemble(at.state, at.factor);
    State right = now.residual;
    negate(right);
    // The next residual anyway, by quadratic convergence.
    const double tolerance = std::clamp(0.1 * now.size, TangentSolver::smallest_tolerance, largest_tolerance);
    double newtons = 0.0;
    if (presses()) {
        if (now.size > renew_press_above && !press(tolerance, step))
            return false;
        // By symmetry what one newton does tells what the solution will do there, before it is known.
        newtons = -dot(unit_press_.change, right) / unit_press_.depth;
        for (std::size_t dof = 0; dof < conditions_.load.size(); ++dof)
            right.displacement[dof] += newtons * conditions_.load[dof];
    }
    auto correction = solve(right, tolerance, step);
    if (!correction)
        return false;
    auto &change = correction->change;
    if (presses()) { // the little that is left
        const double more = -depth_of(change) / unit_press_.depth;
        add(unit_press_.change, more, change);
        newtons += more;
    }
    return system_.ball() ? balance_along(change, at, now) : shorten(change, newtons, at, now);
}

LoadedState EquilibriumSearch::moved(const LoadedState &at, const State &change, double newtons, double part) const {
    LoadedState there = at;
    add(change, part, there.state);
    there.factor += part * newtons;
    return there;
}

/// Takes halves of the correction until the residual, or its component along it, is less.
bool EquilibriumSearch::shorten(const State &change, double newtons, LoadedState &at, Balance &now) const {
    // At what is not free the change is zero, so that reactions do no work.
    const auto along = [&](const Balance &there) { return std::abs(dot(there.residual, change)); };
    const double first_along = along(now);
    constexpr double shortest = 1.0 / 32.0;
    for (double part = 1.0; part >= shortest; part *= 0.5) {
        auto there = moved(at, change, newtons, part);
        auto then = balance(there);
        const bool is_better =
            then.smallest_jacobian > 0.0 && (then.size < now.size || along(then) < 0.5 * first_along);
        if (is_better) {
            at = std::move(there);
            now = std::move(then);
            return true;
        }
    }
    return false;
}

/// Takes the part of the correction beyond which the residual would act against it, or all of it. Where a ball touches,
/// the norm of the residual is not a measure of progress: it is that of a stiff penalty, and points that begin to touch
/// or to slip make it leap.
bool EquilibriumSearch::balance_along(const State &change, LoadedState &at, Balance &now) {
    constexpr int max_tries = 7;
    constexpr double enough = 0.5; // of the first component along the correction
    const double first = dot(now.residual, change);
    double lower = 0.0, at_lower = first, upper = 1.0, at_upper = 0.0;
    bool is_bracketed = false;
    double part = 1.0;
    for (int time = 1; time <= max_tries; ++time) {
        auto there = moved(at, change, 0.0, part);
        auto then = balance(there);
        const bool is_valid = then.smallest_jacobian > 0.0;
        const double along = is_valid ? dot(then.residual, change) : 0.0;
        const bool goes_on = is_valid && along * first > 0.0;
        const bool is_taken =
            is_valid && (std::abs(along) < enough * std::abs(first) || (goes_on && part == 1.0) || time == max_tries);
        if (is_taken) {
            system_.expect(at.state, at.factor, change, part);
            at = std::move(there);
            now = std::move(then);
            return true;
        }
        if (goes_on) {
            lower = part;
            at_lower = along;
        } else {
            upper = part;
            at_upper = along;
            is_bracketed = is_valid;
        }
        constexpr double least = 0.1;
        const double secant = is_bracketed ? at_lower / (at_lower - at_upper) : 0.5;
        part = lower + (upper - lower) * std::clamp(secant, least, 1.0 - least);
    }
    return false;
}

/// Tolerance of the first solve, whose solution is the linear one.
double EquilibriumSearch::first_tolerance() const {
    return std::max(0.1 * path_.tolerance, TangentSolver::smallest_tolerance);
}

/// Displacements to which the tangent leads for what is prescribed and the loads to grow.
std::optional<LoadedState> EquilibriumSearch::predicted(const LoadedState &at, double to, LoadStep &step) {
    system_.expect(at.state, at.factor);
    system_.assemble(at.state, to);
    State increment{std::vector<double>(is_free_.size(), 0.0), {}};
    for (std::size_t dof = 0; dof < is_free_.size(); ++dof)
        if (!is_free_[dof])
            increment.displacement[dof] = to * conditions_.prescribed[dof] - at.state.displacement[dof];
    const auto now = balance({at.state, to});
    auto right = system_.product(increment.displacement);
    for (std::size_t dof = 0; dof < is_free_.size(); ++dof)
        right.displacement[dof] = -right.displacement[dof] - now.residual.displacement[dof];
    for (std::size_t k = 0; k < right.pressure.size(); ++k)
        right.pressure[k] = -right.pressure[k] - now.residual.pressure[k];
    // The first one is the linearised solution of the whole load.
    const auto predictor = solve(right, result_.linearised.empty() ? first_tolerance() : largest_tolerance, step);
    if (!predictor)
        return std::nullopt;
    system_.expect(at.state, to, predictor->change, 1.0);
    LoadedState there{at.state, to};
    for (std::size_t dof = 0; dof < is_free_.size(); ++dof)
        there.state.displacement[dof] = is_free_[dof]
                                            ? there.state.displacement[dof] + predictor->change.displacement[dof]
                                            : to * conditions_.prescribed[dof];
    for (std::size_t k = 0; k < there.state.pressure.size(); ++k)
        there.state.pressure[k] += predictor->change.pressure[k];
    return there;
}

/// The same for a depth to grow.
std::optional<LoadedState> EquilibriumSearch::predicted_by_press(const LoadedState &at, double to, LoadStep &step) {
    system_.assemble(at.state, at.factor);
    if (!press(result_.linearised.empty() ? first_tolerance() : largest_tolerance, step))
        return std::nullopt;
    const double newtons = (to * conditions_.press_depth - depth_of(at.state)) / unit_press_.depth;
    LoadedState there = at;
    add(unit_press_.change, newtons, there.state);
    there.factor += newtons;
    return there;
}

bool EquilibriumSearch::advance(LoadedState &at, double from, double to, LoadStep &step) {
    if (path_.observe)
        path_.observe(step);
    auto there = presses() ? predicted_by_press(at, to, step) : predicted(at, to, step);
    if (!there)
        return false;
    if (result_.linearised.empty()) {
        result_.linearised = there->state.displacement; // from rest
        for (double &value : result_.linearised)
            value /= to - from;
    }
    if (!converge(*there, step))
        return false;
    at = std::move(*there);
    return true;
}

bool EquilibriumSearch::settle(LoadedState &at, LoadStep &step) {
    auto there = at;
    if (!converge(there, step))
        return false;
    at = std::move(there);
    return true;
}

void EquilibriumSearch::note(double residual, LoadStep &step) const {
    step.residuals.push_back(residual);
    if (path_.observe)
        path_.observe(step);
}

/// Corrects until what is out of balance is little enough.
bool EquilibriumSearch::converge(LoadedState &there, LoadStep &step) {
    auto now = balance(there);
    if (!(now.smallest_jacobian > 0.0))
        return false;
    note(now.size, step);
    const int max_iterations = system_.ball() ? path_.max_touching_iterations : path_.max_iterations;
    while (now.size > path_.tolerance) {
        if (static_cast<int>(step.residuals.size()) > max_iterations || !correct(there, now, step))
            return false;
        note(now.size, step);
    }
    step.converged = true;
    return true;
}

PathPoint EquilibriumSearch::point(const LoadedState &at, double fraction) const {
    const auto now = balance(at);
    PathPoint point{.fraction = fraction,
                    .press = presses() ? at.factor : 0.0,
                    .state = at.state,
                    .reaction = std::vector<core::Vector3>(num_constraints_, core::Vector3::Zero()),
                    .strain_energy = now.energy,
                    .smallest_jacobian = now.smallest_jacobian};
    for (std::size_t dof = 0; dof < is_free_.size(); ++dof)
        if (const int owner = conditions_.constraint[dof]; owner >= 0 && system_.counted_displacements()[dof])
            point.reaction[owner][static_cast<int>(dof % 3)] += now.residual.displacement[dof];
    if (const auto *ball = system_.ball()) {
        point.touch = ball->sums(ball->tool().centre_at(at.factor), at.state.displacement);
        point.reaction[ball->tool().constraint] += point.touch.force;
        if (ball->tool().between)
            point.reaction[ball->tool().constraint + 1] += point.touch.other_force;
    }
    for (auto &reaction : point.reaction)
        for (double &component : reaction)
            component = system_.sum(component);
    return point;
}

} // namespace livermark::hyperelastic
