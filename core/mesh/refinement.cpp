#include "core/mesh/refinement.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <map>
#include <memory>
#include <numeric>
#include <span>
#include <stdexcept>
#include <utility>

namespace livermark::core {

namespace {

/// A diagonal of the inner octahedron joins the middles of two opposite edges, and the other four middles go around it.
/// Numbers are places in tetrahedron_edges; each ring turns so that the tetrahedra (from, to, ring k, ring k + 1) have
/// the sign of the parent.
struct OctahedronCut {
    int from;
    int to;
    std::array<int, 4> ring;
};
constexpr std::array<OctahedronCut, 3> octahedron_cuts{
    {{0, 5, {1, 2, 4, 3}}, {1, 4, {0, 3, 5, 2}}, {2, 3, {0, 1, 5, 4}}}};

/// For each corner of a tetrahedron the edges to the other corners, in an order that keeps the sign.
constexpr std::array<std::array<int, 3>, 4> edges_at_corner{{{0, 1, 2}, {0, 4, 3}, {1, 3, 5}, {2, 5, 4}}};

template <class T> std::vector<T> repeated(const std::vector<T> &values, int times) {
    std::vector<T> result;
    result.reserve(values.size() * times);
    for (const auto &value : values)
        result.insert(result.end(), times, value);
    return result;
}

void cut_tetrahedron(const std::array<int, 4> &corners, const std::array<int, 6> &middles, TetraMesh &fine) {
    for (int corner = 0; corner < 4; ++corner) {
        const auto &[a, b, c] = edges_at_corner[corner];
        fine.tetrahedra.push_back({corners[corner], middles[a], middles[b], middles[c]});
    }
    const auto length = [&](const OctahedronCut &cut) {
        return (fine.points[middles[cut.from]] - fine.points[middles[cut.to]]).squaredNorm();
    };
    const auto &cut = *std::ranges::min_element(octahedron_cuts, {}, length);
    for (int k = 0; k < 4; ++k)
        fine.tetrahedra.push_back(
            {middles[cut.from], middles[cut.to], middles[cut.ring[k]], middles[cut.ring[(k + 1) % 4]]});
}

void cut_triangle(const std::array<int, 3> &corners, const EdgeTable &table, int num_coarse_nodes, TetraMesh &fine) {
    const auto middle = [&](int a, int b) {
        const std::array edge{std::min(a, b), std::max(a, b)};
        const auto found = std::ranges::lower_bound(table.edges, edge);
        if (found == table.edges.end() || *found != edge)
            throw std::invalid_argument(
                fmt::format("the edge of nodes {} and {} of a boundary triangle belongs to no tetrahedron", a, b));
        return num_coarse_nodes + static_cast<int>(found - table.edges.begin());
    };
    const auto &[a, b, c] = corners;
    const int ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
    fine.boundary_triangles.insert(fine.boundary_triangles.end(),
                                   {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
}

} // namespace

Body refine(const Body &body) {
    const auto &coarse = body.mesh;
    const auto table = edge_table(coarse.tetrahedra);
    Body refined{.name = body.name,
                 .mesh = {},
                 .materials = body.materials,
                 .capsule = body.capsule,
                 .vessels = body.vessels,
                 .modulus_factor = repeated(body.modulus_factor, 8)};
    auto &fine = refined.mesh;
    fine.points = coarse.points;
    fine.points.reserve(coarse.points.size() + table.edges.size());
    for (const auto &[a, b] : table.edges)
        fine.points.emplace_back(0.5 * (coarse.points[a] + coarse.points[b]));
    if (refined.capsule)
        refined.capsule->surface = refined_surface(body, table.edges, fine.points);

    fine.tetrahedra.reserve(8 * coarse.tetrahedra.size());
    for (std::size_t t = 0; t < coarse.tetrahedra.size(); ++t) {
        auto middles = table.tetrahedron_edge[t];
        for (int &middle : middles)
            middle += coarse.num_nodes();
        cut_tetrahedron(coarse.tetrahedra[t], middles, fine);
    }
    fine.region = repeated(coarse.region, 8);
    fine.region_names = coarse.region_names;

    fine.boundary_triangles.reserve(4 * coarse.boundary_triangles.size());
    for (const auto &triangle : coarse.boundary_triangles)
        cut_triangle(triangle, table, coarse.num_nodes(), fine);
    fine.boundary_patch = repeated(coarse.boundary_patch, 4);
    fine.patch_names = coarse.patch_names;
    return refined;
}

namespace {

/// Lets events lie on the parts of their facets.
/// @param parent  of each facet of the finer mesh
void move_events_to_parts(LoadCase &load_case, const std::vector<int> &parent) {
    for_each_event(load_case, [&](auto &event) {
        if constexpr (requires { event.move_to_parts(parent); })
            event.move_to_parts(parent);
    });
}

} // namespace

LoadCase refine(const LoadCase &load_case, const TetraMesh &coarse) {
    auto refined = load_case;
    std::vector<int> facets(load_case.condition_on.size());
    std::iota(facets.begin(), facets.end(), 0);
    move_events_to_parts(refined, repeated(facets, 4));
    refined.condition_on = repeated(load_case.condition_on, 4);
    refined.value = repeated(load_case.value, 4);
    for (int f = 0; f < load_case.num_facets(); ++f)
        if (load_case.round_load_on(f)) {
            const auto [a, b, c] = corners_of(coarse, f); // as cut_triangle() has them
            const Vector3 ab = 0.5 * (a + b), bc = 0.5 * (b + c), ca = 0.5 * (c + a);
            const std::array<Corners, 4> parts{{{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}}};
            const auto share = shares_of_parts(load_case.round_load_on(f), parts);
            for (int k = 0; k < 4; ++k)
                refined.value[4 * f + k] *= share[k];
        }
    if (!load_case.node_factor.empty())
        for (const auto &[a, b] : edge_table(coarse.tetrahedra).edges)
            refined.node_factor.push_back(load_case.factor_between(a, b));
    if (!load_case.node_shift.empty())
        for (const auto &[a, b] : edge_table(coarse.tetrahedra).edges)
            refined.node_shift.emplace_back(0.5 * (load_case.node_shift[a] + load_case.node_shift[b]));
    return refined;
}

Problem refine(const Problem &problem) {
    return {std::make_shared<const Body>(refine(*problem.body)), refine(problem.load_case, problem.body->mesh)};
}

namespace {

using Edge = std::array<int, 2>;

Edge edge_of(int a, int b) {
    return {std::min(a, b), std::max(a, b)};
}

/// The nodes on the edges that are split.
class NewNodes {
  public:
    NewNodes(std::vector<Vector3> &points, const std::map<Edge, Vector3> &on_edges)
        : points_(points), is_end_(points.size() + on_edges.size(), false) {
        for (const auto &[edge, point] : on_edges) {
            node_[edge] = static_cast<int>(points_.size());
            points_.push_back(point);
            for (const int end : edge)
                is_end_[end] = true;
        }
    }

    /// Cuts a tetrahedron or triangle until none of its edges has a new node, and hands out the parts. What is
    /// right-handed stays so.
    template <std::size_t corners, class Keep> void cut(const std::array<int, corners> &nodes, const Keep &keep) const {
        // The longest; of several the last by the numbers of its nodes, so that all who have it choose alike.
        std::pair<double, Edge> longest{0.0, {}};
        std::array<std::size_t, 2> ends{};
        for (std::size_t i = 0; i < corners; ++i)
            for (std::size_t j = i + 1; j < corners; ++j)
                if (const auto edge = edge_of(nodes[i], nodes[j]); is_split(edge)) {
                    const std::pair candidate{(points_[edge[0]] - points_[edge[1]]).squaredNorm(), edge};
                    if (candidate > longest) {
                        longest = candidate;
                        ends = {i, j};
                    }
                }
        if (longest.first == 0.0)
            return keep(nodes);
        for (const auto end : ends) {
            auto part = nodes;
            part[end] = node_.at(longest.second);
            cut(part, keep);
        }
    }

  private:
    bool is_split(const Edge &edge) const {
        return is_end_[edge[0]] && is_end_[edge[1]] && node_.contains(edge); // few edges of a large mesh are
    }

    std::vector<Vector3> &points_;
    std::map<Edge, int> node_;
    std::vector<bool> is_end_; ///< of an edge that is split
};

/// Conditions on a boundary triangle, free ones are all alike.
bool are_alike(const LoadCase &load_case, int a, int b) {
    if (load_case.is_free(a) != load_case.is_free(b) || load_case.is_constrained(a) != load_case.is_constrained(b) ||
        load_case.constraint_on(a) != load_case.constraint_on(b))
        return false;
    if (!load_case.is_loaded(a))
        return true;
    if (const auto *load = load_case.round_load_on(a); load && load == load_case.round_load_on(b))
        return true;
    // Pressures change their direction from facet to facet of a curved surface; that is no rim.
    const double x = load_case.value[a].norm(), y = load_case.value[b].norm();
    constexpr double rounding = 1e-6;
    return std::abs(x - y) <= rounding * std::max(x, y);
}

/// Gives the parts of each facet that a round tool presses their own mean traction. They stand in one row.
void spread_round_loads(const LoadCase &load_case, const BisectedBody &parts, LoadCase &result) {
    const auto &parent = parts.parent_triangle;
    for (std::size_t first = 0, end = 0; first < parent.size(); first = end) {
        for (end = first; end < parent.size() && parent[end] == parent[first];)
            ++end;
        const auto *load = load_case.round_load_on(parent[first]);
        if (!load)
            continue;
        std::vector<Corners> corners;
        for (auto part = first; part < end; ++part)
            corners.push_back(corners_of(parts.body.mesh, static_cast<int>(part)));
        const auto share = shares_of_parts(load, corners);
        for (auto part = first; part < end; ++part)
            result.value[part] *= share[part - first];
    }
}

bool has_one_of(const std::array<int, 4> &nodes, const std::vector<bool> &is_marked) {
    return std::ranges::any_of(nodes, [&](int node) { return is_marked[node]; });
}

/// @return [m]
double longest_edge_of(const TetraMesh &mesh, const std::array<int, 4> &nodes) {
    double longest = 0.0;
    for (const auto &[i, j] : tetrahedron_edges)
        longest = std::max(longest, (mesh.points[nodes[i]] - mesh.points[nodes[j]]).norm());
    return longest;
}

Vector3 centroid_of(const TetraMesh &mesh, const std::array<int, 4> &nodes) {
    Vector3 centroid = Vector3::Zero();
    for (const int node : nodes)
        centroid += 0.25 * mesh.points[node];
    return centroid;
}

/// The same with nothing on the facets that round tools press.
LoadCase without_round_loads(LoadCase load_case) {
    for (int f = 0; f < load_case.num_facets(); ++f)
        if (load_case.round_load_on(f))
            load_case.free_facet(f);
    return load_case;
}

/// Whether strains below some round tool change too much within a tetrahedron.
/// @param longest_edge  see refine_at_rims_and_tools()
bool is_coarse_below(std::span<const RoundLoad> tools, const TetraMesh &mesh, const std::array<int, 4> &nodes,
                     double longest_edge) {
    const Vector3 centroid = centroid_of(mesh, nodes);
    const double longest = longest_edge_of(mesh, nodes);
    return std::ranges::any_of(tools, [&](const RoundLoad &tool) {
        return longest > longest_edge * std::max(tool.radius, (centroid - tool.middle).norm());
    });
}

/// Cuts all edges of some tetrahedra in two.
/// @param is_chosen  (four nodes) -> bool
template <class Choose> BisectedProblem refine_where(const Problem &problem, const Choose &is_chosen) {
    std::set<Edge> edges;
    for (const auto &nodes : problem.body->mesh.tetrahedra)
        if (is_chosen(nodes))
            for (const auto &[i, j] : tetrahedron_edges)
                edges.insert(edge_of(nodes[i], nodes[j]));
    auto bisected = bisect(*problem.body, edges);
    auto load_case = on_parts(problem.load_case, bisected);
    return {{std::make_shared<const Body>(std::move(bisected.body)), std::move(load_case)},
            std::move(bisected.parent_tetrahedron)};
}

} // namespace

BisectedBody split_edges(const Body &body, const std::map<Edge, Vector3> &points) {
    const auto &coarse = body.mesh;
    BisectedBody result{
        {.name = body.name, .mesh = {}, .materials = body.materials, .capsule = body.capsule, .vessels = body.vessels},
        {},
        {},
        {}};
    for (const auto &[edge, point] : points)
        result.parent_edge.push_back(edge);
    auto &fine = result.body.mesh;
    fine.points = coarse.points;
    fine.region_names = coarse.region_names;
    fine.patch_names = coarse.patch_names;
    const NewNodes new_nodes(fine.points, points);
    if (body.capsule)
        result.body.capsule->surface = refined_surface(body, result.parent_edge, fine.points);
    for (std::size_t t = 0; t < coarse.tetrahedra.size(); ++t)
        new_nodes.cut(coarse.tetrahedra[t], [&](const auto &part) {
            fine.tetrahedra.push_back(part);
            fine.region.push_back(coarse.region[t]);
            if (!body.modulus_factor.empty())
                result.body.modulus_factor.push_back(body.modulus_factor[t]);
            result.parent_tetrahedron.push_back(static_cast<int>(t));
        });
    for (int f = 0; f < coarse.num_boundary_triangles(); ++f)
        new_nodes.cut(coarse.boundary_triangles[f], [&](const auto &part) {
            fine.boundary_triangles.push_back(part);
            fine.boundary_patch.push_back(coarse.boundary_patch[f]);
            result.parent_triangle.push_back(f);
        });
    return result;
}

BisectedBody bisect(const Body &body, const std::set<Edge> &edges) {
    std::map<Edge, Vector3> middles;
    for (const auto &[a, b] : edges)
        middles.emplace(Edge{a, b}, 0.5 * (body.mesh.points[a] + body.mesh.points[b]));
    return split_edges(body, middles);
}

LoadCase on_parts(const LoadCase &load_case, const BisectedBody &parts) {
    auto result = load_case;
    result.condition_on.clear();
    result.value.clear();
    for (const int parent : parts.parent_triangle) {
        result.condition_on.push_back(load_case.condition_on[parent]);
        result.value.push_back(load_case.value[parent]);
    }
    move_events_to_parts(result, parts.parent_triangle);
    spread_round_loads(load_case, parts, result);
    if (!load_case.node_factor.empty())
        for (const auto &[a, b] : parts.parent_edge)
            result.node_factor.push_back(load_case.factor_between(a, b));
    if (!load_case.node_shift.empty())
        for (const auto &[a, b] : parts.parent_edge)
            result.node_shift.emplace_back(0.5 * (load_case.node_shift[a] + load_case.node_shift[b]));
    return result;
}

std::vector<bool> rim_nodes(const TetraMesh &mesh, const LoadCase &load_case) {
    std::map<Edge, int> first_triangle;
    std::vector<bool> is_rim(mesh.points.size(), false);
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        for (std::size_t c = 0; c < 3; ++c) {
            const auto edge = edge_of(mesh.boundary_triangles[f][c], mesh.boundary_triangles[f][(c + 1) % 3]);
            const auto [other, is_new] = first_triangle.try_emplace(edge, f);
            if (!is_new && !are_alike(load_case, f, other->second))
                is_rim[edge[0]] = is_rim[edge[1]] = true;
        }
    return is_rim;
}

BisectedProblem refine_at_rims(const Problem &problem) {
    const auto is_rim = rim_nodes(problem.body->mesh, problem.load_case);
    return refine_where(problem, [&](const auto &nodes) { return has_one_of(nodes, is_rim); });
}

BisectedProblem refine_at_rims_and(const Problem &problem, const std::vector<bool> &is_further) {
    const auto is_rim = rim_nodes(problem.body->mesh, problem.load_case);
    return refine_where(problem,
                        [&](const auto &nodes) { return has_one_of(nodes, is_rim) || has_one_of(nodes, is_further); });
}

namespace {

/// Whether a point is nearer to the middle of a place than so many of its radii and a distance.
bool is_near_one_of(std::span<const InteriorPlace> places, const Vector3 &point, double radii, double distance) {
    return std::ranges::any_of(places, [&](const InteriorPlace &place) {
        return (point - place.middle).norm() < radii * place.radius + distance;
    });
}

} // namespace

BisectedProblem refine_near_places(const Problem &problem, std::span<const InteriorPlace> places, double radii) {
    const auto &mesh = problem.body->mesh;
    return refine_where(
        problem, [&](const auto &nodes) { return is_near_one_of(places, centroid_of(mesh, nodes), radii, 0.0); });
}

BisectedProblem refine_at_rims_and_near(const Problem &problem, std::span<const InteriorPlace> places, double radii) {
    const auto &mesh = problem.body->mesh;
    const auto is_rim = rim_nodes(mesh, problem.load_case);
    return refine_where(problem, [&](const auto &nodes) {
        return has_one_of(nodes, is_rim) ||
               is_near_one_of(places, centroid_of(mesh, nodes), radii, 0.5 * longest_edge_of(mesh, nodes));
    });
}

BisectedProblem refine_at_rims_and_tools(const Problem &problem, double longest_edge) {
    const auto &mesh = problem.body->mesh;
    const auto round_loads = problem.load_case.round_loads();
    const auto is_rim = rim_nodes(mesh, without_round_loads(problem.load_case));
    return refine_where(problem, [&](const auto &nodes) {
        return has_one_of(nodes, is_rim) || is_coarse_below(round_loads, mesh, nodes, longest_edge);
    });
}

Problem refine_at_rims(const Problem &problem, int levels) {
    auto refined = problem;
    for (int level = 0; level < levels; ++level)
        refined = refine_at_rims(refined).problem;
    return refined;
}

} // namespace livermark::core
