#include "fem_reference/hyperelastic/one_process_system.hpp"

#include <cmath>
#include <numeric>

namespace livermark::hyperelastic {

std::vector<bool> free_of(const std::vector<double> &prescribed) {
    std::vector<bool> is_free;
    for (const double value : prescribed)
        is_free.push_back(std::isnan(value));
    return is_free;
}

std::vector<double> loads_at(const fem_reference::DofConditions &conditions, const FollowerPressure &follower,
                             const State &state, double fraction) {
    auto load = conditions.load;
    for (double &value : load)
        value *= fraction;
    follower.add_forces(fraction, state.displacement, load);
    return load;
}

OneProcessSystem::OneProcessSystem(const Elements &elements, const fem_reference::DofConditions &conditions,
                                   std::span<const double> pressure)
    : elements_(elements), conditions_(conditions), follower_(elements.system(), elements.body().mesh, pressure),
      solver_(elements, follower_, free_of(conditions.prescribed)), tangent_(elements.zero_tangent()),
      counted_displacements_(elements.num_displacements(), true), counted_pressures_(elements.num_pressures(), true) {}

std::vector<double> OneProcessSystem::loads(const State &state, double fraction) const {
    return loads_at(conditions_, follower_, state, fraction);
}

void OneProcessSystem::assemble(const State &state, double fraction) {
    elements_.assemble_tangent(state, tangent_);
    load_stiffness_ = follower_.load_stiffness(fraction, state.displacement);
    follower_.add_symmetric_part(load_stiffness_, tangent_.stiffness);
}

bool OneProcessSystem::factorise_at_rest() {
    auto at_rest = elements_.zero_tangent();
    elements_.assemble_tangent(elements_.rest(), at_rest);
    return solver_.factorise(at_rest.stiffness);
}

double OneProcessSystem::volume() const {
    const auto volumes = core::tetrahedron_volumes(elements_.body().mesh);
    return std::accumulate(volumes.begin(), volumes.end(), 0.0);
}

} // namespace livermark::hyperelastic
