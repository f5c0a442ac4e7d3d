#pragma once

#include <array>
#include <span>
#include <vector>

namespace livermark::meshes {

/// Tetrahedra without which a piece would fall into parts of which two have more than one tetrahedron.
/// (J. Hopcroft and R. Tarjan 1973, Algorithm 447: efficient algorithms for graph manipulation, Comm. ACM 16(6))
/// @param piece       tetrahedra that hang together by faces
/// @param neighbours  (M, 4) by face, -1 for none
/// @param alive       (M) those that are still there
/// @return numbers of tetrahedra
std::vector<int> articulations(std::span<const int> piece, const std::vector<std::array<int, 4>> &neighbours,
                               const std::vector<bool> &alive);

} // namespace livermark::meshes
