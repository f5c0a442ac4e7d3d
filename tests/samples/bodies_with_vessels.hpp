#pragma once

#include <memory>
#include <utility>

#include "core/problem.hpp"

/// Bodies with vessels as lines, and what closed forms say of them.
namespace livermark::tests::vessels {

/// A trunk with two branches in a block of 0.1 m; one of these ends outside it.
inline const core::VesselTree tree{
    .points = {{0.01, 0.02, 0.02}, {0.05, 0.04, 0.04}, {0.09, 0.07, 0.03}, {0.05, 0.05, 0.15}},
    .radius = {4e-3, 4e-3, 2e-3, 2e-3},
    .segments = {{0, 1}, {1, 2}, {1, 3}},
    .wall_ratio = 0.2,
    .wall_modulus = 1e6};

/// A straight tube of many points.
inline core::VesselTree chain(int num_points) {
    core::VesselTree chain{.points = {}, .radius = {}, .segments = {}, .wall_ratio = 0.1, .wall_modulus = 0.62e6};
    for (int p = 0; p < num_points; ++p) {
        chain.points.emplace_back(0.5, 0.5, (p + 0.5) / num_points);
        chain.radius.push_back(0.01);
        if (p > 0)
            chain.segments.push_back({p - 1, p});
    }
    return chain;
}

/// A straight tube that is solid, so that its section is pi r^2.
inline core::VesselTree rod(const core::Vector3 &begin, const core::Vector3 &end, double radius, double modulus) {
    return {.points = {begin, end},
            .radius = {radius, radius},
            .segments = {{0, 1}},
            .wall_ratio = 1.0,
            .wall_modulus = modulus};
}

inline std::shared_ptr<const core::Body> with_vessels(const std::shared_ptr<const core::Body> &body,
                                                      const core::VesselTree &vessels = tree) {
    auto other = *body;
    other.vessels = vessels;
    return std::make_shared<const core::Body>(std::move(other));
}

/// Length of a segment in a block of these sides at the origin [m].
inline double length_inside(const core::VesselTree &vessels, std::size_t segment, const core::Vector3 &sides) {
    const auto [a, b] = vessels.segments[segment];
    const core::Vector3 begin = vessels.points[static_cast<std::size_t>(a)],
                        way = vessels.points[static_cast<std::size_t>(b)] - begin;
    constexpr int num_parts = 100'000;
    int inside = 0;
    for (int k = 0; k < num_parts; ++k) {
        const core::Vector3 point = begin + (k + 0.5) / num_parts * way;
        inside += (point.array() > 0.0).all() && (point.array() < sides.array()).all() ? 1 : 0;
    }
    return inside * way.norm() / num_parts;
}

/// Energy of the vessels of a body of one material, a block, where F is the same everywhere [J].
inline double energy(const core::Body &body, const core::Vector3 &sides, const Eigen::Matrix3d &f) {
    const auto &vessels = body.vessels.value();
    double sum = 0.0;
    for (std::size_t s = 0; s < vessels.segments.size(); ++s) {
        const auto [a, b] = vessels.segments[s];
        const core::Vector3 direction =
            (vessels.points[static_cast<std::size_t>(b)] - vessels.points[static_cast<std::size_t>(a)]).normalized();
        const double change = (f * direction).norm() - 1.0;
        sum += 0.5 * vessels.axial_stiffness(s, body.materials.front().young_modulus) *
               length_inside(vessels, s, sides) * change * change;
    }
    return sum;
}

} // namespace livermark::tests::vessels
