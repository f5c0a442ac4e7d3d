#pragma once

#include <memory>

#include "msm/elastic_body.hpp"

namespace livermark::msm {

/// What terms can do whose forces take long: work out once what depends on where the body is and not on how it moves.
class FixableTerm {
  public:
    virtual ~FixableTerm() = default;

    /// The same term where the body stays: add_force() gives the same bits in less time. To be asked at no other
    /// positions.
    /// @param x  shape (3N) [m]
    virtual std::shared_ptr<const ElasticTerm> fixed_at(const Eigen::VectorXd &x) const = 0;
};

} // namespace livermark::msm
