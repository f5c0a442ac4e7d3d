#include <fmt/format.h>
#include <memory>
#include <optional>

#include "fem_reference/linear_elasticity.hpp"
#include "fem_reference/modes.hpp"
#include "models/model_table.hpp"

namespace livermark::models::families {

namespace {

/// Keeps the solver of the last body, and with it the factor of its stiffness.
class KeptSolver {
  public:
    explicit KeptSolver(int degree) : degree_(degree) {}

    core::Solution solve(const core::Problem &problem) {
        if (body_ != problem.body) {
            solver_.reset(); // the old factor goes before the new one needs the memory
            solver_.emplace(problem.body, degree_);
            body_ = problem.body;
        }
        return solver_->solve(problem.load_case);
    }

  private:
    int degree_;
    std::shared_ptr<const core::Body> body_;
    std::optional<fem_reference::StaticSolver> solver_;
};

core::Model finite_elements(int degree, std::string summary) {
    return {.name = fmt::format("fem_p{}", degree),
            .summary = std::move(summary),
            .source = "Arndt et al. 2022, The deal.II library, version 9.4, J. Numer. Math. 30(3)",
            .solve = [solver = std::make_shared<KeptSolver>(degree)](
                         const core::Problem &problem) { return solver->solve(problem); },
            .modes = [degree](const core::Problem &problem,
                              int count) { return fem_reference::lowest_modes(problem, degree, count); }};
}

} // namespace

/// Linear-elastic finite elements on the same tetrahedra.
ModelFamily fem() {
    return {.name = {}, .models = [] {
                return std::vector{
                    finite_elements(1, "linear elasticity, linear tetrahedra (the baseline)"),
                    finite_elements(2, "linear elasticity, quadratic tetrahedra (the reference)"),
                };
            }};
}

} // namespace livermark::models::families
