#include "fem_reference/linear/chosen_solver.hpp"

#include <limits>
#include <stdexcept>
#include <string>

#include "fem_reference/linear/deal_ii_mesh.hpp"
#include "fem_reference/solvers/algebraic_multigrid.hpp"
#include "fem_reference/solvers/two_level.hpp"

namespace livermark::fem_reference {

namespace {

/// Sparse Cholesky factors as a preconditioner that is exact: one for each set of unknowns that are free.
class Factor : public Preconditioner {
  public:
    /// @param first  of the first set, shared with who solves with it alone
    Factor(const SymmetricBlocks<double> &stiffness, ConstrainedSolver &first) : stiffness_(stiffness), first_(first) {}

    bool set_up(const FreeUnknowns &free) override {
        while (others_.size() + 1 < free.sets.size())
            others_.emplace_back(compressed_rows(stiffness_));
        columns_.assign(free.sets.size(), {});
        for (int lane = 0; lane < free.lanes(); ++lane)
            columns_[free.set[lane]].push_back(lane);
        bool unique = true;
        for (std::size_t s = 0; s < free.sets.size(); ++s) {
            const auto &is_free = free.sets[s];
            std::vector<double> prescribed(is_free.size(), 0.0);
            for (std::size_t dof = 0; dof < is_free.size(); ++dof)
                if (is_free[dof])
                    prescribed[dof] = std::numeric_limits<double>::quiet_NaN();
            unique = solver(s).factorise(prescribed) && unique;
        }
        lanes_ = free.lanes();
        return unique;
    }
    void apply(std::span<const float> residual, std::span<float> correction) override {
        for (std::size_t s = 0; s < columns_.size(); ++s)
            solver(s).solve_single_precision(residual, correction, lanes_, columns_[s]);
    }
    std::size_t max_columns() const override { return most_lanes; }
    std::string name() const override { return "CHOLMOD"; }

  private:
    ConstrainedSolver &solver(std::size_t set) { return set == 0 ? first_ : others_[set - 1]; }

    const SymmetricBlocks<double> &stiffness_;
    ConstrainedSolver &first_;
    std::vector<ConstrainedSolver> others_;
    std::vector<std::vector<int>> columns_; ///< of each set
    int lanes_ = 0;
};

} // namespace

ChosenSolver::ChosenSolver(const ElasticSystem &system, SolverChoice choice) : stiffness_(&system.stiffness) {
    if (choice == SolverChoice::iterative ||
        (choice == SolverChoice::automatic && system.stiffness.num_rows() > largest_direct_system)) {
        iterative_.emplace(system.stiffness, algebraic_multigrid(system));
    } else {
        direct_.emplace(compressed_rows(system.stiffness));
        factor_ = std::make_unique<Factor>(system.stiffness, *direct_);
    }
}

ChosenSolver::ChosenSolver(const ElasticSystem &fine, const ElasticSystem &coarse, ChosenSolver &coarse_solver,
                           std::span<const int> parent)
    : stiffness_(&fine.stiffness),
      single_precision_(std::make_unique<SymmetricBlocks<float>>(rounded(fine.stiffness))) {
    iterative_.emplace(fine.stiffness,
                       two_level(prolongation(coarse, fine, parent), *single_precision_, coarse_solver.inverse()));
}

void ChosenSolver::set_up(std::span<const double> prescribed) {
    if (direct_)
        direct_->factorise(prescribed);
    else
        iterative_->set_up(prescribed);
}

ConstrainedSolution ChosenSolver::solve(std::span<const double> prescribed, std::span<const double> load) {
    return direct_ ? direct_->solve(prescribed, load) : iterative_->solve(prescribed, load);
}

double ChosenSolver::setup_seconds() const {
    return direct_ ? direct_->factor_seconds() : iterative_->setup_seconds();
}

void ChosenSolver::multiply(std::span<const double> x, std::span<double> out) const {
    stiffness_->multiply(x, out);
}

void ChosenSolver::multiply(std::span<const float> x, std::span<float> out) const {
    if (!single_precision_)
        single_precision_ = std::make_unique<SymmetricBlocks<float>>(rounded(*stiffness_));
    single_precision_->multiply(x, out);
}

Preconditioner &ChosenSolver::inverse() {
    return direct_ ? *factor_ : iterative_->preconditioner();
}

std::size_t ChosenSolver::max_columns() const {
    return direct_ ? 1 : iterative_->preconditioner().max_columns(); // factors of several sets fill the memory
}

std::string ChosenSolver::description(const ConstrainedSolution &solution) const {
    if (direct_)
        return "CHOLMOD";
    return "CG, " + std::to_string(solution.iterations) + " iterations, " + iterative_->preconditioner().name();
}

Discretisation::Discretisation(const core::Body &body, int degree, Formulation formulation) {
    if (formulation == Formulation::displacement) {
        system = assemble(body, degree);
        return;
    }
    if (degree != 2)
        throw std::invalid_argument("the mixed formulation takes quadratic elements, not those of degree " +
                                    std::to_string(degree));
    const auto order = has_pressure(body) ? NodeOrder::by_distance : NodeOrder::of_mesh;
    const DealIiMesh mesh(body.mesh);
    system = assemble(without_pressure(body), mesh, degree, order);
    pressure = assemble_pressure(body, mesh, system);
}

Corners::Corners(const core::Body &body, SolverChoice choice, const Discretisation &matrices, int largest_factor) {
    const bool is_mixed = matrices.pressure.num_pressures() > 0;
    const bool is_large =
        matrices.system.nodes_per_cell > 4 && matrices.system.stiffness.num_rows() > largest_direct_quadratic_system;
    if (choice != SolverChoice::automatic || !(is_mixed || is_large))
        return;
    system = std::make_unique<ElasticSystem>(assemble(is_mixed ? without_pressure(body) : body, 1));
    const bool is_factored = system->stiffness.num_rows() <= largest_factor;
    solver = std::make_unique<ChosenSolver>(*system, is_factored ? SolverChoice::direct : SolverChoice::iterative);
}

} // namespace livermark::fem_reference
