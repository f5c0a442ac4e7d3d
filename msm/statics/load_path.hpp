#pragma once

#include <utility>
#include <vector>

#include "core/problem.hpp"
#include "core/tool/touching_tool.hpp"
#include "msm/statics/equilibrium.hpp"

namespace livermark::msm {

/// Tolerance of residuals along a path: nobody looks at more digits, and large forces leave fewer.
inline constexpr double path_tolerance = 1e-9;

/// Contact in an equilibrium on the way.
struct Touch {
    const SurfaceContact *contact = nullptr; ///< with a ball, which no pressure follows the surface beside
    double tolerance = path_tolerance;       ///< of the residual, see EquilibriumOptions
};

/// Equilibria of one problem at parts of its loads, one after another: each learns from those before, and pressures
/// that follow the surface are turned with it. They have an energy, but for what the rim of their place is pushed with:
/// that is a load of a fixed direction within an equilibrium, and is turned until the surface moves no more.
class EquilibriumSearch {
  public:
    /// @param problem    kept by reference
    /// @param node_mass  shape (N) [kg], kept by reference
    /// @param bears_rounding  see EquilibriumOptions
    EquilibriumSearch(const core::Problem &problem, const std::vector<double> &node_mass, bool bears_rounding = false);

    /// The problem with a part of all that drives it.
    core::Problem at(double fraction) const;
    /// Conditions of that. A place that presses does so at every part, 0 included.
    NodalConditions conditions_at(double fraction) const;
    /// Positions at displacements, shape (N) [m].
    Field positions(const Field &displacement) const;

    /// @param body   may be another one each time
    /// @param rest   of that body or one that is about as stiff; as for find_equilibrium()
    /// @param start  shape (N) [m]; what is prescribed is put to its place
    Equilibrium find(const ElasticBody &body, const RestStiffness &rest, double fraction, Field start,
                     const Touch &touch = {});

    /// Forces of the constraints at an equilibrium, shape (P) [N].
    Field reaction(const Equilibrium &found, double fraction) const;

    LimitedMemory &memory() { return memory_; }
    int num_equilibria() const { return num_equilibria_; }
    int num_iterations() const { return num_iterations_; } ///< of all
    int num_factors() const { return num_factors_; }       ///< of all

  private:
    Equilibrium find(const ElasticBody &body, const RestStiffness &rest, const NodalConditions &conditions, Field start,
                     const SurfacePressure *pressure, const Touch &touch);

    const core::Problem &problem_;
    const std::vector<double> &node_mass_;
    bool has_followers_, bears_rounding_;
    LimitedMemory memory_;
    int num_equilibria_ = 0, num_iterations_ = 0, num_factors_ = 0;
};

/// A body with the springs of LoadCase::foundation below its facets, on which displacements are linear; without a
/// foundation the body as it is. Their energy is a part of it then.
/// @param body  at rest on the mesh of the problem
ElasticBody on_foundation(ElasticBody body, const core::Problem &problem);

/// Place where a body comes to rest under the whole load of a problem, on its foundation.
/// @param body       at rest on the mesh of the problem, without the foundation
/// @param node_mass  shape (N) [kg]
/// @param rest       as for find_equilibrium(); not looked at where the body stands on a foundation
Equilibrium find_equilibrium(const ElasticBody &body, const core::Problem &problem,
                             const std::vector<double> &node_mass, const RestStiffness &rest,
                             const EquilibriumOptions &options = {});

/// Places of a body on the way to the whole load, and there.
struct FollowedPath {
    Equilibrium end; ///< at the whole load, or where it ended; iterations and factors are those of the whole way
    std::vector<core::PathPoint>
        points;        ///< at the parts of LoadCase::path, as far as it came; reactions and displacements
    int num_steps = 0; ///< equilibria
};

/// Follows equilibrium along LoadCase::path as all that drives the body grows. A step begins where the last one ended,
/// and goes on by the solution linearised at rest to what was added; one without an equilibrium is taken again in
/// halves. See EquilibriumSearch on pressures that follow the surface. Under a ball that touches equilibria follow one
/// another as SurfaceContact says, and its friction is that of these steps. A foundation bears the body all the way;
/// the energy of its springs is not among the points' strain energies.
/// @param problem            with a path
/// @param node_mass          shape (N) [kg]
/// @param rest               as for find_equilibrium(); not looked at where the body stands on a foundation
/// @return status not_converged with the points as far as it came
FollowedPath follow_path(const ElasticBody &body, const core::Problem &problem, const std::vector<double> &node_mass,
                         const RestStiffness &rest);

} // namespace livermark::msm
