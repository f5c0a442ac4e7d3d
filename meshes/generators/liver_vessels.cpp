#include "meshes/generators/liver_vessels.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "meshes/generators/liver_shape.hpp"
#include "meshes/io/vessel_files.hpp"

namespace livermark::meshes {

using core::Vector3;

namespace {

const std::array<VeinTrunk, 7> trunks{{
    {LiverVein::hepatic, {0.022, 0.050, 0.046}, {0.008, 0.018, 0.040}, 6.0e-3},
    {LiverVein::hepatic, {0.008, 0.018, 0.040}, {0.002, -0.030, 0.020}, 4.0e-3},
    {LiverVein::hepatic, {0.008, 0.018, 0.040}, {-0.060, 0.030, 0.045}, 5.0e-3},
    {LiverVein::portal, {0.016, 0.014, -0.034}, {-0.012, 0.018, -0.012}, 6.0e-3},
    {LiverVein::portal, {-0.012, 0.018, -0.012}, {-0.052, 0.034, -0.006}, 5.0e-3},
    {LiverVein::portal, {-0.052, 0.034, -0.006}, {-0.080, 0.026, -0.020}, 3.0e-3},
    {LiverVein::portal, {-0.002, 0.016, -0.020}, {0.050, 0.004, 0.012}, 4.0e-3},
}};

constexpr double twig_radius = 1.2e-3;  // [m]
constexpr double below_surface = 6e-3;  // [m]
constexpr double nearest_part = 0.5;    // of the edge of a cube of the volume that a twig has for itself
constexpr double liver_volume = 1.5e-3; // [m^3]
constexpr double same_place = 1.5e-3;   // [m] that a fork moves to a point that is there

/// A tree that grows; each point but the root has one before it.
class GrowingTree {
  public:
    explicit GrowingTree(const Vector3 &root) : points_{root}, parent_{-1} {}

    /// Goes from the nearest point of the tree to a point.
    void reach(const Vector3 &end) {
        const auto [child, place] = nearest(end);
        add(end, fork_at(child, place));
    }

    double distance(const Vector3 &point) const { return (nearest(point).place - point).norm(); }

    /// Adds the tree to others, with Murray's radii.
    void add_to(core::VesselTree &tree) const {
        std::vector<double> cube(points_.size(), 0.0); // of the radius of the segment that ends there
        std::vector<int> num_children(points_.size(), 0);
        for (const int before : parent_)
            if (before >= 0)
                ++num_children[static_cast<std::size_t>(before)];
        for (std::size_t p = 0; p < points_.size(); ++p)
            if (num_children[p] == 0)
                for (int at = static_cast<int>(p); at >= 0; at = parent_[static_cast<std::size_t>(at)])
                    cube[static_cast<std::size_t>(at)] += twig_radius * twig_radius * twig_radius;
        const auto first = static_cast<int>(tree.points.size());
        for (std::size_t p = 0; p < points_.size(); ++p) {
            tree.points.push_back(points_[p]);
            tree.radius.push_back(std::cbrt(cube[p]));
            if (parent_[p] >= 0)
                tree.segments.push_back({first + parent_[p], first + static_cast<int>(p)});
        }
    }

  private:
    /// A place on the segment that ends at a point; of a tree without segments, its root.
    struct Nearest {
        int child = 0;
        Vector3 place = Vector3::Zero();
    };

    Nearest nearest(const Vector3 &point) const {
        Nearest found{0, points_.front()};
        double least = (points_.front() - point).squaredNorm();
        for (std::size_t p = 1; p < points_.size(); ++p) {
            const Vector3 &begin = points_[static_cast<std::size_t>(parent_[p])];
            const Vector3 way = points_[p] - begin;
            const double along = std::clamp((point - begin).dot(way) / way.squaredNorm(), 0.0, 1.0);
            const Vector3 place = begin + along * way;
            if (const double square = (place - point).squaredNorm(); square < least) {
                least = square;
                found = {static_cast<int>(p), place};
            }
        }
        return found;
    }

    /// Number of a point at a place of the segment that ends at another one.
    int fork_at(int child, const Vector3 &place) {
        const int before = parent_[static_cast<std::size_t>(child)];
        for (const int end : {child, before})
            if (end >= 0 && (points_[static_cast<std::size_t>(end)] - place).norm() < same_place)
                return end;
        const int fork = add(place, before);
        parent_[static_cast<std::size_t>(child)] = fork;
        return fork;
    }

    int add(const Vector3 &point, int before) {
        points_.push_back(point);
        parent_.push_back(before);
        return static_cast<int>(points_.size()) - 1;
    }

    std::vector<Vector3> points_;
    std::vector<int> parent_;
};

/// A point well inside the liver that ships. The bits of this engine are the same everywhere.
Vector3 point_in_liver(std::mt19937 &bits) {
    const auto [low, high] = liver_bounding_box();
    const auto part = [&bits] {
        return static_cast<double>(bits()) / (1.0 + std::numeric_limits<std::uint32_t>::max());
    };
    Vector3 point;
    do
        for (int d = 0; d < 3; ++d)
            point[d] = low[d] + part() * (high[d] - low[d]);
    while (liver_level(point) > -below_surface);
    return point;
}

} // namespace

std::span<const VeinTrunk> liver_vein_trunks() {
    return trunks;
}

core::VesselTree liver_veins(int twigs_of_each) {
    core::VesselTree tree{
        .points = {}, .radius = {}, .segments = {}, .wall_ratio = usual_wall_ratio, .wall_modulus = usual_wall_modulus};
    std::mt19937 bits(61);
    for (const auto vein : {LiverVein::hepatic, LiverVein::portal}) {
        const auto first = std::ranges::find(trunks, vein, &VeinTrunk::vein);
        GrowingTree growing(first->begin);
        for (const auto &trunk : trunks)
            if (trunk.vein == vein)
                growing.reach(trunk.end);
        for (int twig = 0; twig < twigs_of_each;) {
            const auto point = point_in_liver(bits);
            const double own_edge = std::cbrt(liver_volume / (1.0 + twig));
            if (growing.distance(point) < nearest_part * own_edge)
                continue;
            growing.reach(point);
            ++twig;
        }
        growing.add_to(tree);
    }
    return tree;
}

} // namespace livermark::meshes
