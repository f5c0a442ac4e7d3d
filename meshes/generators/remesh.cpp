#include <algorithm>
#include <utility>

#include "meshes/generators/surface_mesh.hpp"

namespace livermark::meshes {

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
        const auto of_a = neighbours(a);
        const auto of_b = neighbours(b);
        std::vector<int> shared;
        std::ranges::set_intersection(of_a, of_b, std::back_inserter(shared));
        if (shared.size() != 2 || std::ranges::any_of(shared, [&](int node) { return around_[node].size() <= 4; }))
            return;
        const Vector3 merged = project_(0.5 * (points_[a] + points_[b]));
        for (const auto *list : {&of_a, &of_b})
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
