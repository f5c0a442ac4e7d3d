#pragma once

#include <array>
#include <functional>
#include <span>
#include <vector>

namespace livermark::core {

/// Parts of tetrahedra that hang together by faces.
/// @param are_joined  whether two with a common face hang together by it; all do if it is empty
/// @return shape (M) the part of each tetrahedron, numbered as their first tetrahedra come
std::vector<int> parts_by_faces(std::span<const std::array<int, 4>> tetrahedra,
                                const std::function<bool(int, int)> &are_joined = {});

} // namespace livermark::core
