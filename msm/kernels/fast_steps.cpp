#include "msm/kernels/fast_steps.hpp"

#include <functional>
#include <map>

#include "msm/kernels/steps_of_body.hpp"

namespace livermark::msm {

namespace {

std::optional<StepScheme> find_scheme(const std::string &integrator, int num_stages) {
    using Kind = StepScheme::Kind;
    static const std::map<std::string, StepScheme, std::less<>> schemes{
        {"explicit_euler", {.kind = Kind::runge_kutta, .weight = {1.0}}},
        {"heun", {.kind = Kind::runge_kutta, .weight = {0.5, 0.5}, .next = {1.0}}},
        {"runge_kutta_4",
         {.kind = Kind::runge_kutta, .weight = {1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0}, .next = {0.5, 0.5, 1.0}}},
        {"symplectic_euler", {.kind = Kind::symplectic_euler}},
        {"velocity_verlet", {.kind = Kind::velocity_verlet}}};
    if (integrator == "runge_kutta_chebyshev")
        return StepScheme{.kind = Kind::runge_kutta_chebyshev, .chebyshev = chebyshev_stages(num_stages)};
    const auto found = schemes.find(integrator);
    return found == schemes.end() ? std::nullopt : std::optional(found->second);
}

} // namespace

std::optional<FastSteps> FastSteps::prepare(const ElasticBody &body, const std::vector<core::Vector3> &positions,
                                            const NodalConditions &conditions, const core::RayleighDamping &damping,
                                            const std::string &integrator, double time_step,
                                            const FastStepOptions &options) {
    auto parts = step_parts(body);
    if (parts && !parts->guard_stiffness.empty())
        parts->watched_volume = options.watched_volume;
    const auto scheme = find_scheme(integrator, options.num_stages);
    const bool is_scaled = !options.scaling.parts.empty();
    const bool relaxes = !options.relaxation.is_elastic();
    if (!parts || !scheme || (is_scaled && scheme->kind != StepScheme::Kind::symplectic_euler))
        return std::nullopt;
    if (relaxes && options.may_be_cut)
        return std::nullopt;
    const auto make = [&]<class T>(T /*precision*/) {
        return FastSteps(std::make_shared<StepsOfBody<T>>(*parts, body, positions, conditions, damping, *scheme,
                                                          time_step, options));
    };
    return options.precision == ForcePrecision::single_precision ? make(float()) : make(double());
}

void FastSteps::set_state(const State &state) {
    implementation_->set_state(state);
}
State FastSteps::state() const {
    return implementation_->state();
}
core::Vector3 FastSteps::displacement(int node) const {
    return implementation_->displacement(node);
}
core::Vector3 FastSteps::velocity(int node) const {
    return implementation_->velocity(node);
}
void FastSteps::push(int node, const core::Vector3 &displacement, const core::Vector3 &velocity) {
    implementation_->push(node, displacement, velocity);
}
void FastSteps::displacements(std::span<const int> nodes, std::span<core::Vector3> found) const {
    implementation_->displacements(nodes, found);
}
void FastSteps::kick(std::span<const int> nodes, std::span<const core::Vector3> velocity, double time_step) {
    implementation_->kick(nodes, velocity, time_step);
}
void FastSteps::set_displacement(int node, const core::Vector3 &displacement) {
    implementation_->set_displacement(node, displacement);
}
void FastSteps::set_load(int node, const core::Vector3 &force) {
    implementation_->set_load(node, force);
}
void FastSteps::set_time_step(double time_step) {
    implementation_->set_time_step(time_step);
}
void FastSteps::set_mass(int node, double mass) {
    implementation_->set_mass(node, mass);
}
bool FastSteps::cut(const StepParts &parts, const std::vector<double> &node_mass, const CutChanges &changes) {
    return implementation_->cut(parts, node_mass, changes);
}
bool FastSteps::part(const StepParts &parts, const std::vector<double> &node_mass, const PartingChanges &changes) {
    return implementation_->part(parts, node_mass, changes);
}
bool FastSteps::set_scaling(const MassScaling &scaling) {
    return implementation_->set_scaling(scaling);
}
bool FastSteps::is_pressed() const {
    return implementation_->is_pressed();
}
void FastSteps::take(int num_steps) {
    implementation_->take(num_steps);
}
void FastSteps::relax(double time) {
    implementation_->relax(time);
}
int FastSteps::steps_between_relaxations() const {
    return implementation_->steps_between_relaxations();
}
std::size_t FastSteps::working_set() const {
    return implementation_->working_set();
}

} // namespace livermark::msm
