#include <algorithm>
#include <functional>
#include <iterator>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/mesh/refinement.hpp"
#include "core/support/processes/mpi_session.hpp"
#include "fem_reference/dynamics/modes.hpp"
#include "fem_reference/dynamics/relaxing_solver.hpp"
#include "fem_reference/linear/linear_elasticity.hpp"
#include "fem_reference/solvers/matrices.hpp"
#include "studies/models/model_table.hpp"
#include "studies/models/refined_solution.hpp"

namespace livermark::models::families {

namespace {

/// Models of finite elements, in one process or several.
struct FemModel {
    const char *name, *summary;
    core::Role at_rest, in_motion = core::Role::candidate;
    std::optional<core::Regime> only{};
};

constexpr FemModel fem_p1{"fem_p1", "linear elasticity, linear tetrahedra (the baseline)", core::Role::baseline};
/// They know modes and motion, which mixed elements do not.
constexpr FemModel fem_p2{"fem_p2", "linear elasticity, quadratic tetrahedra (the reference of motion)",
                          core::Role::substitute_reference, core::Role::reference};
constexpr FemModel fem_p2p1{"fem_p2p1",
                            "linear elasticity, quadratic tetrahedra with a linear pressure (Taylor and Hood)",
                            core::Role::reference};
/// Their mesh is not what is wrong with linear elasticity at large deformations.
constexpr FemModel fem_p2p1_refined{
    "fem_p2p1_refined",
    "linear elasticity, Taylor and Hood on meshes refined at the rims of places and below round "
    "tools (the reference of small deformations)",
    core::Role::refined_reference, core::Role::candidate, core::Regime::small};

using fem_reference::Formulation;
using fem_reference::RelaxingSolver;
using fem_reference::SolverChoice;
using fem_reference::StaticSolver;

/// Linear solutions grow with the load.
void add_path(core::Solution &solution, const core::LoadCase &load_case) {
    if (solution.status != core::SolutionStatus::ok)
        return;
    for (const double fraction : load_case.path) {
        auto &point = solution.path.emplace_back();
        for (const auto &displacement : solution.displacement)
            point.displacement.push_back((fraction * displacement).cast<float>());
        for (const auto &reaction : solution.reaction)
            point.reaction.emplace_back(fraction * reaction);
        point.strain_energy = fraction * fraction * solution.strain_energy;
    }
}

/// The discretisation is wrong by a percent, and these iterations then by less than a hundred-thousandth: on both
/// livers by 8e-7 of the displacement and 1.5e-6 of the reactions at most.
constexpr double refined_tolerance = 1e-5;

/// Distance from places up to which meshes are refined, over their radius, and number of times.
constexpr double near_places = 1.5;
constexpr int times_near_places = 2;

using MaybeFoundation = std::optional<core::Foundation>;

/// A body on a foundation, or on none.
StaticSolver solver_on(const std::shared_ptr<const core::Body> &body, const MaybeFoundation &foundation, int degree,
                       SolverChoice choice, Formulation formulation) {
    return {body, degree, choice, formulation, fem_reference::largest_direct_coarse_system, foundation};
}

/// Solutions of load cases, of those together that follow one another on one foundation or on none.
/// @param solve  some load cases on the foundation of the first
template <class Solve>
std::vector<core::Solution> solve_by_foundation(std::span<const core::LoadCase> load_cases, const Solve &solve) {
    std::vector<core::Solution> solutions;
    while (!load_cases.empty()) {
        const auto end = std::ranges::find_if(load_cases, [&](const core::LoadCase &load_case) {
            return load_case.foundation != load_cases.front().foundation;
        });
        const auto some = load_cases.first(static_cast<std::size_t>(end - load_cases.begin()));
        std::ranges::move(solve(some), std::back_inserter(solutions));
        load_cases = load_cases.subspan(some.size());
    }
    return solutions;
}

/// Mixed elements on a finer mesh, with those on the mesh before as a preconditioner where nobody chose a solver.
std::unique_ptr<StaticSolver> finer_solver(const core::BisectedProblem &refined, StaticSolver &coarse,
                                           SolverChoice choice) {
    const auto &[body, load_case] = refined.problem;
    return choice == SolverChoice::automatic
               ? std::make_unique<StaticSolver>(body, coarse, refined_tolerance, refined.parent_tetrahedron,
                                                load_case.foundation)
               : std::make_unique<StaticSolver>(solver_on(body, load_case.foundation, 2, choice, Formulation::mixed));
}

/// The compliance of the mixed elements on the mesh and on two that are finer near the places.
core::Compliance refined_compliance(const core::Problem &problem, std::span<const core::InteriorPlace> places,
                                    SolverChoice choice) {
    std::vector<std::unique_ptr<StaticSolver>> solvers;
    solvers.push_back(std::make_unique<StaticSolver>(
        solver_on(problem.body, problem.load_case.foundation, 2, choice, Formulation::mixed)));
    auto found = solvers.back()->compliance(problem.load_case, places);
    auto finest = problem;
    for (int level = 0; level < times_near_places; ++level) {
        const auto refined = core::refine_near_places(finest, places, near_places);
        finest = refined.problem;
        solvers.push_back(finer_solver(refined, *solvers.back(), choice));
        auto finer = solvers.back()->compliance(finest.load_case, places);
        finer.on_coarser = std::move(found.on_coarser);
        finer.on_coarser.push_back(std::move(found.matrix));
        finer.seconds += found.seconds;
        found = std::move(finer);
    }
    return found;
}

bool has_slow_history(const core::LoadCase &load_case) {
    return load_case.slow_history.has_value();
}

/// The mixed solver of a body on what it stands on, and the load cases that it solved last: fem_p2p1_refined begins
/// with the solutions that fem_p2p1 has just found.
class MixedSolverWithLast {
  public:
    MixedSolverWithLast(const std::shared_ptr<const core::Body> &body, const MaybeFoundation &stands_on,
                        SolverChoice choice)
        : foundation(stands_on), solver(solver_on(body, stands_on, 2, choice, Formulation::mixed)) {}

    std::vector<core::Solution> solve(std::span<const core::LoadCase> load_cases) {
        if (!std::ranges::equal(load_cases, last_, core::are_statically_equal)) {
            last_.clear(); // what follows may throw
            solutions_ = solver.solve(load_cases);
            last_.assign(load_cases.begin(), load_cases.end());
        }
        return solutions_;
    }

    MaybeFoundation foundation;
    StaticSolver solver;

  private:
    std::vector<core::LoadCase> last_;
    std::vector<core::Solution> solutions_; ///< of last_; the same whatever a load case releases, since none moves
};

/// A solver that others may use as well.
struct SharedSolver {
    std::shared_ptr<StaticSolver> in_turn; ///< for what takes one load case after the other
    /// By the same solver.
    std::function<std::vector<core::Solution>(std::span<const core::LoadCase>)> solve_all;
};

/// Solves with the solver of the foundation that came last.
class PreparedElements : public core::PreparedModel {
  public:
    using MakeSolver = std::function<SharedSolver(const MaybeFoundation &)>;

    PreparedElements(std::shared_ptr<const core::Body> body, SolverChoice choice, MakeSolver make)
        : body_(std::move(body)), choice_(choice), make_(std::move(make)) {}

    std::vector<core::Solution> solve(std::span<const core::LoadCase> load_cases) override {
        return solve_by_foundation(load_cases, [this](std::span<const core::LoadCase> some) {
            stand_on(some.front().foundation);
            if (std::ranges::any_of(some, has_slow_history))
                return solve_in_turn(some);
            auto solutions = here_->solver.solve_all(some);
            for (std::size_t i = 0; i < solutions.size(); ++i)
                add_path(solutions[i], some[i]);
            return solutions;
        });
    }

  private:
    struct Place {
        Place(MaybeFoundation stands_on, SharedSolver shared)
            : foundation(std::move(stands_on)), solver(std::move(shared)) {}

        MaybeFoundation foundation;
        SharedSolver solver;
        std::optional<RelaxingSolver> relaxing; ///< when the first history comes
    };

    void stand_on(const MaybeFoundation &foundation) {
        if (here_ && here_->foundation == foundation)
            return;
        here_.reset();
        here_.emplace(foundation, make_(foundation));
    }

    std::vector<core::Solution> solve_in_turn(std::span<const core::LoadCase> load_cases) {
        auto &solver = *here_->solver.in_turn;
        if (!here_->relaxing)
            here_->relaxing.emplace(body_, solver, choice_);
        std::vector<core::Solution> solutions;
        for (const auto &load_case : load_cases)
            if (has_slow_history(load_case)) {
                solutions.push_back(here_->relaxing->solve(load_case));
            } else {
                solutions.push_back(solver.solve(load_case));
                add_path(solutions.back(), load_case);
            }
        return solutions;
    }

    std::shared_ptr<const core::Body> body_;
    SolverChoice choice_;
    MakeSolver make_;
    std::optional<Place> here_; ///< when the first load case comes
};

/// The mixed solver of the body and foundation that came last, while somebody uses it: fem_p2p1 solves with it, and
/// fem_p2p1_refined takes it for its coarsest level.
class MixedSolvers {
  public:
    explicit MixedSolvers(SolverChoice choice) : choice_(choice) {}

    SolverChoice choice() const { return choice_; }

    std::shared_ptr<MixedSolverWithLast> on(const std::shared_ptr<const core::Body> &body,
                                            const MaybeFoundation &foundation) {
        if (auto solver = solver_.lock(); solver && body_.lock() == body && solver->foundation == foundation)
            return solver;
        auto solver = std::make_shared<MixedSolverWithLast>(body, foundation, choice_);
        body_ = body;
        solver_ = solver;
        return solver;
    }

  private:
    SolverChoice choice_;
    std::weak_ptr<const core::Body> body_; ///< of the solver
    std::weak_ptr<MixedSolverWithLast> solver_;
};

std::unique_ptr<core::PreparedModel> mixed_elements(const std::shared_ptr<const core::Body> &body,
                                                    const std::shared_ptr<MixedSolvers> &solvers) {
    return std::make_unique<PreparedElements>(
        body, solvers->choice(), [body, solvers](const MaybeFoundation &foundation) -> SharedSolver {
            const auto shared = solvers->on(body, foundation);
            return {{shared, &shared->solver}, [shared](auto load_cases) { return shared->solve(load_cases); }};
        });
}

/// Half a percent, where four meshes give it.
constexpr Refinement refinement{.goal = 0.005, .finest_level = 3};

/// The mixed elements on the mesh and on those that are refined at the rims of the places of each load case and below
/// its round tools, where nearly all of the error is; each mesh but the first has the solver of the one before as a
/// preconditioner.
class PreparedRefinedElements : public core::PreparedModel {
  public:
    PreparedRefinedElements(std::shared_ptr<const core::Body> body, std::shared_ptr<MixedSolvers> solvers)
        : body_(std::move(body)), choice_(solvers->choice()), solvers_(std::move(solvers)) {}

    std::vector<core::Solution> solve(std::span<const core::LoadCase> load_cases) override {
        std::vector<core::LoadCase> at_rest(load_cases.begin(), load_cases.end());
        for (auto &load_case : at_rest)
            load_case.release.reset(); // motion on the refined mesh would take hours
        return solve_by_foundation(
            at_rest, [this](std::span<const core::LoadCase> some) { return solve_on_one_foundation(some); });
    }

  private:
    std::vector<core::Solution> solve_on_one_foundation(std::span<const core::LoadCase> at_rest) {
        shared_ = solvers_->on(body_, at_rest.front().foundation);
        solver_ = &shared_->solver;
        std::vector<core::Solution> solutions;
        if (std::ranges::any_of(at_rest, has_slow_history)) {
            for (const auto &load_case : at_rest)
                solutions.push_back(has_slow_history(load_case) ? solve_history(load_case)
                                                                : solve_one(load_case, solver_->solve(load_case)));
            return solutions;
        }
        const auto on_mesh = shared_->solve(at_rest);
        for (std::size_t i = 0; i < at_rest.size(); ++i)
            solutions.push_back(solve_one(at_rest[i], on_mesh[i]));
        return solutions;
    }

    /// Solution of a body that relaxes: on each mesh with what is needed of elastic solutions there.
    core::Solution solve_history(const core::LoadCase &load_case) {
        core::Problem problem{body_, load_case};
        std::vector<std::unique_ptr<StaticSolver>> finer; // each is used by the next, and so are those below
        std::vector<std::unique_ptr<RelaxingSolver>> relaxing;
        relaxing.push_back(std::make_unique<RelaxingSolver>(body_, *solver_, choice_));
        return solve_refined({body_, load_case}, refinement, [&](int level) {
            if (level > 0) {
                const auto refined = core::refine_at_rims_and_tools(problem);
                problem = refined.problem;
                finer.push_back(finer_solver(refined, finer.empty() ? *solver_ : *finer.back(), choice_));
                relaxing.push_back(choice_ == SolverChoice::automatic
                                       ? std::make_unique<RelaxingSolver>(problem.body, *finer.back(), choice_,
                                                                          *relaxing.back(), refined_tolerance,
                                                                          refined.parent_tetrahedron)
                                       : std::make_unique<RelaxingSolver>(problem.body, *finer.back(), choice_));
            }
            return relaxing.back()->solve(problem.load_case);
        });
    }

    core::Solution solve_one(const core::LoadCase &load_case, const core::Solution &on_mesh) {
        core::Problem problem{body_, load_case};
        std::vector<std::unique_ptr<StaticSolver>> finer; // each is used by the next
        return solve_refined({body_, load_case}, refinement, [&](int level) {
            if (level == 0)
                return on_mesh;
            const auto refined = core::refine_at_rims_and_tools(problem);
            problem = refined.problem;
            finer.push_back(finer_solver(refined, finer.empty() ? *solver_ : *finer.back(), choice_));
            return finer.back()->solve(problem.load_case);
        });
    }

    std::shared_ptr<const core::Body> body_;
    SolverChoice choice_;
    std::shared_ptr<MixedSolvers> solvers_;
    std::shared_ptr<MixedSolverWithLast> shared_; ///< on the mesh, of the load cases that came last
    StaticSolver *solver_ = nullptr;              ///< the same
};

core::Model model(const FemModel &elements, core::PrepareModel prepare) {
    return {.name = elements.name,
            .summary = elements.summary,
            .source = "Arndt et al. 2022, The deal.II library, version 9.4, J. Numer. Math. 30(3)",
            .prepare = std::move(prepare),
            .at_rest = elements.at_rest,
            .in_motion = elements.in_motion,
            .only = elements.only,
            .follows = core::EventSet::of<core::Release, core::ToolMotion, core::Foundation>(),
            .is_collective = support::mpi_num_ranks() > 1};
}

/// Several MPI ranks solve together, whatever the size: the same models as in one process.
std::vector<core::Model> distributed_models() {
    const auto solve_with = [](const fem_reference::DistributedOptions &options) {
        return [options](const core::Problem &problem) {
            auto solution = fem_reference::solve_distributed(problem, options);
            add_path(solution, problem.load_case);
            return solution;
        };
    };
    const auto solve_mixed = solve_with({.formulation = Formulation::mixed});
    const auto at_rims = [solve_mixed](const core::Problem &problem) {
        auto at_rest = problem;
        at_rest.load_case.release.reset();
        return solve_locally_refined(
            at_rest, refinement, [](const core::Problem &coarse) { return core::refine_at_rims_and_tools(coarse); },
            solve_mixed);
    };
    std::vector<core::Model> models{model(fem_p1, core::solves_each(solve_with({.degree = 1}))),
                                    model(fem_p2, core::solves_each(solve_with({.degree = 2}))),
                                    model(fem_p2p1, core::solves_each(solve_mixed)),
                                    model(fem_p2p1_refined, core::solves_each(at_rims))};
    // Of displacements alone: takes most of the memory and time of a large body, and judges nothing.
    models[1].only_when_named = true;
    return models;
}

/// Elements of displacement alone, which know their modes.
core::Model displacement_elements(const FemModel &elements, int degree, SolverChoice choice) {
    auto result = model(elements, [=](const std::shared_ptr<const core::Body> &body, const core::LoadCase *common) {
        const auto make = [=, constrained = common ? std::optional(*common)
                                                   : std::nullopt](const MaybeFoundation &foundation) -> SharedSolver {
            auto solver =
                std::make_shared<StaticSolver>(solver_on(body, foundation, degree, choice, Formulation::displacement));
            if (constrained)
                solver->prepare(*constrained);
            return {solver, [solver](auto load_cases) { return solver->solve(load_cases); }};
        };
        return std::make_unique<PreparedElements>(body, choice, make);
    });
    result.modes = [degree](const core::Problem &problem, int count) {
        return fem_reference::lowest_modes(problem, degree, count);
    };
    result.compliance = [=](const core::Problem &problem, std::span<const core::InteriorPlace> places) {
        return solver_on(problem.body, problem.load_case.foundation, degree, choice, Formulation::displacement)
            .compliance(problem.load_case, places);
    };
    return result;
}

std::vector<core::Model> models(const ModelOptions &options) {
    if (support::mpi_num_ranks() > 1)
        return distributed_models();
    const auto choice = options.fem_solver;
    const auto solvers = std::make_shared<MixedSolvers>(choice);
    auto on_mesh =
        model(fem_p2p1, [solvers](const std::shared_ptr<const core::Body> &body, const core::LoadCase * /*common*/) {
            return mixed_elements(body, solvers);
        });
    on_mesh.compliance = [solvers](const core::Problem &problem, std::span<const core::InteriorPlace> places) {
        return solvers->on(problem.body, problem.load_case.foundation)->solver.compliance(problem.load_case, places);
    };
    auto finer = model(fem_p2p1_refined,
                       [solvers](const std::shared_ptr<const core::Body> &body, const core::LoadCase * /*common*/) {
                           return std::make_unique<PreparedRefinedElements>(body, solvers);
                       });
    finer.compliance = [choice](const core::Problem &problem, std::span<const core::InteriorPlace> places) {
        return refined_compliance(problem, places, choice);
    };
    for (auto *together : {&on_mesh, &finer}) // nothing is gained where the user chose a solver
        together->most_together = choice == SolverChoice::automatic ? fem_reference::most_lanes : 1;
    std::vector<core::Model> models{displacement_elements(fem_p1, 1, choice), displacement_elements(fem_p2, 2, choice),
                                    std::move(on_mesh), std::move(finer)};
    for (auto &each : models)
        each.follows.add<core::SlowHistory>();
    return models;
}

} // namespace

/// Linear-elastic finite elements on the same tetrahedra, and on finer ones.
ModelFamily fem() {
    return {.name = {}, .models = models};
}

} // namespace livermark::models::families
