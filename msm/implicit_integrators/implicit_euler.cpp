#include <Eigen/CholmodSupport>
#include <memory>

#include "core/support/processes/own_process.hpp"
#include "msm/integrator.hpp"

namespace livermark::msm::implicit_integrators {

namespace {

constexpr double tolerance = 1e-10; ///< of the velocity, relative
constexpr int max_iterations = 50;
/// A correction that is not this much smaller than the one before asks for a new factor.
constexpr double slow = 0.3;

/// u_1 = u_0 + h v_1, v_1 = v_0 + h a(u_1, v_1), by Newton's method. The factor of M + h D + h^2 K is kept from step to
/// step as long as it makes the corrections small quickly.
class ImplicitEuler {
  public:
    ImplicitEuler(const EquationOfMotion &equation, double h) : equation_(&equation), h_(h) {
        support::keep_openmp_in_this_thread();
        solver_->cholmod().print = 0;
    }

    void operator()(State &state) {
        const Eigen::VectorXd start_u = state.displacement, start_v = state.velocity;
        Eigen::VectorXd a(start_u.size());
        double last = 0.0;
        bool is_new = !factored_;
        if (is_new)
            factorise(start_u);
        for (int iteration = 0; iteration < max_iterations; ++iteration) {
            state.displacement = start_u + h_ * state.velocity;
            equation_->acceleration(state.displacement, state.velocity, a);
            const Eigen::VectorXd imbalance = equation_->mass.cwiseProduct(start_v + h_ * a - state.velocity);
            const Eigen::VectorXd correction = [&] {
                const auto lock = support::only_in_blas();
                return Eigen::VectorXd(solver_->solve(imbalance));
            }();
            state.velocity += correction;
            const double size = correction.norm();
            if (!(size > tolerance * state.velocity.norm()))
                break;
            if (iteration > 0 && size > slow * last && !is_new) {
                factorise(state.displacement);
                is_new = true;
            }
            last = size;
        }
        state.displacement = start_u + h_ * state.velocity;
    }

  private:
    void factorise(const Eigen::VectorXd &u) {
        const auto matrix = equation_->effective_mass(u, h_, h_ * h_);
        if (!factored_) {
            const auto lock = support::only_ordering();
            solver_->analyzePattern(matrix);
        }
        const auto lock = support::only_in_blas();
        solver_->factorize(matrix);
        factored_ = true;
    }

    const EquationOfMotion *equation_;
    double h_;
    bool factored_ = false;
    // Shared by copies of the step, as std::function wants to copy and the factor cannot be.
    std::shared_ptr<Eigen::CholmodSupernodalLLT<Eigen::SparseMatrix<double>>> solver_ =
        std::make_shared<Eigen::CholmodSupernodalLLT<Eigen::SparseMatrix<double>>>();
};

Step prepare(const EquationOfMotion &equation, double h) {
    return ImplicitEuler(equation, h);
}

} // namespace

Integrator implicit_euler() {
    return {.name = {},
            .summary =
                "implicit Euler with a factor that is kept: stable at every step, damps what it does not resolve",
            .source = "Baraff, Witkin 1998, Large steps in cloth simulation, SIGGRAPH 98",
            .is_explicit = false,
            .forces_per_step = 0,
            .prepare = prepare};
}

} // namespace livermark::msm::implicit_integrators
