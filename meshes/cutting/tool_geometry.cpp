#include "meshes/cutting/parting.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <limits>
#include <memory>
#include <utility>

#include "core/mesh/tetra_mesh.hpp"

namespace livermark::meshes {

namespace {

using core::Vector3;
using Corners = std::array<Vector3, 3>;

std::array<Corners, 2> triangles_of(const BladeCut &blade) {
    const auto &[a, b, c, d] = blade.corners;
    return {{{a, b, c}, {a, c, d}}};
}

double distance_to(const Corners &triangle, const Vector3 &point) {
    return (core::nearest_of_triangle(triangle, point) - point).norm();
}

double distance_to(const BladeCut &blade, const Vector3 &point) {
    const auto [first, second] = triangles_of(blade);
    return std::min(distance_to(first, point), distance_to(second, point));
}

/// Place where a segment goes through a triangle, from either side. (Moeller and Trumbore 1997)
std::optional<double> crossing_of(const Corners &triangle, const Vector3 &from, const Vector3 &to) {
    constexpr double parallel = 1e-12; // sine of an angle: what lies in the plane goes nowhere through it
    constexpr double rounding = 1e-9;  // a segment through a common side goes through one of both at least
    const Vector3 ab = triangle[1] - triangle[0], ac = triangle[2] - triangle[0], way = to - from;
    const Vector3 normal = ab.cross(ac);
    const double volume = -normal.dot(way);
    if (std::abs(volume) <= parallel * normal.norm() * way.norm())
        return std::nullopt;
    const Vector3 start = from - triangle[0];
    const double along = normal.dot(start) / volume;
    const Vector3 side = start.cross(way);
    const double v = ac.dot(side) / volume, w = -ab.dot(side) / volume;
    if (!(along >= 0.0 && along <= 1.0) || v < -rounding || w < -rounding || v + w > 1.0 + rounding)
        return std::nullopt;
    return along;
}

/// Smallest distance of two segments. (C. Ericson 2005, Real-Time Collision Detection, 5.1.9)
double distance_of(const Vector3 &p, const Vector3 &q, const Vector3 &r, const Vector3 &s) {
    const Vector3 d = q - p, e = s - r, between = p - r;
    const double a = d.squaredNorm(), b = d.dot(e), c = d.dot(between), f = e.dot(between), g = e.squaredNorm();
    const double denominator = a * g - b * b;
    double u = denominator > 0.0 ? std::clamp((b * f - c * g) / denominator, 0.0, 1.0) : 0.0;
    double v = (b * u + f) / g;
    if (v < 0.0 || v > 1.0) {
        v = std::clamp(v, 0.0, 1.0);
        u = std::clamp((b * v - c) / a, 0.0, 1.0);
    }
    return (between + u * d - v * e).norm();
}

/// 0 where they cross.
double distance_of(const Corners &one, const Corners &other) {
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < 3; ++i) {
        if (crossing_of(one, other[i], other[(i + 1) % 3]) || crossing_of(other, one[i], one[(i + 1) % 3]))
            return 0.0;
        nearest = std::min({nearest, distance_to(one, other[i]), distance_to(other, one[i])});
        for (std::size_t j = 0; j < 3; ++j)
            nearest = std::min(nearest, distance_of(one[i], one[(i + 1) % 3], other[j], other[(j + 1) % 3]));
    }
    return nearest;
}

std::array<Vector3, 4> corners_of(const core::TetraMesh &mesh, std::size_t t) {
    const auto &[a, b, c, d] = mesh.tetrahedra[t];
    return {mesh.points[a], mesh.points[b], mesh.points[c], mesh.points[d]};
}

bool holds(const std::array<Vector3, 4> &x, const Vector3 &point) {
    return std::ranges::all_of(core::tetrahedron_faces, [&](const auto &face) {
        const Vector3 area = (x[face[1]] - x[face[0]]).cross(x[face[2]] - x[face[0]]);
        return area.dot(point - x[face[0]]) <= 0.0;
    });
}

/// Whether a tetrahedron is nearer to a blade than half its thickness.
bool touches(const BladeCut &blade, const std::array<Vector3, 4> &x) {
    for (const auto &triangle : triangles_of(blade)) {
        if (holds(x, triangle[0]))
            return true;
        for (const auto &[a, b, c] : core::tetrahedron_faces)
            if (distance_of({x[a], x[b], x[c]}, triangle) < 0.5 * blade.thickness)
                return true;
    }
    return false;
}

/// A triangle, and a ball that it is in.
struct Facet {
    Corners corners;
    Vector3 middle;
    double radius;
};

Facet ball_around(const Corners &triangle) {
    const Vector3 middle = (triangle[0] + triangle[1] + triangle[2]) / 3.0;
    double radius = 0.0;
    for (const auto &corner : triangle)
        radius = std::max(radius, (corner - middle).norm());
    return {triangle, middle, radius};
}

/// The surface of a region, for distances from outside.
class RegionSurface {
  public:
    RegionSurface(const core::TetraMesh &mesh, int region) {
        std::vector<std::array<int, 4>> inside;
        for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t)
            if (mesh.region[t] == region)
                inside.push_back(mesh.tetrahedra[t]);
        for (const auto &[a, b, c] : core::outer_faces(inside)) {
            facets_.push_back(ball_around({mesh.points[a], mesh.points[b], mesh.points[c]}));
            for (const auto &corner : facets_.back().corners)
                box_.extend(corner);
        }
    }

    /// Beyond this, the distance from the box around the surface.
    double distance(const Vector3 &point, double farthest) const {
        if (const double from_box = box_.exteriorDistance(point); from_box > farthest)
            return from_box;
        double nearest = std::numeric_limits<double>::infinity();
        for (const auto &[triangle, middle, radius] : facets_)
            if ((point - middle).norm() - radius < nearest)
                nearest = std::min(nearest, distance_to(triangle, point));
        return nearest;
    }

  private:
    std::vector<Facet> facets_;
    Eigen::AlignedBox3d box_;
};

int number_of(const std::string &region, const core::TetraMesh &mesh) {
    return static_cast<int>(std::ranges::find(mesh.region_names, region) - mesh.region_names.begin());
}

std::vector<bool> tetrahedra_in(int region, const core::TetraMesh &mesh) {
    std::vector<bool> inside(mesh.tetrahedra.size());
    for (std::size_t t = 0; t < inside.size(); ++t)
        inside[t] = mesh.region[t] == region;
    return inside;
}

/// A tetrahedron with more than half of its neighbours on the other side goes there, so that neither spikes nor dents
/// are left. Each change leaves a smaller number of faces between both.
void go_with_most_neighbours(std::vector<bool> &taken, const std::vector<bool> &is_in_region,
                             const core::TetraMesh &mesh) {
    const auto neighbours = core::face_neighbours(mesh.tetrahedra);
    for (bool has_changed = true; has_changed;) {
        has_changed = false;
        for (std::size_t t = 0; t < taken.size(); ++t) {
            int num_neighbours = 0, num_others = 0;
            for (const int other : neighbours[t])
                if (other >= 0) {
                    ++num_neighbours;
                    num_others += taken[other] != taken[t];
                }
            if (!is_in_region[t] && 2 * num_others > num_neighbours) {
                taken[t] = !taken[t];
                has_changed = true;
            }
        }
    }
}

std::vector<double> levels_of_nodes(const ToolLevel &level, const core::TetraMesh &mesh) {
    std::vector<double> levels;
    levels.reserve(mesh.points.size());
    for (const auto &point : mesh.points)
        levels.push_back(level.at(point));
    return levels;
}

ToolLevel level_around(const RegionCut &cut, const core::TetraMesh &mesh) {
    const int region = number_of(cut.region, mesh);
    const auto surface = std::make_shared<const RegionSurface>(mesh, region);
    ToolLevel level{
        [surface, margin = cut.margin](const Vector3 &point) { return surface->distance(point, margin) - margin; },
        {},
        tetrahedra_in(region, mesh)};
    level.node_values = levels_of_nodes(level, mesh);
    for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t)
        if (level.is_in_region[t])
            for (const int node : mesh.tetrahedra[t])
                level.node_values[node] = -cut.margin;
    return level;
}

} // namespace

std::optional<double> crossing_of(const BladeCut &blade, const Vector3 &a, const Vector3 &b) {
    for (const auto &triangle : triangles_of(blade))
        if (const auto along = crossing_of(triangle, a, b))
            return along;
    return std::nullopt;
}

bool is_above(const BladeCut &blade, const Vector3 &point) {
    const auto [first, second] = triangles_of(blade);
    const auto &nearer = distance_to(first, point) <= distance_to(second, point) ? first : second;
    return (nearer[1] - nearer[0]).cross(nearer[2] - nearer[0]).dot(point - nearer[0]) > 0.0;
}

ToolLevel tool_level(const CutTool &tool, const core::TetraMesh &mesh) {
    if (const auto *region = std::get_if<RegionCut>(&tool))
        return level_around(*region, mesh);
    ToolLevel level;
    if (const auto *half_space = std::get_if<HalfSpaceCut>(&tool))
        level.at = [point = half_space->point, normal = Vector3(half_space->normal.normalized())](const Vector3 &x) {
            return normal.dot(point - x);
        };
    else
        level.at = [blade = std::get<BladeCut>(tool)](const Vector3 &x) {
            return distance_to(blade, x) - 0.5 * blade.thickness;
        };
    level.node_values = levels_of_nodes(level, mesh);
    return level;
}

std::vector<bool> tetrahedra_taken(const CutTool &tool, const core::TetraMesh &mesh) {
    std::vector<bool> taken(mesh.tetrahedra.size(), false);
    if (const auto *blade = std::get_if<BladeCut>(&tool)) {
        Eigen::AlignedBox3d reach;
        for (const auto &corner : blade->corners)
            reach.extend(corner);
        reach.min().array() -= blade->thickness;
        reach.max().array() += blade->thickness;
        for (std::size_t t = 0; t < taken.size(); ++t) {
            const auto corners = corners_of(mesh, t);
            Eigen::AlignedBox3d box;
            for (const auto &corner : corners)
                box.extend(corner);
            taken[t] = reach.intersects(box) && touches(*blade, corners);
        }
        return taken;
    }
    auto level = tool_level(tool, mesh);
    level.is_in_region.resize(taken.size(), false);
    for (std::size_t t = 0; t < taken.size(); ++t) {
        const auto corners = corners_of(mesh, t);
        taken[t] = level.is_in_region[t] || level.at(0.25 * (corners[0] + corners[1] + corners[2] + corners[3])) < 0.0;
    }
    go_with_most_neighbours(taken, level.is_in_region, mesh);
    return taken;
}

double distance_between(std::span<const std::array<core::Vector3, 3>> triangles,
                        std::span<const std::array<core::Vector3, 3>> others) {
    std::vector<Facet> facets;
    for (const auto &triangle : others)
        facets.push_back(ball_around(triangle));
    double nearest = std::numeric_limits<double>::infinity();
    for (const auto &triangle : triangles) {
        const auto facet = ball_around(triangle);
        for (const auto &other : facets)
            if ((facet.middle - other.middle).norm() - facet.radius - other.radius < nearest)
                nearest = std::min(nearest, distance_of(facet.corners, other.corners));
    }
    return nearest;
}

namespace {

[[noreturn]] void refuse_tool(const Cut &cut, const std::string &what, const std::string &remedy) {
    throw support::InputError("{}: {}; {}", cut.place, what, remedy);
}

void refuse_infinite(std::span<const core::Vector3> points, const Cut &cut) {
    if (!std::ranges::all_of(points, [](const core::Vector3 &point) { return point.allFinite(); }))
        refuse_tool(cut, "a coordinate is not finite", "correct it");
}

void check_blade(const BladeCut &blade, const Cut &cut) {
    refuse_infinite(blade.corners, cut);
    if (!(blade.thickness >= 0.0) || !std::isfinite(blade.thickness))
        refuse_tool(cut, fmt::format("the blade has a thickness of {} m", blade.thickness), "give 0 or more");
    const auto &[a, b, c, d] = blade.corners;
    const core::Vector3 first = (b - a).cross(c - a), second = (c - a).cross(d - a);
    const double size = core::extent(blade.corners);
    constexpr double flat = 1e-6;
    if (!(std::min(first.norm(), second.norm()) > flat * size * size) || !(first.dot(second) > 0.0))
        refuse_tool(cut, "the corners of the blade do not form a quadrilateral", "give four in turn, not on one line");
}

} // namespace

CutNotOnBody::CutNotOnBody(const std::string &place, std::string reason, std::string remedy)
    : InputError("{}: {}; {}", place, reason, remedy), place_(place), reason_(std::move(reason)),
      remedy_(std::move(remedy)) {}

void check_cut(const Cut &cut, const core::TetraMesh &mesh) {
    const auto &names = mesh.region_names;
    if (const auto *region = std::get_if<RegionCut>(&cut.tool)) {
        if (!(region->margin >= 0.0) || !std::isfinite(region->margin))
            refuse_tool(cut, fmt::format("the margin is {} m", region->margin), "give 0 or more");
        if (std::ranges::find(names, region->region) == names.end())
            throw CutNotOnBody(cut.place, fmt::format("the body has no region '{}'", region->region),
                               fmt::format("it has {}", fmt::join(names, ", ")));
    } else if (const auto *half_space = std::get_if<HalfSpaceCut>(&cut.tool)) {
        refuse_infinite(std::array{half_space->point, half_space->normal}, cut);
        if (!(half_space->normal.norm() > 0.0))
            refuse_tool(cut, "the normal of the plane is zero", "give one that points to what is taken away");
    } else {
        check_blade(std::get<BladeCut>(cut.tool), cut);
    }
}

} // namespace livermark::meshes
