#include "live/scene.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <numbers>
#include <utility>

#include "core/bounding_box.hpp"
#include "live/material.hpp"
#include "live/parameters.hpp"
#include "live/springs.hpp"
#include "support/input_error.hpp"

namespace livermark::live {

namespace {

constexpr int most_steps = 10000;
/// What the surface of a body resists for each metre that a probe is in it, in Young's moduli by the probe's radius.
constexpr double contact_stiffening = 20.0;
/// A tool of stiffness k at a node of mass m would ask for steps h with h^2 k / m < 4, which are shorter than the
/// body's. So the node gets some of the mass of the tool while it touches, and h^2 k over what is added is
constexpr double touched_part = 2.0;
/// And h^2 k over the mass of the tool itself is at most
constexpr double coupled_part = 0.5;
/// Where springs with an energy are pressed flatter than this, they get no stiffer: the guard is at work long before.
constexpr double least_stretch = 0.4;
/// A probe may be put down deep in the body: its pressure grows to what it should be in this time, so that it parts the
/// body and does not burst it [s].
constexpr double soft_start = 0.02;
constexpr double stiffest_grip = 2000.0; ///< [N/m]
/// Steps that are divided after something was pressed: to change their length at each oscillation would add energy.
constexpr int num_divided = 16;
/// The triangles near a probe are found again after so many steps; nothing moves further meanwhile than the margin.
constexpr int steps_between_searches = 8;
constexpr double search_margin = 0.008; ///< [m]
/// A body that has moved by so many times its size is lost.
constexpr double largest_motion = 1.0;

/// @param velocity  shape (3 N) [m/s]
double largest_speed(const Eigen::VectorXd &velocity) {
    double square = 0.0;
    for (Eigen::Index i = 0; i < velocity.size(); i += 3)
        square = std::max(square, velocity.segment<3>(i).squaredNorm());
    return std::sqrt(square);
}

} // namespace

Scene::Scene(core::Body body, const std::vector<bool> &is_constrained, int num_threads)
    : body_(std::move(body)), num_threads_(num_threads) {
    check_body(body_, is_constrained);
    surface_ = touchable_surface(body_.mesh, is_constrained);
    is_constrained_ = constrained_nodes(body_.mesh, is_constrained);
    tool_stiffness_.assign(body_.mesh.points.size(), 0.0);
    extent_ = core::extent(body_.mesh.points);
    load_ = no_load(surface_);
}

Chosen Scene::choose(const Settings &settings) {
    check_settings(settings);
    const auto body = with_material(body_, settings.young_modulus, settings.poisson_ratio);
    const auto parts = mass_springs(body, settings, springs_);
    const auto conditions = constrained_conditions(is_constrained_);
    const auto stepping = chosen_steps(body, parts, conditions, settings);
    const auto &chosen = stepping.chosen;

    auto next = msm::FastSteps::prepare(parts.body, body_.mesh.points, conditions, settings.damping, "symplectic_euler",
                                        chosen.time_step,
                                        {.precision = msm::ForcePrecision::single_precision,
                                         .num_threads = num_threads_,
                                         .scaling = stepping.scaling,
                                         .least_stretch = least_stretch,
                                         .watched_volume = watched_volumes(body, parts, conditions, stepping)});
    if (steps_)
        next->set_state(steps_->state());
    steps_ = std::move(next);
    node_mass_ = parts.body.node_mass;
    young_modulus_ = settings.young_modulus;
    time_step_ = chosen.time_step;
    num_parts_ = static_cast<int>(std::ceil(chosen.time_step / chosen.pressed_time_step - 1e-6));
    fit_tool();
    return chosen;
}

core::Vector3 Scene::position(int node) const {
    return body_.mesh.points[node] + steps_->displacement(node);
}

/// Begins with a tool where it differs from the one before.
void Scene::take_up(const Tool &tool) {
    const bool is_same = tool.kind == tool_.kind && tool.radius == tool_.radius &&
                         (tool.kind != ToolKind::pull || tool.node == tool_.node);
    tool_ = tool;
    if (is_same)
        return;
    take_load_off();
    tool_time_ = 0.0;
    num_touches_ = 0;
    divided_steps_ = num_divided; // it is not known yet how far it presses
    proxy_ = {.position = tool.target, .target = tool.target};
    if (tool.kind == ToolKind::pull) {
        grip_ = grip_around(surface_, body_.mesh.points, tool.node, tool.radius);
        proxy_.position = proxy_.target = mean_over(grip_, surface_, [&](int i) { return position(i); });
    }
    fit_tool();
}

/// How stiff the tool is.
void Scene::fit_tool() {
    std::ranges::fill(tool_stiffness_, 0.0);
    const double bearable = coupled_part * coupling_mass / (time_step_ * time_step_); // [N/m]
    if (tool_.kind == ToolKind::probe) {
        const double half_sphere = 2.0 * std::numbers::pi * tool_.radius * tool_.radius;
        contact_modulus_ = std::min(contact_stiffening * young_modulus_ / tool_.radius, bearable / half_sphere);
        for (const int node : surface_.nodes)
            tool_stiffness_[node] = contact_modulus_ * surface_.nodal_area[node];
    }
    if (tool_.kind == ToolKind::pull) {
        auto unit = no_load(surface_);
        add_pull(grip_, surface_, core::Vector3::UnitX(), unit);
        grip_stiffness_ = std::min(stiffest_grip, bearable);
        for (const int node : unit.nodes)
            tool_stiffness_[node] = grip_stiffness_ * unit.nodal[node].x();
    }
}

/// The forces of the tool, from where the body is now.
/// @param part  of a step that they are for [s]
void Scene::touch(double part) {
    const auto before = load_.nodes;
    clear(load_);
    const auto position_of = [&](int node) { return position(node); };
    tool_time_ += part;
    if (tool_.kind == ToolKind::probe) {
        const Sphere sphere{proxy_.position, tool_.radius};
        if (num_touches_++ % steps_between_searches == 0)
            near_ = near_triangles(surface_, sphere, search_margin, position_of);
        const double modulus = contact_modulus_ * std::min(1.0, tool_time_ / soft_start);
        add_contact(surface_, near_, sphere, modulus, position_of, load_);
    } else {
        const core::Vector3 gripped = mean_over(grip_, surface_, position_of);
        add_pull(grip_, surface_, grip_stiffness_ * (proxy_.position - gripped), load_);
    }
    for (const int node : before)
        if (load_.nodal[node].isZero(0.0)) {
            steps_->set_load(node, core::Vector3::Zero());
            steps_->set_mass(node, node_mass_[node]);
        }
    carry_load(part);
}

/// Puts the load on the nodes, and what of the tool's mass they move with.
void Scene::carry_load(double part) {
    for (const int node : load_.nodes) {
        steps_->set_load(node, load_.nodal[node]);
        steps_->set_mass(node, node_mass_[node] + part * part * tool_stiffness_[node] / touched_part);
    }
}

/// @param part  that is moved on by [s]
void Scene::step(const core::Vector3 &goal, double part) {
    if (tool_.kind != ToolKind::none) {
        follow(proxy_, goal, part);
        touch(part);
        advance(proxy_, -load_.total, part);
    }
    steps_->set_time_step(part);
    steps_->take(1);
    if (steps_->is_pressed())
        divided_steps_ = num_divided;
    ++num_evaluations_;
}

core::Vector3 Scene::feel(const Tool &tool, int num_steps) {
    if (!steps_)
        throw support::InputError("nothing has been chosen yet that could move; choose springs first");
    if (num_steps < 0 || num_steps > most_steps)
        throw support::InputError(fmt::format("{} steps at once; ask for 0 to {}", num_steps, most_steps));
    check_tool(tool, surface_);
    take_up(tool);
    // What a pull draws to its target is the node; the rest of what it holds stays around it.
    const core::Vector3 goal = tool.kind == ToolKind::pull
                                   ? core::Vector3(tool.target + grip_.rest - body_.mesh.points[tool.node])
                                   : tool.target;
    for (int i = 0; i < num_steps; ++i) {
        const int parts = divided_steps_ > 0 ? num_parts_ : 1;
        divided_steps_ = std::max(0, divided_steps_ - 1);
        for (int k = 0; k < parts; ++k)
            step(goal, time_step_ / parts);
    }
    time_ += num_steps * time_step_;
    return -load_.total;
}

Frame Scene::move(const Tool &tool, int num_steps) {
    feel(tool, num_steps);
    return frame();
}

Frame Scene::frame() {
    auto state = steps_->state();
    if (is_lost(state)) {
        reset();
        ++restarts_;
        state = steps_->state();
    }
    Frame frame;
    frame.time = time_;
    frame.tool = proxy_.position;
    frame.force = -load_.total;
    frame.largest_speed = largest_speed(state.velocity);
    if (tool_.kind != ToolKind::none)
        frame.largest_speed = std::max(frame.largest_speed, proxy_.velocity.norm());
    frame.restarts = restarts_;
    frame.displacement = msm::to_field(state.displacement);
    frame.smallest_volume = smallest_volume_ratio(body_.mesh, frame.displacement);
    frame.indentation = indentation(load_, frame.displacement);
    frame.load = load_;
    frame.surface = &surface_;
    return frame;
}

bool Scene::is_lost(const msm::State &state) const {
    // Written so that what is no number counts as lost.
    return !(state.displacement.lpNorm<Eigen::Infinity>() < largest_motion * extent_ && state.velocity.allFinite() &&
             proxy_.position.allFinite());
}

void Scene::take_load_off() {
    for (const int node : load_.nodes) {
        steps_->set_load(node, core::Vector3::Zero());
        steps_->set_mass(node, node_mass_[node]);
    }
    clear(load_);
}

void Scene::reset() {
    kept_.reset();
    if (!steps_)
        return;
    const auto size = static_cast<Eigen::Index>(3 * body_.mesh.points.size());
    take_load_off();
    steps_->set_state({Eigen::VectorXd::Zero(size), Eigen::VectorXd::Zero(size)});
    tool_ = {};
    proxy_ = {};
    divided_steps_ = 0;
}

void Scene::keep() {
    if (!steps_)
        throw support::InputError("nothing has been chosen yet that could be kept; choose springs first");
    kept_ = {.state = steps_->state(),
             .tool = tool_,
             .proxy = proxy_,
             .grip = grip_,
             .load = load_,
             .tool_time = tool_time_,
             .divided_steps = divided_steps_};
    // The digits of both parts of a number may be more than a double has: from here on it moves as when it is restored.
    steps_->set_state(kept_->state);
}

void Scene::restore() {
    if (!steps_ || !kept_)
        throw support::InputError("no state is kept that one could go back to; take a tool first");
    take_load_off();
    steps_->set_state(kept_->state);
    tool_ = kept_->tool;
    proxy_ = kept_->proxy;
    grip_ = kept_->grip;
    load_ = kept_->load;
    tool_time_ = kept_->tool_time;
    num_touches_ = 0;
    divided_steps_ = kept_->divided_steps;
    // The time step may be another one by now.
    fit_tool();
    carry_load(time_step_);
}

} // namespace livermark::live
