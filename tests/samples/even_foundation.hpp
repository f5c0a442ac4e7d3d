#pragma once

#include <utility>
#include <vector>

#include "core/events.hpp"

namespace livermark::tests {

/// Springs that are the same below all facets.
inline core::Foundation even_foundation(std::vector<int> facets, double stiffness, bool normal_only) {
    const auto num_facets = facets.size();
    return {.facets = std::move(facets),
            .stiffness = std::vector<double>(num_facets, stiffness),
            .normal_only = std::vector<int>(num_facets, normal_only ? 1 : 0)};
}

} // namespace livermark::tests
