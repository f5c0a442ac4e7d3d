#pragma once

#include <span>
#include <vector>

namespace livermark::interactive {

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
