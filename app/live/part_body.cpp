#include "app/live/part_body.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <utility>

#include "app/live/find_cut.hpp"
#include "core/support/input_error.hpp"
#include "meshes/cutting/parting.hpp"

namespace livermark::live {

namespace {

using core::Vector3;
using Corners = std::array<Vector3, 4>;

/// Part of its smallest height that a tetrahedron keeps.
constexpr double kept_height = 0.3;
/// A tetrahedron does not become flatter than this part of the smallest height in the body: that height has a say in
/// how long steps may be.
constexpr double flattest_part = 0.7;
/// Parts of the way to the blade that a node tries.
constexpr std::array parts_of_way{1.0, 0.75, 0.5, 0.25};
/// Times that faces are chosen again after nodes have gone to the blade.
constexpr int num_choices = 4;
/// Rounds in which all nodes try: one that has moved makes room for others.
constexpr int num_rounds = 3;

Corners corners_of(const std::vector<Vector3> &points, const std::array<int, 4> &nodes) {
    return {points[nodes[0]], points[nodes[1]], points[nodes[2]], points[nodes[3]]};
}

double volume_of(const Corners &x) {
    return (x[1] - x[0]).cross(x[2] - x[0]).dot(x[3] - x[0]) / 6.0;
}

/// Smallest height of a tetrahedron [m]; below 0 if it is inverted.
double height_of(const Corners &x) {
    double largest = 0.0;
    for (const auto &[a, b, c] : core::tetrahedron_faces)
        largest = std::max(largest, (x[b] - x[a]).cross(x[c] - x[a]).norm());
    return 6.0 * volume_of(x) / largest;
}

/// The plane of a blade next to a point.
struct Plane {
    Vector3 point, normal;

    double distance(const Vector3 &x) const { return normal.dot(x - point); }
};

Plane plane_at(const meshes::BladeCut &blade, const Vector3 &x) {
    const auto &[a, b, c, d] = blade.corners;
    const auto plane = [&](const Vector3 &p, const Vector3 &q, const Vector3 &r) {
        return Plane{p, (q - p).cross(r - p).normalized()};
    };
    const auto first = plane(a, b, c), second = plane(a, c, d);
    // Which side of the common diagonal the point is on.
    return (c - a).cross(first.normal).dot(x - a) * (c - a).cross(first.normal).dot(b - a) >= 0.0 ? first : second;
}

/// Weights of the corners of a tetrahedron at a point.
std::array<double, 4> weights_at(const Corners &x, const Vector3 &point) {
    const double volume = volume_of(x);
    std::array<double, 4> weights{};
    for (std::size_t k = 0; k < 4; ++k) {
        auto part = x;
        part[k] = point;
        weights[k] = volume_of(part) / volume;
    }
    return weights;
}

Vector3 nearest_on_segment(const Vector3 &a, const Vector3 &b, const Vector3 &x) {
    const double length = (b - a).squaredNorm();
    return length > 0.0 ? Vector3(a + std::clamp((b - a).dot(x - a) / length, 0.0, 1.0) * (b - a)) : a;
}

/// Place nearest to a node where a plane goes through the triangles around it; nothing if it goes through none.
std::optional<Vector3> crossing_near(const Plane &plane, const std::vector<Vector3> &points, int node,
                                     const std::vector<std::array<int, 2>> &fan) {
    const Vector3 &x = points[node];
    const double at_node = plane.distance(x);
    const auto between = [&](const Vector3 &p, double dp, const Vector3 &q, double dq) {
        return Vector3(p + dp / (dp - dq) * (q - p));
    };
    std::optional<Vector3> nearest;
    for (const auto &[b, c] : fan) {
        const double at_b = plane.distance(points[b]), at_c = plane.distance(points[c]);
        std::vector<Vector3> ends;
        if ((at_node < 0.0) != (at_b < 0.0))
            ends.push_back(between(x, at_node, points[b], at_b));
        if ((at_b < 0.0) != (at_c < 0.0))
            ends.push_back(between(points[b], at_b, points[c], at_c));
        if ((at_c < 0.0) != (at_node < 0.0))
            ends.push_back(between(points[c], at_c, x, at_node));
        if (ends.size() != 2)
            continue;
        const Vector3 place = nearest_on_segment(ends[0], ends[1], x);
        if (!nearest || (place - x).norm() < (*nearest - x).norm())
            nearest = place;
    }
    return nearest;
}

/// Nodes of a wound on their way to the blade.
class Snapping {
  public:
    Snapping(const core::TetraMesh &rest, std::vector<Vector3> moved, const std::vector<bool> &is_constrained,
             const meshes::BladeCut &blade)
        : rest_(&rest), stars_(core::tetrahedra_at_nodes(rest)), moved_before_(std::move(moved)), moved_(moved_before_),
          points_(rest.points), blade_(&blade), stays_(is_constrained), fans_(rest.points.size()) {
        flattest_ = std::numeric_limits<double>::infinity();
        for (const auto &nodes : rest.tetrahedra) {
            height_.push_back(height_of(corners_of(rest.points, nodes)));
            flattest_ = std::min(flattest_, height_.back());
        }
        for (std::size_t node = 0; node < stars_.size(); ++node) {
            before_.push_back(
                {{static_cast<int>(node), static_cast<int>(node), static_cast<int>(node), static_cast<int>(node)},
                 {1.0, 0.0, 0.0, 0.0}});
            for (const int t : stars_[node])
                if (rest.region[t] != rest.region[stars_[node].front()])
                    stays_[node] = true;
        }
        for (const auto &[a, b, c] : rest.boundary_triangles) {
            fans_[a].push_back({b, c});
            fans_[b].push_back({c, a});
            fans_[c].push_back({a, b});
        }
    }

    void run(const std::set<int> &nodes) {
        struct Way {
            int node;
            Vector3 target;
            double length;
            std::size_t gone = parts_of_way.size(); // which part it has gone
        };
        std::vector<Way> ways;
        for (const int node : nodes)
            if (const auto target = target_of(node))
                ways.push_back({node, *target, (*target - moved_before_[node]).norm()});
        std::ranges::stable_sort(ways, {}, &Way::length); // the nearest ones have the room first
        for (int round = 0; round < num_rounds; ++round)
            for (auto &[node, target, length, gone] : ways)
                for (std::size_t part = 0; part < gone; ++part)
                    if (go(node, moved_before_[node] + parts_of_way[part] * (target - moved_before_[node])))
                        gone = part;
    }

    const std::vector<Vector3> &points() const { return points_; } ///< at rest [m]
    const std::vector<Vector3> &moved() const { return moved_; }   ///< where the body is [m]
    const std::vector<PlaceBefore> &before() const { return before_; }

  private:
    std::optional<Vector3> target_of(int node) const {
        if (stays_[node])
            return std::nullopt;
        const Vector3 &x = moved_before_[node];
        const auto plane = plane_at(*blade_, x);
        if (!fans_[node].empty())
            return crossing_near(plane, moved_before_, node, fans_[node]);
        return x - plane.distance(x) * plane.normal;
    }

    /// Moves a node to a place if its tetrahedra bear it.
    bool go(int node, const Vector3 &place) {
        // The tetrahedron around it that has the place in it, or next to it.
        int within = -1;
        std::array<double, 4> weights{};
        double least = -std::numeric_limits<double>::infinity();
        for (const int t : stars_[node]) {
            const auto found = weights_at(corners_of(moved_before_, rest_->tetrahedra[t]), place);
            if (const double smallest = *std::ranges::min_element(found); smallest > least) {
                least = smallest;
                within = t;
                weights = found;
            }
        }
        if (within < 0)
            return false;
        const auto &nodes = rest_->tetrahedra[within];
        Vector3 point = Vector3::Zero();
        for (std::size_t k = 0; k < 4; ++k)
            point += weights[k] * rest_->points[nodes[k]];
        const Vector3 old_point = std::exchange(points_[node], point), old_moved = std::exchange(moved_[node], place);
        const bool is_borne = std::ranges::all_of(stars_[node], [&](int t) {
            const double least_height =
                std::max(kept_height * height_[t], std::min(height_[t], flattest_part * flattest_));
            return height_of(corners_of(points_, rest_->tetrahedra[t])) >= least_height &&
                   volume_of(corners_of(moved_, rest_->tetrahedra[t])) > 0.0;
        });
        if (is_borne) {
            before_[node] = {nodes, weights};
        } else {
            points_[node] = old_point;
            moved_[node] = old_moved;
        }
        return is_borne;
    }

    const core::TetraMesh *rest_;
    std::vector<std::vector<int>> stars_;
    std::vector<Vector3> moved_before_, moved_, points_;
    const meshes::BladeCut *blade_;
    std::vector<bool> stays_;
    std::vector<std::vector<std::array<int, 2>>> fans_; // of nodes on the boundary: the other two of each triangle
    std::vector<double> height_;                        // (M) at rest, before [m]
    double flattest_;
    std::vector<PlaceBefore> before_;
};

OffBlade off_blade(const meshes::BladeCut &blade, const std::vector<Vector3> &places,
                   std::span<const std::array<int, 3>> faces) {
    OffBlade off;
    double area = 0.0;
    for (const auto &[a, b, c] : faces) {
        const double part = 0.5 * (places[b] - places[a]).cross(places[c] - places[a]).norm();
        area += part;
        for (const int node : {a, b, c}) {
            const double distance = std::abs(plane_at(blade, places[node]).distance(places[node]));
            off.mean += part * distance / 3.0;
            off.worst = std::max(off.worst, distance);
        }
    }
    off.mean /= area;
    return off;
}

} // namespace

core::TetraMesh parted_mesh(const core::TetraMesh &original, std::vector<Vector3> points,
                            std::vector<std::array<int, 4>> tetrahedra) {
    core::TetraMesh mesh;
    mesh.points = std::move(points);
    mesh.tetrahedra = std::move(tetrahedra);
    mesh.region = original.region;
    mesh.region_names = original.region_names;
    mesh.boundary_triangles = original.boundary_triangles;
    mesh.boundary_patch = original.boundary_patch;
    mesh.patch_names = original.patch_names;
    std::map<std::array<int, 3>, int> number;
    for (int f = 0; f < original.num_boundary_triangles(); ++f)
        number[core::face_key(original.boundary_triangles[f])] = f;
    const auto neighbours = core::face_neighbours(mesh.tetrahedra);
    std::vector<std::array<int, 3>> parted;
    for (std::size_t t = 0; t < neighbours.size(); ++t)
        for (std::size_t k = 0; k < 4; ++k) {
            if (neighbours[t][k] >= 0)
                continue;
            const auto &nodes = mesh.tetrahedra[t], &nodes_before = original.tetrahedra[t];
            const auto found = number.find(core::face_key(nodes_before, k));
            if (found == number.end()) {
                const auto &[a, b, c] = core::tetrahedron_faces[k];
                parted.push_back({nodes[a], nodes[b], nodes[c]});
                continue;
            }
            for (int &node : mesh.boundary_triangles[found->second])
                node = nodes[std::ranges::find(nodes_before, node) - nodes_before.begin()];
        }
    if (parted.empty())
        return mesh;
    auto wound = std::ranges::find(mesh.patch_names, core::wound_patch) - mesh.patch_names.begin();
    if (wound == std::ssize(mesh.patch_names))
        mesh.patch_names.emplace_back(core::wound_patch);
    for (const auto &triangle : parted) {
        mesh.boundary_triangles.push_back(triangle);
        mesh.boundary_patch.push_back(static_cast<int>(wound));
    }
    return mesh;
}

namespace {

/// A parting and its wound.
struct Wound {
    meshes::PartedMesh parted;
    std::vector<std::array<int, 3>> faces; ///< in nodes before the parting, once
    std::set<int> nodes;                   ///< of these
};

/// @param mesh  where the body is
Wound wound_of(const meshes::BladeCut &blade, const core::TetraMesh &mesh) {
    Wound wound{.parted = meshes::part_along(mesh, meshes::faces_across(blade, mesh)), .faces = {}, .nodes = {}};
    const auto before = core::face_neighbours(mesh.tetrahedra), after = core::face_neighbours(wound.parted.tetrahedra);
    for (std::size_t t = 0; t < after.size(); ++t)
        for (std::size_t k = 0; k < 4; ++k)
            if (after[t][k] < 0 && before[t][k] > static_cast<int>(t)) {
                const auto &face = wound.faces.emplace_back(core::face_key(mesh.tetrahedra[t], k));
                wound.nodes.insert(face.begin(), face.end());
            }
    return wound;
}

} // namespace

PartedBody part_body(const core::TetraMesh &original, const core::TetraMesh &whole, const Remains &before,
                     const std::vector<bool> &is_constrained, const std::vector<Vector3> &displacement,
                     const meshes::BladeCut &blade) {
    auto moved = before.mesh;
    for (std::size_t i = 0; i < displacement.size(); ++i)
        moved.points[i] += displacement[i];
    auto wound = wound_of(blade, moved);
    if (wound.faces.empty())
        throw support::InputError("the blade parts nothing of the body; lead it through the body, or deeper");
    const Snapping at_first(before.mesh, moved.points, is_constrained, blade);
    auto snapping = at_first;
    snapping.run(wound.nodes);
    PartedBody result;
    result.jagged = off_blade(blade, moved.points, wound.faces);
    result.snapped = off_blade(blade, snapping.moved(), wound.faces);
    // Where nodes have gone to the blade, other faces are along it.
    for (int round = 0; round < num_choices; ++round) {
        auto closer = moved;
        closer.points = snapping.moved();
        auto other = wound_of(blade, closer);
        if (other.faces.empty() || other.faces == wound.faces)
            break;
        auto next = at_first;
        next.run(other.nodes);
        const auto off = off_blade(blade, next.moved(), other.faces);
        if (off.mean >= result.snapped.mean)
            break;
        result.snapped = off;
        wound = std::move(other);
        snapping = std::move(next);
    }
    for (const auto &[a, b, c] : wound.faces) {
        const auto &points = snapping.points();
        result.area += 0.5 * (points[b] - points[a]).cross(points[c] - points[a]).norm();
    }
    const auto &parted = wound.parted;
    auto points = snapping.points();
    result.before = snapping.before();
    result.parent_node = parted.parent_node;
    for (std::size_t node = points.size(); node < parted.points.size(); ++node) {
        points.push_back(Vector3(points[parted.parent_node[node]]));
        result.before.push_back(PlaceBefore(result.before[parted.parent_node[node]]));
    }
    auto tetrahedra = whole.tetrahedra;
    for (std::size_t t = 0; t < before.tetrahedron.size(); ++t) {
        const auto &nodes = before.mesh.tetrahedra[t];
        const bool has_moved = std::ranges::any_of(nodes, [&](int node) { return points[node] != whole.points[node]; });
        if (has_moved || parted.tetrahedra[t] != nodes)
            result.changed.push_back(before.tetrahedron[t]);
        tetrahedra[before.tetrahedron[t]] = parted.tetrahedra[t];
    }
    result.mesh = parted_mesh(original, std::move(points), std::move(tetrahedra));
    return result;
}

} // namespace livermark::live
