#include "core/tool/round_load.hpp"

#include <algorithm>
#include <cmath>

namespace livermark::core {

namespace {

std::array<double, 3> linear_shapes(const Vector3 &at) {
    return {at[0], at[1], at[2]};
}

std::array<double, 6> quadratic_shapes(const Vector3 &at) {
    return {at[0] * (2.0 * at[0] - 1.0), at[1] * (2.0 * at[1] - 1.0), at[2] * (2.0 * at[2] - 1.0),
            4.0 * at[0] * at[1],         4.0 * at[1] * at[2],         4.0 * at[2] * at[0]};
}

/// Means of h times each shape function over the mean of h.
/// @param even  where the traction is the same everywhere, and where a triangle is beyond the rim
template <std::size_t nodes>
std::array<double, nodes> parts_of(const RoundLoad *load, const Corners &corners,
                                   std::array<double, nodes> (*shapes)(const Vector3 &),
                                   const std::array<double, nodes> &even) {
    if (!load)
        return even;
    std::array<double, nodes> moment{};
    double sum = 0.0;
    visit_triangle_parts([&](const Vector3 &at) {
        const double height = load->height(point_at(corners, at));
        const auto shape = shapes(at);
        for (std::size_t k = 0; k < nodes; ++k)
            moment[k] += height * shape[k];
        sum += height;
    });
    if (sum == 0.0)
        return even;
    for (double &value : moment)
        value /= sum;
    return moment;
}

} // namespace

double RoundLoad::height(const Vector3 &point) const {
    return std::sqrt(std::max(0.0, 1.0 - (point - middle).squaredNorm() / (radius * radius)));
}

Corners corners_of(const TetraMesh &mesh, int facet) {
    const auto &[a, b, c] = mesh.boundary_triangles[facet];
    return {mesh.points[a], mesh.points[b], mesh.points[c]};
}

Vector3 point_at(const Corners &corners, const Vector3 &barycentric) {
    return barycentric[0] * corners[0] + barycentric[1] * corners[1] + barycentric[2] * corners[2];
}

double mean_height(const RoundLoad &load, const Corners &corners) {
    double sum = 0.0;
    visit_triangle_parts([&](const Vector3 &at) { sum += load.height(point_at(corners, at)); });
    return sum / num_triangle_parts;
}

std::array<double, 3> linear_parts(const RoundLoad *load, const Corners &corners) {
    constexpr double third = 1.0 / 3.0;
    return parts_of<3>(load, corners, linear_shapes, {third, third, third});
}

std::array<double, 6> quadratic_parts(const RoundLoad *load, const Corners &corners) {
    constexpr double third = 1.0 / 3.0;
    return parts_of<6>(load, corners, quadratic_shapes, {0.0, 0.0, 0.0, third, third, third});
}

std::vector<double> shares_of_parts(const RoundLoad *load, std::span<const Corners> parts) {
    std::vector<double> share(parts.size(), 1.0);
    if (!load)
        return share;
    double pressed = 0.0, area = 0.0;
    for (std::size_t k = 0; k < parts.size(); ++k) {
        const auto &[a, b, c] = parts[k];
        const double part = 0.5 * (b - a).cross(c - a).norm();
        share[k] = mean_height(*load, parts[k]);
        pressed += part * share[k];
        area += part;
    }
    for (double &value : share)
        value *= pressed > 0.0 ? area / pressed : 0.0;
    return share;
}

} // namespace livermark::core
