#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/problem.hpp"

namespace livermark::studies {

/// Numbers of problems with the same static solution.
using CaseGroup = std::vector<std::size_t>;

/// Problems of one body with the same static solution, which models keep: one after the other by one worker, so that
/// what is kept does not depend on how many there are.
struct CaseGroups {
    std::vector<CaseGroup> problems; ///< numbers of the problems of each group
    std::vector<int> body;           ///< of each group
};

/// Groups that constrain the same components of a body come one after the other: models keep the last factor. Bodies
/// come by their number of tetrahedra, the largest first: it would keep the others waiting at the end. What comes first
/// otherwise stays first.
CaseGroups case_groups_of(std::span<const core::Problem> problems);

/// Of each body with load cases that constrain all that another one constrains and more, the first problem whose
/// constrained components are constrained in most of them.
std::vector<core::Problem> most_shared(std::span<const core::Problem> problems);

} // namespace livermark::studies
