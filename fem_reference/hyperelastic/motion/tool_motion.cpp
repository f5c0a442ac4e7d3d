#include "fem_reference/hyperelastic/motion/tool_motion.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <utility>

#include "fem_reference/dof_conditions.hpp"
#include "fem_reference/hyperelastic/elements.hpp"
#include "fem_reference/hyperelastic/motion/energy_momentum.hpp"

namespace livermark::hyperelastic {

namespace {

using fem_reference::DofConditions;
using fem_reference::ElasticSystem;

/// What is prescribed along the way, at all unknowns.
class Way {
  public:
    Way(const core::LoadCase &load_case, const ElasticSystem &system)
        : pressed_(fem_reference::dof_conditions(load_case, system)),
          slid_(fem_reference::dof_conditions(core::with_slide(load_case), system).prescribed),
          tool_(load_case.tool.value()) {}

    std::vector<double> at(double time) const {
        const auto position = core::tool_position(tool_, time);
        std::vector<double> target(slid_.size(), 0.0);
        for (std::size_t dof = 0; dof < target.size(); ++dof)
            if (is_tool(dof))
                target[dof] = position.pressed * pressed_.prescribed[dof] + position.slid * slid_[dof];
        return target;
    }

    /// The sum of forces at the nodes of the place.
    core::Vector3 sum(const std::vector<double> &force) const {
        core::Vector3 sum = core::Vector3::Zero();
        for (std::size_t dof = 0; dof < force.size(); ++dof)
            if (is_tool(dof))
                sum[static_cast<Eigen::Index>(dof % 3)] += force[dof];
        return sum;
    }

  private:
    bool is_tool(std::size_t dof) const { return pressed_.constraint[dof] == tool_.constraint; }

    DofConditions pressed_;
    std::vector<double> slid_;
    core::ToolMotion tool_;
};

std::vector<bool> free_dofs(const core::LoadCase &load_case, const ElasticSystem &system) {
    std::vector<bool> is_free;
    for (const double value : fem_reference::dof_conditions(load_case, system).prescribed)
        is_free.push_back(std::isnan(value));
    return is_free;
}

/// About what a tool presses with: Young's modulus times its size and its depth.
double order_of_force(const core::Body &body, const core::LoadCase &load_case) {
    double area = 0.0, modulus = 0.0;
    if (const auto &ball = load_case.touching)
        area = std::numbers::pi * ball->radius * ball->press.norm();
    for (int f = 0; f < body.mesh.num_boundary_triangles(); ++f)
        if (load_case.constraint_on(f) == load_case.tool->constraint)
            area += core::area_vector(body.mesh, f).norm();
    for (const auto &material : body.materials)
        modulus = std::max(modulus, material.young_modulus);
    return modulus * std::sqrt(area) * load_case.target_peak_displacement;
}

} // namespace

core::ToolHistory move_tool(const core::Problem &problem, const MaterialLaw &law, int degree, int steps_per_frame,
                            TetrahedronRule rule_of_quadratic) {
    const auto &load_case = problem.load_case;
    if (!load_case.tool || steps_per_frame < 1)
        throw std::invalid_argument("a tool moves in a load case that has one, in a step or more per frame");
    const auto &tool = *load_case.tool;
    const auto rule = degree == 1 ? TetrahedronRule::one_point : rule_of_quadratic;
    const Elements elements(problem.body, degree, fem_reference::Formulation::displacement, law, rule);
    const auto &system = elements.system();
    const Way way(load_case, system);
    const core::RayleighDamping damping{.alpha = tool.mass_damping, .beta = 0.0};
    const double force = order_of_force(*problem.body, load_case);
    std::optional<EnergyMomentum> steps(std::in_place, elements, rule, free_dofs(load_case, system), damping, force);
    const std::vector<double> load(static_cast<std::size_t>(elements.num_displacements()), 0.0);
    fem_reference::Motion motion{load, load};
    std::optional<TouchingBall> ball;
    if (load_case.touching) {
        ball.emplace(system, *problem.body, load_case);
        steps->touch_with(&*ball);
    }
    const auto centre_at = [&](double time) {
        if (!ball)
            return core::Vector3(core::Vector3::Zero());
        const auto position = core::tool_position(tool, time);
        return core::Vector3(ball->tool().start + position.pressed * ball->tool().press + position.slid * tool.slide);
    };
    const auto force_on_tool = [&] {
        return ball ? core::Vector3(-steps->force_of_ball())
                    : core::Vector3(-way.sum(elements.internal_forces({motion.displacement, {}}).force));
    };
    core::ToolHistory history;
    const int last_held = core::last_record_held(tool);
    const auto record = [&](int frame) {
        history.time.push_back(tool.time_of(frame));
        history.force.emplace_back(frame <= last_held ? force_on_tool() : core::Vector3(core::Vector3::Zero()));
        if (core::ToolHistory::has_field(frame))
            for (const int node : system.mesh_node)
                history.displacement.emplace_back(core::Vector3::Map(&motion.displacement[3 * node]).cast<float>());
    };
    record(0);
    const double time_step = tool.frame_interval / steps_per_frame;
    for (int frame = 1; frame <= tool.num_frames; ++frame) {
        const double start = tool.time_of(frame - 1);
        if (frame == last_held + 1)
            steps.emplace(elements, rule, free_dofs(core::let_go(load_case), system), damping, force);
        for (int step = 1; step <= steps_per_frame; ++step) {
            const double end = start + step * time_step;
            const auto target = frame > last_held ? std::vector<double>{} : way.at(end);
            if (!steps->advance(motion, load, time_step, target, {centre_at(end - time_step), centre_at(end)}))
                return history;
        }
        record(frame);
    }
    return history;
}

} // namespace livermark::hyperelastic
