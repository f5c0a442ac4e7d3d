#include "meshes/cutting/improving.hpp"

#include <algorithm>
#include <iterator>
#include <limits>
#include <utility>

#include "core/mesh/neighbours.hpp"
#include "meshes/io/mesh_figures.hpp"

namespace livermark::meshes {

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

} // namespace livermark::meshes
