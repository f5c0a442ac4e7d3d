#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <deque>

#include "msm/statics/conjugate_gradients.hpp"

namespace livermark::msm {

/// What the last steps downhill say of the second derivative of an energy: a first inverse with their corrections of
/// rank two (limited-memory BFGS; the two loops of Nocedal 1980, Updating quasi-Newton matrices with limited storage,
/// Math. Comput. 35).
class LimitedMemory {
  public:
    /// @param most_steps  that are remembered
    explicit LimitedMemory(std::size_t most_steps) : most_steps_(most_steps) {}

    /// The corrected inverse times a vector.
    /// @param first  positive definite
    Eigen::VectorXd times(const LinearMap &first, Eigen::VectorXd vector) const;

    /// Learns from a step and the change of the gradient on it. Where the energy bends downwards there is nothing to be
    /// learnt for an inverse that is to stay positive definite.
    void learn(Eigen::VectorXd step, Eigen::VectorXd change);

  private:
    struct Pair {
        Eigen::VectorXd step, change;
        double curvature;
    };
    std::size_t most_steps_;
    std::deque<Pair> pairs_;
};

} // namespace livermark::msm
