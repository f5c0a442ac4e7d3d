#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace livermark::interactive {

/// Weights of Chebyshev's semi-iterative method, which accelerates iterations x <- g(x) that converge linearly:
///     x_n = omega_n (g(x_{n-1}) - x_{n-2}) + x_{n-2},   omega_1 = 1, omega_2 = 2 / (2 - rho^2),
///     omega_n = 4 / (4 - rho^2 omega_{n-1}).
/// A part that has the factor s in an iteration is left with T_n(s / rho) / T_n(1 / rho) after n of them, T_n being the
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

namespace livermark::interactive::kernels {

/// Sorts each window of so many items by itself, so that they stay near where they are.
template <class T, class Less> void sort_in_windows_of(std::size_t window, std::vector<T> &items, const Less &less) {
    for (std::size_t first = 0; first < items.size(); first += window)
        std::stable_sort(items.begin() + static_cast<std::ptrdiff_t>(first),
                         items.begin() + static_cast<std::ptrdiff_t>(std::min(first + window, items.size())), less);
}

/// Tetrahedra around an edge, each of which shares a face with the next: tetrahedron k has the nodes of the axis, rim k
/// and rim k + 1. So each but the first brings one new node.
struct Fan {
    std::array<int, 2> axis{};
    std::vector<int> rim;        ///< (m + 1) nodes; the first and the last are the same where the fan is closed
    std::vector<int> tetrahedra; ///< (m) numbers
};

/// Fans behind each other, in few arrays: a body has thousands of them.
class FanList {
  public:
    /// Behind all others.
    void add(const std::array<int, 2> &axis, std::span<const int> rim, std::span<const int> tetrahedra) {
        axis_.push_back(axis);
        rim_.insert(rim_.end(), rim.begin(), rim.end());
        tetrahedra_.insert(tetrahedra_.end(), tetrahedra.begin(), tetrahedra.end());
        start_.push_back(static_cast<int>(tetrahedra_.size()));
    }
    void reserve(std::size_t num_fans, std::size_t num_tetrahedra) {
        axis_.reserve(num_fans);
        start_.reserve(num_fans + 1);
        rim_.reserve(num_tetrahedra + num_fans);
        tetrahedra_.reserve(num_tetrahedra);
    }

    std::size_t size() const { return axis_.size(); }
    std::size_t num_tetrahedra() const { return tetrahedra_.size(); }
    /// Members of a fan, as those of Fan.
    const std::array<int, 2> &axis(std::size_t fan) const { return axis_[fan]; }
    std::span<const int> rim(std::size_t fan) const {
        return std::span(rim_).subspan(start_[fan] + fan, start_[fan + 1] - start_[fan] + 1);
    }
    std::span<const int> tetrahedra(std::size_t fan) const {
        return std::span(tetrahedra_).subspan(start_[fan], start_[fan + 1] - start_[fan]);
    }

  private:
    std::vector<std::array<int, 2>> axis_;
    std::vector<int> start_{0}; ///< of their tetrahedra, and the end; rims have one more node each
    std::vector<int> rim_, tetrahedra_;
};

/// Puts each tetrahedron into one fan, greedily: the longest fan that is left comes first, that of the first edge of
/// core::edge_table() among equals.
std::vector<Fan> cut_into_fans(const std::vector<std::array<int, 4>> &tetrahedra);

/// A node in a strip of triangles. Each but the first two ends a triangle with two nodes before it, which is none where
/// a strip begins anew.
struct StripNode {
    int node;
    int triangle; ///< its number, or -1 where there is none
    /// The triangle has the node before and the one that the triangle before began with, not that before that: of
    /// (a, b, c) the next one is (a, c, d), not (b, c, d).
    bool keeps_first;
};

/// The triangles as strips, one behind the other: each triangle shares an edge with the one before where that is
/// possible, so that it brings one new node. Greedily, as few strips as a walk from any of the triangles finds.
/// @param triangles  each edge in at most two of them
std::vector<StripNode> cut_into_strips(const std::vector<std::array<int, 3>> &triangles);

} // namespace livermark::interactive::kernels
