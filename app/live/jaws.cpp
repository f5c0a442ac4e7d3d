#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <limits>

#include "app/live/scene.hpp"
#include "core/support/input_error.hpp"

namespace livermark::live {

namespace {

using core::Vector3;

/// Part of the thickness at rest by which jaws close at most: what is between them would be inverted.
constexpr double most_closed = 0.75;
/// Distance of the place from the surface at most, over the radius: the body has moved since the picture was drawn.
constexpr double beside_surface = 0.5;
/// Way at most out of the body until a jaw just touches it, over its radius; one is enough on a face across the axis.
constexpr double longest_way_out = 4.0;
/// Difference of distances, over the radius, with which a jaw just touches.
constexpr double nearly_touching = 1e-9;
constexpr int most_approaches = 1000;
/// Part of its area by which a triangle is larger for a line, so that none goes through between two.
constexpr double beside_triangle = 1e-9;

/// Boundary of the body as it is now.
struct Boundary {
    std::vector<core::Corners> corners; ///< of each triangle [m]
    const std::vector<bool> &is_constrained;
};

/// A line that goes through the boundary.
struct Crossing {
    double at = 0.0;        ///< along the line [m]
    bool is_inwards = true; ///< whether the line gets into the body there
};

/// All of them, ascending.
std::vector<Crossing> crossings(const Boundary &boundary, const Vector3 &from, const Vector3 &direction) {
    std::vector<Crossing> found;
    for (const auto &corners : boundary.corners) {
        const Vector3 normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        const double along = normal.dot(direction);
        if (along == 0.0)
            continue;
        const double at = normal.dot(corners[0] - from) / along;
        const Vector3 point = from + at * direction;
        bool is_in = true;
        for (std::size_t k = 0; k < 3; ++k) {
            const auto &a = corners[k], &b = corners[(k + 1) % 3];
            is_in = is_in && (b - a).cross(point - a).dot(normal) >= -beside_triangle * normal.squaredNorm();
        }
        if (is_in)
            found.push_back({at, along < 0.0});
    }
    std::ranges::sort(found, {}, &Crossing::at);
    return found;
}

/// Centre of a jaw that just touches, on the way out of the body: no nearer one on that line does.
/// @param from  on the surface [m]
Vector3 touching_centre(const Boundary &boundary, const Vector3 &from, const Vector3 &outwards, double radius) {
    double way = 0.0;
    for (int approach = 0; approach < most_approaches; ++approach) {
        Vector3 centre = from + way * outwards;
        double distance = std::numeric_limits<double>::infinity();
        std::size_t nearest = 0;
        for (std::size_t t = 0; t < boundary.corners.size(); ++t) {
            const double there = (core::nearest_of_triangle(boundary.corners[t], centre) - centre).norm();
            if (there < distance) {
                distance = there;
                nearest = t;
            }
        }
        if (distance > (1.0 - nearly_touching) * radius) {
            if (boundary.is_constrained[nearest])
                throw support::InputError("a jaw would stand on what is constrained; take another edge");
            return centre;
        }
        way += radius - distance; // the distance grows by no more
        if (way > longest_way_out * radius)
            break;
    }
    throw support::InputError("there is no room for jaws of this size beside the body; take smaller ones or another "
                              "edge");
}

} // namespace

Jaws jaws_around(const core::TetraMesh &mesh, const std::vector<bool> &is_constrained, const Tool &tool,
                 const PositionOf &position_of) {
    Boundary boundary{.corners = {}, .is_constrained = is_constrained};
    for (const auto &[a, b, c] : mesh.boundary_triangles)
        boundary.corners.push_back({position_of(a), position_of(b), position_of(c)});
    Jaws jaws{.axis = tool.inwards.normalized()};
    const auto through = crossings(boundary, tool.place, jaws.axis);
    auto entry = through.end();
    for (auto crossing = through.begin(); crossing != through.end(); ++crossing)
        if (crossing->is_inwards && std::abs(crossing->at) <= beside_surface * tool.radius &&
            (entry == through.end() || std::abs(crossing->at) < std::abs(entry->at)))
            entry = crossing;
    const auto exit = std::find_if(entry, through.end(), [](const Crossing &c) { return !c.is_inwards; });
    if (exit == through.end() || !(exit->at > entry->at))
        throw support::InputError("a grasp begins beside the body; press on its surface");
    if (exit->at - entry->at > widest_grasp)
        throw support::InputError(fmt::format("the body is {:.0f} mm thick there, and jaws open to {:.0f} mm; take an "
                                              "edge",
                                              1e3 * (exit->at - entry->at), 1e3 * widest_grasp));
    const Vector3 first = touching_centre(boundary, tool.place + entry->at * jaws.axis, -jaws.axis, tool.radius),
                  other = touching_centre(boundary, tool.place + exit->at * jaws.axis, jaws.axis, tool.radius);
    for (const auto &[a, b, c] : boundary.corners)
        jaws.is_for_other.push_back((b - a).cross(c - a).dot(jaws.axis) > 0.0);
    jaws.middle = 0.5 * (first + other);
    jaws.apart = 0.5 * (other - first).norm();
    jaws.thickness = 2.0 * (jaws.apart - tool.radius);
    if (!(jaws.thickness > 0.0))
        throw support::InputError("jaws of this size touch each other beside the edge; take smaller ones, or a place "
                                  "further in");
    return jaws;
}

bool are_one_grasp(const Tool &a, const Tool &b) {
    return a.kind == ToolKind::grasp && b.kind == ToolKind::grasp && a.place == b.place && a.inwards == b.inwards &&
           a.radius == b.radius && a.friction == b.friction;
}

void close(Jaws &jaws, double depth, double closing, double time_step) {
    const double goal = std::min(depth, 0.5 * most_closed * jaws.thickness), most = fastest_jaw * time_step;
    const double way = std::clamp(goal - jaws.depth, -most, closing < strongest_coupling ? most : 0.0);
    jaws.depth += way;
    jaws.speed = way / time_step;
}

} // namespace livermark::live
