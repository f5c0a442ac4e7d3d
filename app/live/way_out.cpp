#include "app/live/way_out.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "app/live/parameters.hpp"
#include "core/mesh/tetra_mesh.hpp"
#include "meshes/cutting/parting.hpp"

namespace livermark::live {

namespace {

using core::Vector3;
using Edge = std::pair<int, int>;

/// Directions that are nearer to one that has been tried are not tried [cosine of an angle].
constexpr double tried_cosine = 0.995;
/// Channels of which the one that takes the least volume is chosen.
constexpr std::size_t most_channels = 40;

Edge edge_of(int a, int b) {
    return std::minmax(a, b);
}

/// Parts of the wound that hang together by edges, as numbers of boundary triangles.
std::vector<std::vector<int>> parts_of_wound(const Remains &remains, const std::map<Edge, std::vector<int>> &at_edge) {
    const auto &triangles = remains.mesh.boundary_triangles;
    std::vector<char> is_seen(triangles.size(), 0);
    std::vector<std::vector<int>> parts;
    for (std::size_t f = 0; f < triangles.size(); ++f) {
        if (remains.facet[f] >= 0 || is_seen[f] != 0)
            continue;
        auto &part = parts.emplace_back(1, static_cast<int>(f));
        is_seen[f] = 1;
        for (std::size_t at = 0; at < part.size(); ++at)
            for (std::size_t k = 0; k < 3; ++k) {
                const auto &nodes = triangles[part[at]];
                for (const int other : at_edge.at(edge_of(nodes[k], nodes[(k + 1) % 3])))
                    if (remains.facet[other] < 0 && is_seen[other] == 0) {
                        is_seen[other] = 1;
                        part.push_back(other);
                    }
            }
    }
    return parts;
}

/// Volume that some triangles enclose from outside of it [m^3].
double volume_within(const core::TetraMesh &mesh, const std::vector<int> &triangles) {
    double volume = 0.0;
    for (const int f : triangles)
        volume -= mesh.points[mesh.boundary_triangles[f][0]].dot(core::area_vector(mesh, f)) / 3.0;
    return volume;
}

std::vector<std::array<Vector3, 3>> corners_of(const core::TetraMesh &mesh, const std::vector<int> &triangles) {
    std::vector<std::array<Vector3, 3>> corners;
    for (const int f : triangles) {
        const auto &[a, b, c] = mesh.boundary_triangles[f];
        corners.push_back({mesh.points[a], mesh.points[b], mesh.points[c]});
    }
    return corners;
}

} // namespace

ClosedCavities closed_cavities(const Remains &remains) {
    const auto &mesh = remains.mesh;
    std::map<Edge, std::vector<int>> at_edge;
    std::vector<int> others;
    for (std::size_t f = 0; f < mesh.boundary_triangles.size(); ++f) {
        const auto &nodes = mesh.boundary_triangles[f];
        for (std::size_t k = 0; k < 3; ++k)
            at_edge[edge_of(nodes[k], nodes[(k + 1) % 3])].push_back(static_cast<int>(f));
        if (remains.facet[f] >= 0)
            others.push_back(static_cast<int>(f));
    }
    ClosedCavities closed{.is_at = std::vector<char>(mesh.points.size(), 0)};
    std::vector<int> walls;
    for (const auto &part : parts_of_wound(remains, at_edge)) {
        const bool is_open = std::ranges::any_of(part, [&](int f) {
            const auto &nodes = mesh.boundary_triangles[f];
            for (std::size_t k = 0; k < 3; ++k)
                for (const int other : at_edge.at(edge_of(nodes[k], nodes[(k + 1) % 3])))
                    if (remains.facet[other] >= 0)
                        return true;
            return false;
        });
        const double volume = is_open ? 0.0 : volume_within(mesh, part);
        if (volume <= 0.0)
            continue;
        closed.volume += volume;
        walls.insert(walls.end(), part.begin(), part.end());
    }
    for (const int f : walls)
        for (const int node : mesh.boundary_triangles[f])
            closed.is_at[node] = 1;
    if (!walls.empty())
        closed.depth = meshes::distance_between(corners_of(mesh, walls), corners_of(mesh, others));
    return closed;
}

namespace {

/// A region as what has to come out.
struct Lesion {
    std::vector<Vector3> corners; ///< its nodes, each once [m]
    Vector3 middle;               ///< centroid of its volume [m]
};

Lesion lesion_of(const core::TetraMesh &mesh, int region, const std::vector<Vector3> &centroids) {
    const auto volumes = core::tetrahedron_volumes(mesh);
    std::set<int> nodes;
    Lesion lesion{.corners = {}, .middle = Vector3::Zero()};
    double volume = 0.0;
    for (std::size_t t = 0; t < volumes.size(); ++t)
        if (mesh.region[t] == region) {
            nodes.insert(mesh.tetrahedra[t].begin(), mesh.tetrahedra[t].end());
            lesion.middle += volumes[t] * centroids[t];
            volume += volumes[t];
        }
    lesion.middle /= volume;
    for (const int node : nodes)
        lesion.corners.push_back(mesh.points[node]);
    return lesion;
}

struct Cylinder {
    Vector3 from;      ///< end of its axis [m]
    Vector3 direction; ///< of length 1
    double radius;     ///< [m]
    double length;     ///< [m]

    bool holds(const Vector3 &point) const {
        const double along = direction.dot(point - from);
        return along >= 0.0 && along <= length && distance(point) <= radius;
    }
    /// From the axis [m].
    double distance(const Vector3 &point) const {
        const Vector3 way = point - from;
        return (way - direction.dot(way) * direction).norm();
    }
};

/// A place of the free surface that a channel may lead to.
struct Exit {
    Vector3 place;  ///< [m]
    double between; ///< distance from the lesion [m]
};

std::vector<Exit> exits_of(const Remains &before, const std::vector<bool> &is_constrained, const Lesion &lesion) {
    std::vector<Exit> exits;
    for (std::size_t f = 0; f < before.facet.size(); ++f) {
        if (before.facet[f] < 0 || is_constrained[before.facet[f]])
            continue;
        const auto &[a, b, c] = before.mesh.boundary_triangles[f];
        const auto &points = before.mesh.points;
        Exit exit{(points[a] + points[b] + points[c]) / 3.0, std::numeric_limits<double>::infinity()};
        for (const auto &corner : lesion.corners)
            exit.between = std::min(exit.between, (corner - exit.place).norm());
        exits.push_back(exit);
    }
    std::ranges::stable_sort(exits, {}, &Exit::between);
    return exits;
}

} // namespace

std::vector<int> way_out(const Remains &before, const std::string &region, const std::vector<bool> &is_constrained,
                         const std::vector<bool> &taken, const std::vector<std::array<int, 4>> &neighbours) {
    const auto &mesh = before.mesh;
    const auto number = static_cast<int>(std::ranges::find(mesh.region_names, region) - mesh.region_names.begin());
    const int main = largest_region(mesh);
    const auto constrained = constrained_nodes(mesh, constrained_remains(before, is_constrained));
    std::vector<Vector3> centroids;
    for (const auto &[a, b, c, d] : mesh.tetrahedra)
        centroids.push_back(0.25 * (mesh.points[a] + mesh.points[b] + mesh.points[c] + mesh.points[d]));
    const auto lesion = lesion_of(mesh, number, centroids);
    std::map<std::array<int, 3>, int> facet_of;
    for (std::size_t f = 0; f < before.facet.size(); ++f)
        facet_of[core::face_key(mesh.boundary_triangles[f])] = before.facet[f];
    const auto channel_in = [&](const Cylinder &cylinder) {
        std::vector<int> channel;
        std::vector<char> is_in(taken.size(), 0);
        const auto take = [&](int t) {
            if (t >= 0 && !taken[t] && is_in[t] == 0 && cylinder.holds(centroids[t])) {
                is_in[t] = 1;
                channel.push_back(t);
            }
        };
        for (std::size_t t = 0; t < taken.size(); ++t)
            if (taken[t])
                std::ranges::for_each(neighbours[t], take);
        bool gets_out = false;
        for (std::size_t at = 0; at < channel.size(); ++at) {
            const int t = channel[at];
            const bool is_at_constrained =
                std::ranges::any_of(mesh.tetrahedra[t], [&](int node) { return constrained[node]; });
            if (is_at_constrained || (mesh.region[t] != main && mesh.region[t] != number))
                return std::vector<int>{};
            for (std::size_t k = 0; k < 4; ++k) {
                if (neighbours[t][k] >= 0)
                    continue;
                gets_out = gets_out || facet_of.at(core::face_key(mesh.tetrahedra[t], k)) >= 0;
            }
            std::ranges::for_each(neighbours[t], take);
        }
        return gets_out ? channel : std::vector<int>{};
    };
    const auto volumes = core::tetrahedron_volumes(mesh);
    double smallest = std::numeric_limits<double>::infinity();
    std::vector<int> best;
    std::size_t num_channels = 0;
    std::vector<Vector3> tried;
    for (const auto &exit : exits_of(before, is_constrained, lesion)) {
        Cylinder cylinder{lesion.middle, (exit.place - lesion.middle).normalized(), 0.0, 0.0};
        const auto &direction = cylinder.direction;
        if (std::ranges::any_of(tried, [&](const Vector3 &other) { return other.dot(direction) > tried_cosine; }))
            continue;
        tried.push_back(direction);
        for (const auto &corner : lesion.corners)
            cylinder.radius = std::max(cylinder.radius, cylinder.distance(corner));
        cylinder.length = (exit.place - lesion.middle).norm() + cylinder.radius; // the surface may be aslant
        auto channel = channel_in(cylinder);
        if (channel.empty())
            continue;
        double volume = 0.0;
        for (const int t : channel)
            volume += volumes[t];
        if (volume < smallest) {
            smallest = volume;
            best = std::move(channel);
        }
        if (++num_channels == most_channels)
            break;
    }
    return best;
}

} // namespace livermark::live
