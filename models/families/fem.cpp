#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/refinement.hpp"
#include "fem_reference/columns.hpp"
#include "fem_reference/distributed_solver.hpp"
#include "fem_reference/linear_elasticity.hpp"
#include "fem_reference/modes.hpp"
#include "fem_reference/mpi_session.hpp"
#include "models/model_table.hpp"

namespace livermark::models::families {

namespace {

constexpr auto linear_summary = "linear elasticity, linear tetrahedra (the baseline)";
constexpr auto quadratic_summary = "linear elasticity, quadratic tetrahedra (the reference of motion)";

/// Keeps the solver of the last body, and with it the factor of its stiffness.
class KeptSolver {
  public:
    KeptSolver(int degree, fem_reference::SolverChoice choice,
               fem_reference::Formulation formulation = fem_reference::Formulation::displacement)
        : degree_(degree), choice_(choice), formulation_(formulation) {}

    /// See core::Model::begin_with.
    void begin_with(const core::Problem &problem) { first_[problem.body] = problem.load_case; }

    void forget() {
        body_.reset();
        solver_.reset();
    }

    fem_reference::StaticSolver &on(const std::shared_ptr<const core::Body> &body) {
        if (body_ != body) {
            forget(); // the old factor goes before the new one needs the memory
            solver_.emplace(body, degree_, choice_, formulation_);
            if (const auto first = first_.find(body); first != first_.end())
                solver_->begin_with(first->second);
            body_ = body;
        }
        return *solver_;
    }

  private:
    int degree_;
    fem_reference::SolverChoice choice_;
    fem_reference::Formulation formulation_;
    std::map<std::shared_ptr<const core::Body>, core::LoadCase> first_; ///< of each body, what begin_with() told
    std::shared_ptr<const core::Body> body_;
    std::optional<fem_reference::StaticSolver> solver_;
};

/// The discretisation is wrong by a percent, and these iterations then by less than a hundred-thousandth: on both
/// livers by 8e-7 of the displacement and 1.5e-6 of the reactions at most.
constexpr double refined_tolerance = 1e-5;

/// The same on the refined mesh, where the solver on the mesh is the second level.
class KeptRefinedSolver {
  public:
    KeptRefinedSolver(std::shared_ptr<KeptSolver> coarse, fem_reference::SolverChoice choice)
        : coarse_(std::move(coarse)), choice_(choice) {}

    /// The solver on the mesh as well.
    void forget() {
        body_.reset();
        solver_.reset();
        coarse_->forget();
    }

    /// @param problems  of one body
    std::vector<core::Solution> solve(std::span<const core::Problem> problems) {
        const auto &body = problems.front().body;
        if (body_ != body) {
            body_.reset();
            solver_.reset();
            const auto refined = std::make_shared<const core::Body>(core::refine(*body));
            if (choice_ == fem_reference::SolverChoice::automatic)
                solver_.emplace(refined, coarse_->on(body), refined_tolerance);
            else
                solver_.emplace(refined, 2, choice_, fem_reference::Formulation::mixed);
            body_ = body;
        }
        std::vector<core::LoadCase> load_cases;
        for (const auto &problem : problems) {
            load_cases.push_back(core::refine(problem.load_case));
            load_cases.back().release.reset(); // motion on the refined mesh would take hours
        }
        auto solutions = solver_->solve(std::span<const core::LoadCase>(load_cases));
        for (auto &solution : solutions)
            solution.displacement.resize(body->mesh.points.size()); // the nodes of the mesh come first
        return solutions;
    }

  private:
    std::shared_ptr<KeptSolver> coarse_;
    fem_reference::SolverChoice choice_;
    std::shared_ptr<const core::Body> body_;
    std::optional<fem_reference::StaticSolver> solver_;
};

core::Model finite_elements(std::string_view name, const char *summary,
                            std::function<core::Solution(const core::Problem &)> solve,
                            std::function<core::Modes(const core::Problem &, int)> modes = {}) {
    return {.name = std::string(name),
            .summary = summary,
            .source = "Arndt et al. 2022, The deal.II library, version 9.4, J. Numer. Math. 30(3)",
            .solve = std::move(solve),
            .modes = std::move(modes),
            .is_collective = fem_reference::mpi_num_ranks() > 1};
}

/// Nothing is gained where the user chose a solver.
core::Model solved_together(core::Model model, fem_reference::SolverChoice choice,
                            std::function<std::vector<core::Solution>(std::span<const core::Problem>)> solve,
                            std::function<void()> forget) {
    model.forget = std::move(forget);
    if (choice != fem_reference::SolverChoice::automatic)
        return model;
    model.solve_together = std::move(solve);
    model.most_together = fem_reference::most_lanes;
    return model;
}

/// Several MPI ranks solve together, whatever the size.
std::vector<core::Model> distributed_models() {
    const auto on_mesh = [](int degree) {
        return [degree](const core::Problem &problem) { return fem_reference::solve_distributed(problem, degree); };
    };
    const auto refined = [](const core::Problem &problem) {
        auto solution = fem_reference::solve_distributed(core::refine(problem), 2);
        solution.displacement.resize(problem.body->mesh.points.size()); // the nodes of the mesh come first
        return solution;
    };
    return {
        finite_elements("fem_p1", linear_summary, on_mesh(1)),
        finite_elements("fem_p2", quadratic_summary, on_mesh(2)),
        finite_elements("fem_p2_refined", "quadratic tetrahedra on the mesh refined once", refined),
    };
}

std::vector<core::Model> models(const ModelOptions &options) {
    if (fem_reference::mpi_num_ranks() > 1)
        return distributed_models();
    const auto linear = std::make_shared<KeptSolver>(1, options.fem_solver);
    const auto quadratic = std::make_shared<KeptSolver>(2, options.fem_solver);
    const auto mixed = std::make_shared<KeptSolver>(2, options.fem_solver, fem_reference::Formulation::mixed);
    const auto refined = std::make_shared<KeptRefinedSolver>(mixed, options.fem_solver);
    const auto on_mesh = [](auto solver) {
        return [solver](const core::Problem &problem) { return solver->on(problem.body).solve(problem.load_case); };
    };
    const auto sharing_factors = [](core::Model model, const std::shared_ptr<KeptSolver> &solver) {
        model.begin_with = [solver](const core::Problem &problem) { solver->begin_with(problem); };
        model.forget = [solver] { solver->forget(); };
        return model;
    };
    const auto modes = [](int degree) {
        return [degree](const core::Problem &problem, int count) {
            return fem_reference::lowest_modes(problem, degree, count);
        };
    };
    return {
        sharing_factors(finite_elements("fem_p1", linear_summary, on_mesh(linear), modes(1)), linear),
        sharing_factors(finite_elements("fem_p2", quadratic_summary, on_mesh(quadratic), modes(2)), quadratic),
        solved_together(
            finite_elements(
                "fem_p2p1",
                "linear elasticity, quadratic tetrahedra with a linear pressure (Taylor and Hood; the reference)",
                on_mesh(mixed)),
            options.fem_solver,
            [mixed](std::span<const core::Problem> problems) {
                std::vector<core::LoadCase> load_cases;
                for (const auto &problem : problems)
                    load_cases.push_back(problem.load_case);
                return mixed->on(problems.front().body).solve(std::span<const core::LoadCase>(load_cases));
            },
            [refined] { refined->forget(); }), // what it is refined from is this one's
        solved_together(
            finite_elements("fem_p2p1_refined",
                            "linear elasticity, Taylor and Hood on the mesh refined once (the reference where fem_p2p1 "
                            "is not good enough)",
                            [refined](const core::Problem &problem) {
                                return std::move(refined->solve(std::span(&problem, 1)).front());
                            }),
            options.fem_solver, [refined](std::span<const core::Problem> problems) { return refined->solve(problems); },
            [refined] { refined->forget(); }),
    };
}

} // namespace

/// Linear-elastic finite elements on the same tetrahedra, and on the same cut into eight.
ModelFamily fem() {
    return {.name = {}, .models = models};
}

} // namespace livermark::models::families
