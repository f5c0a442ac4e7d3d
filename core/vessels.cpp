#include "core/vessels.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "core/mesh/places.hpp"
#include "core/problem.hpp"

namespace livermark::core {

double VesselTree::axial_stiffness(std::size_t segment, double young_modulus) const {
    const auto [a, b] = segments[segment];
    const double r = 0.5 * (radius[static_cast<std::size_t>(a)] + radius[static_cast<std::size_t>(b)]);
    const double inner = 1.0 - wall_ratio;
    return std::max(0.0, std::numbers::pi * r * r * (wall_modulus * (1.0 - inner * inner) - young_modulus));
}

double VesselTree::length(std::size_t segment) const {
    const auto [a, b] = segments[segment];
    return (points[static_cast<std::size_t>(b)] - points[static_cast<std::size_t>(a)]).norm();
}

Vector3 VesselPoint::pull(const Vector3 &moved) const {
    const double stretch = moved.norm();
    return weight * (1.0 - 1.0 / stretch) * moved;
}

double VesselPoint::energy(const Vector3 &moved) const {
    const double change = moved.norm() - 1.0;
    return 0.5 * weight * change * change;
}

Eigen::Matrix3d VesselPoint::stiffness(const Vector3 &moved) const {
    const double stretch = moved.norm();
    const Vector3 along = moved / stretch;
    const Eigen::Matrix3d axial = along * along.transpose();
    return weight * (axial + (1.0 - 1.0 / stretch) * (Eigen::Matrix3d::Identity() - axial));
}

namespace {

constexpr int num_fibres = 6;

/// Distance by which lines are moved, over the size of the tree.
constexpr double shift_part = 1e-6;

/// Vector in no plane that a mesh is likely to have.
Vector3 shift_of(const VesselTree &tree) {
    Eigen::AlignedBox3d box;
    for (const auto &point : tree.points)
        box.extend(point);
    return shift_part * box.diagonal().norm() * Vector3(0.6132, 0.3719, 0.6969);
}

/// Part of a straight line, from 0 to 1 along it.
struct Interval {
    double begin = 0.0, end = 1.0;

    double length() const { return std::max(0.0, end - begin); }
};

/// The part of a line along which a coordinate that is linear is positive.
void keep_positive(double at_begin, double at_end, Interval &interval) {
    const double slope = at_end - at_begin;
    if (slope == 0.0) {
        if (at_begin < 0.0)
            interval.end = interval.begin;
        return;
    }
    const double zero = -at_begin / slope;
    if (slope > 0.0)
        interval.begin = std::max(interval.begin, zero);
    else
        interval.end = std::min(interval.end, zero);
}

/// Barycentric coordinates in one tetrahedron.
struct Coordinates {
    Coordinates(const TetraMesh &mesh, const std::array<int, 4> &nodes)
        : corner(mesh.points[static_cast<std::size_t>(nodes[0])]), gradients(coordinate_gradients(mesh, nodes)) {}

    Eigen::Vector4d of(const Vector3 &point) const {
        const Vector3 others = gradients.transpose() * (point - corner);
        return {1.0 - others.sum(), others[0], others[1], others[2]};
    }

    Vector3 corner;
    Eigen::Matrix3d gradients;
};

/// Straight fibre of a wall.
struct Fibre {
    std::size_t segment;
    Vector3 begin, end;
};

/// Fibres around each axis, at the radius that gives their sum the second moment of the wall.
std::vector<Fibre> fibres_of(const VesselTree &tree) {
    const Vector3 shift = shift_of(tree);
    const double inner = 1.0 - tree.wall_ratio, of_radius = std::sqrt(0.5 * (1.0 + inner * inner));
    std::vector<Fibre> fibres;
    for (std::size_t s = 0; s < tree.segments.size(); ++s) {
        const auto [a, b] = tree.segments[s];
        const auto first = static_cast<std::size_t>(a), second = static_cast<std::size_t>(b);
        const Vector3 begin = tree.points[first] + shift, end = tree.points[second] + shift;
        const Vector3 side = (end - begin).unitOrthogonal(), other = (end - begin).normalized().cross(side);
        const double radius = of_radius * 0.5 * (tree.radius[first] + tree.radius[second]);
        for (int k = 0; k < num_fibres; ++k) {
            const double angle = 2.0 * std::numbers::pi * k / num_fibres;
            const Vector3 outwards = radius * (std::cos(angle) * side + std::sin(angle) * other);
            fibres.push_back({s, begin + outwards, end + outwards});
        }
    }
    return fibres;
}

/// Calls visit(tetrahedron, fibre, its part in there, coordinates of its ends) wherever a fibre passes.
template <class Visit> void for_each_passage(const VesselTree &tree, const TetraMesh &mesh, const Visit &visit) {
    const auto fibres = fibres_of(tree);
    std::vector<Eigen::AlignedBox3d> boxes;
    Eigen::AlignedBox3d around;
    for (const auto &fibre : fibres) {
        boxes.emplace_back(fibre.begin).extend(fibre.end);
        around.extend(boxes.back());
    }
    for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
        Eigen::AlignedBox3d box;
        for (const int node : mesh.tetrahedra[t])
            box.extend(mesh.points[static_cast<std::size_t>(node)]);
        if (!box.intersects(around))
            continue;
        std::optional<Coordinates> coordinates;
        for (std::size_t f = 0; f < fibres.size(); ++f) {
            if (!box.intersects(boxes[f]))
                continue;
            if (!coordinates)
                coordinates.emplace(mesh, mesh.tetrahedra[t]);
            const auto at_begin = coordinates->of(fibres[f].begin), at_end = coordinates->of(fibres[f].end);
            Interval interval;
            for (int k = 0; k < 4; ++k)
                keep_positive(at_begin[k], at_end[k], interval);
            if (interval.length() > 0.0)
                visit(t, fibres[f], interval, at_begin, at_end);
        }
    }
}

} // namespace

std::vector<VesselPoint> vessel_points(const Body &body) {
    std::vector<VesselPoint> points;
    if (!body.vessels)
        return points;
    const auto &tree = *body.vessels;
    constexpr double gauss = 0.5 / std::numbers::sqrt3; // from the middle
    for_each_passage(
        tree, body.mesh,
        [&](std::size_t t, const Fibre &fibre, const Interval &inside, const auto &at_begin, const auto &at_end) {
            const Vector3 direction = (fibre.end - fibre.begin).normalized();
            const double weight = 0.5 / num_fibres * inside.length() * tree.length(fibre.segment) *
                                  tree.axial_stiffness(fibre.segment, body.young_modulus_of(t));
            for (const double from_middle : {-gauss, gauss}) {
                const double along = 0.5 * (inside.begin + inside.end) + from_middle * inside.length();
                points.push_back({static_cast<int>(t), (1.0 - along) * at_begin + along * at_end, direction, weight});
            }
        });
    return points;
}

double part_inside(const Body &body) {
    const auto &tree = body.vessels.value();
    double inside = 0.0, whole = 0.0;
    for (std::size_t s = 0; s < tree.segments.size(); ++s)
        whole += tree.length(s);
    for_each_passage(tree, body.mesh,
                     [&](std::size_t /*t*/, const Fibre &fibre, const Interval &part, const auto &, const auto &) {
                         inside += part.length() * tree.length(fibre.segment) / num_fibres;
                     });
    return inside / whole;
}

} // namespace livermark::core
