#include "msm/needle/moving_needle.hpp"

#include <span>
#include <type_traits>

namespace livermark::msm {

namespace {

std::vector<double> needle_per_mass(const std::vector<double> &node_mass, const NodalConditions &conditions) {
    std::vector<double> per_mass;
    for (std::size_t node = 0; node < node_mass.size(); ++node)
        per_mass.push_back(conditions.displacement[node].array().isNaN().any() ? 1.0 / node_mass[node] : 0.0);
    return per_mass;
}

/// @tparam Steps  FastSteps, or those that are read only
template <class Steps> class NodesOfSteps : public core::MovingNodes {
  public:
    explicit NodesOfSteps(Steps &steps) : steps_(steps) {}

    void displacements(std::span<const int> nodes, std::span<core::Vector3> found) const override {
        steps_.displacements(nodes, found);
    }
    void kick(std::span<const int> nodes, std::span<const core::Vector3> velocity, double time_step) override {
        if constexpr (!std::is_const_v<Steps>)
            steps_.kick(nodes, velocity, time_step);
    }

  private:
    Steps &steps_;
};

} // namespace

MovingNeedle::MovingNeedle(const core::Needle &needle, const core::TetraMesh &mesh,
                           const std::vector<double> &node_mass, const NodalConditions &conditions)
    : core::MovingNeedle(needle, mesh, needle_per_mass(node_mass, conditions)) {}

void MovingNeedle::begin(const FastSteps &steps) {
    core::MovingNeedle::begin(NodesOfSteps(steps));
}

void MovingNeedle::act(FastSteps &steps, double depth, double time_step) {
    NodesOfSteps nodes(steps);
    core::MovingNeedle::act(nodes, depth, time_step);
}

core::Vector3 MovingNeedle::target_displacement(const FastSteps &steps) const {
    return core::MovingNeedle::target_displacement(NodesOfSteps(steps));
}

std::vector<core::Vector3> MovingNeedle::place_displacements(const FastSteps &steps) const {
    return core::MovingNeedle::place_displacements(NodesOfSteps(steps));
}

} // namespace livermark::msm
