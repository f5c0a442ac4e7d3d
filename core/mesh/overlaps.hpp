#pragma once

#include <array>
#include <functional>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"

namespace livermark::core {

/// Two nodes in one place, to within 1e-9 of the extent of all; nothing if there are none.
/// @param is_meant  whether two of them may be, as on both sides of a cut; none may if it is empty
std::optional<std::pair<int, int>> nodes_in_one_place(std::span<const Vector3> points,
                                                      const std::function<bool(int, int)> &is_meant = {});

/// Two tetrahedra of the same nodes, the first in front; nothing if there are none.
std::optional<std::pair<int, int>> tetrahedra_of_same_nodes(std::span<const std::array<int, 4>> tetrahedra);

} // namespace livermark::core
