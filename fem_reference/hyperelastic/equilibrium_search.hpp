#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "fem_reference/hyperelastic/elements.hpp"
#include "fem_reference/hyperelastic/hyperelasticity.hpp"
#include "fem_reference/hyperelastic/surface.hpp"
#include "fem_reference/linear/conditions.hpp"

namespace livermark::hyperelastic {

/// The linear systems of Newton's method,
///     [K + L, D^T; D, -C] [du; dp] = [f; g]
/// on free displacements and all pressures, with L the stiffness of the surface under follower pressures and contact,
/// which need not be symmetric. Generalised minimal residuals (deal.II) solve them with the true matrix, preconditioned
/// by the lower block triangle of an approximate inverse of a K with the part of L that is put there
/// (SurfaceStiffness), and of the norm of the pressure (fem_reference::PressureSystem) for the Schur complement. The
/// approximate inverse is
/// - in displacements alone a sparse Cholesky factor (CHOLMOD), because what is coarser locks;
/// - with a pressure two levels (fem_reference::two_level()), the linear elements of the same tetrahedra below.
/// It may be that of an earlier state: then there are more iterations, and the solution is the same within the
/// tolerance.
class TangentSolver {
  public:
    /// Remainder of the first residual, as the preconditioner sees it, in the norm of displacements and scaled
    /// pressures: little enough that Newton's method converges as with exact solves.
    static constexpr double smallest_tolerance = 1e-9;
    static constexpr int max_iterations = 200;

    /// @param elements  kept alive by the caller
    /// @param is_free   shape (3 n)
    TangentSolver(const Elements &elements, std::vector<bool> is_free);
    ~TangentSolver();

    /// A pressure in the units of displacement is a pressure over this [Pa/m]: the mean shear modulus over the cube
    /// root of the volume.
    double pressure_scale() const;

    /// Prepares the approximate inverse of K for the solves to come.
    /// @return false if it, or the coarse level, is not positive definite; there is no inverse then
    /// @throws std::runtime_error if CHOLMOD runs out of memory
    bool factorise(const fem_reference::SymmetricBlocks<double> &stiffness);

    /// Result of a solve.
    struct Correction {
        bool converged = false;
        int iterations = 0;
        State change; ///< zero where displacements are not free
    };
    /// Only after a factorise() that returned true.
    /// @param tangent  K with the symmetric part of L, and D
    /// @param surface  L
    /// @param right    f [N], shape (3 n), and g [m^3], shape (m); what is not free does not count
    /// @param tolerance  what may be left of the first residual
    Correction solve(const TangentMatrices &tangent, const SurfaceStiffness &surface, const State &right,
                     double tolerance) const;

    /// Whether the inverse is a factor of all unknowns.
    bool is_direct() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// [m^3]
double volume_of(const core::TetraMesh &mesh);

/// System whose equilibrium is looked for: elements under conditions, of one process or of one of several MPI ranks,
/// which then all do the same at once. Entries that another rank owns are there to read from, and do not count in sums.
class PathSystem {
  public:
    /// Elements and conditions are kept alive by the caller.
    /// @param conditions  at the whole load
    /// @param pressure    shape (T) [Pa], see FollowerPressure; or empty
    /// @param ball        what touches the body, kept alive by the caller; or nullptr
    PathSystem(const Elements &elements, const fem_reference::DofConditions &conditions,
               std::span<const double> pressure, TouchingBall *ball = nullptr);
    virtual ~PathSystem() = default;

    const fem_reference::DofConditions &conditions() const { return conditions_; }
    TouchingBall *ball() const { return ball_; }
    State rest() const { return elements_.rest(); }
    /// Dead loads, follower pressures and contact at a fraction of the load.
    /// @return shape (3 n) [N]
    std::vector<double> loads(const State &state, double fraction) const;

    /// Once loads have found their equilibrium, the pressures of a ball are those of the tangents to come; without a
    /// ball this does nothing. See TouchingBall::expected_pressure().
    void expect(const State &state, double fraction);
    /// The same where the tangent says how they change.
    /// @param state  before the change
    /// @param part   of the change that is taken
    void expect(const State &state, double fraction, const State &change, double part);
    /// The tangent that factorise(), solve() and product() are about.
    void assemble(const State &state, double fraction);
    /// @return false if the tangent is not positive definite; there is no inverse then
    bool factorise() { return set_up(tangent_.stiffness); }
    /// The same of the tangent at rest.
    bool factorise_at_rest();
    /// Displacements alone, whether free or not.
    State product(const std::vector<double> &u) const;

    /// smallest_jacobian and energy are those of the whole body.
    virtual InternalForces internal_forces(const State &state) const = 0;
    /// After a factorise() that returned true, maybe of another state.
    virtual TangentSolver::Correction solve(const State &right, double tolerance) const = 0;
    /// See TangentSolver.
    virtual double pressure_scale() const = 0;
    virtual bool is_direct() const = 0;
    /// [m^3]
    virtual double volume() const = 0;

    /// (3 n), (m) whether entries count here
    virtual const std::vector<bool> &counted_displacements() const = 0;
    virtual const std::vector<bool> &counted_pressures() const = 0;
    /// Over all ranks.
    virtual double sum(double mine) const = 0;

  protected:
    const Elements &elements() const { return elements_; }
    const TangentMatrices &tangent() const { return tangent_; }
    const SurfaceStiffness &surface_stiffness() const { return surface_stiffness_; }

  private:
    /// Makes the inverse of a stiffness.
    /// @return false if it is not positive definite
    virtual bool set_up(const fem_reference::SymmetricBlocks<double> &stiffness) = 0;

    const Elements &elements_;
    const fem_reference::DofConditions &conditions_;
    FollowerPressure follower_;
    TouchingBall *ball_;
    TangentMatrices tangent_;
    SurfaceStiffness surface_stiffness_;
    std::vector<double> expected_pressure_; ///< of the ball, see TouchingBall; or empty
};

/// Elements of a whole body.
class OneProcessSystem : public PathSystem {
  public:
    /// See PathSystem.
    OneProcessSystem(const Elements &elements, const fem_reference::DofConditions &conditions,
                     std::span<const double> pressure, TouchingBall *ball = nullptr);

    InternalForces internal_forces(const State &state) const override { return elements().internal_forces(state); }
    TangentSolver::Correction solve(const State &right, double tolerance) const override {
        return solver_.solve(tangent(), surface_stiffness(), right, tolerance);
    }
    double pressure_scale() const override { return solver_.pressure_scale(); }
    bool is_direct() const override { return solver_.is_direct(); }
    double volume() const override { return volume_of(elements().body().mesh); }
    const std::vector<bool> &counted_displacements() const override { return counted_displacements_; }
    const std::vector<bool> &counted_pressures() const override { return counted_pressures_; }
    double sum(double mine) const override { return mine; }

  private:
    bool set_up(const fem_reference::SymmetricBlocks<double> &stiffness) override {
        return solver_.factorise(stiffness);
    }

    TangentSolver solver_;
    std::vector<bool> counted_displacements_, counted_pressures_; ///< all
};

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
    /// Forces out of balance at a state.
    struct Balance {
        double smallest_jacobian; ///< if not positive, nothing else is set
        double energy = 0.0;
        State residual{};  ///< internal minus external forces [N], at what is not free the reactions; and volumes [m^3]
        double size = 0.0; ///< of what is free, over the reactions and loads
    };
    /// Response to one newton of the places that press.
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
    void note(double residual, LoadStep &step) const;
    double first_tolerance() const;
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
    /// Effect of the last digits of positions on forces [N]: of a shear modulus on the square of the extent. Where a
    /// body moves as a rigid one there is nothing else.
    double rounding_force_;
};

} // namespace livermark::hyperelastic
