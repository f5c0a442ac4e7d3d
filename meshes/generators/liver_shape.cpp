#include "meshes/generators/liver_shape.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fmt/format.h>
#include <tuple>
#include <utility>

#include "core/support/input_error.hpp"
#include "core/support/random_numbers.hpp"
#include "meshes/generators/box_generator.hpp"
#include "meshes/generators/surface_mesh.hpp"

namespace livermark::meshes {

namespace {

using core::Vector3;

const Vector3 left_lobe_center(22.0, -14.0, 26.0);

/// Smaller of two levels with the corner between them rounded over a width k: the union of two bodies.
double smooth_union(double a, double b, double k) {
    const double h = std::max(k - std::abs(a - b), 0.0);
    return std::min(a, b) - h * h / (4.0 * k);
}

double smooth_intersection(double a, double b, double k) {
    return -smooth_union(-a, -b, k);
}

double smooth_difference(double a, double b, double k) {
    return smooth_intersection(a, -b, k);
}

/// First-order distance to an ellipsoid, |q| (|q| - 1) / |grad| with q the point in units of the semi-axes.
double ellipsoid(const Vector3 &p, const Vector3 &center, const Vector3 &semi_axes) {
    const Vector3 q = (p - center).cwiseQuotient(semi_axes);
    const double k0 = q.norm();
    const double k1 = q.cwiseQuotient(semi_axes).norm();
    return k1 > 0.0 ? k0 * (k0 - 1.0) / k1 : -semi_axes.minCoeff();
}

/// Distance to a segment from a to b swept by a ball whose radius goes from ra to rb.
double tapered_capsule(const Vector3 &p, const Vector3 &a, const Vector3 &b, double ra, double rb) {
    const double t = std::clamp((p - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
    return (p - a - t * (b - a)).norm() - (ra + t * (rb - ra));
}

/// A Riedel's lobe: a tongue of the right lobe that reaches below the costal margin.
double tongue(const Vector3 &p, const LiverShape &shape) {
    const Vector3 root(-82.0, -14.0, -30.0);
    const Vector3 tip(-90.0, -18.0, -66.0 - shape.tongue_length);
    return tapered_capsule(p, root, tip, 26.0, 17.0);
}

/// The convex side, moulded by the diaphragm and the ribs: a large right lobe and a flat left one.
double diaphragmatic_body(const Vector3 &p, const LiverShape &shape) {
    const double right = ellipsoid(p, {-40.0, 4.0, -16.0}, shape.right_lobe);
    const double left = ellipsoid(p, left_lobe_center, shape.left_lobe);
    return smooth_union(right, left, 34.0);
}

/// Everything below and behind that presses into the visceral side: positive where the liver may be.
double visceral_side(const Vector3 &p, const LiverShape &shape) {
    const Vector3 down = Vector3(0.56, 0.62, -1.0).normalized();
    double level = down.dot(p - Vector3(0.0, 0.0, shape.visceral_height));
    level = smooth_difference(level, ellipsoid(p, {66.0, 26.0, -22.0}, shape.stomach), 16.0);       // stomach
    level = smooth_difference(level, ellipsoid(p, {-64.0, 54.0, -68.0}, {36.0, 36.0, 52.0}), 16.0); // right kidney
    level = smooth_difference(level, ellipsoid(p, {-84.0, 4.0, -122.0}, {44.0, 40.0, 42.0}), 14.0); // colon
    return level;
}

/// The vertebral column and the great vessels behind the liver.
double midline_behind(const Vector3 &p) {
    return tapered_capsule(p, {30, 78, -200}, {30, 74, 200}, 46.0, 46.0);
}

double level_in_millimetres(const Vector3 &p, const LiverShape &shape) {
    double level = diaphragmatic_body(p, shape);
    level = smooth_intersection(level, visceral_side(p, shape), 9.0);
    if (shape.tongue_length > 0.0)
        level = smooth_union(level, tongue(p, shape), 24.0);
    level = smooth_difference(level, midline_behind(p), 24.0);
    // Caudate lobe, between the vena cava and the fissure of the ligamentum venosum.
    level = smooth_union(level, ellipsoid(p, {12.0, 24.0, 14.0}, {15.0, 15.0, 24.0}), 10.0);
    // The H of the visceral side: vena cava and gallbladder on its right limb, ligamentum venosum and ligamentum teres
    // on its left, the porta hepatis across.
    level = smooth_difference(level, tapered_capsule(p, {-8, 50, -80}, {-8, 44, 120}, 12.0, 12.0), 10.0);
    level = smooth_difference(level, tapered_capsule(p, {-20, -2, -33}, {-32, -62, -87}, 11.0, 15.0), 9.0);
    level = smooth_difference(level, tapered_capsule(p, {-18, 10, -22}, {22, 2, -9}, 9.0, 9.0), 9.0);
    level = smooth_difference(level, tapered_capsule(p, {22, 0, -10}, {15, -72, -42}, 8.0, 12.0), 8.0);
    // The falciform ligament ties the front to the diaphragm and leaves a shallow crease.
    level = smooth_difference(level, ellipsoid(p, {15.0, -83.0, 10.0}, {10.0, 26.0, 70.0}), 12.0);
    // The heart flattens the top between the two domes.
    level = smooth_difference(level, ellipsoid(p, {26.0, -14.0, 92.0}, {46.0, 40.0, 40.0}), 24.0);
    return level;
}

Vector3 to_drawing(const Vector3 &point, const LiverShape &shape) {
    return point.cwiseQuotient(shape.metres_per_unit) + shape.centroid;
}

/// @param semi_axes  [mm]
/// @param first, second  the first axis points along `first`, the second lies in the plane of both
Lesion make_lesion(const Vector3 &center, const Vector3 &semi_axes, const Vector3 &first, const Vector3 &second) {
    const Vector3 a = first.normalized();
    const Vector3 b = (second - second.dot(a) * a).normalized();
    return {center, semi_axes / 1000.0, {a, b, a.cross(b)}};
}

} // namespace

double liver_level(const core::Vector3 &point, const LiverShape &shape) {
    return level_in_millimetres(to_drawing(point, shape), shape) * shape.metres_per_unit.minCoeff();
}

double diaphragmatic_depth(const core::Vector3 &point, const LiverShape &shape) {
    const auto p = to_drawing(point, shape);
    double level = diaphragmatic_body(p, shape);
    if (shape.tongue_length > 0.0)
        level = std::min(level, tongue(p - Vector3(12.0, 8.0, 0.0), shape) - 12.0); // deep on its inner side alone
    return -level * shape.metres_per_unit.minCoeff();
}

core::Vector3 liver_gradient(const core::Vector3 &point, const LiverShape &shape) {
    constexpr double step = 1e-5;
    Vector3 gradient;
    for (int d = 0; d < 3; ++d) {
        const Vector3 offset = step * Vector3::Unit(d);
        gradient[d] = (liver_level(point + offset, shape) - liver_level(point - offset, shape)) / (2.0 * step);
    }
    return gradient;
}

core::Vector3 project_to_liver(core::Vector3 point, const LiverShape &shape) {
    constexpr double close_enough = 1e-10;
    constexpr int max_iterations = 10;
    double level = liver_level(point, shape);
    for (int iteration = 0; iteration < max_iterations && std::abs(level) > close_enough; ++iteration) {
        const Vector3 gradient = liver_gradient(point, shape);
        point -= level / gradient.squaredNorm() * gradient;
        level = liver_level(point, shape);
    }
    return point;
}

std::array<core::Vector3, 2> liver_bounding_box() {
    return {Vector3(-0.10, -0.07, -0.105), Vector3(0.16, 0.09, 0.085)};
}

std::array<core::Vector3, 2> liver_bounding_box(const LiverShape &shape) {
    constexpr double margin = 12.0; // of the drawing, for blends
    const double left_end = left_lobe_center.x() + shape.left_lobe.x();
    const double bottom =
        std::min(-16.0 - shape.right_lobe.z(), shape.tongue_length > 0.0 ? -83.0 - shape.tongue_length : 0.0);
    const double top = std::max(-16.0 + shape.right_lobe.z(), left_lobe_center.z() + shape.left_lobe.z());
    const Vector3 low(std::min(-40.0 - shape.right_lobe.x(), -108.0) - margin, -80.0 - margin, bottom - margin);
    const Vector3 high(left_end + margin, 67.0 + margin, top + margin);
    return {(low - shape.centroid).cwiseProduct(shape.metres_per_unit),
            (high - shape.centroid).cwiseProduct(shape.metres_per_unit)};
}

double left_lobe_tip_begin(const LiverShape &shape) {
    // As in the liver that ships, where the tip begins at x = 0.105 m.
    constexpr double part = 0.522;
    return (left_lobe_center.x() + part * shape.left_lobe.x() - shape.centroid.x()) * shape.metres_per_unit.x();
}

double left_lobe_end(const LiverShape &shape) {
    return (left_lobe_center.x() + shape.left_lobe.x() - shape.centroid.x()) * shape.metres_per_unit.x();
}

std::vector<Lesion> liver_lesions() {
    // On the right, Couinaud's segment.
    return {
        make_lesion({-0.028, 0.008, 0.024}, {24.5, 21.5, 18.5}, {1.0, 0.3, 0.4}, {0.0, 1.0, 0.2}),   // VII, VIII
        make_lesion({-0.050, 0.006, -0.034}, {18.0, 15.0, 13.5}, {0.2, -0.3, 1.0}, {1.0, 0.2, 0.0}), // V, VI
        make_lesion({0.030, -0.016, 0.004}, {13.5, 11.5, 10.0}, {0.3, 1.0, -0.2}, {1.0, 0.0, 0.3}),  // IV
        make_lesion({0.080, -0.019, 0.019}, {10.5, 9.0, 8.0}, {1.0, -0.4, 0.2}, {0.0, 0.3, 1.0}),    // III
        make_lesion({-0.015, -0.032, -0.036}, {8.2, 7.4, 6.5}, {-0.2, 0.5, 1.0}, {1.0, 0.3, 0.0}),   // V
        make_lesion({0.115, -0.016, 0.027}, {5.9, 5.4, 5.0}, {0.5, 1.0, 0.3}, {0.0, 0.4, 1.0}),      // II
    };
}

namespace {

using support::RandomNumbers;

constexpr double smallest_volume = 0.9e-3; // [m^3]
constexpr double largest_volume = 2.2e-3;  // [m^3]

/// @return body surface [m^2] and liver volume [m^3]
std::pair<double, double> draw_person(RandomNumbers &random) {
    while (true) {
        const double surface = random.normal(1.8, 0.2);
        const double volume = 1e-6 * (1267.28 * surface - 794.41 + random.normal(0.0, 200.0));
        if (volume >= smallest_volume && volume <= largest_volume)
            return {surface, volume};
    }
}

LiverShape draw_shape(RandomNumbers &random) {
    LiverShape shape;
    const double length = random.uniform(0.72, 1.15);
    const double thickness = random.uniform(0.85, 1.2);
    shape.left_lobe = shape.left_lobe.cwiseProduct(Vector3(length, thickness, thickness));
    shape.right_lobe.z() *= random.uniform(0.92, 1.12);
    shape.visceral_height += random.uniform(-7.0, 4.0);
    shape.stomach *= random.uniform(0.9, 1.06);
    shape.metres_per_unit.y() *= random.uniform(0.86, 1.16);
    shape.metres_per_unit.x() *= random.uniform(0.96, 1.04);
    if (random.below(6) == 0)
        shape.tongue_length = random.uniform(20.0, 60.0);
    return shape;
}

/// Plane where the falciform ligament parts the left lobe from the rest: x [m].
double left_lobe_border(const LiverShape &shape) {
    return (15.0 - shape.centroid.x()) * shape.metres_per_unit.x();
}

/// Volume and centroid, and the part of the volume on the left of the falciform ligament, which is summed over columns
/// of a grid.
struct Extent {
    double volume = 0.0;                // [m^3]
    Vector3 centroid = Vector3::Zero(); // [m]
    double left_part = 0.0;
};

Extent extent_of(const LiverShape &shape) {
    constexpr double spacing = 0.003; // [m]
    const auto [low, high] = liver_bounding_box(shape);
    const auto surface = march_tetrahedra([&](const Vector3 &p) { return liver_level(p, shape); }, low, high, spacing);
    Extent extent{.volume = enclosed_volume(surface)};
    for (const auto &[a, b, c] : surface.triangles) {
        const auto &p = surface.points;
        extent.centroid += p[a].dot(p[b].cross(p[c])) / 24.0 * (p[a] + p[b] + p[c]);
    }
    extent.centroid /= extent.volume;
    const double border = left_lobe_border(shape);
    int inside = 0, left = 0;
    for (double x = low.x(); x < high.x(); x += spacing)
        for (double y = low.y(); y < high.y(); y += spacing)
            for (double z = low.z(); z < high.z(); z += spacing)
                if (liver_level({x, y, z}, shape) < 0.0) {
                    ++inside;
                    left += x > border ? 1 : 0;
                }
    extent.left_part = static_cast<double>(left) / inside;
    return extent;
}

/// Every direction alike: a point of the ball, by rejection.
Vector3 draw_direction(RandomNumbers &random) {
    while (true) {
        Vector3 point;
        for (int c = 0; c < 3; ++c)
            point[c] = random.uniform(-1.0, 1.0);
        if (point.norm() <= 1.0 && point.norm() > 0.1)
            return point.normalized();
    }
}

Lesion draw_lesion(RandomNumbers &random) {
    const double u = random.uniform();
    const double across = 0.011 + 0.039 * u * u; // [m]
    Lesion lesion;
    lesion.semi_axes = 0.5 * across * Vector3(1.0, random.uniform(0.8, 1.0), 0.0);
    lesion.semi_axes.z() = lesion.semi_axes.y() * random.uniform(0.85, 1.0);
    const Vector3 a = draw_direction(random);
    Vector3 b = a;
    while (a.cross(b).norm() < 0.1)
        b = draw_direction(random);
    b = (b - b.dot(a) * a).normalized();
    lesion.axes = {a, b, a.cross(b)};
    return lesion;
}

/// Whether a lesion lies deep enough below the capsule and apart from others.
bool has_room(const Lesion &lesion, const std::vector<Lesion> &others, const LiverShape &shape) {
    constexpr double below_capsule = 0.009; // [m]
    constexpr double apart = 0.014;         // [m]
    constexpr int frequency = 3;
    static const auto directions = geodesic_sphere(frequency).points;
    for (const auto &other : others)
        if ((lesion.center - other.center).norm() < lesion.semi_axes.x() + other.semi_axes.x() + apart)
            return false;
    return std::ranges::all_of(directions, [&](const Vector3 &direction) {
        Vector3 point = lesion.center;
        for (int d = 0; d < 3; ++d)
            point += direction[d] * lesion.semi_axes[d] * lesion.axes[d];
        return liver_level(point, shape) < -below_capsule;
    });
}

/// A lesion that finds no place is made smaller, until it does.
std::vector<Lesion> draw_lesions(RandomNumbers &random, const LiverShape &shape) {
    constexpr int most = 8;
    constexpr int tries = 500;
    constexpr double smallest = 0.0052; // half its length [m]
    std::vector<Lesion> drawn(random.below(most + 1));
    for (auto &lesion : drawn)
        lesion = draw_lesion(random);
    const auto by_size = [](const Lesion &lesion) { return -lesion.semi_axes.prod(); };
    std::ranges::stable_sort(drawn, {}, by_size);
    const auto [low, high] = liver_bounding_box(shape);
    std::vector<Lesion> placed;
    for (auto &lesion : drawn)
        for (int attempt = 1; attempt > 0; ++attempt) {
            for (int c = 0; c < 3; ++c)
                lesion.center[c] = random.uniform(low[c], high[c]);
            if (has_room(lesion, placed, shape)) {
                placed.push_back(lesion);
                break;
            }
            if (attempt % tries == 0 && lesion.semi_axes.x() > smallest)
                lesion.semi_axes *= 0.9;
        }
    std::ranges::stable_sort(placed, {}, by_size);
    return placed;
}

} // namespace

LiverVariant draw_liver(int number) {
    if (number < 1)
        throw support::InputError(
            "there is no variant {} of the liver; give a number from 1, or 0 for the one that ships", number);
    RandomNumbers random(static_cast<std::uint64_t>(number));
    LiverVariant variant;
    variant.number = number;
    std::tie(variant.body_surface, variant.volume) = draw_person(random);
    auto &shape = variant.shape;
    shape = draw_shape(random);
    const LiverShape shipped;
    const auto relative = shape.metres_per_unit.cwiseQuotient(shipped.metres_per_unit);
    const auto extent = extent_of(shape);
    variant.front_to_back = relative.y() / cube_root(relative.prod());
    variant.has_riedel_lobe = shape.tongue_length > 0.0;
    variant.left_part = extent.left_part;
    shape.centroid += extent.centroid.cwiseQuotient(shape.metres_per_unit);
    shape.metres_per_unit *= cube_root(variant.volume / extent.volume);
    variant.lesions = draw_lesions(random, shape);
    return variant;
}

std::string to_text(const LiverVariant &variant) {
    const auto across = [](const Lesion &lesion) { return 2e3 * lesion.semi_axes.maxCoeff(); };
    std::string lesions = "no lesion";
    if (variant.lesions.size() == 1)
        lesions = fmt::format("1 lesion of {:.0f} mm", across(variant.lesions.front()));
    else if (!variant.lesions.empty())
        lesions = fmt::format("{} lesions of {:.0f} to {:.0f} mm", variant.lesions.size(),
                              across(std::ranges::min(variant.lesions, {}, across)),
                              across(std::ranges::max(variant.lesions, {}, across)));
    return fmt::format(
        "variant {}: {:.2f} L (body surface {:.2f} m^2), {:.0f} % of it in the left lobe, {:.2f} as thick "
        "from front to back as the liver that ships, {}, {}",
        variant.number, 1e3 * variant.volume, variant.body_surface, 100.0 * variant.left_part, variant.front_to_back,
        variant.has_riedel_lobe ? "Riedel's lobe" : "no Riedel's lobe", lesions);
}

} // namespace livermark::meshes
