#include "msm/step_parts.hpp"

#include <algorithm>

namespace livermark::msm {

std::optional<StepParts> step_parts(const ElasticBody &body) {
    StepParts parts;
    const bool are_known = std::ranges::all_of(body.terms, [&](const auto &term) { return term->describe(parts); });
    return are_known ? std::optional(std::move(parts)) : std::nullopt;
}

} // namespace livermark::msm
