#include "msm/calibration.hpp"

#include <Eigen/CholmodSupport>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <nlopt.h>

#include "msm/elastic_body.hpp"
#include "support/factors/blas_memory.hpp"
#include "support/factors/orderings.hpp"
#include "support/openmp.hpp"

namespace livermark::msm {

namespace {

Eigen::VectorXd logarithms(const std::vector<double> &values) {
    return Eigen::VectorXd::Map(values.data(), static_cast<Eigen::Index>(values.size())).array().log();
}

/// Row s takes displacements of the free components to the extension of spring s.
Eigen::SparseMatrix<double> extension_matrix(const CalibrationTask &task, const FreeComponents &free) {
    const auto num_springs = static_cast<Eigen::Index>(task.springs.edges.size());
    std::vector<Eigen::Triplet<double>> entries;
    for (Eigen::Index s = 0; s < num_springs; ++s) {
        const auto [i, j] = task.springs.edges[s];
        const core::Vector3 direction = (task.points[j] - task.points[i]).normalized();
        for (int c = 0; c < 3; ++c) {
            if (const auto at = free.number(3 * static_cast<Eigen::Index>(i) + c); at >= 0)
                entries.emplace_back(s, at, -direction[c]);
            if (const auto at = free.number(3 * static_cast<Eigen::Index>(j) + c); at >= 0)
                entries.emplace_back(s, at, direction[c]);
        }
    }
    Eigen::SparseMatrix<double> extension(num_springs, free.size());
    extension.setFromTriplets(entries.begin(), entries.end());
    return extension;
}

/// What NLopt's callback needs.
struct Search {
    CalibrationObjective *objective;
    const std::function<void(const CalibrationState &)> *observe;
    nlopt_opt optimiser;
    /// The first step of L-BFGS is the gradient, so J is scaled to make that a change of a spring by a tenth at most.
    double scale = 0.0;
    double best = std::numeric_limits<double>::infinity();
    Eigen::VectorXd best_point;
};

double evaluate_for_nlopt(unsigned num_springs, const double *point, double *gradient, void *data) {
    auto &search = *static_cast<Search *>(data);
    const Eigen::VectorXd log_stiffness = Eigen::VectorXd::Map(point, num_springs);
    const auto state = search.objective->evaluate(log_stiffness);
    if (*search.observe)
        (*search.observe)(state);
    if (!std::isfinite(state.objective)) {
        nlopt_force_stop(search.optimiser);
        return state.objective;
    }
    if (state.objective < search.best) {
        search.best = state.objective;
        search.best_point = log_stiffness;
    }
    const double largest = state.gradient.cwiseAbs().maxCoeff();
    if (search.scale == 0.0)
        search.scale = largest > 0.0 ? 0.1 / largest : 1.0;
    if (gradient)
        Eigen::VectorXd::Map(gradient, num_springs) = search.scale * state.gradient;
    return search.scale * state.objective;
}

} // namespace

struct CalibrationObjective::Factor {
    Eigen::CholmodSupernodalLLT<Eigen::SparseMatrix<double>> solver;
    bool is_analysed = false;
};

CalibrationObjective::~CalibrationObjective() = default;

CalibrationObjective::CalibrationObjective(const CalibrationTask &task)
    : free_(task.constrained), extension_(extension_matrix(task, free_)), other_(free_.restrict(task.other_stiffness)),
      num_training_(static_cast<Eigen::Index>(task.training.size())), penalty_(task.penalty),
      start_(logarithms(task.springs.stiffness)), factor_(std::make_unique<Factor>()) {
    support::keep_openmp_in_this_thread();
    std::vector<core::Vector3> volume;
    for (const double value : task.nodal_volume)
        volume.emplace_back(core::Vector3::Constant(value));
    volume_ = free_.gather(volume);
    const auto num_loads = num_training_ + static_cast<Eigen::Index>(task.held_out.size());
    force_.resize(free_.size(), num_loads);
    wanted_.resize(free_.size(), num_loads);
    for (Eigen::Index l = 0; l < num_loads; ++l) {
        const auto &solution = l < num_training_ ? task.training[l] : task.held_out[l - num_training_];
        force_.col(l) = free_.gather(solution.force);
        wanted_.col(l) = free_.gather(solution.displacement);
    }
    wanted_square_ = wanted_.cwiseAbs2().transpose() * volume_;
    factor_->solver.cholmod().print = 0;
}

std::vector<double> CalibrationObjective::errors(const Eigen::MatrixXd &difference, Eigen::Index first,
                                                 Eigen::Index count) const {
    std::vector<double> errors;
    for (Eigen::Index l = first; l < first + count; ++l)
        errors.push_back(std::sqrt(volume_.dot(difference.col(l).cwiseAbs2()) / wanted_square_[l]));
    return errors;
}

CalibrationState CalibrationObjective::evaluate(const Eigen::VectorXd &log_stiffness) {
    CalibrationState state;
    const Eigen::VectorXd stiffness = log_stiffness.array().exp();
    const Eigen::SparseMatrix<double> scaled = stiffness.asDiagonal() * extension_;
    Eigen::SparseMatrix<double> matrix = extension_.transpose() * scaled;
    matrix += other_;
    auto &solver = factor_->solver;
    if (!factor_->is_analysed) {
        const auto lock = support::only_ordering();
        solver.analyzePattern(matrix);
    }
    factor_->is_analysed = true;
    const auto lock = support::only_in_blas();
    solver.factorize(matrix);
    if (solver.info() != Eigen::Success) {
        state.objective = std::numeric_limits<double>::infinity();
        return state;
    }
    const Eigen::MatrixXd displacement = solver.solve(force_);
    const Eigen::MatrixXd difference = displacement - wanted_;
    state.training_errors = errors(difference, 0, num_training_);
    state.held_out_errors = errors(difference, num_training_, force_.cols() - num_training_);

    const auto num_training = static_cast<double>(num_training_);
    const Eigen::VectorXd change = log_stiffness - start_;
    const double weight = penalty_ / static_cast<double>(change.size());
    state.objective = weight * change.squaredNorm();
    for (const double error : state.training_errors)
        state.objective += error * error / num_training;

    const Eigen::VectorXd factor = (0.5 * num_training * wanted_square_.head(num_training_)).cwiseInverse();
    const Eigen::MatrixXd slope = volume_.asDiagonal() * difference.leftCols(num_training_) * factor.asDiagonal();
    const Eigen::MatrixXd adjoint = solver.solve(slope);
    const Eigen::MatrixXd extensions = extension_ * displacement.leftCols(num_training_);
    const Eigen::MatrixXd adjoint_extensions = extension_ * adjoint;
    state.gradient =
        2.0 * weight * change - stiffness.cwiseProduct(extensions.cwiseProduct(adjoint_extensions).rowwise().sum());
    return state;
}

std::vector<double> calibration_round(CalibrationObjective &objective, const std::vector<double> &stiffness,
                                      int num_iterations, double widest,
                                      const std::function<void(const CalibrationState &)> &observe) {
    constexpr unsigned memory = 20;
    const auto num_springs = static_cast<unsigned>(stiffness.size());
    const std::unique_ptr<nlopt_opt_s, void (*)(nlopt_opt)> optimiser(nlopt_create(NLOPT_LD_LBFGS, num_springs),
                                                                      nlopt_destroy);
    Search search{.objective = &objective, .observe = &observe, .optimiser = optimiser.get(), .best_point = {}};
    const Eigen::VectorXd lower = objective.start().array() - std::log(widest);
    const Eigen::VectorXd upper = objective.start().array() + std::log(widest);
    nlopt_set_lower_bounds(optimiser.get(), lower.data());
    nlopt_set_upper_bounds(optimiser.get(), upper.data());
    nlopt_set_maxeval(optimiser.get(), num_iterations);
    nlopt_set_vector_storage(optimiser.get(), memory);
    nlopt_set_min_objective(optimiser.get(), evaluate_for_nlopt, &search);
    // A stiffness at its bound may be beyond it by the rounding of the logarithm.
    Eigen::VectorXd point = logarithms(stiffness).cwiseMax(lower).cwiseMin(upper);
    double value = 0.0;
    // Its status only says why it stopped. Any reason is good: the best point is kept here.
    nlopt_optimize(optimiser.get(), point.data(), &value);
    if (search.best_point.size() == 0)
        return stiffness;
    const Eigen::VectorXd best = search.best_point.array().exp();
    return {best.begin(), best.end()};
}

} // namespace livermark::msm
