#include "meshes/cutting/parting.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/mesh/refinement.hpp"
#include "core/mesh/tetra_mesh.hpp"
#include "meshes/io/mesh_checks.hpp"

namespace livermark::meshes {

/// Moves a node if the tetrahedra around it stay good enough: quality of 0.1, or as much as before.
/// @param star  the tetrahedra at the node
/// @return whether it has moved
bool move_node(core::TetraMesh &mesh, std::span<const int> star, int node, const core::Vector3 &target);

/// Moves nodes at the cut, one by one, so that the worst tetrahedron around each gets better, and merges those that
/// stay bad with a neighbour where that helps. Nodes on the cut stay on it, or where they are if there is no level. The
/// volume of all tetrahedra together stays. Tetrahedra that are taken need a positive volume only.
/// @param split  loses the tetrahedra at edges that vanish; their nodes stay, without a tetrahedron
/// @param level  distance from the cut [m], or nothing
void improve(SplitBody &split, const std::function<double(const core::Vector3 &)> &level);

namespace {

using core::Vector3;

double quality_of(const core::TetraMesh &mesh, int t) {
    const auto &[a, b, c, d] = mesh.tetrahedra[t];
    const auto &x = mesh.points;
    return tetrahedron_quality(x[a], x[b], x[c], x[d]);
}

double worst_of(const core::TetraMesh &mesh, std::span<const int> star) {
    double worst = std::numeric_limits<double>::infinity();
    for (const int t : star)
        worst = std::min(worst, quality_of(mesh, t));
    return worst;
}

/// The worst quality of what stays around a node; negative where something is turned inside out.
double worst_that_stays(const core::TetraMesh &mesh, std::span<const int> star, const std::vector<bool> &taken) {
    constexpr double flat = 1e-6;
    double worst = std::numeric_limits<double>::infinity();
    for (const int t : star) {
        const double quality = quality_of(mesh, t);
        if (!taken[t])
            worst = std::min(worst, quality);
        else if (quality < flat)
            return -1.0;
    }
    return worst;
}

double mean_edge_at(const core::TetraMesh &mesh, std::span<const int> star, int node) {
    double sum = 0.0;
    for (const int t : star)
        for (const int other : mesh.tetrahedra[t])
            sum += (mesh.points[other] - mesh.points[node]).norm() / (3.0 * static_cast<double>(star.size()));
    return sum;
}

/// Newton's steps along the gradient of the level, by central differences.
Vector3 onto(const std::function<double(const Vector3 &)> &level, Vector3 point, double step) {
    for (int iteration = 0; iteration < 2; ++iteration) {
        Vector3 gradient;
        for (int axis = 0; axis < 3; ++axis)
            gradient[axis] =
                (level(point + step * Vector3::Unit(axis)) - level(point - step * Vector3::Unit(axis))) / (2.0 * step);
        if (!(gradient.squaredNorm() > 0.1))
            return point;
        point -= level(point) * gradient / gradient.squaredNorm();
    }
    return point;
}

/// Tries steps along the axes, shorter and shorter ones.
void climb(core::TetraMesh &mesh, std::span<const int> star, int node, const std::vector<bool> &taken,
           const std::function<Vector3(const Vector3 &, double)> &keep_on_cut) {
    double best = worst_that_stays(mesh, star, taken);
    const double edge = mean_edge_at(mesh, star, node);
    for (double step = 0.2 * edge; step > 0.02 * edge; step *= 0.5)
        for (bool is_better = true; is_better;) {
            is_better = false;
            for (const double sign : {-1.0, 1.0})
                for (int axis = 0; axis < 3; ++axis) {
                    const Vector3 before = mesh.points[node];
                    mesh.points[node] = keep_on_cut(before + sign * step * Vector3::Unit(axis), edge);
                    const double quality = worst_that_stays(mesh, star, taken);
                    if (quality > 1.02 * best && quality > 0.0) {
                        best = quality;
                        is_better = true;
                    } else {
                        mesh.points[node] = before;
                    }
                }
        }
}

/// (N) nodes of tetrahedra at the cut.
std::vector<bool> nodes_at_cut(const SplitBody &split) {
    std::vector<bool> is_at_cut(split.body.mesh.points.size(), false);
    for (const auto &nodes : split.body.mesh.tetrahedra)
        if (std::ranges::any_of(nodes, [&](int node) { return split.is_on_cut[node]; }))
            for (const int node : nodes)
                is_at_cut[node] = true;
    return is_at_cut;
}

void move_nodes(SplitBody &split, const std::vector<bool> &is_fixed,
                const std::function<double(const Vector3 &)> &level) {
    constexpr double bad = 0.25;
    auto &mesh = split.body.mesh;
    const auto is_at_cut = nodes_at_cut(split);
    const auto stars = core::tetrahedra_at_nodes(mesh);
    for (int node = 0; node < mesh.num_nodes(); ++node) {
        if (!is_at_cut[node] || is_fixed[node] || (split.is_on_cut[node] && !level))
            continue;
        if (const double worst = worst_that_stays(mesh, stars[node], split.taken); worst > bad || worst < 0.0)
            continue;
        climb(mesh, stars[node], node, split.taken, [&](const Vector3 &point, double edge) {
            return split.is_on_cut[node] ? onto(level, point, 1e-4 * edge) : point;
        });
    }
}

/// The worst quality of what stays around a node once it is where a neighbour is and the tetrahedra at both are gone.
double worst_when_merged(core::TetraMesh &mesh, const std::vector<int> &star, int node, int neighbour,
                         const std::vector<bool> &taken) {
    std::vector<int> left;
    std::ranges::copy_if(star, std::back_inserter(left), [&](int t) {
        return std::ranges::find(mesh.tetrahedra[t], neighbour) == mesh.tetrahedra[t].end();
    });
    const Vector3 place = std::exchange(mesh.points[node], mesh.points[neighbour]);
    const double worst = worst_that_stays(mesh, left, taken);
    mesh.points[node] = place;
    return worst;
}

/// A node inside of the body may go: what is around it is then filled from one of its neighbours.
/// @return whether any has gone
bool merge_nodes(SplitBody &split, const std::vector<bool> &is_fixed) {
    constexpr double bad = 0.15, better = 1.2;
    auto &mesh = split.body.mesh;
    const auto is_at_cut = nodes_at_cut(split);
    auto stars = core::tetrahedra_at_nodes(mesh);
    std::vector<bool> is_gone(mesh.tetrahedra.size(), false);
    for (int node = 0; node < mesh.num_nodes(); ++node) {
        if (!is_at_cut[node] || is_fixed[node] || stars[node].empty())
            continue;
        const double worst = worst_that_stays(mesh, stars[node], split.taken);
        if (worst > bad || worst < 0.0)
            continue;
        int chosen = -1;
        double best = better * worst;
        for (const int t : stars[node])
            for (const int other : mesh.tetrahedra[t]) {
                if (other == node || (split.is_on_cut[node] && !split.is_on_cut[other]))
                    continue;
                if (const double quality = worst_when_merged(mesh, stars[node], node, other, split.taken);
                    quality > best) {
                    best = quality;
                    chosen = other;
                }
            }
        if (chosen < 0)
            continue;
        for (const int t : std::exchange(stars[node], {})) {
            auto &nodes = mesh.tetrahedra[t];
            if (std::ranges::find(nodes, chosen) != nodes.end()) {
                is_gone[t] = true;
                for (const int corner : nodes)
                    std::erase(stars[corner], t);
            } else {
                std::ranges::replace(nodes, node, chosen);
                stars[chosen].push_back(t);
            }
        }
    }
    const auto erase = [&](auto &values) {
        std::size_t kept = 0;
        for (std::size_t t = 0; t < is_gone.size(); ++t)
            if (!is_gone[t])
                values[kept++] = values[t];
        values.resize(kept);
        return kept < is_gone.size();
    };
    erase(mesh.region);
    erase(split.parent_tetrahedron);
    erase(split.taken);
    return erase(mesh.tetrahedra);
}

} // namespace

/// Nodes that may not move: on the boundary, and between regions. @return (N)
std::vector<bool> fixed_nodes(const core::TetraMesh &mesh) {
    std::vector<bool> is_fixed(mesh.points.size(), false);
    const auto neighbours = core::face_neighbours(mesh.tetrahedra);
    for (std::size_t t = 0; t < neighbours.size(); ++t)
        for (std::size_t k = 0; k < 4; ++k)
            if (const int other = neighbours[t][k]; other < 0 || mesh.region[other] != mesh.region[t])
                for (const int corner : core::tetrahedron_faces[k])
                    is_fixed[mesh.tetrahedra[t][corner]] = true;
    return is_fixed;
}

bool move_node(core::TetraMesh &mesh, std::span<const int> star, int node, const Vector3 &target) {
    constexpr double good_enough = 0.1;
    const double before = worst_of(mesh, star);
    const Vector3 place = mesh.points[node];
    mesh.points[node] = target;
    if (worst_of(mesh, star) >= std::min(before, good_enough))
        return true;
    mesh.points[node] = place;
    return false;
}

void improve(SplitBody &split, const std::function<double(const Vector3 &)> &level) {
    constexpr int num_rounds = 3;
    const auto is_fixed = fixed_nodes(split.body.mesh);
    for (int round = 0; round < num_rounds; ++round) {
        move_nodes(split, is_fixed, level);
        if (!merge_nodes(split, is_fixed))
            break;
    }
}

namespace {

using Edge = std::array<int, 2>;

/// Place where an edge goes through the cut: 0 at a, 1 at b.
using Crossing = std::function<std::optional<double>(int a, int b)>;

/// Fate of a node that the cut passes nearby: the cut does not go through it, or it does and the node stays or moves.
enum class Snap { no, stay, move };

/// Distance from a node within which the cut counts as going through it, of an edge: of one that can move there, and of
/// one that stays.
constexpr double reach_of_free = 0.3, reach_of_fixed = 0.2;

/// @param fraction  of the edge on which the cut is nearest
using SnapRule = std::function<Snap(int node, double fraction)>;

SnapRule by_freedom(const std::vector<bool> &is_fixed) {
    return [&is_fixed](int node, double fraction) {
        return is_fixed[node] ? (fraction < reach_of_fixed ? Snap::stay : Snap::no)
                              : (fraction < reach_of_free ? Snap::move : Snap::no);
    };
}

/// Target of a node.
struct Pull {
    double distance; ///< [m]
    double fraction; ///< of the edge
    Vector3 target;
};

/// Nodes near the cut become nodes on it, and what edges still go through it are split there.
/// @param is_on_cut  (N) what is on it already; gets the nodes on it
std::map<Edge, Vector3> points_on_edges(core::TetraMesh &mesh, std::vector<bool> &is_on_cut, const Crossing &crossing,
                                        const SnapRule &rule) {
    std::map<Edge, double> crossings;
    std::map<int, Pull> pulls;
    for (const auto &[a, b] : core::edge_table(mesh.tetrahedra).edges) {
        if (is_on_cut[a] || is_on_cut[b])
            continue;
        const auto along = crossing(a, b);
        if (!along)
            continue;
        crossings[{a, b}] = *along;
        const Vector3 way = mesh.points[b] - mesh.points[a], target = mesh.points[a] + *along * way;
        for (const auto &[node, fraction] : {std::pair{a, *along}, std::pair{b, 1.0 - *along}}) {
            if (rule(node, fraction) == Snap::no)
                continue;
            const Pull pull{fraction * way.norm(), fraction, target};
            const auto [known, is_new] = pulls.try_emplace(node, pull);
            if (!is_new && pull.distance < known->second.distance)
                known->second = pull;
        }
    }
    const auto stars = core::tetrahedra_at_nodes(mesh);
    for (const auto &[node, pull] : pulls)
        is_on_cut[node] = rule(node, pull.fraction) == Snap::stay || move_node(mesh, stars[node], node, pull.target) ||
                          pull.fraction < reach_of_fixed;
    std::map<Edge, Vector3> points;
    for (const auto &[edge, along] : crossings)
        if (!is_on_cut[edge[0]] && !is_on_cut[edge[1]])
            points[edge] = mesh.points[edge[0]] + along * (mesh.points[edge[1]] - mesh.points[edge[0]]);
    return points;
}

/// Splits the edges; the new nodes are on the cut.
void split(SplitBody &split, const std::map<Edge, Vector3> &points) {
    auto parts = core::split_edges(split.body, points);
    parts.body.assumptions = std::move(split.body.assumptions);
    parts.body.patch_confidence = split.body.patch_confidence;
    parts.body.axes = split.body.axes;
    split.body = std::move(parts.body);
    std::vector<int> parents;
    parents.reserve(parts.parent_tetrahedron.size());
    for (const int parent : parts.parent_tetrahedron)
        parents.push_back(split.parent_tetrahedron[parent]);
    split.parent_tetrahedron = std::move(parents);
    split.is_on_cut.resize(split.body.mesh.points.size(), true);
}

SplitBody whole(const core::Body &body) {
    SplitBody result{body, {}, std::vector<bool>(body.mesh.points.size(), false), {}};
    for (int t = 0; t < body.mesh.num_tetrahedra(); ++t)
        result.parent_tetrahedron.push_back(t);
    return result;
}

/// Zero of a level that changes its sign between two points: 0 at the first, 1 at the second. Regula falsi in the
/// Illinois variant. (M. Dowell and P. Jarratt 1971, BIT 11(2))
double zero_between(const std::function<double(double)> &level, double at_start, double at_end) {
    double start = 0.0, end = 1.0;
    int last_side = 0;
    for (int iteration = 0; iteration < 60 && end - start > 1e-12; ++iteration) {
        const double middle = (start * at_end - end * at_start) / (at_end - at_start);
        const double there = level(middle);
        if (there == 0.0)
            return middle;
        const int side = (there < 0.0) == (at_start < 0.0) ? -1 : 1;
        if (side < 0) {
            start = middle;
            at_start = there;
            at_end *= side == last_side ? 0.5 : 1.0;
        } else {
            end = middle;
            at_end = there;
            at_start *= side == last_side ? 0.5 : 1.0;
        }
        last_side = side;
        if (std::abs(there) < 1e-15)
            return middle;
    }
    return std::abs(at_start) < std::abs(at_end) ? start : end;
}

Crossing crossing_of_blade(const core::TetraMesh &mesh, const BladeCut &blade) {
    return [&mesh, &blade](int a, int b) { return crossing_of(blade, mesh.points[a], mesh.points[b]); };
}

/// Inside a thin blade a node is put on each edge that goes through, so that levels change their sign on both sides.
void meet_middle(SplitBody &body, const BladeCut &blade, std::vector<double> &levels) {
    const auto is_inside = [&](int node, double fraction) {
        return levels[node] < -0.25 * blade.thickness && fraction < reach_of_free ? Snap::stay : Snap::no;
    };
    auto &mesh = body.body.mesh;
    split(body, points_on_edges(mesh, body.is_on_cut, crossing_of_blade(mesh, blade), is_inside));
    levels.resize(mesh.points.size(), -0.5 * blade.thickness);
}

/// Whether a part is inside: its nodes off the cut say so, and where there are none its middle.
bool is_inside(const SplitBody &split, const ToolLevel &level, const std::array<int, 4> &nodes) {
    double lowest = 0.0, highest = 0.0;
    Vector3 middle = Vector3::Zero();
    for (const int node : nodes) {
        middle += 0.25 * split.body.mesh.points[node];
        if (!split.is_on_cut[node]) {
            lowest = std::min(lowest, level.node_values[node]);
            highest = std::max(highest, level.node_values[node]);
        }
    }
    return (lowest < 0.0) != (highest > 0.0) ? lowest < 0.0 : level.at(middle) < 0.0;
}

} // namespace

SplitBody split_along(const core::Body &body, const CutTool &tool) {
    auto result = whole(body);
    auto level = tool_level(tool, body.mesh);
    auto &mesh = result.body.mesh;
    std::vector<bool> is_in_middle(mesh.points.size(), false);
    if (const auto *blade = std::get_if<BladeCut>(&tool)) {
        meet_middle(result, *blade, level.node_values);
        is_in_middle = std::exchange(result.is_on_cut, std::vector<bool>(mesh.points.size(), false));
    }
    const double rounding = 1e-12 * core::extent(mesh.points);
    for (std::size_t node = 0; node < mesh.points.size(); ++node)
        if (std::abs(level.node_values[node]) < rounding)
            result.is_on_cut[node] = true;
    const Crossing crossing = [&](int a, int b) -> std::optional<double> {
        const double at_a = level.node_values[a], at_b = level.node_values[b];
        if ((at_a < 0.0) == (at_b < 0.0))
            return std::nullopt;
        const auto along = [&](double t) { return level.at(mesh.points[a] + t * (mesh.points[b] - mesh.points[a])); };
        return zero_between(along, at_a, at_b);
    };
    const auto is_fixed = fixed_nodes(mesh);
    const auto by_place = by_freedom(is_fixed);
    const SnapRule rule = [&](int node, double fraction) {
        return is_in_middle[node] ? Snap::no : by_place(node, fraction);
    };
    split(result, points_on_edges(mesh, result.is_on_cut, crossing, rule));
    level.node_values.resize(mesh.points.size(), 0.0);
    for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t)
        result.taken.push_back((!level.is_in_region.empty() && level.is_in_region[result.parent_tetrahedron[t]]) ||
                               is_inside(result, level, mesh.tetrahedra[t]));
    improve(result, level.at);
    return result;
}

SplitBody split_along_blade(const core::Body &body, const BladeCut &blade) {
    auto result = whole(body);
    auto &mesh = result.body.mesh;
    const auto is_fixed = fixed_nodes(mesh);
    split(result, points_on_edges(mesh, result.is_on_cut, crossing_of_blade(mesh, blade), by_freedom(is_fixed)));
    result.taken.assign(mesh.tetrahedra.size(), false);
    improve(result, {});
    return result;
}

} // namespace livermark::meshes
