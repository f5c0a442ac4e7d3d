#pragma once

namespace livermark::interactive {

/// Weights of Chebyshev's semi-iterative method, which accelerates iterations x <- g(x) that converge linearly:
///     x_n = omega_n (g(x_{n-1}) - x_{n-2}) + x_{n-2},   omega_1 = 1, omega_2 = 2 / (2 - rho^2),
///     omega_n = 4 / (4 - rho^2 omega_{n-1}).
/// What has the factor s in an iteration is left with T_n(s / rho) / T_n(1 / rho) after n of them, T_n being the
/// polynomials of Chebyshev: at most 1 / T_n(1 / rho) where |s| <= rho.
/// (Wang 2015, A Chebyshev semi-iterative approach for accelerating projective and position-based dynamics, ACM TOG
/// 34(6), eq. 8)
/// @param iteration    n, from 1 on
/// @param last_weight  omega_{n-1}
double chebyshev_weight(int iteration, double last_weight, double rho);

/// The rho for all iterations of a step of backward Euler that begin where velocities lead: 0.95, less where they are
/// so few that steps were unstable. A stiff part of which P is left in each step goes from x_n to
/// x_{n+1} = P (2 x_n - x_{n-1}), which grows where P < -1/3. Here |P| <= 0.1 for whatever has |s| <= rho, less than a
/// third because iterations on one node after another are not symmetric, and turn parts into each other.
double chebyshev_rho(int num_iterations);

} // namespace livermark::interactive
