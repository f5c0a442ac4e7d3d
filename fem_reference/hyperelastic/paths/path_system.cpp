#include "fem_reference/hyperelastic/paths/path_system.hpp"

#include <cmath>
#include <numeric>

namespace livermark::hyperelastic {

std::vector<bool> free_of(const std::vector<double> &prescribed) {
    std::vector<bool> is_free;
    for (const double value : prescribed)
        is_free.push_back(std::isnan(value));
    return is_free;
}

double volume_of(const core::TetraMesh &mesh) {
    const auto volumes = core::tetrahedron_volumes(mesh);
    return std::accumulate(volumes.begin(), volumes.end(), 0.0);
}

PathSystem::PathSystem(const Elements &elements, const fem_reference::DofConditions &conditions,
                       std::span<const double> pressure, TouchingBall *ball)
    : elements_(elements), conditions_(conditions), follower_(elements.system(), elements.body().mesh, pressure),
      ball_(ball), tangent_(elements.zero_tangent()) {
    if (ball_)
        expected_pressure_.assign(ball_->num_points(), 0.0);
}

std::vector<double> PathSystem::loads(const State &state, double fraction) const {
    auto load = conditions_.load;
    for (double &value : load)
        value *= fraction;
    follower_.add_forces(fraction, state.displacement, load);
    if (ball_)
        ball_->add_forces(ball_->tool().centre_at(fraction), state.displacement, load);
    return load;
}

void PathSystem::assemble(const State &state, double fraction) {
    elements_.assemble_tangent(state, tangent_);
    surface_stiffness_ = follower_.load_stiffness(fraction, state.displacement);
    if (ball_)
        ball_->add_stiffness(ball_->tool().centre_at(fraction), state.displacement, surface_stiffness_,
                             expected_pressure_);
    surface_stiffness_.add_to(tangent_.stiffness);
}

void PathSystem::expect(const State &state, double fraction) {
    if (ball_)
        expected_pressure_ = ball_->expected_pressure(ball_->tool().centre_at(fraction), state.displacement);
}

void PathSystem::expect(const State &state, double fraction, const State &change, double part) {
    if (!ball_)
        return;
    const auto expected =
        ball_->expected_pressure(ball_->tool().centre_at(fraction), state.displacement, change.displacement);
    for (std::size_t point = 0; point < expected.size(); ++point)
        expected_pressure_[point] += part * (expected[point] - expected_pressure_[point]);
}

bool PathSystem::factorise_at_rest() {
    auto at_rest = elements_.zero_tangent();
    elements_.assemble_tangent(rest(), at_rest);
    return set_up(at_rest.stiffness);
}

State PathSystem::product(const std::vector<double> &u) const {
    State result{std::vector<double>(u.size()), std::vector<double>(elements_.num_pressures(), 0.0)};
    tangent_.stiffness.multiply(u, result.displacement);
    surface_stiffness_.add_product(u, result.displacement);
    if (!result.pressure.empty()) {
        const std::vector<double> nothing(result.pressure.size(), 0.0);
        tangent_.divergence.subtract_product(u, nothing, result.pressure, 1);
    }
    return result;
}

} // namespace livermark::hyperelastic
