#include "live/contact.hpp"

#include <cmath>

namespace livermark::live {

namespace {

constexpr int parts_of_edge = 4;

/// Barycentric coordinates of the middles of 16 equal triangles.
std::vector<std::array<double, 3>> middles() {
    std::vector<std::array<double, 3>> found;
    for (int i = 0; i < parts_of_edge; ++i)
        for (int j = 0; i + j < parts_of_edge; ++j) {
            const auto at = [&](double offset) {
                const double a = (i + offset) / parts_of_edge, b = (j + offset) / parts_of_edge;
                found.push_back({a, b, 1.0 - a - b});
            };
            at(1.0 / 3.0);
            if (i + j < parts_of_edge - 1)
                at(2.0 / 3.0);
        }
    return found;
}

} // namespace

std::vector<int> near_triangles(const Surface &surface, const Sphere &sphere, double margin,
                                const PositionOf &position_of) {
    // Each node belongs to six triangles.
    std::vector<core::Vector3> position(surface.nodal_area.size());
    for (const int node : surface.nodes)
        position[node] = position_of(node);
    std::vector<int> found;
    for (int t = 0; t < static_cast<int>(surface.triangles.size()); ++t) {
        const auto [a, b, c] = surface.triangles[t];
        const auto &x = position[a], &y = position[b], &z = position[c];
        const core::Vector3 middle = (x + y + z) / 3.0;
        const double size =
            std::sqrt(std::max({(x - middle).squaredNorm(), (y - middle).squaredNorm(), (z - middle).squaredNorm()}));
        const double reach = sphere.radius + size + margin;
        if ((middle - sphere.centre).squaredNorm() < reach * reach)
            found.push_back(t);
    }
    return found;
}

void add_contact(const Surface &surface, const std::vector<int> &triangles, const Sphere &sphere, double modulus,
                 const PositionOf &position_of, Load &load) {
    static const auto parts = middles();
    for (const int t : triangles) {
        const auto [a, b, c] = surface.triangles[t];
        const core::Vector3 x = position_of(a), y = position_of(b), z = position_of(c);
        const core::Vector3 normal = (y - x).cross(z - x);
        if (normal.dot(sphere.centre - (x + y + z) / 3.0) <= 0.0)
            continue;
        const double stiffness = modulus * surface.area[t] / static_cast<double>(parts.size());
        core::Vector3 sum = core::Vector3::Zero();
        std::array<core::Vector3, 3> on_corner{sum, sum, sum};
        for (const auto &share : parts) {
            const core::Vector3 from_centre = share[0] * x + share[1] * y + share[2] * z - sphere.centre;
            const double square = from_centre.squaredNorm();
            if (square >= sphere.radius * sphere.radius || square == 0.0)
                continue;
            const double distance = std::sqrt(square);
            const core::Vector3 force = stiffness * (sphere.radius - distance) / distance * from_centre;
            sum += force;
            for (std::size_t corner = 0; corner < 3; ++corner)
                on_corner[corner] += share[corner] * force;
        }
        if (!sum.isZero(0.0))
            add_forces(load, surface, t, sum, on_corner);
    }
}

} // namespace livermark::live
