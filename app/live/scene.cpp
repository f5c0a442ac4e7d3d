#include "app/live/scene.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <utility>

#include "app/live/parameters.hpp"
#include "core/mesh/tetra_mesh.hpp"
#include "core/support/input_error.hpp"

namespace livermark::live {

namespace {

constexpr int most_steps = 10000;
/// Stiffness between a pull and what it holds, at most [N/m]: the strongest coupling draws a pull 6 mm from that.
constexpr double stiffest_grip = 2000.0;
/// A tool of stiffness k at a node of mass m would ask for steps h with h^2 k / m < 4, which are shorter than the
/// body's. So the node gets some of the mass of the tool while it is held, and h^2 k over what is added is
constexpr double touched_part = 2.0;
/// And h^2 k over the mass of the tool itself is at most
constexpr double coupled_part = 0.5;
/// Stretch below which springs with an energy get no stiffer: the guard is at work long before.
constexpr double least_stretch = 0.4;
/// Parts of the mean edge that each component of a node's motion is at most long in one step. Nothing that a hand does
/// is so fast but what snaps back from half the size of the body. Where a body is torn so far that its steps are too
/// long, it keeps them from adding energy without end.
constexpr double way_in_step = 0.25;
/// A pull leads its disc no further from its place at rest than this part of the diagonal of the body: with the
/// strongest coupling a soft body could be drawn out to many times its size.
constexpr double furthest_pull = 0.5;
/// A body that has moved by so many times its size is lost. A soft bar that is bent over moves by more than once its
/// size, and is not.
constexpr double largest_motion = 4.0;

} // namespace

int num_parts_of(double time_step, double longest) {
    return std::max(1, static_cast<int>(std::ceil(time_step / longest - 1e-6)));
}

Scene::Scene(core::Body body, const std::vector<bool> &is_constrained,
             const std::optional<core::Foundation> &foundation, int num_threads)
    : body_(std::move(body)), is_constrained_facet_(is_constrained), num_threads_(num_threads) {
    check_body(body_, is_constrained);
    stands_.assign(body_.mesh.boundary_triangles.size(), false);
    if (foundation) {
        check_foundation(*foundation, body_.mesh, is_constrained);
        stands_on_ = foundation;
        stand_on_foundation();
        for (std::size_t i = 0; i < foundation->facets.size(); ++i)
            stands_[static_cast<std::size_t>(foundation->facets[i])] = foundation->normal_only[i] == 0;
    }
    if (std::ranges::all_of(body_.modulus_factor, [](double factor) { return factor == 1.0; }))
        body_.modulus_factor.clear(); // an even map is none
    for (int node = 0; node < body_.mesh.num_nodes(); ++node)
        original_node_.push_back(node);
    show_remains();
    is_constrained_ = constrained_nodes(body_.mesh, is_constrained);
    extent_ = core::extent(body_.mesh.points);
    mean_edge_ = mean_edge(body_.mesh);
}

Chosen Scene::choose(const Settings &settings) {
    check_settings(settings);
    auto body = with_material(body_, settings.young_modulus, settings.poisson_ratio);
    auto parts = mass_springs(body_, settings, springs_);
    if (foundation_)
        parts.body.add(foundation_);
    const auto conditions = constrained_conditions(is_constrained_);
    Prepared next{std::move(body), std::move(parts), settings, {}, nullptr, cuts_.size()};
    if (cuts_.empty()) {
        next.stepping = chosen_steps(next.body, next.parts, conditions, settings);
    } else {
        next.rest = std::make_shared<const FittedRest>(
            fit_rest(next.body, foundation_, is_gone(cuts_.size()), conditions, settings));
        next.stepping = next.rest->stepping;
    }
    const auto chosen = next.stepping.chosen;
    time_step_ = chosen.time_step;
    prepared_ = std::make_shared<const Prepared>(std::move(next));
    prepare_steps(!needle_);
    fit_tool();
    return chosen;
}

/// Goes on with steps of what was chosen, and without what has been cut.
/// @param may_be_scaled  whether they may have scaled masses, which a needle cannot push
void Scene::prepare_steps(bool may_be_scaled) {
    const auto conditions = constrained_conditions(is_constrained_);
    const auto &rest = prepared_->rest;
    auto stepping = prepared_->stepping;
    are_scaled_ = may_be_scaled && !stepping.scaling.parts.empty();
    has_ended_scaling_ = false;
    fewest_parts_ = 1;
    if (!are_scaled_ && !stepping.scaling.parts.empty()) {
        fewest_parts_ = num_parts_of(time_step_, stepping.unscaled.longest_time_step);
        stepping.chosen = stepping.unscaled;
        stepping.chosen.time_step = time_step_ / fewest_parts_;
        stepping.scaling = {};
    }
    const auto &chosen = stepping.chosen;
    num_parts_ = fewest_parts_ * num_parts_of(chosen.time_step, chosen.pressed_time_step);
    const auto num_tetrahedra = body_.mesh.tetrahedra.size();
    const std::shared_ptr<const core::Body> body(prepared_, &prepared_->body);
    auto next = std::make_unique<msm::SpringStepper>(
        body,
        msm::MovingSprings{.springs = prepared_->parts.body,
                           .source = spring_source(body_, prepared_->settings),
                           .damping = prepared_->settings.damping,
                           .options = {.precision = msm::ForcePrecision::single_precision,
                                       .num_threads = num_threads_,
                                       .scaling = rest ? msm::MassScaling{} : stepping.scaling,
                                       .least_stretch = least_stretch,
                                       .largest_speed = way_in_step * mean_edge_ / chosen.time_step,
                                       .watched_volume = rest ? watched_of_whole(*rest, stepping, num_tetrahedra)
                                                              : watched_volumes(prepared_->body, prepared_->parts,
                                                                                conditions, stepping),
                                       .may_be_cut = true},
                           .critical_time_step = chosen.critical_time_step,
                           .bears_ball_as_loads = true},
        conditions);
    next->prepare(chosen.time_step);
    divided_steps_ = 0;
    std::optional<msm::State> state;
    if (steps_)
        state = sound_state();
    steps_ = std::move(next);
    touchable_ = touchable_remains();
    if (!cuts_.empty())
        cut_anew();
    if (state) {
        steps_->set_state(*state);
        if (!state->displacement.isZero(0.0))
            divided_steps_ = num_divided; // these springs may be pressed where the body is
    }
    if (!balls_.empty())
        touch_anew();
}

/// Puts a needle in, or takes it out.
void Scene::put_needle(const Tool &tool) {
    const bool was_in = needle_.has_value();
    needle_.reset();
    const bool is_in = tool.kind == ToolKind::needle;
    if (is_in != was_in && !prepared_->stepping.scaling.parts.empty())
        prepare_steps(!is_in);
    if (is_in)
        needle_.emplace(tool.needle, remains_.mesh, *steps_);
}

core::Vector3 Scene::displacement(int node) const {
    core::Vector3 found;
    steps_->displacements({&node, 1}, {&found, 1});
    return found;
}

/// Jaws of a grasp that differs from the tool before.
std::optional<Jaws> Scene::checked_jaws(const Tool &tool) const {
    if (tool.kind != ToolKind::grasp || are_one_grasp(tool, tool_))
        return std::nullopt;
    return jaws_around(remains_.mesh, constrained_remains(), tool, [&](int node) { return steps_->position(node); });
}

/// Place where a probe begins that differs from the tool before [m].
std::optional<core::Vector3> Scene::checked_place(const Tool &tool) const {
    if (tool.kind != ToolKind::probe || are_one_probe(tool, tool_))
        return std::nullopt;
    const auto position_of = [&](int node) { return steps_->position(node); };
    const auto shape = shape_of(tool);
    return shape.is_plate() ? before(take_ball(*touchable_, shape, tool.friction), tool.target, position_of)
                            : outside(surface_, tool.radius, tool.target, position_of);
}

/// Begins with a tool where it differs from the one before.
/// @param jaws   of a grasp that differs
/// @param place  of a probe that differs
void Scene::take_up(const Tool &tool, const std::optional<Jaws> &jaws, const std::optional<core::Vector3> &place) {
    const bool is_same = tool.kind == ToolKind::needle  ? are_one_needle(tool, tool_)
                         : tool.kind == ToolKind::grasp ? !jaws
                         : tool.kind == ToolKind::probe
                             ? !place
                             : tool.kind == tool_.kind && tool.radius == tool_.radius && tool.node == tool_.node;
    tool_ = tool;
    if (is_same)
        return;
    take_load_off();
    put_needle(tool);
    disc_ = {};
    balls_.clear();
    jaws_ = jaws;
    divided_steps_ = num_divided; // it is not known yet how far it presses
    proxy_ = {.position = tool.target, .target = tool.target};
    if (place) {
        balls_ = {take_ball(*touchable_, shape_of(tool), tool.friction)};
        proxy_.position = proxy_.target = *place;
    }
    if (jaws) {
        balls_ = take_jaws(*touchable_, surface_, *jaws, tool.radius, tool.friction);
        proxy_.position = proxy_.target = jaws->middle;
    }
    if (tool.kind == ToolKind::pull) {
        const auto &points = body_.mesh.points;
        const auto place = place_of_node(surface_, points, tool.node);
        disc_ = disc_around(surface_, points, place, tool.radius);
        proxy_.position = proxy_.target = mean_over(disc_, [&](int node) { return displacement(node); }) + place.point;
    }
    let_touch();
    fit_tool();
}

/// Begins to touch again where the body was of another material, or whole, or not.
void Scene::touch_anew() {
    auto anew = jaws_ ? take_jaws(*touchable_, surface_, *jaws_, tool_.radius, tool_.friction)
                      : std::vector<HeldBall>{take_ball(*touchable_, shape_of(tool_), tool_.friction)};
    for (std::size_t i = 0; i < anew.size(); ++i)
        anew[i].is_below = balls_[i].is_below;
    balls_ = std::move(anew);
    let_touch();
}

/// Lets balls take part in steps, as long as they are outside.
void Scene::let_touch() {
    std::vector<std::shared_ptr<core::BallContact>> touching;
    for (const auto &ball : balls_)
        if (!ball.is_below)
            touching.push_back(ball.contact);
    steps_->touch(std::move(touching));
}

/// Finds the stiffness of a pull.
void Scene::fit_tool() {
    const double bearable = coupled_part * coupling_mass / (time_step_ * time_step_); // [N/m]
    grip_stiffness_ = std::min(stiffest_grip, bearable);
}

/// Forces of a pull, from where the body is now.
/// @param part  of a step that they are for [s]
void Scene::draw(double part) {
    const auto moved = mean_over(disc_, [&](int node) { return displacement(node); });
    load_ = load_of(disc_, grip_stiffness_ * (proxy_.position - disc_.place.point - moved));
    carry_load(part);
}

/// Puts the load of a pull on the nodes, and what of the tool's mass they move with.
void Scene::carry_load(double part) {
    std::vector<double> masses;
    for (std::size_t k = 0; k < load_.nodes.size(); ++k)
        masses.push_back(part * part * grip_stiffness_ * disc_.weight[k] / touched_part);
    steps_->load(load_.nodes, load_.nodal);
    steps_->add_masses(load_.nodes, masses);
}

/// Leads a probe on, against what the body exerted on it in the last step.
void Scene::lead_ball(double part) {
    const auto from = proxy_.position;
    advance(proxy_, -balls_[0].force(), part);
    lead(
        balls_[0], surface_, proxy_, from, part, [&](int node) { return steps_->position(node); },
        [&](int node) { return remains_.mesh.points[node]; });
    let_touch();
}

/// Force of each jaw on the body along their axis, in the mean of both [N].
double Scene::closing_force() const {
    return 0.5 * (balls_[0].force() - balls_[1].force()).dot(jaws_->axis);
}

/// Leads both jaws on with the point between them, and closes them.
/// @param depth  that is asked for [m]
void Scene::lead_jaws(double depth, double part) {
    const std::array from{jaws_->centre(0, proxy_.position), jaws_->centre(1, proxy_.position)};
    close(*jaws_, depth, closing_force(), part);
    advance(proxy_, -(balls_[0].force() + balls_[1].force()), part);
    for (std::size_t i = 0; i < balls_.size(); ++i) {
        const core::Vector3 to = jaws_->centre(i, proxy_.position);
        balls_[i].depth = jaws_->depth;
        lead(
            balls_[i], surface_, {.position = to, .velocity = (to - from[i]) / part}, from[i], part,
            [&](int node) { return steps_->position(node); }, [&](int node) { return remains_.mesh.points[node]; });
    }
    let_touch();
}

core::Vector3 Scene::within_reach(const core::Vector3 &goal) const {
    if (tool_.kind != ToolKind::pull && !jaws_)
        return goal;
    const auto &middle = jaws_ ? jaws_->middle : disc_.place.point;
    const double length = (goal - middle).norm(), furthest = furthest_pull * extent_;
    return length > furthest ? core::Vector3(middle + furthest / length * (goal - middle)) : goal;
}

/// @param depth  where the hand leads a needle, or by which it closes jaws [m]
/// @param part   that is moved on by [s]
void Scene::step(const Tool &tool, double depth, double part) {
    if (tool_.kind != ToolKind::none && !needle_) {
        follow(proxy_, within_reach(jaws_ ? jaws_->middle + (tool.target - tool.place) : tool.target), part);
        if (jaws_) {
            lead_jaws(depth, part);
        } else if (!balls_.empty()) {
            lead_ball(part);
        } else {
            draw(part);
            advance(proxy_, -load_.total, part);
        }
    }
    steps_->prepare(part);
    steps_->step(part, 1);
    if (needle_)
        needle_->act(*steps_, depth, part);
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
    check_depth(tool);
    if (!are_one_needle(tool, tool_))
        check_needle(tool, remains_.mesh, is_constrained_);
    take_up(tool, checked_jaws(tool), checked_place(tool));
    // A hand leads a needle evenly, as far as it goes in these steps, and closes jaws so.
    const double start = needle_ ? needle_->depth() : jaws_ ? jaws_->depth : 0.0, way = tool.depth - start;
    for (int i = 0; i < num_steps; ++i) {
        const int parts = divided_steps_ > 0 ? num_parts_ : fewest_parts_;
        divided_steps_ = std::max(0, divided_steps_ - 1);
        for (int k = 0; k < parts; ++k)
            step(tool, start + way * (i + (k + 1.0) / parts) / num_steps, time_step_ / parts);
    }
    time_ += num_steps * time_step_;
    return force_on_tool();
}

core::Vector3 Scene::force_on_tool() const {
    if (balls_.empty())
        return -(needle_ ? needle_->force() : load_.total);
    core::Vector3 force = core::Vector3::Zero();
    for (const auto &ball : balls_)
        force -= ball.force();
    return force;
}

Frame Scene::move(const Tool &tool, int num_steps) {
    const long before = num_evaluations_;
    feel(tool, num_steps);
    auto found = frame();
    found.num_evaluations = num_evaluations_ - before;
    return found;
}

msm::State Scene::sound_state() {
    auto state = steps_->state();
    if (!is_lost(state))
        return state;
    settle();
    ++restarts_;
    return steps_->state();
}

Frame Scene::frame() {
    const auto state = sound_state();
    Frame frame;
    frame.time = time_;
    if (needle_)
        frame.needle = needle_->reading(*steps_);
    if (jaws_)
        frame.grasp = {.depth = jaws_->depth,
                       .closing = closing_force(),
                       .other = jaws_->centre(1, proxy_.position),
                       .other_force = -balls_[1].force()};
    frame.tool = needle_ ? needle_->tip() : jaws_ ? jaws_->centre(0, proxy_.position) : proxy_.position;
    frame.force = force_on_tool();
    frame.largest_speed = largest_speed(state.velocity);
    if (tool_.kind != ToolKind::none)
        frame.largest_speed = std::max(frame.largest_speed, proxy_.velocity.norm());
    if (jaws_)
        frame.largest_speed = std::max(frame.largest_speed, std::abs(jaws_->speed));
    frame.restarts = restarts_;
    frame.displacement = msm::to_field(state.displacement);
    for (const int node : gone_nodes_)
        frame.displacement[node].setZero();
    frame.smallest_volume = smallest_volume_ratio(remains_.mesh, frame.displacement);
    frame.load = balls_.empty() ? load_ : load_of(balls_, surface_);
    frame.indentation = indentation(frame.load, frame.displacement);
    frame.surface = &surface_;
    return frame;
}

bool Scene::is_lost(const msm::State &state) const {
    // Written so that what is no number counts as lost.
    return !(state.displacement.lpNorm<Eigen::Infinity>() < largest_motion * extent_ && state.velocity.allFinite() &&
             proxy_.position.allFinite());
}

void Scene::take_load_off() {
    load_ = {};
    steps_->load({}, {});
    steps_->add_masses({}, {});
}

void Scene::reset() {
    kept_.reset();
    if (!cuts_.empty()) {
        take_load_off();
        undo_cuts(0);
    }
    if (steps_)
        settle();
}

void Scene::settle() {
    const auto size = static_cast<Eigen::Index>(3 * body_.mesh.points.size());
    take_load_off();
    steps_->set_state({Eigen::VectorXd::Zero(size), Eigen::VectorXd::Zero(size)});
    tool_ = {};
    proxy_ = {};
    disc_ = {};
    balls_.clear();
    jaws_.reset();
    let_touch();
    put_needle(tool_);
    divided_steps_ = 0;
    fit_tool();
}

namespace {

std::vector<HeldBall> copies(const std::vector<HeldBall> &balls) {
    std::vector<HeldBall> found;
    for (const auto &ball : balls)
        found.push_back(ball.copy());
    return found;
}

} // namespace

void Scene::keep() {
    if (!steps_)
        throw support::InputError("nothing has been chosen yet that could be kept; choose springs first");
    auto state = sound_state();
    kept_ = {.num_cuts = cuts_.size(),
             .state = std::move(state),
             .tool = tool_,
             .proxy = proxy_,
             .disc = disc_,
             .balls = copies(balls_),
             .jaws = jaws_,
             .touched = touchable_->facets,
             .load = load_,
             .divided_steps = divided_steps_,
             .needle = needle_};
    // The digits of both parts of a number may be more than a double has: from here on it moves as when it is restored.
    steps_->set_state(kept_->state);
}

void Scene::restore() {
    if (!steps_ || !kept_)
        throw support::InputError("no state is kept that one could go back to; take a tool first");
    take_load_off();
    if (kept_->num_cuts < cuts_.size())
        undo_cuts(kept_->num_cuts);
    put_needle(kept_->tool);
    needle_ = kept_->needle;
    steps_->set_state(kept_->state);
    tool_ = kept_->tool;
    proxy_ = kept_->proxy;
    disc_ = kept_->disc;
    const auto at_first = [](const core::TouchedFacet &facet) { return facet.penalty(0.0); };
    const bool is_same = std::ranges::equal(kept_->touched, touchable_->facets, {}, at_first, at_first);
    balls_ = copies(kept_->balls);
    jaws_ = kept_->jaws;
    let_touch();
    if (!balls_.empty() && !is_same)
        touch_anew();
    load_ = kept_->load;
    divided_steps_ = kept_->divided_steps;
    // The time step may be another one by now.
    fit_tool();
    carry_load(time_step_);
}

} // namespace livermark::live
