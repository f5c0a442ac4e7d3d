#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/problem.hpp"
#include "msm/elastic_body.hpp"

namespace livermark::msm {

/// A way in which a body resists changes of its volume, beside its springs. Central springs are a solid with the first
/// Lame parameter lambda = mu; a volume term with the modulus kappa = lambda - mu makes of it any other. One file each
/// in volume_terms/, named as the term.
struct VolumeTerm {
    std::string name;    ///< the file stem; set by the table
    std::string summary; ///< half a line, to be read after "with"
    std::string source;  ///< literature reference
    /// @param body     at rest, positive volumes
    /// @param modulus  kappa of each region, shape (R) [Pa]; negative where Poisson's ratio is below 1/4
    std::shared_ptr<const ElasticTerm> (*make)(const core::Body &body, const std::vector<double> &modulus);
};

/// Every term of volume_terms/, in alphabetical order.
std::span<const VolumeTerm> all_volume_terms();

} // namespace livermark::msm
