#include "fem_reference/hyperelastic/load_path.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <optional>
#include <utility>

#include "fem_reference/hyperelastic/one_process_system.hpp"

namespace livermark::hyperelastic {

namespace {

using Clock = std::chrono::steady_clock;
/// After so many linear iterations a new factor is worth its time.
constexpr int refactor_after = 20;
/// After so many times the iterations with new levels others are worth theirs.
constexpr double renew_levels_after = 1.3;
/// What linear solves may leave of a residual far from equilibrium (inexact Newton; Dembo, Eisenstat, Steihaug 1982).
constexpr double largest_tolerance = 1e-3;

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

/// What is out of balance at a state.
struct Balance {
    double smallest_jacobian; ///< if not positive, nothing else is set
    double energy = 0.0;
    State residual{};  ///< internal minus external forces [N], at what is not free the reactions; and volumes [m^3]
    double size = 0.0; ///< of what is free, over the reactions and loads
};

class Follower {
  public:
    Follower(PathSystem &system, int num_constraints, const LoadPath &path)
        : system_(system), conditions_(system.conditions()), path_(path), num_constraints_(num_constraints),
          is_free_(free_of(conditions_.prescribed)),
          rounding_force_(100.0 * std::numeric_limits<double>::epsilon() * system.pressure_scale() * system.volume()) {}

    FollowedPath run();

  private:
    Balance balance(const State &state, double fraction) const;
    double dot(const State &a, const State &b) const;
    bool factorise();
    std::optional<TangentSolver::Correction> solve(const State &right, double tolerance, LoadStep &step);
    bool advance(State &state, double from, double to, LoadStep &step);
    bool correct(State &state, Balance &now, double fraction, LoadStep &step);
    PathPoint point(const State &state, double fraction) const;

    PathSystem &system_;
    const fem_reference::DofConditions &conditions_;
    const LoadPath &path_;
    int num_constraints_;
    std::vector<bool> is_free_;
    bool needs_factor_ = true;
    double iterations_when_new_ = 0.0; ///< of levels, for each e-fold of the residual
    /// What the last digits of positions make of forces [N]: of a shear modulus on the square of the extent. Where a
    /// body moves as a rigid one there is nothing else.
    double rounding_force_;
    FollowedPath result_;
};

double Follower::dot(const State &a, const State &b) const {
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

Balance Follower::balance(const State &state, double fraction) const {
    auto internal = system_.internal_forces(state);
    Balance now{.smallest_jacobian = internal.smallest_jacobian};
    if (!(now.smallest_jacobian > 0.0))
        return now;
    now.energy = internal.energy;
    const auto load = system_.loads(state, fraction);
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
bool Follower::factorise() {
    ++result_.factorisations;
    needs_factor_ = false;
    return system_.factorise() || system_.factorise_at_rest();
}

std::optional<TangentSolver::Correction> Follower::solve(const State &right, double tolerance, LoadStep &step) {
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

/// Goes along the correction of Newton's method.
/// @return false if there is none, or no way along it
bool Follower::correct(State &state, Balance &now, double fraction, LoadStep &step) {
    system_.assemble(state, fraction);
    State right = now.residual;
    for (auto *const part : {&right.displacement, &right.pressure})
        for (double &value : *part)
            value = -value;
    // What the next residual will be anyway, by quadratic convergence.
    const double tolerance = std::clamp(0.1 * now.size, TangentSolver::smallest_tolerance, largest_tolerance);
    const auto correction = solve(right, tolerance, step);
    if (!correction)
        return false;
    const auto &change = correction->change;
    // At what is not free the change is zero, so that reactions do no work.
    const auto along = [&](const Balance &there) { return std::abs(dot(there.residual, change)); };
    const double first_along = along(now);
    constexpr double shortest = 1.0 / 32.0;
    for (double part = 1.0; part >= shortest; part *= 0.5) {
        State there = state;
        for (std::size_t dof = 0; dof < change.displacement.size(); ++dof)
            there.displacement[dof] += part * change.displacement[dof];
        for (std::size_t k = 0; k < change.pressure.size(); ++k)
            there.pressure[k] += part * change.pressure[k];
        auto then = balance(there, fraction);
        const bool is_better =
            then.smallest_jacobian > 0.0 && (then.size < now.size || along(then) < 0.5 * first_along);
        if (is_better) {
            state = std::move(there);
            now = std::move(then);
            return true;
        }
    }
    return false;
}

/// One load step.
/// @param state  where loads are from; changed if it converges
bool Follower::advance(State &state, double from, double to, LoadStep &step) {
    system_.assemble(state, to);
    State increment{std::vector<double>(is_free_.size(), 0.0), {}};
    for (std::size_t dof = 0; dof < is_free_.size(); ++dof)
        if (!is_free_[dof])
            increment.displacement[dof] = to * conditions_.prescribed[dof] - state.displacement[dof];
    auto now = balance(state, to);
    auto right = system_.product(increment.displacement);
    for (std::size_t dof = 0; dof < is_free_.size(); ++dof)
        right.displacement[dof] = -right.displacement[dof] - now.residual.displacement[dof];
    for (std::size_t k = 0; k < right.pressure.size(); ++k)
        right.pressure[k] = -right.pressure[k] - now.residual.pressure[k];
    // The first one is the linearised solution of the whole load.
    const bool is_first = result_.linearised.empty();
    const auto predictor = solve(right, is_first ? TangentSolver::smallest_tolerance : largest_tolerance, step);
    if (!predictor)
        return false;
    State there = state;
    for (std::size_t dof = 0; dof < is_free_.size(); ++dof)
        there.displacement[dof] = is_free_[dof] ? there.displacement[dof] + predictor->change.displacement[dof]
                                                : to * conditions_.prescribed[dof];
    for (std::size_t k = 0; k < there.pressure.size(); ++k)
        there.pressure[k] += predictor->change.pressure[k];
    if (is_first) {
        result_.linearised = there.displacement; // from rest
        for (double &value : result_.linearised)
            value /= to - from;
    }
    now = balance(there, to);
    if (!(now.smallest_jacobian > 0.0))
        return false;
    step.residuals.push_back(now.size);
    while (now.size > path_.tolerance) {
        if (static_cast<int>(step.residuals.size()) > path_.max_iterations || !correct(there, now, to, step))
            return false;
        step.residuals.push_back(now.size);
    }
    step.converged = true;
    state = std::move(there);
    return true;
}

PathPoint Follower::point(const State &state, double fraction) const {
    const auto now = balance(state, fraction);
    PathPoint point{.fraction = fraction,
                    .state = state,
                    .reaction = std::vector<core::Vector3>(num_constraints_, core::Vector3::Zero()),
                    .strain_energy = now.energy,
                    .smallest_jacobian = now.smallest_jacobian};
    for (std::size_t dof = 0; dof < is_free_.size(); ++dof)
        if (const int owner = conditions_.constraint[dof]; owner >= 0 && system_.counted_displacements()[dof])
            point.reaction[owner][static_cast<int>(dof % 3)] += now.residual.displacement[dof];
    for (auto &reaction : point.reaction)
        for (double &component : reaction)
            component = system_.sum(component);
    return point;
}

FollowedPath Follower::run() {
    auto start = Clock::now();
    auto state = system_.rest();
    system_.assemble(state, 0.0);
    const bool is_constrained = factorise();
    result_.setup_seconds = seconds_since(start);
    start = Clock::now();
    double reached = 0.0;
    if (!is_constrained) {
        result_.status = core::SolutionStatus::not_converged;
        result_.message = "the tangent stiffness at rest is singular: the prescribed displacements leave the body, or "
                          "a part of it, free to move as a rigid body; constrain it in all six ways";
        return std::move(result_);
    }
    for (const double fraction : path_.fractions) {
        const double way = fraction - reached;
        double length = way;
        while (reached < fraction) {
            // Not a step that leaves next to nothing for another.
            const double to = reached + 1.001 * length >= fraction ? fraction : reached + length;
            LoadStep step{.fraction = to, .converged = false, .residuals = {}, .linear_iterations = {}};
            const bool done = advance(state, reached, to, step);
            result_.steps.push_back(std::move(step));
            if (done) {
                reached = to;
                constexpr std::size_t few = 6;
                if (result_.steps.back().residuals.size() <= few)
                    length *= 2.0;
            } else {
                length = 0.5 * (to - reached);
                needs_factor_ = true;
            }
            if (length < path_.smallest_step * way) {
                result_.status = core::SolutionStatus::not_converged;
                result_.message = fmt::format(
                    "Newton's method finds no equilibrium beyond {:.1f} % of the load, in steps of {:.2f} % either: "
                    "the "
                    "body may buckle or fold there; take a smaller load, a finer mesh or constrain more of the body",
                    100.0 * reached, 100.0 * length);
                result_.points.push_back(point(state, reached));
                result_.solve_seconds = seconds_since(start);
                return std::move(result_);
            }
        }
        result_.points.push_back(point(state, fraction));
    }
    result_.solve_seconds = seconds_since(start);
    return std::move(result_);
}

} // namespace

FollowedPath follow(PathSystem &system, int num_constraints, const LoadPath &path) {
    return Follower(system, num_constraints, path).run();
}

FollowedPath follow(const Elements &elements, const fem_reference::DofConditions &conditions, int num_constraints,
                    std::span<const double> follower_pressure, const LoadPath &path) {
    OneProcessSystem system(elements, conditions, follower_pressure);
    return follow(system, num_constraints, path);
}

} // namespace livermark::hyperelastic
