#include "msm/dynamics/spring_stepper.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "msm/dynamics/time_step.hpp"

namespace livermark::msm {

SpringStepper::SpringStepper(std::shared_ptr<const core::Body> body, MovingSprings moving, NodalConditions held)
    : body_(std::move(body)), moving_(std::move(moving)), held_(std::move(held)), numbers_(body_->mesh) {
    if (moving_.options.may_be_cut)
        parts_ = CutParts::prepare(*body_, moving_.springs, moving_.source);
    if (!moving_.bears_ball_as_loads)
        return;
    force_of_balls_.assign(body_->mesh.points.size(), core::Vector3::Zero());
    set_factors(moving_.options.scaling);
}

/// Steps from where the body is.
void SpringStepper::make_steps() {
    auto options = moving_.options;
    options.scaling = constrained(options.scaling, held_);
    auto parted = part_terms(moving_.springs);
    auto steps = FastSteps::prepare(parted.in_kernels, body_->mesh.points, held_, moving_.damping, "symplectic_euler",
                                    time_step_, options);
    beside_ = std::move(parted.beside);
    if (!beside_.empty()) {
        rest_ = to_unknowns(body_->mesh.points);
        given_load_ = held_.force;
        bears_more_.assign(given_load_.size(), 0);
    }
    if (!steps)
        throw std::logic_error("the fast kernels do not know these springs");
    if (steps_)
        steps->set_state(steps_->state());
    steps_ = std::move(steps);
}

void SpringStepper::prepare(double time_step) {
    if (steps_ && time_step == time_step_)
        return;
    time_step_ = time_step;
    if (steps_)
        steps_->set_time_step(time_step);
    else
        make_steps();
}

void SpringStepper::step(double time_step, int /*iterations*/) {
    if (!balls_.empty() && moving_.bears_ball_as_loads)
        load_with_balls();
    if (!beside_.empty())
        load_with_terms_beside();
    steps_->take(1);
    for (std::size_t i = 0; i < led_nodes_.size(); ++i)
        steps_->set_displacement(led_nodes_[i], led_to_[i]);
    led_nodes_.clear();
    if (!balls_.empty())
        push_out(time_step);
    if (after_)
        after_(*this, 1.0, time_step);
}

void SpringStepper::lead(std::span<const int> nodes, std::span<const core::Vector3> displacement) {
    led_nodes_.assign(nodes.begin(), nodes.end());
    led_to_.assign(displacement.begin(), displacement.end());
}

void SpringStepper::hold(const NodalConditions &conditions) {
    held_ = conditions;
    make_steps();
}

bool SpringStepper::remove(std::span<const int> tetrahedra) {
    const auto &changes = parts_->remove(tetrahedra);
    const bool are_scaled = steps_->cut(parts_->parts(), parts_->node_mass(), changes);
    cut_terms_beside();
    return are_scaled;
}

void SpringStepper::part(const Parting &parting) {
    const auto &changes = parts_->part(parting);
    steps_->part(parts_->parts(), parts_->node_mass(), changes);
    if (beside_.empty())
        return;
    const Eigen::Index num_before = rest_.size();
    rest_.conservativeResize(num_before + 3 * std::ssize(parting.parent_node));
    for (std::size_t k = 0; k < parting.parent_node.size(); ++k)
        rest_.segment<3>(num_before + 3 * static_cast<Eigen::Index>(k)) =
            core::Vector3(node_part(rest_, parting.parent_node[k]));
    given_load_.resize(given_load_.size() + parting.parent_node.size(), core::Vector3::Zero());
    bears_more_.resize(given_load_.size(), 0);
    cut_terms_beside();
}

void SpringStepper::cut_terms_beside() {
    for (auto &term : beside_)
        term = term->after_cut({rest_, parts_->tetrahedra(), parts_->parts().is_removed});
}

void SpringStepper::cut(const core::NodalProblem &after, const std::vector<int> &parent_tetrahedron) {
    const auto cut = numbers_.follow(after.body->mesh, parent_tetrahedron);
    if (!cut.removed.empty())
        remove(cut.removed);
    if (!cut.parting.tetrahedra.empty())
        part(cut.parting);
    body_ = after.body;
    for (std::size_t i = 0; i < numbers_.nodes().size(); ++i)
        give_load(numbers_.nodes()[i], after.conditions.force[i]);
}

std::vector<core::Vector3> SpringStepper::displacement() const {
    std::vector<core::Vector3> found(numbers_.nodes().size());
    steps_->displacements(numbers_.nodes(), found);
    return found;
}

void SpringStepper::start_from(const std::vector<core::Vector3> &displacement) {
    const auto size = static_cast<Eigen::Index>(3 * displacement.size());
    Eigen::VectorXd components(size);
    for (std::size_t i = 0; i < displacement.size(); ++i)
        components.segment<3>(3 * static_cast<Eigen::Index>(i)) = displacement[i];
    steps_->set_state({components, Eigen::VectorXd::Zero(size)});
}

void SpringStepper::take_motion_of(const core::Stepper &other) {
    steps_->set_state(dynamic_cast<const SpringStepper &>(other).steps_->state());
}

core::Vector3 SpringStepper::elastic_force(std::span<const int> held) const {
    auto positions = displacement();
    for (std::size_t i = 0; i < positions.size(); ++i)
        positions[i] += body_->mesh.points[i];
    const auto gradient = elastic_gradient(moving_.springs, positions);
    core::Vector3 force = core::Vector3::Zero();
    for (const int node : held)
        force -= gradient[node];
    return force;
}

std::vector<double> SpringStepper::per_mass() const {
    std::vector<double> result;
    for (std::size_t node = 0; node < held_.displacement.size(); ++node)
        result.push_back(held_.constrains(node) ? 0.0 : 1.0 / node_mass()[node]);
    return result;
}

core::FrameCost SpringStepper::cost(const core::Effort &effort) const {
    return {static_cast<double>(effort.steps),
            static_cast<double>(steps_->working_set()) / static_cast<double>(body_->mesh.tetrahedra.size())};
}

void SpringStepper::load(std::span<const int> nodes, std::span<const core::Vector3> force) {
    for (const int node : loaded_)
        if (std::ranges::find(nodes, node) == nodes.end())
            give_load(node, core::Vector3::Zero());
    loaded_.assign(nodes.begin(), nodes.end());
    for (std::size_t i = 0; i < nodes.size(); ++i)
        give_load(nodes[i], force[i]);
}

void SpringStepper::give_load(int node, const core::Vector3 &force) {
    steps_->set_load(node, force);
    if (!given_load_.empty())
        given_load_[static_cast<std::size_t>(node)] = force;
}

void SpringStepper::load_with_terms_beside() {
    const auto state = steps_->state();
    const Eigen::VectorXd x = rest_ + state.displacement;
    Eigen::VectorXd force = Eigen::VectorXd::Zero(x.size());
    for (const auto &term : beside_)
        term->add_force(x, state.velocity, moving_.damping.beta, force);
    for (std::size_t node = 0; node < given_load_.size(); ++node) {
        const core::Vector3 more = node_part(force, static_cast<int>(node));
        const bool bears_more = !more.isZero(0.0);
        if (bears_more || bears_more_[node] != 0)
            steps_->set_load(static_cast<int>(node), given_load_[node] + more);
        bears_more_[node] = bears_more ? 1 : 0;
    }
}

void SpringStepper::add_masses(std::span<const int> nodes, std::span<const double> more) {
    for (const int node : heavier_) // a mass that changes makes that of a scaled part be found anew
        if (std::ranges::find(nodes, node) == nodes.end())
            steps_->set_mass(node, node_mass()[node]);
    heavier_.assign(nodes.begin(), nodes.end());
    for (std::size_t i = 0; i < nodes.size(); ++i)
        steps_->set_mass(nodes[i], node_mass()[nodes[i]] + more[i]);
}

std::vector<core::TouchedFacet> SpringStepper::touched_facets(std::vector<core::TouchedFacet> facets) const {
    for (auto &facet : facets)
        facet.softness = moving_.springs.softness;
    return facets;
}

void SpringStepper::touch(std::shared_ptr<core::BallContact> ball) {
    std::vector<std::shared_ptr<core::BallContact>> balls;
    if (ball)
        balls.push_back(std::move(ball));
    touch(std::move(balls));
}

void SpringStepper::touch(std::vector<std::shared_ptr<core::BallContact>> balls) {
    balls_ = std::move(balls);
    if (balls_.empty() && moving_.bears_ball_as_loads)
        load({}, {});
}

void SpringStepper::set_factors(const MassScaling &scaling) {
    factor_.assign(scaling.parts.empty() ? 0 : body_->mesh.points.size(), 1.0);
    for (const auto &part : scaling.parts)
        for (const int node : part.nodes)
            factor_[node] = part.factor;
}

void SpringStepper::set_scaling(const MassScaling &scaling) {
    steps_->set_scaling(scaling);
    if (moving_.bears_ball_as_loads)
        set_factors(scaling);
}

/// Loads nodes with the forces of balls in the step before.
void SpringStepper::load_with_balls() {
    for (const int node : pressed_)
        force_of_balls_[node].setZero();
    pressed_.clear();
    for (const auto &ball : balls_)
        ball->begin_step([this](int node, const core::Vector3 &force) {
            if (force_of_balls_[node].isZero(0.0) && !force.isZero(0.0))
                pressed_.push_back(node);
            force_of_balls_[node] += force;
        });
    std::vector<core::Vector3> forces;
    for (const int node : pressed_)
        forces.push_back(force_of_balls_[node]);
    load(pressed_, forces);
}

double SpringStepper::moved_mass(int node) const {
    return factor_.empty() ? node_mass()[node] : factor_[node] * node_mass()[node];
}

/// Forces of balls take part in the step.
void SpringStepper::push_out(double h) {
    const auto now = [this](int node) { return position(node); };
    const auto yields = [&](int node) {
        return held_.constrains(static_cast<std::size_t>(node)) ? 0.0 : h * h / moved_mass(node);
    };
    const auto give = [&](int node, const core::Vector3 &force) {
        const core::Vector3 way = yields(node) * force;
        steps_->push(node, way, way / h);
    };
    if (!moving_.bears_ball_as_loads)
        for (const auto &ball : balls_)
            ball->begin_step(give);
    for (const auto &ball : balls_) {
        ball->sweep(
            ball->part(0, 1), [&](int node) { return core::Vector3(position(node) - h * steps_->velocity(node)); }, now,
            [&](int node) { return Eigen::Matrix3d(yields(node) * Eigen::Matrix3d::Identity()); }, give);
        ball->end_step(h);
    }
}

} // namespace livermark::msm
