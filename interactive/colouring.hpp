#pragma once

#include <span>
#include <vector>

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

/// Groups, so that no two of one group share a node: the order in which constraints or nodes can be visited in
/// parallel, and in which Gauss-Seidel iterations visit them here.
struct Colouring {
    std::vector<int> order;   ///< (M) what is coloured, colour after colour
    std::vector<int> offsets; ///< (K+1) where each colour begins in order, and the end

    int num_colours() const { return static_cast<int>(offsets.size()) - 1; }
};

/// The groups of given colours.
/// @param colour  (M) from 0 on, of each
Colouring by_colours(const std::vector<int> &colour);

/// The colour of each, the other way round.
/// @return (M)
std::vector<int> colours_of(const Colouring &colouring);

/// Gives each, in its order, the first colour that none of its neighbours has.
/// @param neighbours  (M) of each; symmetric
Colouring colour_greedily(const std::vector<std::vector<int>> &neighbours);

/// Colours sets of nodes, such as edges or tetrahedra; those that share a node differ.
/// @param sets       (M) node numbers
/// @param num_nodes  N, more than any of them
Colouring colour_sets(std::span<const std::vector<int>> sets, int num_nodes);

/// Colours nodes; those of one set differ.
Colouring colour_nodes(std::span<const std::vector<int>> sets, int num_nodes);

} // namespace livermark::interactive
