#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/events.hpp"

namespace livermark::fem_reference {

/// A linear body that relaxes, in m coordinates c of its displacement u = sum_j c_j b_j:
///   V c + D (remaining c + sum_k w_k) = factor(t) f,   dw_k/dt + w_k / tau_k = g_k dc/dt,
/// with V and D the volumetric and the deviatoric part of its stiffness, and w_k what the branches remember. Both are
/// positive semidefinite, so that the reduced body is one itself: it stores energy and dissipates it.
struct ReducedBody {
    Eigen::MatrixXd volumetric, deviatoric; ///< (m, m) b_i^T V b_j and b_i^T D b_j [J]
    Eigen::VectorXd load;                   ///< (m) work of the whole given loads on each b_j [J]
    /// Whether b_0 is where the whole prescribed displacement or depth is, and all others are zero there: c_0 is the
    /// factor of the history then, and what that takes is a reaction.
    bool is_moved = false;
};

/// A time.
struct ReducedRecord {
    Eigen::VectorXd coordinates;           ///< (m) c
    Eigen::VectorXd relaxed;               ///< (m) remaining c + sum_k w_k: what D is multiplied by
    std::vector<Eigen::VectorXd> branches; ///< (B) of (m) w_k
    double stored_energy = 0.0;            ///< [J]
    double work = 0.0;              ///< done so far by all that drives the body, trapezoidal rule over the steps [J]
    double dissipated_energy = 0.0; ///< in all branches so far [J]
};

/// Follows a history, in which u is linear over steps: the error is of second order in them, and none where stresses
/// grow linearly.
/// @param steps_per_record  of equal length between two times, at least 1
/// @return shape (K)
std::vector<ReducedRecord> follow(const ReducedBody &body, const core::SlowHistory &history, int steps_per_record);

} // namespace livermark::fem_reference
