#include "meshes/generators/liver/liver_shape.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

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

double left_lobe_border(const LiverShape &shape) {
    return (15.0 - shape.centroid.x()) * shape.metres_per_unit.x();
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

} // namespace livermark::meshes
