#include "meshes/segmentation/images/centrelines.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <queue>
#include <utility>

#include "meshes/io/vessel_files.hpp"
#include "meshes/segmentation/images/voxel_shapes.hpp"

namespace livermark::segmentation {

namespace {

using core::Vector3;

/// Power of the depth by which a length is cheaper where it is deep, alike in thin vessels and thick ones. The cost of
/// Sato et al., (1 - depth / the largest)^16, is so flat in the middle of a thick vessel that paths leave it.
constexpr double power_of_depth = 8.0;
/// Distance from a path, over the depth there, within which a voxel belongs to it.
constexpr double reach_of_path = 2.0;
/// Distance within which voxels count for the middle of a vessel, over the depth.
constexpr double reach_of_middle = 1.5;

using Voxel = std::array<int, 3>; // along each axis

/// The voxels of vessels as nodes that hang together by faces, edges and corners.
struct VesselGraph {
    const ImageGrid &grid;
    std::vector<int> node_at{};  ///< (num_voxels) -1 outside
    std::vector<Voxel> voxel{};  ///< (N)
    std::vector<double> depth{}; ///< (N) distance to the nearest voxel outside [m]

    double margin_of_path() const { return grid.spacing.norm(); } ///< a voxel beside a path belongs to it too [m]
    Vector3 place(const Voxel &at) const { return Vector3(at[0], at[1], at[2]).cwiseProduct(grid.spacing); }
    Vector3 place(int node) const { return place(voxel[static_cast<std::size_t>(node)]); } ///< in the image [m]

    /// Calls visit(node or -1, voxel) for the voxels of the image in a box.
    template <class Visit> void for_each_in(const Voxel &low, const Voxel &high, const Visit &visit) const {
        const auto row = static_cast<std::size_t>(grid.size[0]), column = static_cast<std::size_t>(grid.size[1]);
        for (int k = std::max(0, low[2]); k <= std::min(high[2], grid.size[2] - 1); ++k)
            for (int j = std::max(0, low[1]); j <= std::min(high[1], grid.size[1] - 1); ++j)
                for (int i = std::max(0, low[0]); i <= std::min(high[0], grid.size[0] - 1); ++i)
                    visit(node_at[static_cast<std::size_t>(i) +
                                  row * (static_cast<std::size_t>(j) + column * static_cast<std::size_t>(k))],
                          Voxel{i, j, k});
    }

    /// Calls visit(node or -1, place) for those that are nearer to a place than a radius.
    template <class Visit> void for_each_near(const Vector3 &centre, double radius, const Visit &visit) const {
        Voxel low{}, high{};
        for (Eigen::Index d = 0; d < 3; ++d) {
            low.at(static_cast<std::size_t>(d)) = static_cast<int>(std::ceil((centre[d] - radius) / grid.spacing[d]));
            high.at(static_cast<std::size_t>(d)) = static_cast<int>(std::floor((centre[d] + radius) / grid.spacing[d]));
        }
        for_each_in(low, high, [&](int node, const Voxel &at) {
            if (const Vector3 near = place(at); (near - centre).squaredNorm() < radius * radius)
                visit(node, near);
        });
    }
};

VesselGraph graph_of(const ImageGrid &grid, const std::vector<char> &is_vessel) {
    VesselGraph graph{.grid = grid, .node_at = std::vector<int>(is_vessel.size(), -1)};
    const auto depths = depths_in(grid, VoxelSet(is_vessel.begin(), is_vessel.end()));
    std::size_t v = 0;
    graph.for_each_in({0, 0, 0}, grid.size, [&](int /*none*/, const Voxel &at) {
        if (is_vessel[v] != 0) {
            graph.node_at[v] = static_cast<int>(graph.voxel.size());
            graph.voxel.push_back(at);
            graph.depth.push_back(static_cast<double>(depths[v]));
        }
        ++v;
    });
    return graph;
}

/// Lowers values of nodes to what the cheapest ways from some of them give (Dijkstra 1959).
/// @param value   (N) of the seeds where they begin; others are not raised
/// @param cost    (N) of a length at a node; 1 where there is none
/// @param before  (N) gets the node before each on its way
/// @return those that were lowered, and the seeds, the lowest first
std::vector<int> spread(const VesselGraph &graph, const std::vector<int> &seeds, std::vector<double> &value,
                        const std::vector<double> *cost = nullptr, std::vector<int> *before = nullptr) {
    using Entry = std::pair<double, int>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
    for (const int seed : seeds)
        queue.emplace(value[static_cast<std::size_t>(seed)], seed);
    std::vector<int> reached;
    while (!queue.empty()) {
        const double start = queue.top().first;
        const int from = queue.top().second;
        queue.pop();
        const auto n = static_cast<std::size_t>(from);
        if (start > value[n])
            continue;
        reached.push_back(from);
        const auto [i, j, k] = graph.voxel[n];
        graph.for_each_in({i - 1, j - 1, k - 1}, {i + 1, j + 1, k + 1}, [&](int to, const Voxel &at) {
            if (to < 0 || to == from)
                return;
            const auto m = static_cast<std::size_t>(to);
            const double length = (graph.place(at) - graph.place(from)).norm();
            const double through = start + length * (cost ? 0.5 * ((*cost)[n] + (*cost)[m]) : 1.0);
            if (through < value[m]) {
                value[m] = through;
                queue.emplace(through, to);
                if (before)
                    (*before)[m] = from;
            }
        });
    }
    return reached;
}

/// Paths through vessels, as a tree of nodes for each piece.
struct Skeleton {
    std::vector<int> nodes;      ///< each after the one before it
    std::vector<int> before;     ///< (N) the next node towards the root, -1 there
    std::vector<int> num_behind; ///< (N) nodes of the skeleton that it is before
    std::vector<char> is_in;     ///< (N)

    bool is_end(int node) const {
        const auto n = static_cast<std::size_t>(node);
        return num_behind[n] == 0 || (before[n] < 0 && num_behind[n] == 1);
    }
    bool is_branch_point(int node) const { return num_behind[static_cast<std::size_t>(node)] > 1; }
};

/// Finds the skeleton, piece by piece.
class PathFinder {
  public:
    PathFinder(const VesselGraph &graph, double least_length) : graph_(graph), least_length_(least_length) {
        const auto size = graph.voxel.size();
        skeleton_ = {.nodes = {},
                     .before = std::vector<int>(size, -1),
                     .num_behind = std::vector<int>(size, 0),
                     .is_in = std::vector<char>(size, 0)};
        from_any_ = from_one_ = from_other_ = total_cost_ =
            std::vector<double>(size, std::numeric_limits<double>::infinity());
        cost_ = uncovered_ = std::vector<double>(size, 0.0);
    }

    Skeleton skeleton() {
        for (std::size_t n = 0; n < from_any_.size(); ++n)
            if (!std::isfinite(from_any_[n])) // of no piece before
                trace_piece(static_cast<int>(n));
        return std::move(skeleton_);
    }

  private:
    double depth(int node) const { return graph_.depth[static_cast<std::size_t>(node)]; }

    /// @return the nodes of the piece, the farthest last
    std::vector<int> reached_from(int node, std::vector<double> &distance) const {
        distance[static_cast<std::size_t>(node)] = 0.0;
        return spread(graph_, {node}, distance);
    }

    void trace_piece(int any) {
        const int one = reached_from(any, from_any_).back();
        const auto after_one = reached_from(one, from_one_);
        const int other = after_one.back(); // no two nodes are much farther apart than these
        if (from_one_[static_cast<std::size_t>(other)] < least_length_)
            return;
        const auto after_other = reached_from(other, from_other_);
        const int deepest = *std::ranges::max_element(after_one, {}, [&](int node) { return depth(node); });
        for (const int node : after_one)
            cost_[static_cast<std::size_t>(node)] = std::pow(depth(deepest) / depth(node), power_of_depth);
        if (from_one_[static_cast<std::size_t>(deepest)] <= from_other_[static_cast<std::size_t>(deepest)])
            trace_from(one, after_one);
        else
            trace_from(other, after_other);
    }

    /// @param nodes  of the piece, the farthest from the root last
    void trace_from(int root, const std::vector<int> &nodes) {
        total_cost_[static_cast<std::size_t>(root)] = 0.0;
        spread(graph_, {root}, total_cost_, &cost_, &skeleton_.before);
        for (auto tip = nodes.rbegin(); tip != nodes.rend(); ++tip) {
            if (uncovered_[static_cast<std::size_t>(*tip)] < 0.0)
                continue;
            std::vector<int> path{*tip};
            double length = 0.0;
            int node = *tip, next = skeleton_.before[static_cast<std::size_t>(node)];
            while (skeleton_.is_in[static_cast<std::size_t>(node)] == 0 && next >= 0) {
                length += (graph_.place(next) - graph_.place(node)).norm();
                path.push_back(node = next);
                next = skeleton_.before[static_cast<std::size_t>(node)];
            }
            const bool is_branch = skeleton_.is_in[static_cast<std::size_t>(node)] != 0;
            if (!is_branch || length - depth(node) >= std::max(depth(node), least_length_)) {
                add(path);
                for (const int on_path : path)
                    total_cost_[static_cast<std::size_t>(on_path)] = 0.0;
                spread(graph_, path, total_cost_, &cost_, &skeleton_.before);
            }
            for (const int on_path : path) {
                auto &value = uncovered_[static_cast<std::size_t>(on_path)];
                value = std::min(value, -(reach_of_path * depth(on_path) + graph_.margin_of_path()));
            }
            spread(graph_, path, uncovered_);
        }
    }

    /// @param path  from a tip to the root or to a node that is there
    void add(const std::vector<int> &path) {
        for (auto node = path.rbegin(); node != path.rend(); ++node) {
            const auto n = static_cast<std::size_t>(*node);
            if (skeleton_.is_in[n] != 0)
                continue;
            skeleton_.is_in[n] = 1;
            skeleton_.nodes.push_back(*node);
            if (const int next = skeleton_.before[n]; next >= 0)
                ++skeleton_.num_behind[static_cast<std::size_t>(next)];
        }
    }

    const VesselGraph &graph_;
    double least_length_;
    Skeleton skeleton_;
    std::vector<double> from_any_, from_one_, from_other_; ///< (N) lengths of ways in a piece [m]
    std::vector<double> cost_, total_cost_;                ///< (N)
    std::vector<double> uncovered_;                        ///< (N) below 0 where a path covers it
};

/// A part of the skeleton between two ends or branch points.
struct VesselBranch {
    int first = 0, last = 0;       ///< nodes
    std::vector<Vector3> places{}; ///< in the image [m]
    std::vector<double> radii{};   ///< [m]

    void turn() {
        std::ranges::reverse(places);
        std::ranges::reverse(radii);
    }
};

/// The middle of a vessel at a node of a path, which is the deepest one around: at most half a voxel from it along each
/// axis.
Vector3 middle_at(const VesselGraph &graph, int node) {
    const Vector3 start = graph.place(node), half = 0.5 * graph.grid.spacing;
    Vector3 middle = start;
    for (int round = 0; round < 2; ++round) {
        Vector3 sum = Vector3::Zero();
        double weights = 0.0;
        graph.for_each_near(middle, reach_of_middle * graph.depth[static_cast<std::size_t>(node)],
                            [&](int near, const Vector3 &place) {
                                const double depth = near < 0 ? 0.0 : graph.depth[static_cast<std::size_t>(near)];
                                sum += depth * depth * place;
                                weights += depth * depth;
                            });
        middle = (sum / weights).cwiseMax(start - half).cwiseMin(start + half);
    }
    return middle;
}

/// The distance to the nearest voxel outside [m], of a place in the middle of a vessel.
/// @param depth  of the node that it is of
double radius_at(const VesselGraph &graph, const Vector3 &place, double depth) {
    double nearest = 2.0 * depth + graph.grid.spacing.norm();
    graph.for_each_near(place, nearest, [&](int node, const Vector3 &at) {
        if (node < 0)
            nearest = std::min(nearest, (at - place).norm());
    });
    return std::max(nearest, 0.5 * graph.grid.spacing.minCoeff());
}

/// Makes the last end straight. A path begins in some corner of the end of a vessel: from where a ball in the vessel
/// comes near it the middle goes straight on as far.
/// @return the number of places that were moved, where the vessel is as thick as before them
std::size_t straighten_end(VesselBranch &branch, double margin) {
    auto &places = branch.places;
    const Vector3 tip = places.back();
    std::size_t from = 1;
    while ((places[from] - tip).norm() > reach_of_path * branch.radii[from] + margin)
        ++from;
    const Vector3 begin = places[from];
    std::size_t behind = from;
    while (behind > 0 && (places[behind] - begin).norm() < 2.0 * branch.radii[from])
        --behind;
    const Vector3 along = (begin - places[behind]).normalized();
    const std::size_t num_moved = places.size() - 1 - from;
    if (num_moved == 0 || !(along.dot(tip - begin) > 0.0))
        return 0;
    const Vector3 step = along.dot(tip - begin) / static_cast<double>(num_moved) * along;
    for (std::size_t p = from + 1; p < places.size(); ++p)
        places[p] = places[p - 1] + step;
    std::fill(branch.radii.begin() + static_cast<std::ptrdiff_t>(from), branch.radii.end(), branch.radii[from]);
    return num_moved;
}

double length_of(const std::vector<Vector3> &places) {
    double length = 0.0;
    for (std::size_t p = 1; p < places.size(); ++p)
        length += (places[p] - places[p - 1]).norm();
    return length;
}

/// Means of values along a branch over as many points to each side; the ends stay.
template <class Value>
std::vector<Value> smoothed(const std::vector<Value> &values, const std::vector<double> &radii, double step) {
    auto means = values;
    for (std::size_t p = 0; p < values.size(); ++p) {
        const auto reach = std::min({static_cast<std::size_t>(radii[p] / step), p, values.size() - 1 - p});
        for (std::size_t k = 1; k <= reach; ++k)
            means[p] += values[p - k] + values[p + k];
        means[p] /= static_cast<double>(2 * reach + 1);
    }
    return means;
}

VesselBranch measured(const VesselGraph &graph, const Skeleton &skeleton, const std::vector<int> &nodes) {
    VesselBranch branch{.first = nodes.front(), .last = nodes.back()};
    for (const int node : nodes) {
        branch.places.push_back(skeleton.is_end(node) ? graph.place(node) : middle_at(graph, node));
        branch.radii.push_back(graph.depth[static_cast<std::size_t>(node)]);
    }
    const auto straightened = [&](int node) {
        return skeleton.is_end(node) ? straighten_end(branch, graph.margin_of_path()) : 0;
    };
    const auto end = nodes.size() - straightened(branch.last);
    branch.turn();
    const auto begin = straightened(branch.first);
    branch.turn();
    const double step = length_of(branch.places) / static_cast<double>(nodes.size() - 1);
    branch.places = smoothed(branch.places, branch.radii, step);
    auto &radii = branch.radii;
    for (std::size_t p = begin; p < end; ++p)
        radii[p] = radius_at(graph, branch.places[p], radii[p]);
    if (begin < end) {
        std::fill(radii.begin(), radii.begin() + static_cast<std::ptrdiff_t>(begin), radii[begin]);
        std::fill(radii.begin() + static_cast<std::ptrdiff_t>(end), radii.end(), radii[end - 1]);
    }
    radii = smoothed(radii, radii, step);
    return branch;
}

std::vector<VesselBranch> branches_of(const VesselGraph &graph, const Skeleton &skeleton) {
    std::vector<int> behind(graph.voxel.size(), -1); // the only one
    for (const int node : skeleton.nodes)
        if (const int before = skeleton.before[static_cast<std::size_t>(node)]; before >= 0)
            behind[static_cast<std::size_t>(before)] = node;
    std::vector<VesselBranch> branches;
    for (const int node : skeleton.nodes) {
        const int before = skeleton.before[static_cast<std::size_t>(node)];
        if (before < 0 || !(skeleton.is_branch_point(before) || skeleton.is_end(before)))
            continue;
        std::vector<int> nodes{before, node};
        while (skeleton.num_behind[static_cast<std::size_t>(nodes.back())] == 1)
            nodes.push_back(behind[static_cast<std::size_t>(nodes.back())]);
        branches.push_back(measured(graph, skeleton, nodes));
    }
    return branches;
}

/// A tree that grows branch by branch.
class GrowingTree {
  public:
    GrowingTree(const VesselGraph &graph, const CentrelineOptions &options)
        : grid_(graph.grid), options_(options), point_of_(graph.voxel.size(), -1) {
        tree_.wall_ratio = meshes::usual_wall_ratio;
        tree_.wall_modulus = meshes::usual_wall_modulus;
    }

    /// Adds what of a branch is thin enough.
    void add(const VesselBranch &branch) {
        const auto size = branch.places.size();
        for (std::size_t begin = 0; begin < size;) {
            std::size_t end = begin;
            while (end < size && branch.radii[end] <= options_.largest_radius)
                ++end;
            if (end > begin + 1)
                add_part(branch, begin, end);
            begin = end + 1;
        }
    }

    const core::VesselTree &tree() const { return tree_; }

  private:
    int new_point(const Vector3 &place, double radius) {
        tree_.points.push_back(to_world(grid_, place));
        tree_.radius.push_back(radius);
        return static_cast<int>(tree_.points.size()) - 1;
    }

    /// The point of a node where branches meet, made when it is first asked for.
    int shared_point(int node, const Vector3 &place, double radius) {
        auto &point = point_of_[static_cast<std::size_t>(node)];
        if (point < 0)
            point = new_point(place, radius);
        return point;
    }

    void add_part(const VesselBranch &branch, std::size_t begin, std::size_t end) {
        std::vector<double> along{0.0}; // to each place
        for (std::size_t p = begin + 1; p < end; ++p)
            along.push_back(along.back() + (branch.places[p] - branch.places[p - 1]).norm());
        const bool is_cut = begin > 0 || end < branch.places.size();
        if (is_cut && along.back() < options_.least_length)
            return;
        const int num_segments = std::max(1, static_cast<int>(std::lround(along.back() / options_.spacing)));
        int before = begin == 0 ? shared_point(branch.first, branch.places.front(), branch.radii.front())
                                : new_point(branch.places[begin], branch.radii[begin]);
        std::size_t p = 1;
        for (int s = 1; s <= num_segments; ++s) {
            int point = 0;
            if (s == num_segments) {
                point = end == branch.places.size()
                            ? shared_point(branch.last, branch.places.back(), branch.radii.back())
                            : new_point(branch.places[end - 1], branch.radii[end - 1]);
            } else {
                const double wanted = along.back() * s / num_segments;
                while (along[p] < wanted)
                    ++p;
                const double part = (wanted - along[p - 1]) / (along[p] - along[p - 1]);
                const auto b = begin + p;
                point = new_point((1.0 - part) * branch.places[b - 1] + part * branch.places[b],
                                  (1.0 - part) * branch.radii[b - 1] + part * branch.radii[b]);
            }
            tree_.segments.push_back({before, point});
            before = point;
        }
    }

    const ImageGrid &grid_;
    const CentrelineOptions &options_;
    std::vector<int> point_of_; ///< of a node; -1 where it has none
    core::VesselTree tree_;
};

} // namespace

core::VesselTree centrelines(const ImageGrid &grid, const std::vector<char> &is_vessel,
                             const CentrelineOptions &options) {
    const auto graph = graph_of(grid, is_vessel);
    GrowingTree tree(graph, options);
    for (const auto &branch : branches_of(graph, PathFinder(graph, options.least_length).skeleton()))
        tree.add(branch);
    return tree.tree();
}

} // namespace livermark::segmentation
