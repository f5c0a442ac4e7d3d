#pragma once

#include <vector>

#include "core/problem.hpp"
#include "msm/nodal_conditions.hpp"

namespace livermark::msm {

/// Some tetrahedra of a body as a body of their own. It has no boundary triangles.
struct PartOfBody {
    core::Body body;
    std::vector<int> node;      ///< of each node of the part: its number in the whole body, ascending
    NodalConditions conditions; ///< of these; no loads
};

/// @param is_in       shape (M) which tetrahedra
/// @param conditions  of the whole body
PartOfBody part_of_body(const core::Body &body, const std::vector<char> &is_in, const NodalConditions &conditions);

} // namespace livermark::msm
