#pragma once

#include <Eigen/Core>
#include <utility>

#include "msm/statics/conjugate_gradients.hpp"

namespace livermark::msm {

/// A load of which the direction f is known and the amount is a result, because f . u is prescribed: what it takes to
/// stay among the displacements that keep f . u.
class PressedLoad {
  public:
    /// @param unit  f of the free components; empty where no place presses, and nothing is changed then
    explicit PressedLoad(Eigen::VectorXd unit) : unit_(std::move(unit)) {}

    bool is_there() const { return unit_.size() > 0; }
    const Eigen::VectorXd &unit() const { return unit_; }

    /// The amount that leaves least of an elastic force.
    double amount_in(const Eigen::VectorXd &elastic) const { return elastic.dot(unit_) / unit_.squaredNorm(); }

    /// A force without its part along f, which whoever presses takes.
    Eigen::VectorXd without(Eigen::VectorXd force) const {
        if (is_there())
            force -= amount_in(force) * unit_;
        return force;
    }

    /// An inverse times a vector, without what changes f . u; of multiples of f nothing is left.
    Eigen::VectorXd step(const LinearMap &inverse, const Eigen::VectorXd &vector) const {
        Eigen::VectorXd step = inverse(vector);
        if (is_there()) {
            const Eigen::VectorXd along = inverse(unit_);
            step -= unit_.dot(step) / unit_.dot(along) * along;
        }
        return step;
    }

  private:
    Eigen::VectorXd unit_;
};

} // namespace livermark::msm
