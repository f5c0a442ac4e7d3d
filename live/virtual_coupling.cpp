#include "live/virtual_coupling.hpp"

#include <cmath>

namespace livermark::live {

namespace {

/// The coupling comes to rest without swinging.
const double coupling_damping = 2.0 * std::sqrt(coupling_stiffness * coupling_mass);

core::Vector3 shortened(const core::Vector3 &vector, double longest) {
    const double length = vector.norm();
    return length > longest ? core::Vector3(longest / length * vector) : vector;
}

} // namespace

void follow(Proxy &proxy, const core::Vector3 &target, double time_step) {
    proxy.target += shortened(target - proxy.target, fastest_target * time_step);
}

void advance(Proxy &proxy, const core::Vector3 &force, double time_step) {
    const core::Vector3 drawn = shortened(coupling_stiffness * (proxy.target - proxy.position), strongest_coupling);
    proxy.velocity += time_step / coupling_mass * (drawn - coupling_damping * proxy.velocity + force);
    proxy.position += time_step * proxy.velocity;
}

} // namespace livermark::live
