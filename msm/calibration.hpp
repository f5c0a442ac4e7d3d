#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <functional>
#include <memory>
#include <vector>

#include "core/solution.hpp"
#include "msm/statics/free_components.hpp"

/// Stiffnesses of springs fitted to given solutions.
///
/// The body is linearised at rest, K(k) = sum over springs s of k_s b_s b_s^T + K_0, and what is constrained does not
/// move. Of each load l the solution r_l is given, and the stiffnesses minimise
///   J = 1/L sum_l e_l^2 + p 1/S sum_s (ln k_s / k0_s)^2,   e_l^2 = sum_i V_i |u_i - r_i|^2 / sum_i V_i |r_i|^2
/// over ln k, so that they stay positive and a spring may be halved as easily as doubled. With the adjoint K lambda_l =
/// dJ/du_l the gradient costs one solve for each load, with the factor that is there already:
///   dJ/d ln k_s = - k_s sum_l (b_s . lambda_l)(b_s . u_l) + 2 p / S ln k_s / k0_s
/// (Givoli 2021, Comput. Methods Appl. Mech. Engrg. 380, 113810: a tutorial on the adjoint method.)
namespace livermark::msm {

/// A load, and where it is to take the nodes.
struct ExpectedSolution {
    std::vector<core::Vector3> force;        ///< (N) [N]
    std::vector<core::Vector3> displacement; ///< (N) [m], zero where a component is constrained, not zero everywhere
};

struct CalibrationTask {
    std::vector<core::Vector3> points;           ///< (N) at rest [m]
    core::SpringNetwork springs;                 ///< with the stiffnesses k0 > 0 to start from
    Eigen::SparseMatrix<double> other_stiffness; ///< K_0: the rest of the body, shape (3N, 3N) [N/m]
    std::vector<core::Vector3> constrained;      ///< (N) 0 where a component is constrained [m], NaN where it is free
    std::vector<double> nodal_volume;            ///< V (N) [m^3]
    std::vector<ExpectedSolution> training;      ///< at least one; these make J
    std::vector<ExpectedSolution> held_out;      ///< these are looked at only
    double penalty = 0.0;                        ///< p, at least 0
};

/// What some stiffnesses are worth.
struct CalibrationState {
    double objective = 0.0;              ///< J; infinity where the body is not stiff in every direction
    Eigen::VectorXd gradient;            ///< (S) dJ/d ln k
    std::vector<double> training_errors; ///< e of each load
    std::vector<double> held_out_errors; ///< e of each load
};

/// J of one task. Keeps the symbolic factorisation.
class CalibrationObjective {
  public:
    explicit CalibrationObjective(const CalibrationTask &task);
    ~CalibrationObjective();
    CalibrationObjective(const CalibrationObjective &) = delete;
    CalibrationObjective &operator=(const CalibrationObjective &) = delete;

    /// One sparse Cholesky factorisation; then a solve for each load, and another for each training load.
    /// @param log_stiffness  shape (S), ln of k [N/m]
    CalibrationState evaluate(const Eigen::VectorXd &log_stiffness);

    /// ln k0
    const Eigen::VectorXd &start() const { return start_; }

  private:
    /// @param columns  the first and how many
    std::vector<double> errors(const Eigen::MatrixXd &difference, Eigen::Index first, Eigen::Index count) const;

    FreeComponents free_;
    Eigen::SparseMatrix<double> extension_; // (S, F) rows b_s
    Eigen::SparseMatrix<double> other_;     // (F, F) K_0
    Eigen::VectorXd volume_;                // (F) V of the node
    Eigen::MatrixXd force_;                 // (F, L) training loads first
    Eigen::MatrixXd wanted_;                // (F, L)
    Eigen::VectorXd wanted_square_;         // (L) sum_i V_i |r_i|^2
    Eigen::Index num_training_;
    double penalty_;
    Eigen::VectorXd start_;
    struct Factor;
    std::unique_ptr<Factor> factor_;
};

/// A round of the minimisation: L-BFGS (NLopt) with every k between k0 / widest and k0 widest. It begins without a
/// memory of earlier rounds, so rounds can be run now or later with the same outcome, to the last bit.
/// @param stiffness       shape (S) [N/m], within the bounds
/// @param num_iterations  how often J is evaluated at most, >= 1
/// @param widest          > 1
/// @param observe         called with every evaluation
/// @return the best stiffnesses that were met, shape (S) [N/m]; those it began with if none was better
std::vector<double> calibration_round(CalibrationObjective &objective, const std::vector<double> &stiffness,
                                      int num_iterations, double widest,
                                      const std::function<void(const CalibrationState &)> &observe = {});

} // namespace livermark::msm
