#pragma once

#include <optional>
#include <vector>

#include "fem_reference/hyperelastic/paths/load_path.hpp"
#include "fem_reference/hyperelastic/paths/path_system.hpp"

namespace livermark::hyperelastic {

/// A state and what it is held in by.
struct LoadedState {
    State state;
    double factor = 0.0; ///< of loads: the fraction of the path, or newtons where places press
};

/// Looks for the next equilibrium on a load path by Newton's method, see follow().
class EquilibriumSearch {
  public:
    /// All are kept alive by the caller; the result takes steps, factorisations and the linear solution.
    EquilibriumSearch(PathSystem &system, int num_constraints, const LoadPath &path, FollowedPath &result);

    /// Factorises the tangent at rest.
    /// @return false if the body is free to move
    bool begin();
    /// One load step.
    /// @param at  where loads are from; changed if it converges
    bool advance(LoadedState &at, double from, double to, LoadStep &step);
    /// Equilibrium at the same loads, after something else has changed.
    /// @param at  changed if it converges
    bool settle(LoadedState &at, LoadStep &step);
    /// The next solve gets a new factor.
    void distrust_factor() { needs_factor_ = true; }
    PathPoint point(const LoadedState &at, double fraction) const;

  private:
    /// What is out of balance at a state.
    struct Balance {
        double smallest_jacobian; ///< if not positive, nothing else is set
        double energy = 0.0;
        State residual{};  ///< internal minus external forces [N], at what is not free the reactions; and volumes [m^3]
        double size = 0.0; ///< of what is free, over the reactions and loads
    };
    /// What one newton of the places that press does.
    struct UnitPress {
        State change;
        double depth = 0.0;
    };

    bool presses() const { return conditions_.press_depth != 0.0; }
    Balance balance(const LoadedState &at) const;
    double dot(const State &a, const State &b) const;
    double depth_of(const State &state) const;
    bool factorise();
    std::optional<TangentSolver::Correction> solve(const State &right, double tolerance, LoadStep &step);
    bool press(double tolerance, LoadStep &step);
    std::optional<LoadedState> predicted(const LoadedState &at, double to, LoadStep &step);
    std::optional<LoadedState> predicted_by_press(const LoadedState &at, double to, LoadStep &step);
    bool correct(LoadedState &at, Balance &now, LoadStep &step);
    LoadedState moved(const LoadedState &at, const State &change, double newtons, double part) const;
    bool shorten(const State &change, double newtons, LoadedState &at, Balance &now) const;
    bool balance_along(const State &change, LoadedState &at, Balance &now);
    bool converge(LoadedState &there, LoadStep &step);

    PathSystem &system_;
    const fem_reference::DofConditions &conditions_;
    const LoadPath &path_;
    FollowedPath &result_;
    int num_constraints_;
    std::vector<bool> is_free_;
    UnitPress unit_press_;
    bool needs_factor_ = true;
    double iterations_when_new_ = 0.0; ///< of levels, for each e-fold of the residual
    /// What the last digits of positions make of forces [N]: of a shear modulus on the square of the extent. Where a
    /// body moves as a rigid one there is nothing else.
    double rounding_force_;
};

} // namespace livermark::hyperelastic
