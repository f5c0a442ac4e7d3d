#include "studies/models/motion/frame_body.hpp"

#include <algorithm>
#include <cmath>

#include "msm/dynamics/time_step.hpp"
#include "msm/elastic_body.hpp"

namespace livermark::models {

namespace {

constexpr double part_of_frame = 1e-9; ///< rounding of lengths over the way of a frame
/// Largest way of places while a method's response is observed [m]: strains of a thousandth.
constexpr double way_of_observation = 1e-5;

/// The same conditions with all that is prescribed at zero; NaN, a free component, stays NaN.
core::NodalConditions at_rest(core::NodalConditions conditions) {
    for (auto &displacement : conditions.displacement)
        displacement *= 0.0;
    return conditions;
}

} // namespace

NodalProblem on_nodes(const core::Problem &problem) {
    auto masses = msm::lumped_masses(*problem.body);
    auto conditions = msm::nodal_conditions(problem, masses);
    return {problem.body, std::move(masses), std::move(conditions)};
}

std::optional<Effort> least_effort(const Stepper &stepper, double frame) {
    const double longest = msm::default_safety_factor * stepper.critical_time_step();
    if (!std::isfinite(longest))
        return std::nullopt;
    const int count = static_cast<int>(std::ceil(frame / longest));
    return stepper.counts_iterations() ? Effort{.iterations = count} : Effort{.steps = count};
}

ToolPlace tool_place(const core::Problem &problem, const std::vector<double> &node_mass) {
    const auto conditions_of = [&](const core::LoadCase &load_case) {
        return msm::nodal_conditions({problem.body, load_case}, node_mass);
    };
    ToolPlace place;
    place.motion = problem.load_case.tool.value();
    const auto pressed = conditions_of(problem.load_case), slid = conditions_of(core::with_slide(problem.load_case));
    for (std::size_t node = 0; node < node_mass.size(); ++node) {
        const int constraint = pressed.constraint[node][0];
        if (constraint == place.motion.constraint) {
            place.nodes.push_back(static_cast<int>(node));
            place.pressed.push_back(pressed.displacement[node]);
            place.slid.push_back(slid.displacement[node]);
        } else if (constraint >= 0) {
            place.held.push_back(static_cast<int>(node));
        }
    }
    place.while_held = at_rest(pressed);
    place.let_go = at_rest(conditions_of(core::let_go(problem.load_case)));
    return place;
}

int NeedlePlan::at_plan(const core::Needle &needle) const {
    return std::max(1, static_cast<int>(std::ceil(needle.depth() / (speed * frame_interval) - part_of_frame)));
}

int NeedlePlan::num_frames(const core::Needle &needle) const {
    return 2 * at_plan(needle) + static_cast<int>(std::lround(rest / frame_interval));
}

double NeedlePlan::depth_after(const core::Needle &needle, int frame) const {
    const int in = at_plan(needle), steps = std::min({frame, in, num_frames(needle) - frame});
    return needle.depth() * steps / in;
}

FrameBody::FrameBody(std::unique_ptr<Stepper> stepper, double frame_interval)
    : stepper_(std::move(stepper)), frame_(frame_interval) {
    if (const auto least = least_effort())
        stepper_->prepare(frame_ / least->steps);
}

void FrameBody::take_tool(ToolPlace place, const core::Problem &problem) {
    place_ = std::move(place);
    if (const auto &touching = problem.load_case.touching) {
        ball_shape_ = *touching;
        ball_ = std::make_shared<core::BallContact>(
            stepper_->touched_facets(core::touched_facets(*problem.body, problem.load_case)),
            core::contact_divisions(*problem.body, problem.load_case), touching->shape, touching->friction);
        stepper_->touch(ball_);
    }
}

void FrameBody::take_needle(const core::Needle &needle, const core::TetraMesh &mesh) {
    if (has_explicit_steps()) {
        needle_.emplace(needle, mesh, stepper_->per_mass());
    } else {
        weights_ = core::place_weights(needle, mesh);
        auto converged = stepper_->converged_response(weights_, frame_);
        force_of_observation_ = way_of_observation / (converged.maxCoeff() * std::pow(frame_, 2));
        needle_.emplace(needle, weights_, std::move(converged));
    }
    needle_->begin(*stepper_);
}

void FrameBody::prepare_for(const Effort &effort) {
    stepper_->prepare(frame_ / effort.steps);
    if (needle_ && !has_explicit_steps())
        needle_->respond_by(stepper_->observed_response(weights_, frame_, effort, force_of_observation_));
}

void FrameBody::advance_alone(const Effort &effort) {
    stepper_->prepare(frame_ / effort.steps);
    for (int s = 0; s < effort.steps; ++s)
        stepper_->step(frame_ / effort.steps, effort.iterations);
}

void FrameBody::lead_tool(double time) {
    const auto position = core::tool_position(place_->motion, time);
    std::vector<core::Vector3> displacement;
    for (std::size_t i = 0; i < place_->nodes.size(); ++i)
        displacement.push_back(place_->displacement(i, position));
    stepper_->lead(place_->nodes, displacement);
}

void FrameBody::advance(const Lead &lead, const Effort &effort) {
    const double h = frame_ / effort.steps, depth = needle_ ? needle_->depth() : 0.0;
    const bool touches = ball_ && !has_let_go_, leads = place_ && !ball_ && !has_let_go_;
    const auto centre = [&](double time) { return core::ball_centre(ball_shape_, place_->motion, time); };
    stepper_->prepare(h);
    if (touches) {
        ball_->set_circle(core::circle_of_contact(ball_shape_, place_->motion, lead.start + frame_));
        ball_->set_way(centre(lead.start), centre(lead.start + frame_));
        ball_->look_around([&](int node) { return stepper_->position(node); });
    }
    const bool acts_in_steps = needle_ && has_explicit_steps();
    int s = 0;
    if (acts_in_steps) {
        needle_force_ = 0.0;
        stepper_->act_after_steps([&](core::MovingNodes &nodes, double part, double step) {
            needle_->act(nodes, depth + (lead.depth - depth) * (s + part) / effort.steps, step);
            needle_force_ += needle_->force() * step / frame_;
        });
    }
    for (; s < effort.steps; ++s) {
        const double until = lead.start + (s + 1) * h;
        if (touches)
            ball_->set_way(centre(lead.start + s * h), centre(until));
        if (leads)
            lead_tool(until);
        stepper_->step(h, effort.iterations);
    }
    if (acts_in_steps)
        stepper_->act_after_steps(nullptr);
    if (needle_ && !acts_in_steps) {
        needle_->act(*stepper_, lead.depth, frame_);
        needle_force_ = needle_->force();
        stepper_->load(needle_->nodes(), needle_->nodal_forces());
    }
    if (touches)
        ball_force_ = -ball_->take_impulse() / frame_;
}

void FrameBody::let_go() {
    has_let_go_ = true;
    if (ball_) // it had hold of nothing
        stepper_->touch(nullptr);
    else
        stepper_->hold(place_->let_go);
}

core::Vector3 FrameBody::tool_force() const {
    if (has_let_go_ || !place_)
        return core::Vector3::Zero();
    return ball_ ? ball_force_ : stepper_->elastic_force(place_->nodes);
}

NeedleReading FrameBody::reading() const {
    return {.force = needle_force_, .tip = needle_->tip(), .places = needle_->place_displacements(*stepper_)};
}

} // namespace livermark::models
