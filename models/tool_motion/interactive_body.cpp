#include <cmath>
#include <utility>

#include "interactive/method.hpp"
#include "models/tool_motion/contenders.hpp"
#include "models/tool_motion/tool_place.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/mass_lumping.hpp"

namespace livermark::models {

namespace {

using livermark::interactive::Field;
using livermark::interactive::Method;
using livermark::interactive::Scene;

class InteractiveBody : public MovingBody {
  public:
    InteractiveBody(Method method, const core::Problem &problem, Precision precision)
        : method_(std::move(method)), scene_{.body = problem.body,
                                             .node_mass = livermark::msm::lumped_masses(*problem.body),
                                             .constrained_nodes = {},
                                             .mass_damping = problem.load_case.tool.value().mass_damping,
                                             .precision = precision},
          place_(tool_place(problem, scene_.node_mass)) {
        scene_.constrained_nodes = place_.nodes; // first, so that their targets are
        scene_.constrained_nodes.insert(scene_.constrained_nodes.end(), place_.held.begin(), place_.held.end());
        simulation_ = method_.prepare(scene_);
    }

    void advance(double start, const Effort &effort) override {
        const double step = place_.motion.frame_interval / effort.steps;
        for (int s = 1; s <= effort.steps; ++s) {
            if (!has_let_go_)
                move_tool(start + s * step);
            simulation_->step(step, effort.iterations);
        }
    }

    void let_go() override {
        const Field positions = simulation_->positions(), velocities = simulation_->velocities();
        scene_.constrained_nodes = place_.held;
        simulation_ = method_.prepare(scene_);
        simulation_->set_state(positions, velocities);
        has_let_go_ = true;
    }

    std::vector<core::Vector3> displacement() const override {
        auto result = scene_.body->mesh.points;
        for (std::size_t i = 0; i < result.size(); ++i)
            result[i] = simulation_->positions().col(static_cast<Eigen::Index>(i)) - result[i];
        return result;
    }

    core::Vector3 tool_force() const override {
        if (has_let_go_)
            return core::Vector3::Zero();
        return -simulation_->reactions().leftCols(static_cast<Eigen::Index>(place_.nodes.size())).rowwise().sum();
    }

    FrameCost cost(const Effort &effort) const override {
        const auto cost = simulation_->cost(effort.iterations);
        return {cost.element_passes * effort.steps, cost.bytes_per_element};
    }

    std::optional<Effort> least_effort() const override {
        const double longest = livermark::msm::default_safety_factor * simulation_->critical_time_step();
        if (!std::isfinite(longest))
            return std::nullopt;
        return Effort{.iterations = static_cast<int>(std::ceil(place_.motion.frame_interval / longest))};
    }

  private:
    void move_tool(double time) {
        const auto position = core::tool_position(place_.motion, time);
        Field targets = simulation_->targets();
        for (std::size_t i = 0; i < place_.nodes.size(); ++i)
            targets.col(static_cast<Eigen::Index>(i)) =
                scene_.body->mesh.points[place_.nodes[i]] + place_.displacement(i, position);
        simulation_->set_targets(targets);
    }

    Method method_;
    Scene scene_;
    ToolPlace place_;
    std::unique_ptr<livermark::interactive::Simulation> simulation_;
    bool has_let_go_ = false;
};

} // namespace

std::vector<Contender> interactive_contenders(Precision precision) {
    std::vector<Contender> contenders;
    for (const auto &method : livermark::interactive::all_methods())
        contenders.push_back(
            {.name = method.name,
             .source = method.source,
             .implementation = precision == Precision::double_precision && !method.in_double.empty()
                                   ? method.in_double
                                   : method.implementation,
             .prepare = [method, precision](const core::Problem &problem) -> std::unique_ptr<MovingBody> {
                 return std::make_unique<InteractiveBody>(method, problem, precision);
             }});
    return contenders;
}

} // namespace livermark::models
