#pragma once

#include <vector>

namespace livermark::msm {

/// How a stage of a Runge-Kutta-Chebyshev method comes from those before. For y' = f(y), with the stages as differences
/// D_j = Y_j - y_0 from where the step starts, D_0 = 0, and F_j = f(Y_j),
///     D_1 = mu~_1 h F_0,   D_j = mu_j D_(j-1) + nu_j D_(j-2) + mu~_j h F_(j-1) + gamma~_j h F_0.
struct ChebyshevStage {
    double mu, nu;                ///< 0 for the first
    double mu_tilde, gamma_tilde; ///< gamma~_1 = 0
    double time;                  ///< c_j: stage j stands at t_0 + c_j h; 1 for the last
};

/// The method of second order of Sommeijer, Shampine, Verwer 1998, J. Comput. Appl. Math. 88. Its stability polynomial
/// is R(z) = 1 - b_s T_s(w_0) + b_s T_s(w_0 + w_1 z), with w_0 = 1 + epsilon / s^2, w_1 = T_s'(w_0) / T_s''(w_0) and
/// b_s = T_s''(w_0) / T_s'(w_0)^2: stable on the real axis from z = -(w_0 + 1) / w_1 to 0, which is about 2/3 (s^2 - 1)
/// (1 - 2/15 epsilon) long.
/// @param num_stages  s >= 2
/// @param epsilon     > 0; the larger, the wider is the region of stability around the negative real axis, and the
///   shorter
/// @return stages 1 to s
std::vector<ChebyshevStage> chebyshev_stages(int num_stages, double epsilon);

/// Those of the integrator runge_kutta_chebyshev.
std::vector<ChebyshevStage> chebyshev_stages(int num_stages);

/// A step gets longer with s^2, until it is so long that accuracy limits it: on livers with tumours, of 5 to 20 stages
/// these need the fewest forces for an error of 3e-4 of the motion.
inline constexpr int usual_num_stages = 8;

} // namespace livermark::msm
