#include "meshes/generators/surface_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace livermark::meshes {

double enclosed_volume(const SurfaceMesh &surface) {
    double volume = 0.0;
    for (const auto &[a, b, c] : surface.triangles)
        volume += surface.points[a].dot(surface.points[b].cross(surface.points[c])) / 6.0;
    return volume;
}

SurfaceMesh geodesic_sphere(int frequency) {
    const double golden = (1.0 + std::sqrt(5.0)) / 2.0;
    const std::array<core::Vector3, 12> corners{{{-1, golden, 0},
                                                 {1, golden, 0},
                                                 {-1, -golden, 0},
                                                 {1, -golden, 0},
                                                 {0, -1, golden},
                                                 {0, 1, golden},
                                                 {0, -1, -golden},
                                                 {0, 1, -golden},
                                                 {golden, 0, -1},
                                                 {golden, 0, 1},
                                                 {-golden, 0, -1},
                                                 {-golden, 0, 1}}};
    constexpr std::array<std::array<int, 3>, 20> faces{{{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                                                        {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                                                        {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                                                        {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}}};

    SurfaceMesh sphere;
    // A node of the subdivision is known by its integer weights at the corners, which neighbouring faces share.
    std::map<std::array<int, 12>, int> known;
    for (const auto &face : faces) {
        const auto node = [&](int i, int j) {
            std::array<int, 12> weights{};
            weights[face[0]] = frequency - i - j;
            weights[face[1]] = i;
            weights[face[2]] = j;
            const auto [entry, is_new] = known.try_emplace(weights, static_cast<int>(sphere.points.size()));
            if (is_new)
                sphere.points.push_back(
                    ((frequency - i - j) * corners[face[0]] + i * corners[face[1]] + j * corners[face[2]])
                        .normalized());
            return entry->second;
        };
        for (int i = 0; i < frequency; ++i)
            for (int j = 0; i + j < frequency; ++j) {
                sphere.triangles.push_back({node(i, j), node(i + 1, j), node(i, j + 1)});
                if (i + j + 2 <= frequency)
                    sphere.triangles.push_back({node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)});
            }
    }
    return sphere;
}

namespace {

/// The six tetrahedra of a cube around its diagonal 0-7; corner c lies at (c & 1, c >> 1 & 1, c >> 2 & 1).
constexpr std::array<std::array<int, 4>, 6> cube_tetrahedra{
    {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7}, {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}}};

class Marcher {
  public:
    Marcher(const LevelFunction &level, const core::Vector3 &low, const core::Vector3 &high, double spacing)
        : low_(low), spacing_(spacing) {
        for (int d = 0; d < 3; ++d)
            count_[d] = static_cast<int>((high[d] - low[d]) / spacing) + 2;
        levels_.reserve(static_cast<std::size_t>(count_[0]) * count_[1] * count_[2]);
        for (int k = 0; k < count_[2]; ++k)
            for (int j = 0; j < count_[1]; ++j)
                for (int i = 0; i < count_[0]; ++i)
                    levels_.push_back(level(position(number(i, j, k))));
    }

    SurfaceMesh run() {
        for (int k = 0; k + 1 < count_[2]; ++k)
            for (int j = 0; j + 1 < count_[1]; ++j)
                for (int i = 0; i + 1 < count_[0]; ++i)
                    for (const auto &corners : cube_tetrahedra) {
                        std::array<int, 4> nodes;
                        for (int c = 0; c < 4; ++c)
                            nodes[c] = number(i + (corners[c] & 1), j + (corners[c] >> 1 & 1), k + (corners[c] >> 2));
                        cut(nodes);
                    }
        return std::move(surface_);
    }

  private:
    int number(int i, int j, int k) const { return (k * count_[1] + j) * count_[0] + i; }

    core::Vector3 position(int n) const {
        const int row = n / count_[0];
        const int layer = row / count_[1];
        return low_ + spacing_ * core::Vector3(n % count_[0], row % count_[1], layer);
    }

    /// The node where the surface crosses a grid edge, made at its first use.
    int crossing(int inside, int outside) {
        const auto [entry, is_new] =
            crossings_.try_emplace({inside, outside}, static_cast<int>(surface_.points.size()));
        if (is_new) {
            const double t = levels_[inside] / (levels_[inside] - levels_[outside]);
            surface_.points.push_back(position(inside) + t * (position(outside) - position(inside)));
        }
        return entry->second;
    }

    void cut(const std::array<int, 4> &nodes) {
        std::vector<int> in;
        std::vector<int> out;
        for (const int node : nodes)
            (levels_[node] < 0.0 ? in : out).push_back(node);
        if (in.empty() || out.empty())
            return;
        const core::Vector3 outward = position(out[0]) - position(in[0]);
        if (in.size() == 1)
            add(crossing(in[0], out[0]), crossing(in[0], out[1]), crossing(in[0], out[2]), outward);
        else if (out.size() == 1)
            add(crossing(in[0], out[0]), crossing(in[1], out[0]), crossing(in[2], out[0]), outward);
        else {
            const std::array quad{crossing(in[0], out[0]), crossing(in[0], out[1]), crossing(in[1], out[1]),
                                  crossing(in[1], out[0])};
            add(quad[0], quad[1], quad[2], outward);
            add(quad[0], quad[2], quad[3], outward);
        }
    }

    void add(int a, int b, int c, const core::Vector3 &outward) {
        const auto &x = surface_.points;
        const bool is_right_handed = (x[b] - x[a]).cross(x[c] - x[a]).dot(outward) > 0.0;
        surface_.triangles.push_back(is_right_handed ? std::array{a, b, c} : std::array{a, c, b});
    }

    core::Vector3 low_;
    double spacing_;
    std::array<int, 3> count_;
    std::vector<double> levels_;
    std::map<std::array<int, 2>, int> crossings_;
    SurfaceMesh surface_;
};

} // namespace

SurfaceMesh march_tetrahedra(const LevelFunction &level, const core::Vector3 &low, const core::Vector3 &high,
                             double spacing) {
    return Marcher(level, low, high, spacing).run();
}

namespace {

using core::Vector3;
using Triangle = std::array<int, 3>;

/// A triangulated closed surface that can be changed edge by edge. A removed triangle keeps its place, marked by -1.
class Remesher {
  public:
    Remesher(const SurfaceMesh &surface, const Projection &project)
        : points_(surface.points), triangles_(surface.triangles), around_(surface.points.size()), project_(project) {
        for (std::size_t t = 0; t < triangles_.size(); ++t)
            for (const int node : triangles_[t])
                around_[node].push_back(static_cast<int>(t));
        for (auto &point : points_)
            point = project_(point);
    }

    void split_longer_than(double longest) {
        for (const auto &[a, b] : edges())
            if (length(a, b) > longest)
                split(a, b);
    }

    void collapse_shorter_than(double shortest, double longest) {
        for (const auto &[a, b] : edges())
            if (is_edge(a, b) && length(a, b) < shortest)
                collapse(a, b, longest);
    }

    void flip_towards_valence_six() {
        for (const auto &[a, b] : edges())
            if (is_edge(a, b))
                flip(a, b);
    }

    void relax() {
        std::vector<Vector3> wanted(points_);
        for (int node = 0; node < static_cast<int>(points_.size()); ++node) {
            if (around_[node].empty())
                continue;
            // Weighting by area draws nodes towards large triangles and so evens the sizes out.
            Vector3 sum = Vector3::Zero();
            Vector3 normal = Vector3::Zero();
            double area = 0.0;
            for (const int t : around_[node]) {
                const auto &[a, b, c] = triangles_[t];
                const Vector3 n = area_vector(triangles_[t]);
                sum += n.norm() * (points_[a] + points_[b] + points_[c]) / 3.0;
                area += n.norm();
                normal += n;
            }
            normal.normalize();
            const Vector3 step = sum / area - points_[node];
            wanted[node] = project_(points_[node] + step - step.dot(normal) * normal);
        }
        points_ = std::move(wanted);
    }

    SurfaceMesh result() const {
        SurfaceMesh surface;
        std::vector<int> number(points_.size(), -1);
        for (std::size_t node = 0; node < points_.size(); ++node)
            if (!around_[node].empty()) {
                number[node] = static_cast<int>(surface.points.size());
                surface.points.push_back(points_[node]);
            }
        for (const auto &[a, b, c] : triangles_)
            if (a >= 0)
                surface.triangles.push_back({number[a], number[b], number[c]});
        return surface;
    }

  private:
    double length(int a, int b) const { return (points_[b] - points_[a]).norm(); }

    Vector3 area_vector(const Triangle &t) const {
        return 0.5 * (points_[t[1]] - points_[t[0]]).cross(points_[t[2]] - points_[t[0]]);
    }

    std::vector<std::array<int, 2>> edges() const {
        std::vector<std::array<int, 2>> found;
        for (const auto &[a, b, c] : triangles_)
            if (a >= 0)
                for (const auto &[i, j] : {std::array{a, b}, std::array{b, c}, std::array{c, a}})
                    if (i < j)
                        found.push_back({i, j});
        std::ranges::sort(found);
        return found;
    }

    std::vector<int> neighbours(int node) const {
        std::vector<int> found;
        for (const int t : around_[node])
            for (const int other : triangles_[t])
                if (other != node)
                    found.push_back(other);
        std::ranges::sort(found);
        found.erase(std::unique(found.begin(), found.end()), found.end());
        return found;
    }

    bool is_edge(int a, int b) const { return left_of(a, b) >= 0; }

    /// The triangle that has the edge from a to b in its own sense, -1 without one.
    int left_of(int a, int b) const {
        for (const int t : around_[a])
            for (int c = 0; c < 3; ++c)
                if (triangles_[t][c] == a && triangles_[t][(c + 1) % 3] == b)
                    return t;
        return -1;
    }

    int opposite(int t, int a, int b) const {
        for (const int node : triangles_[t])
            if (node != a && node != b)
                return node;
        return -1;
    }

    void add(const Triangle &triangle) {
        for (const int node : triangle)
            around_[node].push_back(static_cast<int>(triangles_.size()));
        triangles_.push_back(triangle);
    }

    void remove(int t) {
        for (const int node : triangles_[t])
            std::erase(around_[node], t);
        triangles_[t] = {-1, -1, -1};
    }

    void split(int a, int b) {
        const int left = left_of(a, b);
        const int right = left_of(b, a);
        const int c = opposite(left, a, b);
        const int d = opposite(right, a, b);
        const int middle = static_cast<int>(points_.size());
        points_.push_back(project_(0.5 * (points_[a] + points_[b])));
        around_.emplace_back();
        remove(left);
        remove(right);
        for (const Triangle &triangle :
             {Triangle{a, middle, c}, Triangle{middle, b, c}, Triangle{b, middle, d}, Triangle{middle, a, d}})
            add(triangle);
    }

    /// Merges b into a, unless that would tie the surface in a knot, fold it or make an edge too long.
    void collapse(int a, int b, double longest) {
        const auto ring_a = neighbours(a);
        const auto ring_b = neighbours(b);
        std::vector<int> shared;
        std::ranges::set_intersection(ring_a, ring_b, std::back_inserter(shared));
        if (shared.size() != 2 || std::ranges::any_of(shared, [&](int node) { return around_[node].size() <= 4; }))
            return;
        const Vector3 merged = project_(0.5 * (points_[a] + points_[b]));
        for (const auto *list : {&ring_a, &ring_b})
            for (const int node : *list)
                if (node != a && node != b && (points_[node] - merged).norm() > longest)
                    return;
        for (const int node : {a, b})
            for (const int t : around_[node]) {
                if (std::ranges::count(triangles_[t], a) + std::ranges::count(triangles_[t], b) == 2)
                    continue;
                const Vector3 before = area_vector(triangles_[t]);
                const Vector3 kept = std::exchange(points_[node], merged);
                const Vector3 after = area_vector(triangles_[t]);
                points_[node] = kept;
                if (before.dot(after) < 0.5 * before.norm() * after.norm())
                    return;
            }
        points_[a] = merged;
        remove(left_of(a, b));
        remove(left_of(b, a));
        for (const int t : std::vector<int>(around_[b])) {
            Triangle triangle = triangles_[t];
            std::ranges::replace(triangle, b, a);
            remove(t);
            add(triangle);
        }
    }

    /// Replaces edge ab by cd if that brings the four nodes nearer to six triangles each and the surface stays smooth.
    void flip(int a, int b) {
        const int left = left_of(a, b);
        const int right = left_of(b, a);
        const int c = opposite(left, a, b);
        const int d = opposite(right, a, b);
        const auto excess = [&](int node, int change) {
            const int e = static_cast<int>(around_[node].size()) + change - 6;
            return e * e;
        };
        const int before = excess(a, 0) + excess(b, 0) + excess(c, 0) + excess(d, 0);
        const int after = excess(a, -1) + excess(b, -1) + excess(c, 1) + excess(d, 1);
        if (after >= before || around_[a].size() <= 3 || around_[b].size() <= 3 || is_edge(c, d))
            return;
        const Triangle first{a, d, c};
        const Triangle second{d, b, c};
        const Vector3 normal = area_vector(triangles_[left]) + area_vector(triangles_[right]);
        for (const auto &triangle : {first, second}) {
            const Vector3 n = area_vector(triangle);
            if (n.dot(normal) < 0.7 * n.norm() * normal.norm())
                return;
        }
        remove(left);
        remove(right);
        add(first);
        add(second);
    }

    std::vector<Vector3> points_;
    std::vector<Triangle> triangles_;
    std::vector<std::vector<int>> around_;
    const Projection &project_;
};

} // namespace

SurfaceMesh remesh(const SurfaceMesh &surface, const Projection &project, double edge) {
    constexpr int num_rounds = 15;
    const double longest = 4.0 / 3.0 * edge;
    const double shortest = 4.0 / 5.0 * edge;
    Remesher remesher(surface, project);
    for (int round = 0; round < num_rounds; ++round) {
        remesher.split_longer_than(longest);
        remesher.collapse_shorter_than(shortest, longest);
        remesher.flip_towards_valence_six();
        for (int pass = 0; pass < 3; ++pass)
            remesher.relax();
    }
    return remesher.result();
}

} // namespace livermark::meshes
