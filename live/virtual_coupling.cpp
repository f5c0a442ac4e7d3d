#include "live/virtual_coupling.hpp"

#include <algorithm>
#include <cmath>

namespace livermark::live {

namespace {

/// The coupling comes to rest without swinging.
const double coupling_damping = 2.0 * std::sqrt(coupling_stiffness * coupling_mass);

constexpr std::array<double, 3> thirds{1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0};

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

Grip grip_around(const Surface &surface, const std::vector<core::Vector3> &points, int node, double radius) {
    const auto normal = [&](int t) -> core::Vector3 {
        const auto [a, b, c] = surface.triangles[t];
        return (points[b] - points[a]).cross(points[c] - points[a]);
    };
    core::Vector3 outwards = core::Vector3::Zero();
    for (int t = 0; t < static_cast<int>(surface.triangles.size()); ++t)
        if (std::ranges::find(surface.triangles[t], node) != surface.triangles[t].end())
            outwards += normal(t);

    Grip grip;
    double sum = 0.0;
    for (int t = 0; t < static_cast<int>(surface.triangles.size()); ++t) {
        const auto [a, b, c] = surface.triangles[t];
        const core::Vector3 middle = (points[a] + points[b] + points[c]) / 3.0;
        const double distance = (middle - points[node]).norm() / radius;
        const bool is_at_node = a == node || b == node || c == node;
        // Triangles at the node are gripped, however large they are; those on the far side of an edge are not.
        if (!is_at_node && (distance >= 1.0 || normal(t).dot(outwards) <= 0.0))
            continue;
        const double nearness = std::max(1.0 - distance * distance, 0.1);
        grip.triangles.push_back(t);
        grip.share.push_back(nearness * surface.area[t]);
        sum += grip.share.back();
    }
    for (double &share : grip.share)
        share /= sum;
    grip.rest = mean_over(grip, surface, [&](int i) { return points[i]; });
    return grip;
}

core::Vector3 mean_over(const Grip &grip, const Surface &surface, const PositionOf &field) {
    core::Vector3 mean = core::Vector3::Zero();
    for (std::size_t i = 0; i < grip.triangles.size(); ++i)
        for (const int node : surface.triangles[grip.triangles[i]])
            mean += grip.share[i] / 3.0 * field(node);
    return mean;
}

void add_pull(const Grip &grip, const Surface &surface, const core::Vector3 &force, Load &load) {
    for (std::size_t i = 0; i < grip.triangles.size(); ++i)
        add_force(load, surface, grip.triangles[i], grip.share[i] * force, thirds);
}

} // namespace livermark::live
