#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/mesh/places.hpp"
#include "core/problem.hpp"
#include "core/solution.hpp"
#include "fem_reference/linear/elastic_system.hpp"

namespace livermark::fem_reference {

struct Discretisation;
class ChosenSolver;

/// Static linear elasticity of one body on its own tetrahedra, with linear or quadratic Lagrange elements:
/// div sigma + rho a = 0, sigma = lambda tr(eps) I + 2 mu eps, eps = (grad u + grad u^T) / 2.
///
/// A facet's prescribed displacement holds at all its nodes, edge midpoints included; its traction and the body's
/// acceleration are integrated with the shape functions. Where several constraints meet at a node, each component
/// takes value and reaction from the constraint of lowest index that prescribes it (and of the first such facet).
///
/// The body is assembled once, with the springs of what it stands on (FoundationSprings). The factor is kept and used
/// again for the next load case that prescribes the same components at the same nodes; the values may differ.
class StaticSolver {
  public:
    /// @param body    tetrahedra of positive volume, every node used
    /// @param degree  1 or 2
    /// @param choice  how the linear systems are solved
    /// @param formulation  mixed for degree 2 only
    /// @param largest_coarse_factor  see Corners
    /// @param foundation  that all load cases to come have
    /// @throws std::invalid_argument for another degree, or if a boundary triangle is not an outer face
    StaticSolver(std::shared_ptr<const core::Body> body, int degree, SolverChoice choice = SolverChoice::automatic,
                 Formulation formulation = Formulation::displacement,
                 int largest_coarse_factor = largest_direct_coarse_system,
                 const std::optional<core::Foundation> &foundation = {});

    /// Quadratic elements on a refined body in the formulation of the coarse solver, by iterations that correct
    /// themselves with the solver of the body before refinement.
    /// @param refined_body  the body of the coarse solver with its tetrahedra in parts
    /// @param coarse        of degree 2; kept alive by the caller, and used by this solver
    /// @param tolerance     of the iterations of the mixed formulation, see MixedSolver; the reactions balance the
    ///   loads whatever it is
    /// @param parent        (M_refined) the tetrahedron that each is a part of, see core::bisect(); empty for
    ///   core::refine(body)
    /// @param foundation    of the coarse solver, on the facets of the refined body
    /// @throws std::invalid_argument if the body is not that, or if a boundary triangle is not an outer face
    StaticSolver(std::shared_ptr<const core::Body> refined_body, StaticSolver &coarse, double tolerance = 1e-7,
                 std::span<const int> parent = {}, const std::optional<core::Foundation> &foundation = {});
    ~StaticSolver();
    StaticSolver(StaticSolver &&) noexcept;
    StaticSolver &operator=(StaticSolver &&) noexcept;

    /// Takes a load case that constrains what many of those to come constrain too, maybe among more: see
    /// ConstrainedSolver::prepare(). Does nothing where there is no direct solver.
    void prepare(const core::LoadCase &load_case);

    /// @return displacement of the mesh nodes; reaction of each constraint, K u - f summed over its unknowns;
    ///   strain_energy 1/2 u^T K u (and 1/2 p^T C p), that of a foundation left out; degrees_of_freedom 3 per node,
    ///   edge midpoints and constrained ones included; setup_seconds for assembly and factorisation, as measured when
    ///   they were done even if this call reused them; of a time-dependent load case the history too, see release(),
    ///   but not in the mixed formulation. If the load case leaves the body free to move, the status is not_converged
    ///   and all fields are NaN. If an iterative solver does not come to its tolerance, the status is not_converged and
    ///   the fields are where it was.
    /// @throws std::invalid_argument if the load case does not have the sizes of the body's mesh, or has another
    ///   foundation
    /// @throws std::runtime_error if the memory does not hold the factor
    core::Solution solve(const core::LoadCase &load_case);

    /// The same, and of a time-dependent load case the history in the mixed formulation too, which takes a solve for
    /// each of its Ritz vectors; none if these would have to be too many, as with weak damping.
    core::Solution solve_with_motion(const core::LoadCase &load_case);

    /// Several load cases, as many at once as take less time together, see max_columns(). Where they are solved
    /// together the solutions differ from those of one by one within the tolerance, and solve_seconds is a part of the
    /// time of all.
    std::vector<core::Solution> solve(std::span<const core::LoadCase> load_cases);

    /// Compliance of the body at some places inside, with what a load case constrains.
    /// @throws support::InputError if the load case leaves the body free to move
    /// @throws std::invalid_argument if a place is outside the body, or as solve()
    core::Compliance compliance(const core::LoadCase &load_case, std::span<const core::InteriorPlace> places);

    /// Number of load cases that take less time together than one by one.
    std::size_t max_columns() const;

    /// The matrices of the body, and the solver of the one of its displacements: for solvers of what differs in few of
    /// them. They live as long as this one.
    const Discretisation &matrices() const;
    ChosenSolver &displacement_solver();
    /// Seconds that the assembly took.
    double assembly_seconds() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// Solves one problem from scratch, see StaticSolver.
core::Solution solve_static(const core::Problem &problem, int degree, SolverChoice choice = SolverChoice::automatic,
                            Formulation formulation = Formulation::displacement);

/// Loads inside the body.
struct InnerForces {
    std::vector<core::InteriorPlace> places; ///< (K)
    std::vector<core::Vector3> forces;       ///< (K) [N]
};

/// Static linear elasticity of one body with quadratic elements, as StaticSolver has it, for many load cases that
/// constrain the same facets and follow each other as somebody leads a tool: displacements only, the same factor for
/// all, and where iterations are cheaper than a factor, iterations that begin with the last solution.
class RepeatedLoads {
  public:
    /// Number of unknowns, edge midpoints included, beyond which there is no factor of the quadratic elements but one
    /// of the linear ones on the same body, the coarse level of conjugate gradients. On the liver that ships (70,000
    /// unknowns) a factor takes 685 MB and 6.8 s of a core, then 0.12 s for each solution; two levels take 92 MB and
    /// 0.9 s, then 0.25 s near the last solution (0.46 s at a Poisson's ratio of 0.49).
    static constexpr int largest_factor = 30'000;

    /// Norm of the residual over that of the loads at which iterations stop.
    static constexpr double tolerance = 1e-6;

    /// Assembles and factorises.
    /// @param body  as for StaticSolver
    /// @param constrained  what every load case to come constrains, and the foundation that it has
    /// @param report  called with a sentence as each stage begins
    /// @throws std::invalid_argument if a boundary triangle is not an outer face, or the load case is not for the mesh
    /// @throws std::runtime_error if the memory does not hold the factor
    RepeatedLoads(const core::Body &body, const core::LoadCase &constrained,
                  const std::function<void(const std::string &sentence)> &report, int largest = largest_factor);
    ~RepeatedLoads();
    RepeatedLoads(const RepeatedLoads &) = delete;
    RepeatedLoads &operator=(const RepeatedLoads &) = delete;

    struct Solution {
        bool is_unique = false; ///< whether what is constrained keeps the body from moving as a rigid one
        bool has_converged = false;
        int iterations = 0;                      ///< 0 with a factor
        double work = 0.0;                       ///< sum of f_i . u_i over all nodes of the elements [J]
        std::vector<core::Vector3> displacement; ///< (N) of the mesh nodes [m]; empty unless unique
        std::vector<core::Vector3> at_places;    ///< (K) in the mean over the places inside [m]; empty unless unique
    };

    /// @param load_case  constrains what the first one did, at zero
    /// @param last       (n) all unknowns of the solution before, from which iterations begin; empty before the first
    ///   one. It becomes those of this one.
    /// @param inner      beside the load case
    /// @throws std::invalid_argument if a place is outside the body
    Solution solve(const core::LoadCase &load_case, std::vector<double> &last, const InnerForces &inner = {});

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// Options of solve_distributed().
struct DistributedOptions {
    int degree = 2;                                      ///< 1 or 2, of the displacement
    Formulation formulation = Formulation::displacement; ///< mixed for degree 2 only
    int num_refinements = 0;                             ///< uniform ones, which no rank sees but its part of
    int max_iterations = 2000;
};

/// The work of StaticSolver, by all ranks of MPI_COMM_WORLD together: METIS cuts the body among them (see Part), and
/// each rank assembles what it owns. Displacements alone are solved for by conjugate gradients with smoothed
/// aggregation multigrid (Trilinos ML), the mixed formulation as in DistributedSaddlePoint. Collective: every rank
/// calls it, with the same problem, while an MpiSession lives. Every rank gets the solution on the mesh.
///
/// If a rank fails where the others cannot know of it (out of memory), it says so and ends them all.
/// @return as StaticSolver::solve(); status not_converged if iterations do not come to a relative residual of 1e-12,
///   in the mixed formulation 1e-10 as the preconditioner sees it, with the last iterate
/// @throws std::invalid_argument on every rank for elements that do not exist, if a boundary triangle is not an outer
///   face, if the load case is not for this mesh, or if there are more ranks than nodes
core::Solution solve_distributed(const core::Problem &problem, const DistributedOptions &options);

} // namespace livermark::fem_reference
