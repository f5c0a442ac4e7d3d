#include "fem_reference/chosen_solver.hpp"

#include <limits>

#include "fem_reference/algebraic_multigrid.hpp"
#include "fem_reference/mass_matrix.hpp"
#include "fem_reference/two_level.hpp"

namespace livermark::fem_reference {

namespace {

/// A sparse Cholesky factor as a preconditioner that is exact.
class Factor : public Preconditioner {
  public:
    explicit Factor(ConstrainedSolver &solver) : solver_(solver) {}

    bool set_up(const std::vector<bool> &is_free) override {
        std::vector<double> prescribed(is_free.size(), 0.0);
        for (std::size_t dof = 0; dof < is_free.size(); ++dof)
            if (is_free[dof])
                prescribed[dof] = std::numeric_limits<double>::quiet_NaN();
        return solver_.factorise(prescribed);
    }
    void apply(std::span<const double> residual, std::span<double> correction) override {
        solver_.solve_held(residual, correction);
    }
    std::string name() const override { return "CHOLMOD"; }

  private:
    ConstrainedSolver &solver_;
};

} // namespace

ChosenSolver::ChosenSolver(const ElasticSystem &system, SolverChoice choice) : stiffness_(&system.stiffness) {
    if (choice == SolverChoice::iterative ||
        (choice == SolverChoice::automatic && system.stiffness.num_rows() > largest_direct_system)) {
        iterative_.emplace(system.stiffness, algebraic_multigrid(system));
    } else {
        direct_.emplace(system.stiffness);
        factor_ = std::make_unique<Factor>(*direct_);
    }
}

ChosenSolver::ChosenSolver(const ElasticSystem &fine, const ElasticSystem &coarse, ChosenSolver &coarse_solver)
    : stiffness_(&fine.stiffness) {
    iterative_.emplace(fine.stiffness, two_level(fine, coarse, coarse_solver.inverse()));
}

void ChosenSolver::set_up(std::span<const double> prescribed) {
    if (direct_)
        direct_->factorise(prescribed);
    else
        iterative_->set_up(prescribed);
}

ConstrainedSolution ChosenSolver::solve(std::span<const double> prescribed, std::span<const double> load, double size) {
    return direct_ ? direct_->solve(prescribed, load) : iterative_->solve(prescribed, load, size);
}

double ChosenSolver::setup_seconds() const {
    return direct_ ? direct_->factor_seconds() : iterative_->setup_seconds();
}

void ChosenSolver::multiply(std::span<const double> x, std::span<double> out) const {
    if (direct_)
        multiply_stiffness(*stiffness_, x, out);
    else
        iterative_->multiply(x, out);
}

Preconditioner &ChosenSolver::inverse() {
    return direct_ ? *factor_ : iterative_->preconditioner();
}

std::string ChosenSolver::description(const ConstrainedSolution &solution) const {
    if (direct_)
        return "CHOLMOD";
    return "CG, " + std::to_string(solution.iterations) + " iterations, " + iterative_->preconditioner().name();
}

} // namespace livermark::fem_reference
