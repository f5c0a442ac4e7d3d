#pragma once

#include <span>
#include <type_traits>
#include <vector>

#include "core/tool/needle/moving_needle.hpp"
#include "msm/elastic_body.hpp"
#include "msm/kernels/fast_steps.hpp"

namespace livermark::msm {

/// A needle in explicit steps of springs that no stepper takes.
class MovingNeedle : public core::MovingNeedle {
  public:
    /// @param mesh        at rest, where the springs are prepared
    /// @param node_mass   shape (N) [kg], those of the steps, not scaled ones
    /// @param conditions  of the steps; nodes that are constrained in all components take forces and do not move
    /// @throws std::invalid_argument if no point of the body is near a place
    MovingNeedle(const core::Needle &needle, const core::TetraMesh &mesh, const std::vector<double> &node_mass,
                 const NodalConditions &conditions)
        : core::MovingNeedle(needle, mesh, inverse_masses(node_mass, conditions)) {}

    /// As of core::MovingNeedle.
    void begin(const FastSteps &steps) { core::MovingNeedle::begin(NodesOfSteps(steps)); }
    void act(FastSteps &steps, double depth, double time_step) {
        NodesOfSteps nodes(steps);
        core::MovingNeedle::act(nodes, depth, time_step);
    }
    core::Vector3 target_displacement(const FastSteps &steps) const {
        return core::MovingNeedle::target_displacement(NodesOfSteps(steps));
    }
    std::vector<core::Vector3> place_displacements(const FastSteps &steps) const {
        return core::MovingNeedle::place_displacements(NodesOfSteps(steps));
    }

  private:
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

    static std::vector<double> inverse_masses(const std::vector<double> &node_mass, const NodalConditions &conditions) {
        std::vector<double> per_mass;
        for (std::size_t node = 0; node < node_mass.size(); ++node)
            per_mass.push_back(conditions.constrains(node) ? 0.0 : 1.0 / node_mass[node]);
        return per_mass;
    }
};

} // namespace livermark::msm
