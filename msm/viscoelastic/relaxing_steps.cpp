#include "msm/viscoelastic/relaxing_steps.hpp"

#include <cmath>
#include <utility>

namespace livermark::msm {

RelaxingSteps::RelaxingSteps(RelaxingBody body, const std::vector<core::Vector3> &positions,
                             const NodalConditions &conditions, const core::RayleighDamping &damping, double time_step)
    : body_(std::move(body)), rest_(to_unknowns(positions)), load_(to_unknowns(conditions.force)), free_(rest_.size()),
      free_per_mass_(rest_.size()), damping_(damping), time_step_(time_step) {
    for (std::size_t i = 0; i < positions.size(); ++i)
        for (int c = 0; c < 3; ++c) {
            const auto at = 3 * static_cast<Eigen::Index>(i) + c;
            free_[at] = std::isnan(conditions.displacement[i][c]) ? 1.0 : 0.0;
            free_per_mass_[at] = free_[at] / body_.instant().node_mass[i];
        }
}

void RelaxingSteps::take(State &state, int num_steps) {
    auto &[displacement, velocity] = state;
    Eigen::VectorXd x = rest_ + displacement, force;
    for (int s = 0; s < num_steps; ++s) {
        force = load_;
        body_.add_force(x, velocity, damping_.beta, force);
        velocity += time_step_ * (force.cwiseProduct(free_per_mass_) - damping_.alpha * velocity.cwiseProduct(free_));
        displacement += time_step_ * velocity;
        x = rest_ + displacement;
        body_.go_on(x, time_step_);
    }
}

} // namespace livermark::msm
